"""How often radii hold for who was seen in few frames: with radii of their own, and without.

For docs/prediction.md: python tests/validation/short_histories.py CROWDS FORECASTER [MORE ...]
"""

import sys

from predictor.datasets import read_tests
from predictor.forecaster import CalibratedForecaster, make_forecaster
from predictor.recalibration import errors_from


def main(data: str, names: list[str]) -> None:
    """Write a row for each forecaster and number of frames seen."""
    recordings = next(iter(read_tests(data).values()))
    lines = [
        "| forecaster | frames seen | n | radius at the end [m] | coverage@0.9 | at the end "
        "| with the radii of full histories | at the end |"
    ]
    for name in names:
        forecaster = make_forecaster(name)
        assert forecaster is not None
        assert isinstance(forecaster, CalibratedForecaster)
        assert forecaster.radius is not None
        full = forecaster.radius[-1]
        for frames, radius in enumerate(forecaster.radius, start=1):
            errors = errors_from(forecaster, recordings, frames)
            held, before = errors <= radius, errors <= full
            lines.append(
                f"| {name} | {frames} | {len(errors)} | {radius[-1]:.2f} | {held.mean():.3f} | "
                f"{held[:, -1].mean():.3f} | {before.mean():.3f} | {before[:, -1].mean():.3f} |"
            )
    sys.stdout.write("\n".join([*lines, ""]))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
