"""Data sets of simulated crowds, the same bytes for any number of worker processes."""

import math
import multiprocessing
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from crowdsim.recordings import FRAME_DT, Picture, Recording
from crowdsim.recordings.rate import SPEED_RANGE
from crowdsim.recordings.store import require_no_dataset, write_manifest, write_shard
from crowdsim.render import render_map
from crowdsim.scenario import Scenario
from crowdsim.scenarios import SCENARIOS, make_scenario
from crowdsim.scenarios.mixed import MIXED, draw_mixed
from crowdsim.world import World

PER_SHARD: Final = 8
"""Recordings per file; a constant, so that the files do not depend on the workers."""
SCENE_STEPS: Final = 20
"""Rows of a training scene: somebody must be seen that long."""
PHYSICS_DT: Final = 0.05


def record(
    scenario: Scenario,
    rng: np.random.Generator,
    *,
    name: str,
    seconds: float = 60.0,
    warmup: float = 4.0,
    frame_dt: float = FRAME_DT,
) -> Recording:
    """Run a world without a robot and write down where everybody is.

    Args:
        scenario: Initial conditions.
        rng: Source of the world's draws.
        name: Name of the recording.
        seconds: Length of the recording [s].
        warmup: Time that passes before it begins [s].
        frame_dt: Time between two rows [s], a whole multiple of `PHYSICS_DT`.

    Returns:
        Recording whose `frames` count from 0, with the map as its picture.

    Raises:
        ValueError: The clocks do not fit, or nobody is seen for `SCENE_STEPS` rows on end.
    """
    per_frame = round(frame_dt / PHYSICS_DT)
    if per_frame < 1 or not math.isclose(per_frame * PHYSICS_DT, frame_dt):
        raise ValueError(f"frame_dt must be a multiple of {PHYSICS_DT} s, got {frame_dt}")
    world = World(scenario, rng=rng, physics_dt=PHYSICS_DT)
    for _ in range(round(warmup / PHYSICS_DT)):
        world.step()
    frames, ids, positions = [], [], []
    for frame in range(round(seconds / frame_dt)):
        seen = world.valid
        frames.append(np.full(int(seen.sum()), frame, dtype=np.int64))
        ids.append(world.ids[seen])
        positions.append(world.positions[seen])
        for _ in range(per_frame):
            world.step()
    if sum(len(part) for part in frames) == 0:
        raise ValueError(f"{name}: expected a crowd, found no pedestrian")
    recording = Recording.from_rows(
        name,
        np.concatenate(frames),
        np.concatenate(ids),
        np.concatenate(positions),
        dt=frame_dt,
        picture=Picture(*render_map(scenario.map)),
    ).regular()
    _require_scene(recording)
    return recording


