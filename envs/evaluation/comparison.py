"""What an evaluation compares: arms, scenarios and seeds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from envs.config import CrowdNavConfig, make_config
from envs.evaluation.summary import ALL_SCENARIOS

VISIBILITY_NAMES: Final = {True: "visible", False: "invisible"}
"""What a scenario is called by whether people see the robot."""


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
        variant: What tells it from others of the same title; "" where nothing does.
    """

    scenario: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    settings: Mapping[str, Any] = field(default_factory=dict)
    title: str = ""
    variant: str = ""

    @property
    def place(self) -> str:
        """Name without the variant; a scenario file goes by its name without folder and ending."""
        return self.title if self.title else Path(self.scenario).stem

    @property
    def name(self) -> str:
        """Name in tables."""
        return f"{self.place}, {self.variant}" if self.variant else self.place


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
        twins: Whether forecast errors are split by twin rollouts (`envs.evaluation.robot_part`).
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


def cross(
    policies: Sequence[str], forecasters: Sequence[str], horizons: Sequence[float] | None = None
) -> tuple[Arm, ...]:
    """Every policy with every forecaster, each arm once.

    Args:
        policies: What `envs.policies.make_policy` takes; `POLICY:FORECASTER` goes with that
            forecaster only.
        forecasters: What `CrowdNavConfig.forecaster` takes.
        horizons: How far forecasts reach [s], an arm each; 0 is the policy without forecasts. The
            environment's if None.
    """
    arms: list[Arm] = []
    for spec in policies:
        policy, _, own = spec.partition(":")
        for forecaster in (own,) if own else forecasters:
            found = _at_horizons(policy, forecaster, horizons)
            arms += [arm for arm in found if arm not in arms]
    return tuple(arms)


def variants(
    choice: ScenarioChoice,
    models: Sequence[str] | None = None,
    robot_visible: Sequence[bool] | None = None,
) -> tuple[ScenarioChoice, ...]:
    """A scenario with people of every motion model, each with the robot visible and invisible.

    Args:
        choice: The scenario.
        models: Names of motion models; the scenario's own if None.
        robot_visible: Values of that keyword of `CrowdNavConfig`; the environment's if None.
    """
    crowds = [choice]
    if models is not None:
        crowds = [
            replace(choice, parameters={**choice.parameters, "model": model}, variant=model)
            for model in models
        ]
    if robot_visible is None:
        return tuple(crowds)
    return tuple(
        replace(
            crowd,
            settings={**crowd.settings, "robot_visible": visible},
            variant=", ".join(filter(None, (crowd.variant, VISIBILITY_NAMES[visible]))),
        )
        for crowd in crowds
        for visible in robot_visible
    )


def _at_horizons(policy: str, forecaster: str, horizons: Sequence[float] | None) -> list[Arm]:
    """One pair of policy and forecaster at every horizon."""
    arm = Arm(policy=policy, forecaster=forecaster)
    if forecaster == "none" or horizons is None:
        return [arm]
    return [
        replace(arm, settings={"horizon": horizon}, title=f"{arm.name} {horizon:g} s")
        if horizon
        else replace(arm, forecaster="none")
        for horizon in horizons
    ]
