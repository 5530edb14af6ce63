"""`crowdnav calibrate-predictor`: how far off long forecasts may be."""

from pathlib import Path

from scripts.options import PositiveNumber


def calibrate_predictor(
    forecaster: Path = Path("runs/predictor"),
    data: str = "runs/dataset",
    horizon: PositiveNumber = 19.2,
) -> None:
    """Measure how far off forecasts are beyond what a network was trained for.

    Training measures the frames that it trains. Here the network is rolled on its own forecasts of
    validation recordings, and the radii that held 90 % of the truth go into its checkpoint: with
    them a robot can be told how far to trust long forecasts.

    Args:
        forecaster: Checkpoint, a folder or a `.safetensors` file; its JSON is written anew.
        data: As `--data` of `train-predictor`: what that keeps for validation is used.
        horizon: How far [s]; people must stay that long.
    """
    from predictor.rolled_calibration import calibrate_rolled

    found = calibrate_rolled(forecaster, data, horizon=horizon, progress=True)
    print(
        f"90 % of {found['windows']} windows were within {found['radius'][-1]:.2f} m after "
        f"{horizon:g} s; kept in {forecaster}"
    )
