"""Data sets of simulated crowds, the same bytes however they are made.

Neither the number of worker processes nor how often the making was killed and resumed matters:
every recording is drawn from the plan and its own number alone.
"""

import math
from collections.abc import Generator, Mapping, Sequence
from concurrent.futures import as_completed
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
from tqdm import tqdm

from crowdsim.motion import ModelChoice, draw_models
from crowdsim.record import SCENE_STEPS, record
from crowdsim.recordings import FRAME_DT, Recording
from crowdsim.recordings.rate import SPEED_RANGE
from crowdsim.recordings.store import shard_name, write_shard
from crowdsim.scenarios import SCENARIOS, find_scenario, make_scenario
from crowdsim.scenarios.mixed import MIXED, draw_mixed
from crowdsim.scenarios.scenario_file import digest, is_scenario_file
from crowdsim.unfinished import Entry, claim, finish, standing, write_entry
from crowdsim.worker_pool import worker_pool

PER_SHARD: Final = 8
"""Recordings per file; a constant, so that the files do not depend on the workers."""


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What a data set is made of; with it every recording can be drawn alone.

    Attributes:
        scenarios: Names in `SCENARIOS`, scenario files, or `mixed`; recording i takes number i,
            in a circle.
        recordings: Number of recordings.
        seconds: Length of each [s].
        warmup: Time that passes before each begins [s].
        seed: Root of all draws.
        model: Motion model of all people, or the share of each; None leaves it to the scenario.

    Raises:
        ValueError: An unknown scenario or model, or a number out of range.
        FileNotFoundError: No such scenario file.
    """

    scenarios: tuple[str, ...]
    recordings: int
    seconds: float
    warmup: float
    seed: int
    model: ModelChoice | None = None

    def __post_init__(self) -> None:
        self._check_scenarios()
        if self.model is not None:
            draw_models(np.random.default_rng(0), 0, self.model)
        if self.recordings < 1:
            raise ValueError(f"expected at least one recording, got {self.recordings}")
        if self.seconds < SCENE_STEPS * FRAME_DT or self.warmup < 0.0:
            raise ValueError(
                f"a recording must last at least {SCENE_STEPS * FRAME_DT:.0f} s after a warm-up of "
                f"at least 0 s, got {self.seconds} and {self.warmup}"
            )
        if self.seed < 0:
            raise ValueError(f"seed must be at least 0, got {self.seed}")

    def _check_scenarios(self) -> None:
        named = [name for name in self.scenarios if not is_scenario_file(name)]
        known = (MIXED, *SCENARIOS)
        if not self.scenarios or not set(named) <= set(known):
            raise ValueError(f"scenarios must be among {', '.join(known)}, got {self.scenarios}")
        for name in set(self.scenarios) - set(named):
            find_scenario(name)

    @property
    def shards(self) -> int:
        """Number of files that the recordings lie in."""
        return math.ceil(self.recordings / PER_SHARD)

    def make(self, index: int) -> Recording:
        """Simulate recording number `index`; depends on nothing but the plan and the number."""
        scenario_rng, world_rng = (
            np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(index, stream)))
            for stream in range(2)
        )
        name = self.scenarios[index % len(self.scenarios)]
        parameters: dict[str, Any] = {} if self.model is None else {"model": self.model}
        if name == MIXED:
            scenario = draw_mixed(scenario_rng, **parameters)
            name = scenario.name
        else:
            scenario = make_scenario(name, scenario_rng, **parameters)
        return record(
            scenario,
            world_rng,
            name=f"{Path(name).stem}-{index:05d}",
            seconds=self.seconds,
            warmup=self.warmup,
        )

    def as_json(self) -> dict[str, Any]:
        """The plan as the manifest holds it, with the digests of the scenario files."""
        files = sorted({name for name in self.scenarios if is_scenario_file(name)})
        model = dict(self.model) if isinstance(self.model, Mapping) else self.model
        return {
            **vars(self),
            "scenarios": list(self.scenarios),
            "model": model,
            "files": {name: digest(name) for name in files},
        }


def generate_dataset(
    out: Path | str,
    *,
    scenarios: Sequence[str] = (MIXED,),
    hours: float = 1.0,
    seconds: float = 60.0,
    warmup: float = 4.0,
    seed: int = 0,
    model: ModelChoice | None = None,
    workers: int = 1,
    resume: bool = False,
    progress: bool = True,
) -> dict[str, float]:
    """Simulate crowds and store them; read them back with `read_recordings`.

    Args:
        out: Folder of the data set; must not hold one yet, unless `resume`.
        scenarios: Names in `SCENARIOS`, scenario files, or `mixed`.
        hours: Simulated time altogether [h]; rounded up to whole recordings.
        seconds: Length of one recording [s].
        warmup: Time that passes before each recording begins [s].
        seed: Root of all draws.
        model: Motion model of all people, or the share of each; None leaves it to the scenarios.
        workers: Processes; the bytes do not depend on it.
        resume: Whether to go on with what stands in `out`: shards whose checksums hold are kept.
        progress: Whether to show a bar on stderr.

    Returns:
        Number of recordings, tracks and rows (positions), and the mean speed [m/s].

    Raises:
        FileExistsError: The folder holds a data set already, and `resume` is false.
        ValueError: A parameter is out of range, what stands was begun with another plan, or a
            crowd came out empty or does not walk.
    """
    if workers < 1:
        raise ValueError(f"workers must be at least 1, got {workers}")
    out = Path(out)
    plan = Plan(
        scenarios=tuple(scenarios),
        recordings=math.ceil(hours * 3600.0 / seconds - 1e-9),
        seconds=seconds,
        warmup=warmup,
        seed=seed,
        model=model,
    )
    claim(out, plan.as_json(), resume=resume)
    entries = _make_missing(plan, out, workers, progress=progress)
    summary = _summary(entries)
    finish(out, entries, {"plan": plan.as_json(), "summary": summary})
    return summary


def _make_missing(plan: Plan, out: Path, workers: int, *, progress: bool) -> list[Entry]:
    """Make the shards that do not stand yet; entries of all, in their order."""
    names = [shard_name(shard) for shard in range(plan.shards)]
    entries = standing(out)
    made = sum(len(entry["recordings"]) for entry in entries.values())
    tasks = [(plan, out, shard) for shard, name in enumerate(names) if name not in entries]
    with (
        tqdm(total=plan.recordings, initial=made, unit="recording", disable=not progress) as bar,
        closing(_run(tasks, workers)) as finished,
    ):
        for entry in finished:
            entries[entry["file"]] = entry
            bar.update(len(entry["recordings"]))
    return [entries[name] for name in names]


Task = tuple[Plan, Path, int]


def _run(tasks: Sequence[Task], workers: int) -> Generator[Entry]:
    """Do the tasks, in this process or in others, in any order; an interrupt ends all at once."""
    if workers == 1 or len(tasks) < 2:
        yield from map(_make_shard, tasks)
        return
    with worker_pool(min(workers, len(tasks)), cv2.setNumThreads, 1) as pool:
        futures = [pool.submit(_make_shard, task) for task in tasks]
        for future in as_completed(futures):
            yield future.result()


def _make_shard(task: Task) -> Entry:
    """Simulate and store one shard; returns its manifest entry, with counts per recording."""
    plan, out, shard = task
    numbers = range(shard * PER_SHARD, min((shard + 1) * PER_SHARD, plan.recordings))
    recordings = [plan.make(index) for index in numbers]
    counts = [(len(part.ids), int(part.valid.sum()), part.mean_speed) for part in recordings]
    tracks, rows, speeds = (list(column) for column in zip(*counts, strict=True))
    entry = write_shard(out, shard, recordings)
    entry |= {"tracks": tracks, "rows": rows, "mean_speed": speeds}
    write_entry(out, entry)
    return entry


def _summary(entries: Sequence[Entry]) -> dict[str, float]:
    """Totals; refuses a data set in which people do not walk at a human pace."""
    tracks, rows, speeds = (
        np.concatenate([entry[key] for entry in entries])
        for key in ("tracks", "rows", "mean_speed")
    )
    speed = float(np.average(speeds, weights=rows))
    if not SPEED_RANGE[0] <= speed <= SPEED_RANGE[1]:
        raise ValueError(
            f"expected a crowd that walks at {SPEED_RANGE[0]}-{SPEED_RANGE[1]} m/s, "
            f"found a mean speed of {speed:.2f} m/s"
        )
    return {
        "recordings": len(rows),
        "tracks": int(tracks.sum()),
        "rows": int(rows.sum()),
        "mean_speed": round(speed, 4),
    }
