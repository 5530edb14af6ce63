"""Episodes that are worth a look, run once more and kept whole."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from envs.evaluation.episode_rows import Row
from envs.trace import Trace


@dataclass(frozen=True, kw_only=True)
class RecordedEpisode:
    """An episode kept whole.

    Attributes:
        scenario: Name of the scenario.
        arm: Name of the arm.
        seed: Seed of the episode.
        trace: What happened.
    """

    scenario: str
    arm: str
    seed: int
    trace: Trace


def instructive_seeds(rows: Sequence[Row], candidates: Sequence[int], count: int) -> list[int]:
    """Chooses the seeds of one scenario whose arms ended most differently.

    A seed that one arm fails and another masters says more than one that all master.

    Args:
        rows: Episodes of all arms in this scenario.
        candidates: Seeds to choose among; with equal variety the first ones are taken.
        count: How many to choose.
    """
    endings = {seed: {_ending(row) for row in rows if row["seed"] == seed} for seed in candidates}
    by_variety = sorted(candidates, key=lambda seed: -len(endings[seed]))
    return sorted(by_variety[:count])


def instructive_failure(points: Sequence[Sequence[Row]]) -> Row | None:
    """Chooses a failure of one arm where turning a knob breaks it.

    That is the value at which success falls most below that of the value before; among its
    failures one whose seed the arm had mastered there says most.

    Args:
        points: Episodes of the arm at every value of the knob, in its order.

    Returns:
        The episode; None where the arm never failed.
    """
    success = [sum(bool(row["success"]) for row in rows) / len(rows) for rows in points]
    falls = [0.0, *(before - after for before, after in pairwise(success))]
    place = falls.index(max(falls))
    failed = [row for row in points[place] if not row["success"]]
    before = points[place - 1] if place > 0 else ()
    mastered = {row["seed"] for row in before if row["success"]}
    return next((row for row in failed if row["seed"] in mastered), next(iter(failed), None))


def _ending(row: Row) -> str:
    """How an episode ended, as one word."""
    endings = ("success", "collision_pedestrian", "collision_wall", "timeout")
    return next(name for name in endings if row[name])
