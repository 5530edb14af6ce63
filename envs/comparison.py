"""What an evaluation compares: arms, scenarios and seeds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from envs.config import CrowdNavConfig, make_config
from envs.summary import ALL_SCENARIOS


@dataclass(frozen=True, kw_only=True)
class Arm:
    """One of the things compared: a policy that is shown the forecasts of a forecaster.

    Attributes:
        policy: What `envs.policies.make_policy` takes.
        forecaster: What `CrowdNavConfig.forecaster` takes.
        settings: Further keywords of `CrowdNavConfig` that only this arm has.
        title: Name in tables; "" names it after policy and forecaster.
    """

    policy: str
    forecaster: str = "none"
    settings: Mapping[str, Any] = field(default_factory=dict)
    title: str = ""

    @property
    def name(self) -> str:
        """Name in tables; a policy or forecaster given as a path goes by its last part."""
        if self.title:
            return self.title
        return f"{Path(self.policy).name}/{Path(self.forecaster).name}"


@dataclass(frozen=True, kw_only=True)
class ScenarioChoice:
    """A scenario to evaluate in.

    Attributes:
        scenario: Name in `crowdsim.scenarios.SCENARIOS`, or a scenario file.
        parameters: Its keywords.
        settings: Further keywords of `CrowdNavConfig` that hold in this scenario.
        title: Name in tables; "" takes the scenario's.
    """

    scenario: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    settings: Mapping[str, Any] = field(default_factory=dict)
    title: str = ""

    @property
    def name(self) -> str:
        """Name in tables; a scenario file goes by its name without folder and ending."""
        return self.title if self.title else Path(self.scenario).stem


@dataclass(frozen=True, kw_only=True)
class EvaluationConfig:
    """What is compared, where, and how often.

    Attributes:
        arms: Each runs all episodes.
        scenarios: Where.
        seeds: One episode per seed, arm and scenario.
        reference: Name of the arm that differences are taken against; "" takes the first.
        environment: Keywords of `CrowdNavConfig` for all arms.
        workers: Processes; they change how long it takes and nothing else.
        width: Episodes side by side in a process; likewise.
        twins: Whether forecast errors are split by twin rollouts (`envs.robot_part`).
        replays: Seeds per scenario whose episodes the report plays.
        replay_candidates: Number of first seeds those are chosen among.
        statistics_seed: Seeds the bootstrap.

    Raises:
        ValueError: Nothing to compare, a name twice, an unknown reference, a count below 1, or a
            scenario named like the pool of all.
    """

    arms: tuple[Arm, ...]
    scenarios: tuple[ScenarioChoice, ...]
    seeds: tuple[int, ...]
    reference: str = ""
    environment: Mapping[str, Any] = field(default_factory=dict)
    workers: int = 1
    width: int = 8
    twins: bool = False
    replays: int = 1
    replay_candidates: int = 6
    statistics_seed: int = 0

    def __post_init__(self) -> None:
        for name, values in (
            ("arms", [arm.name for arm in self.arms]),
            ("scenarios", [choice.name for choice in self.scenarios]),
            ("seeds", list(self.seeds)),
        ):
            if not values or len(set(values)) < len(values):
                raise ValueError(f"{name}: expected at least one and each once, found {values}")
        if self.reference and self.reference not in [arm.name for arm in self.arms]:
            names = ", ".join(arm.name for arm in self.arms)
            raise ValueError(f"reference: expected one of {names}, found {self.reference!r}")
        if ALL_SCENARIOS in [choice.name for choice in self.scenarios]:
            raise ValueError(f"scenarios: expected other names than {ALL_SCENARIOS!r}, the pool")
        for name in ("workers", "width"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name}: expected at least 1, found {getattr(self, name)}")

    @property
    def reference_arm(self) -> str:
        """Name of the reference."""
        return self.reference if self.reference else self.arms[0].name

    def environment_of(self, arm: Arm, choice: ScenarioChoice) -> CrowdNavConfig:
        """The environment of one arm in one scenario."""
        return make_config(
            **{
                **self.environment,
                **choice.settings,
                **arm.settings,
                "forecaster": arm.forecaster,
                "scenario": choice.scenario,
                "scenario_parameters": dict(choice.parameters),
            }
        )


def cross(policies: Sequence[str], forecasters: Sequence[str]) -> tuple[Arm, ...]:
    """Every policy with every forecaster."""
    return tuple(
        Arm(policy=policy, forecaster=forecaster)
        for policy in policies
        for forecaster in forecasters
    )
