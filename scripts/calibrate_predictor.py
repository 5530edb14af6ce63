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
    from predictor.recalibration import recalibrate

    rolled = recalibrate(forecaster, data, horizon=horizon, progress=True)["rolled"]
    print(
        f"90 % of {rolled['windows']} windows were within {rolled['radius'][-1][-1]:.2f} m after "
        f"{horizon:g} s, {rolled['radius'][0][-1]:.2f} m if people were seen once; kept in "
        f"{forecaster}"
    )