def _require_scene(recording: Recording) -> None:
    for row in recording.windows(SCENE_STEPS - 1, 1):
        if recording.valid[row : row + SCENE_STEPS].all(axis=0).any():
            return
    raise ValueError(
        f"{recording.name}: expected somebody seen for {SCENE_STEPS} rows on end, found nobody"
    )


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What a data set is made of; with it every recording can be drawn alone.

    Attributes:
        scenarios: Names in `SCENARIOS`, or `mixed`; recording i takes number i, in a circle.
        recordings: Number of recordings.
        seconds: Length of each [s].
        warmup: Time that passes before each begins [s].
        seed: Root of all draws.

    Raises:
        ValueError: An unknown scenario, or a number out of range.
    """

    scenarios: tuple[str, ...]
    recordings: int
    seconds: float
    warmup: float
    seed: int

    def __post_init__(self) -> None:
        known = (MIXED, *SCENARIOS)
        unknown = [name for name in self.scenarios if name not in known]
        if unknown or not self.scenarios:
            raise ValueError(f"scenarios must be among {', '.join(known)}, got {self.scenarios}")
        if self.recordings < 1:
            raise ValueError(f"expected at least one recording, got {self.recordings}")
        if self.seconds < SCENE_STEPS * FRAME_DT or self.warmup < 0.0:
            raise ValueError(
                f"a recording must last at least {SCENE_STEPS * FRAME_DT:.0f} s after a warm-up of "
                f"at least 0 s, got {self.seconds} and {self.warmup}"
            )
        if self.seed < 0:
            raise ValueError(f"seed must be at least 0, got {self.seed}")

    def make(self, index: int) -> Recording:
        """Simulate recording number `index`; depends on nothing but the plan and the number."""
        scenario_rng, world_rng = (
            np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(index, stream)))
            for stream in range(2)
        )
        name, parameters = self.scenarios[index % len(self.scenarios)], dict[str, Any]()
        if name == MIXED:
            name, parameters = draw_mixed(scenario_rng)
        return record(
            make_scenario(name, scenario_rng, **parameters),
            world_rng,
            name=f"{name}-{index:05d}",
            seconds=self.seconds,
            warmup=self.warmup,
        )


def generate_dataset(
    out: Path | str,
    *,
    scenarios: Sequence[str] = (MIXED,),
    hours: float = 1.0,
    seconds: float = 60.0,
    warmup: float = 4.0,
    seed: int = 0,
    workers: int = 1,
    progress: bool = True,
) -> dict[str, float]:
    """Simulate crowds and store them; read them back with `read_recordings`.

    Args:
        out: Folder of the data set; must not hold one yet.
        scenarios: Names in `SCENARIOS`, or `mixed`.
        hours: Simulated time altogether [h]; rounded up to whole recordings.
        seconds: Length of one recording [s].
        warmup: Time that passes before each recording begins [s].
        seed: Root of all draws.
        workers: Processes; the bytes do not depend on it.
        progress: Whether to show a bar on stderr.

    Returns:
        Number of recordings, tracks and rows (positions), and the mean speed [m/s].

    Raises:
        FileExistsError: The folder holds a data set already.
        ValueError: A parameter is out of range, or a crowd came out empty or does not walk.
    """
    out = Path(out)
    require_no_dataset(out)
    if workers < 1:
        raise ValueError(f"workers must be at least 1, got {workers}")
    plan = Plan(
        scenarios=tuple(scenarios),
        recordings=math.ceil(hours * 3600.0 / seconds - 1e-9),
        seconds=seconds,
        warmup=warmup,
        seed=seed,
    )
    tasks = [(plan, out, shard) for shard in range(math.ceil(plan.recordings / PER_SHARD))]
    entries, counts = [], []
    with tqdm(total=plan.recordings, unit="recording", disable=not progress) as bar:
        for entry, count in _run(tasks, min(workers, len(tasks))):
            entries.append(entry)
            counts.append(count)
            bar.update(len(entry["recordings"]))
    summary = _summary(np.concatenate(counts))
    write_manifest(out, entries, {"plan": _json_plan(plan), "summary": summary})
    return summary


Task = tuple[Plan, Path, int]
Done = tuple[dict[str, Any], NDArray[np.float64]]


def _run(tasks: Sequence[Task], workers: int) -> Iterator[Done]:
    if workers == 1:
        yield from map(_make_shard, tasks)
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context, initializer=_take_one_thread) as pool:
        yield from pool.map(_make_shard, tasks)


def _take_one_thread() -> None:
    cv2.setNumThreads(1)


def _make_shard(task: Task) -> Done:
    """Simulate and store one shard; returns its manifest entry and (R, 3) tracks, rows, speed."""
    plan, out, shard = task
    numbers = range(shard * PER_SHARD, min((shard + 1) * PER_SHARD, plan.recordings))
    recordings = [plan.make(index) for index in numbers]
    counts = [(len(part.ids), part.valid.sum(), part.mean_speed) for part in recordings]
    return write_shard(out, shard, recordings), np.array(counts, dtype=np.float64)


def _summary(counts: NDArray[np.float64]) -> dict[str, float]:
    """Totals; refuses a data set in which people do not walk at a human pace."""
    tracks, rows = counts[:, :2].sum(axis=0).tolist()
    speed = float(np.average(counts[:, 2], weights=counts[:, 1]))
    if not SPEED_RANGE[0] <= speed <= SPEED_RANGE[1]:
        raise ValueError(
            f"expected a crowd that walks at {SPEED_RANGE[0]}-{SPEED_RANGE[1]} m/s, "
            f"found a mean speed of {speed:.2f} m/s"
        )
    return {
        "recordings": len(counts),
        "tracks": int(tracks),
        "rows": int(rows),
        "mean_speed": round(speed, 4),
    }


def _json_plan(plan: Plan) -> dict[str, Any]:
    return {**vars(plan), "scenarios": list(plan.scenarios)}
