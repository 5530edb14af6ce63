"""Why radii hold less in the loop than in recordings: who goes on as before, and who does not.

python tests/validation/radii_in_the_loop.py SEEDS FORECASTER SCENARIO_OR_RECORDINGS [MORE ...]
"""

import sys
from pathlib import Path

import numpy as np

from envs.config import make_config
from envs.evaluation.forecast_breakdown import mean_of_sums
from envs.evaluation.forecast_scores import rows_ahead, scored_forecasts
from envs.evaluation.runs import run_episodes
from envs.trace import Trace
from predictor.datasets import read_tests
from predictor.forecaster import CalibratedForecaster, make_forecaster
from predictor.trajectory_errors import batches, forecast_scenes

WIDTH = 20
HISTORY = 8
WALKING = 0.3
"""Who is faster than this walks [m/s]."""
TURN = np.deg2rad(45.0)
"""Who walks in another direction by more than this has turned."""


def ends(trace: Trace) -> np.ndarray:
    """(E, 2), whether people seen in full histories change, and are in the radius at the end."""
    scored = scored_forecasts(trace)
    full = scored.frames_seen == HISTORY
    row, column = scored.row[full], scored.column[full][:, None]
    before = trace.velocity[row[:, None], column]
    after = trace.velocity[rows_ahead(trace, row), column]  # (E, F, 2)
    return np.stack((changes(before, after), scored.within[full, -1]), axis=1)


def in_the_loop(scenario: str, forecaster: str, seeds: int) -> list[np.ndarray]:
    """`ends` of each episode."""
    config = make_config(scenario=scenario, forecaster=forecaster)
    return [ends(trace) for _, trace in run_episodes(config, "mppi", range(seeds), WIDTH)]


def in_recordings(folder: str, name: str) -> list[np.ndarray]:
    """The same of each recording, of whose people velocities are displacements."""
    forecaster, found = make_forecaster(name), []
    assert forecaster is not None
    assert isinstance(forecaster, CalibratedForecaster)
    assert forecaster.radius is not None
    for recording in next(iter(read_tests(folder).values())):
        own = []
        for batch in batches(forecaster, [recording]):
            for scene, path in zip(batch, forecast_scenes(forecaster, batch), strict=True):
                known = np.concatenate((scene.history[-2:, scene.agents], scene.future))
                velocity = (np.diff(known, axis=0) / recording.dt).swapaxes(0, 1)  # (A, 1 + F, 2)
                held = np.linalg.norm(path[-1] - scene.future[-1], axis=-1)
                changed = changes(velocity[:, :1], velocity[:, 1:])
                own.append(np.stack((changed, held <= forecaster.radius[-1, -1]), axis=1))
        found += [np.concatenate(own)] if own else []
    return found


def changes(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """(E,), who turns, stops or starts at any of the (E, F, 2) velocities after (E, 1, 2)."""
    speeds = [np.linalg.norm(velocity, axis=-1) for velocity in (before, after)]
    walked, walks = (speed > WALKING for speed in speeds)
    along = (before * after).sum(axis=-1)
    turned = walked & walks & (along < np.cos(TURN) * speeds[0] * speeds[1])
    return (turned | (walked != walks)).any(axis=1)


def main(seeds: int, forecaster: str, names: list[str]) -> None:
    """Write a row for each scenario or folder: all forecasts, and of those who go on as before."""
    lines = [
        "| scenario | n | coverage at the end | who turn, stop or start | of them | of the others |"
    ]
    for name in names:
        told = Path(name).is_dir()
        found = in_recordings(name, forecaster) if told else in_the_loop(name, forecaster, seeds)
        changed, within = ([each[:, key] for each in found] for key in (0, 1))
        everyone = [np.ones_like(each) for each in changed]
        cells = [
            share(within, everyone),
            share(changed, everyone),
            share(within, changed),
            share(within, [~each for each in changed]),
        ]
        lines.append(f"| {name} | {sum(map(len, changed))} | {' | '.join(cells)} |")
    sys.stdout.write("\n".join([*lines, ""]))


def share(hits: list[np.ndarray], among: list[np.ndarray]) -> str:
    """Share of the hits among some forecasts of each episode, with its interval by episodes."""
    counts = np.array([each.sum() for each in among], dtype=np.float64)
    sums = np.array([(hit & own).sum() for hit, own in zip(hits, among, strict=True)], np.float64)
    found = mean_of_sums(sums, counts, np.random.default_rng(0))
    return f"{found.mean:.3f} [{found.low:.3f}, {found.high:.3f}]"


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2], sys.argv[3:])
