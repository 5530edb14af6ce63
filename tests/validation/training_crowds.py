"""How the crowds that predictors are trained on move beside recorded ones, at 0.4 s.

Run it for the table of docs/data.md: python tests/validation/training_crowds.py
"""

import argparse
import sys
from collections import defaultdict

import numpy as np

from crowdsim.generate import Plan
from crowdsim.recordings import find_data, read_obsmat, read_scene

SCENES = ("biwi_eth", "biwi_hotel", "crowds_zara01", "crowds_zara02", "students001", "students003")
STANDING = 0.2
"""Slower than this is standing [m/s]."""
WALKING = 0.5
"""Turns are only counted from this speed on [m/s]."""
NEAR = 2.0
HISTORY, WINDOW = 8, 20
COLUMNS = (
    "standing [%]",
    "speed of walkers [m/s]",
    "acceleration [m/s²]",
    "turn per step [°]",
    "turn, 95 % [°]",
    "neighbors within 2 m",
    "straight ones [%]",
    "turned back [%]",
    "CV ADE [m]",
    "CV FDE [m]",
)


def motion(recording):
    """The ten `COLUMNS` of a recording."""
    positions, valid, dt = recording.positions, recording.valid, recording.dt
    velocity = np.diff(positions, axis=0) / dt  # (T - 1, N, 2)
    both = valid[1:] & valid[:-1]
    speed = np.linalg.norm(velocity, axis=-1)
    three = both[1:] & both[:-1]
    walking = three & (speed[1:] > WALKING) & (speed[:-1] > WALKING)
    change = np.linalg.norm(np.diff(velocity, axis=0), axis=-1)[walking] / dt
    turn = np.degrees(_angle(velocity[:-1][walking], velocity[1:][walking]))
    return (
        100.0 * (speed[both] < STANDING).mean(),
        speed[both & (speed > WALKING)].mean(),
        change.mean(),
        turn.mean(),
        np.quantile(turn, 0.95),
        _neighbors(positions, valid),
        *_windows(positions, valid),
    )


def _angle(before, after):
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return np.abs(np.arctan2(cross, (before * after).sum(axis=1)))


def _neighbors(positions, valid):
    """Mean number of others within `NEAR` of a person."""
    counts = []
    for place, there in zip(positions, valid, strict=True):
        apart = np.linalg.norm(place[there][:, None] - place[there], axis=-1)
        counts.append((apart < NEAR).sum(axis=1) - 1)
    return np.concatenate(counts).mean()


def _windows(positions, valid):
    """Of 8 + 12 steps: shares that go straight and turn back, errors of constant velocity."""
    view = np.lib.stride_tricks.sliding_window_view
    tracks = view(positions, WINDOW, axis=0).transpose(0, 1, 3, 2)  # (S, N, 20, 2)
    tracks = tracks[view(valid, WINDOW, axis=0).all(axis=-1)]  # (R, 20, 2)
    last = tracks[:, HISTORY - 1]
    step = last - tracks[:, HISTORY - 2]
    ahead = np.arange(1, WINDOW - HISTORY + 1)[:, None]
    error = np.linalg.norm(last[:, None] + step[:, None] * ahead - tracks[:, HISTORY:], axis=-1)
    past, future = last - tracks[:, 0], tracks[:, -1] - last
    moved = (np.linalg.norm(past, axis=1) > 1.0) & (np.linalg.norm(future, axis=1) > 1.0)
    turned = np.degrees(_angle(past[moved], future[moved]))
    straight, back = 100.0 * (turned < 10.0).mean(), 100.0 * (turned > 90.0).mean()
    return straight, back, error.mean(), error[:, -1].mean()


def recorded(scene):
    """A recorded scene at its true 0.4 s."""
    folder = find_data(None)
    if scene == "biwi_eth":
        return read_obsmat(folder / "scenes" / scene / "obsmat.txt.gz")
    return read_scene(folder, scene)


def simulated(scenario, recordings, seed):
    """Recordings of a scenario or the mixture by name."""
    plan = Plan(scenarios=(scenario,), recordings=recordings, seconds=60.0, warmup=4.0, seed=seed)
    return [plan.make(index) for index in range(recordings)]


def write_row(name, rows):
    """One line of the table: means over recordings."""
    cells = (f"{value:.2f}" for value in np.nanmean(rows, axis=0))
    sys.stdout.write(f"| {name} | {' | '.join(cells)} |\n")


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recordings", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    sys.stdout.write(f"| | {' | '.join(COLUMNS)} |\n|---|{'---|' * len(COLUMNS)}\n")
    real = [motion(recorded(scene)) for scene in SCENES]
    for scene, row in zip(SCENES, real, strict=True):
        write_row(scene, [row])
    write_row("ETH/UCY", real)
    parts = defaultdict(list)
    for recording in simulated("mixed", options.recordings, options.seed):
        parts[recording.name.rpartition("-")[0]].append(motion(recording))
    for name, rows in parts.items():
        write_row(f"{name} ({len(rows)})", rows)
    write_row("mixed", [row for rows in parts.values() for row in rows])


if __name__ == "__main__":
    main()
