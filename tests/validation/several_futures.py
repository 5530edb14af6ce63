"""Whether the modes of a forecaster differ, and whether their probabilities and regions are right.

Run it for the tables of docs/prediction.md:
python tests/validation/several_futures.py iterative_attention CROWDS
"""

import sys

import numpy as np

from predictor.calibration import LEVEL
from predictor.datasets import read_tests
from predictor.forecaster import ModalForecaster, make_forecaster
from predictor.modal_metrics import region_mass
from predictor.scenes import scenes

LIKELY = 0.05
"""A mode of this probability counts as one that is there."""
STRIDE = 4
"""Frames between two windows."""


def futures(forecaster, recording):
    """Modes and true paths of the agents of some windows of a recording."""
    for scene in scenes(recording, history_steps=8, forecast_steps=12, stride=STRIDE):
        people = np.zeros(scene.history.shape[1], dtype=np.bool_)
        people[scene.agents] = True
        picture = recording.map_image, recording.pixel_from_world
        found = forecaster.forecast_modes(scene.history, scene.valid, *picture, people)
        yield found.of_people(scene.agents), scene.future


def measured(forecast, future):
    """Of each agent: its probabilities, nearest mode, distances of ends, and covered steps."""
    errors = np.linalg.norm(forecast.position - future, axis=-1).mean(axis=1)  # (M, A)
    ends = forecast.position[:, -1]
    apart = np.linalg.norm(ends - ends[:1], axis=-1)
    mean = (forecast.probability[..., None] * ends).sum(axis=0)
    variance = (forecast.probability * np.square(ends - mean).sum(axis=-1)).sum(axis=0)
    covered = (region_mass(forecast, future) <= LEVEL).mean(axis=0)
    return forecast.probability.T, errors.argmin(axis=0), apart.T, np.sqrt(variance), covered


def main(spec: str, data: str) -> None:
    """Write the tables."""
    forecaster = make_forecaster(spec)
    assert isinstance(forecaster, ModalForecaster)
    recordings = next(iter(read_tests(data).values()))
    by_recording = [
        [np.concatenate(parts) for parts in zip(*(measured(*f) for f in found), strict=True)]
        for found in (list(futures(forecaster, recording)) for recording in recordings)
        if found
    ]
    probability, nearest, apart, spread, _ = map(np.concatenate, zip(*by_recording, strict=True))
    covered = np.array([covered.mean() for *_, covered in by_recording])
    modes = probability.shape[1]
    rows = [
        ["rank", *range(1, modes + 1)],
        ["mean probability", *(f"{p:.3f}" for p in probability.mean(axis=0))],
        [
            "share in which it is the nearest",
            *(f"{(nearest == m).mean():.3f}" for m in range(modes)),
        ],
        ["end, from that of the first [m]", *(f"{d:.2f}" for d in apart.mean(axis=0))],
    ]
    sys.stdout.writelines(f"| {' | '.join(map(str, row))} |\n" for row in rows)
    sys.stdout.write(
        f"{len(probability)} forecasts; modes of at least {LIKELY}: "
        f"{(probability >= LIKELY).sum(axis=1).mean():.2f} in the mean, "
        f"at least two in {100 * ((probability >= LIKELY).sum(axis=1) > 1).mean():.1f} %; "
        f"standard deviation of their ends {spread.mean():.2f} m; "
        f"coverage of the {LEVEL} region by recording {covered.min():.2f} to {covered.max():.2f}, "
        f"standard error of their mean {covered.std(ddof=1) / np.sqrt(len(covered)):.3f}\n"
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
