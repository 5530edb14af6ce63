"""Every case with the band in which its value is to lie."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import counterflow
import evacuation
import flow
import walks

INF = float("inf")


FIRST_SEED = 100
"""Parameters were chosen on smaller seeds; what is reported is none of those."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One value of the simulator and the band that literature or measurements give it.

    Attributes:
        name: of the case.
        value: what is measured, with its unit.
        low: least value that passes.
        high: greatest.
        measure: seed -> value.
        seeds: how many are run, from `FIRST_SEED` on.
        needed: how many of them have to lie in the band; None is all.
        miss: why the case is known to miss its band; empty if it holds.
    """

    name: str
    value: str
    low: float = -INF
    high: float = INF
    measure: Callable[[int], float]
    seeds: int = 5
    needed: int | None = None
    miss: str = ""

    @property
    def wanted(self) -> int:
        """Seeds that have to lie in the band."""
        return self.seeds if self.needed is None else self.needed

    @cached_property
    def values(self) -> list[float]:
        """The value for each seed."""
        return [self.measure(seed) for seed in range(FIRST_SEED, FIRST_SEED + self.seeds)]

    def hits(self) -> int:
        """How many seeds lie in the band."""
        return sum(self.low <= value <= self.high for value in self.values)


def _flow(width):
    return lambda seed: flow.bottleneck(seed, width)[0]


def _stuck(seed):
    return sum(flow.bottleneck(seed, width)[1] for width in flow.DOORS)


CASES = (
    Case(
        name="RiMEA 1: 40 m of corridor at 1.33 m/s",
        value="time [s]",
        low=26.0,
        high=34.0,
        measure=walks.corridor_time,
    ),
    Case(
        name="RiMEA 1: the same corridor turned by 45°",
        value="difference [s]",
        high=0.1,
        measure=walks.turned_corridor,
    ),
    Case(
        name="Five people hidden behind a wall",
        value="sideways shift [m]",
        high=0.005,
        measure=walks.hidden_people,
    ),
    Case(
        name="Three overtake three in a corridor of 2.4 m",
        value="least gap between bodies [m]",
        low=0.0,
        measure=walks.overtaking,
    ),
    Case(
        name="Ten queue behind somebody slow",
        value="least gap between bodies [m]",
        low=-0.005,
        measure=walks.queueing,
    ),
    Case(
        name="RiMEA 6: 20 people round a corner",
        value="positions in the block, and people left behind",
        high=0,
        measure=walks.corner,
    ),
    Case(
        name="RiMEA 9: 1,000 people, two doors against four",
        value="ratio of times",
        low=1.6,
        high=2.4,
        measure=evacuation.door_ratio,
    ),
    Case(
        name="RiMEA 12: a jam before a passage, none before the door after it",
        value="time in the second room / free walk",
        high=2.0,
        measure=evacuation.second_room,
    ),
    Case(
        name="RiMEA 15: 150 people round a corner",
        value="mean time, 0 inner length straight on, 1 outer length",
        low=0.0,
        high=1.0,
        measure=evacuation.crowd_round_a_corner,
    ),
    *(
        Case(
            name=f"Bottleneck of {width} m",
            value="flow [1/s]",
            low=low - 0.5,
            high=high + 0.5,
            measure=_flow(width),
        )
        for width, low, high in flow.measured_flows()
    ),
    Case(
        name="Bottlenecks of 0.8, 1.0 and 1.2 m",
        value="people left after 120 s",
        high=0,
        measure=_stuck,
    ),
    Case(
        name="One-way corridor, 1.8 m",
        value="two-dimensional KS distance",
        high=0.35,
        measure=flow.one_way_distance,
    ),
    Case(
        name="One-way corridor against Weidmann's curve",
        value="RMSE of speed [m/s]",
        high=0.25,
        measure=flow.weidmann_error,
    ),
    Case(
        name="One-way corridor, largest specific flow",
        value="[1/(m s)]",
        low=1.2,
        high=2.0,
        measure=flow.largest_specific_flow,
    ),
    Case(
        name="Single file up to 1.8 /m",
        value="two-dimensional KS distance",
        high=0.35,
        measure=flow.single_file_distance,
    ),
    Case(
        name="Lanes in counterflow, 0.8 /m²",
        value="growth of lane order",
        low=0.01,
        measure=counterflow.growth_of_lanes,
        seeds=10,
        needed=9,
    ),
    Case(
        name="Counterflow at 2 /m² (measured at 1.75 to 2.25 /m²)",
        value="mean speed [m/s]",
        low=0.41,
        high=0.88,
        measure=counterflow.counterflow_speed,
        miss="in one seed 0.03 m/s below the slowest measured",
    ),
    Case(
        name="Faster is slower, door of 1 m",
        value="s lost at the ends against the best between",
        low=0.5,
        measure=evacuation.fastest_interior,
        miss=(
            "bodies slide along each other without friction, so nobody arches before the door; "
            "with as much friction as it takes (coefficient 0.5 and more) doors of 0.8 m jam "
            "for good"
        ),
    ),
)
