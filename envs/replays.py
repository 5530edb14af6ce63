"""Episodes that are worth a look, run once more and kept whole."""

from collections.abc import Sequence
from dataclasses import dataclass

from envs.episode_rows import Row
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


def _ending(row: Row) -> str:
    """How an episode ended, as one word."""
    endings = ("success", "collision_pedestrian", "collision_wall", "timeout")
    return next(name for name in endings if row[name])
