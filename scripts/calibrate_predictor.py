"""`crowdnav calibrate-predictor`: how far off forecasts may be that training does not measure."""

from pathlib import Path

from scripts.options import PositiveNumber


def calibrate_predictor(
    forecaster: Path = Path("runs/predictor"),
    data: str = "runs/dataset",
    horizon: PositiveNumber = 19.2,
) -> None:
    """Measure how far off forecasts are that training does not measure.

    Training measures forecasts of the frames that it trains, from the whole history. Here they are
    made from less history, and the network is rolled on its own forecasts; the radii that held 90 %
    of the truth of validation recordings go into its checkpoint. With them a robot can be told how
    far to trust forecasts of whom it has just come upon, and long ones.

    Args:
        forecaster: Checkpoint, a folder or a `.safetensors` file; its JSON is written anew.
        data: As `--data` of `train-predictor`: what that keeps for validation is used.
        horizon: How far to roll [s]; people must stay that long.
    """
    from predictor.rolled_calibration import calibrate_rolled
    from predictor.short_calibration import calibrate_short

    short = calibrate_short(forecaster, data)
    found = calibrate_rolled(forecaster, data, horizon=horizon, progress=True)
    print(
        f"90 % of {short['windows']} forecasts from one frame of history were within "
        f"{short['radius'][0][-1]:.2f} m at their end, and of {found['windows']} windows within "
        f"{found['radius'][-1]:.2f} m after {horizon:g} s; kept in {forecaster}"
    )
