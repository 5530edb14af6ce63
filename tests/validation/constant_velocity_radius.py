"""Radii of constant velocity, and how often they hold further ahead than they were measured.

Run it for the radii of `predictor.constant_velocity`, from the validation part of simulated crowds,
and for docs: python tests/validation/constant_velocity_radius.py CROWDS [OTHER CROWDS]
"""

import sys

import numpy as np

from crowdsim.recordings import Recording
from predictor.calibration import conformal_radius
from predictor.constant_velocity import ConstantVelocityForecaster, calibrated_radius
from predictor.datasets import read_tests, read_training
from predictor.recalibration import errors_from
from predictor.trajectory_errors import trajectory_errors

HORIZONS = (4.8, 9.6, 19.2)


def errors(recordings: list[Recording], horizon: float) -> np.ndarray:
    """(M, F) errors of constant velocity [m]."""
    forecaster = ConstantVelocityForecaster(forecast_steps=round(horizon / 0.4))
    return trajectory_errors(forecaster, recordings).errors


def main(calibrating: str, others: list[str]) -> None:
    """Write the radii, and the coverage of those that are committed."""
    lines = ["| crowds | horizon [s] | n | coverage@0.9 | least and most of a step | at the end |"]
    validation = read_training(calibrating)[1]
    once = errors_from(ConstantVelocityForecaster(), validation, 1)
    measured = {"RADIUS": errors(validation, 4.8), "RADIUS_SEEN_ONCE": once}
    crowds = {calibrating: validation}
    crowds |= {name: next(iter(read_tests(name).values())) for name in others}
    for name, recordings in crowds.items():
        for horizon in HORIZONS:
            found = errors(recordings, horizon)
            radius = calibrated_radius(0.4 * np.arange(1.0, found.shape[1] + 1.0), 8)[-1]
            held = (found <= radius).mean(axis=0)
            lines.append(
                f"| {name} | {horizon} | {len(found)} | {held.mean():.3f} | "
                f"{held.min():.3f} to {held.max():.3f} | {held[-1]:.3f} |"
            )
    radii = {
        name: ", ".join(f"{radius:.3f}" for radius in conformal_radius(found))
        for name, found in measured.items()
    }
    head = [f"{name} = ({text})" for name, text in radii.items()]
    sys.stdout.write("\n".join([*head, *lines, ""]))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
