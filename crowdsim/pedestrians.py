"""A crowd's initial conditions: who stands where, and where and how fast they want to go."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crowdsim.motion import ModelChoice, MotionModel, draw_models

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

ALONE = -1
"""Group of who has none."""

_BROADCAST = ("model", "notices_robot", "group")
"""Columns for which one value for all will do."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Pedestrians:
    """Struct of arrays, one row per pedestrian; N may be 0.

    Attributes:
        position: `(N, 2)` start [m].
        velocity: `(N, 2)` at the start [m/s].
        waypoints: `(N, G, 2)` points to walk to, in order; the last one is the goal [m].
        desired_speed: `(N,)` speed when nothing is in the way [m/s].
        relaxation_time: `(N,)` time in which that speed is taken up [s].
        radius: `(N,)` of the body [m].
        mass: `(N,)` [kg].
        notices_robot: `(N,)` whether they see a robot at all, and keep off it; all unless told.
        group: `(N,)` number of the group with which they walk, in consecutive rows; -1 (`ALONE`)
            for who is alone; all unless told.
        model: `(N,)` codes of `MotionModel`, by which each moves; the social force unless told.
    """

    position: FloatArray
    velocity: FloatArray
    waypoints: FloatArray
    desired_speed: FloatArray
    relaxation_time: FloatArray
    radius: FloatArray
    mass: FloatArray
    notices_robot: BoolArray = field(default_factory=lambda: np.array(True))
    group: IntArray = field(default_factory=lambda: np.array(ALONE))
    model: IntArray = field(default_factory=lambda: np.array(MotionModel.SOCIAL_FORCE))

    def __post_init__(self) -> None:
        """Refuse what the physics engine would silently accept.

        Raises:
            ValueError: if shapes do not agree, or values are not finite or not positive.
        """
        count = len(self.position)
        if self.waypoints.ndim != 3 or self.waypoints.shape[1] < 1:
            raise ValueError(
                f"waypoints: expected shape ({count}, G, 2) with G >= 1, "
                f"found {self.waypoints.shape}"
            )
        for name in _BROADCAST:
            if getattr(self, name).ndim == 0:
                object.__setattr__(self, name, np.full(count, getattr(self, name)))
        goals = self.waypoints.shape[1]
        shapes = {"position": (count, 2), "velocity": (count, 2), "waypoints": (count, goals, 2)}
        for name in (column.name for column in fields(self)):
            _check_column(name, getattr(self, name), shapes.get(name, (count,)))
        for name in ("relaxation_time", "radius", "mass"):
            if (getattr(self, name) <= 0).any():
                raise ValueError(f"{name}: expected > 0, found {getattr(self, name).min()}")
        if (self.desired_speed < 0).any():
            raise ValueError(f"desired_speed: expected >= 0, found {self.desired_speed.min()}")
        _refuse_scattered_groups(self.group)
        if not np.isin(self.model, list(MotionModel)).all():
            raise ValueError(f"model: expected codes of MotionModel, found {np.unique(self.model)}")

    def __len__(self) -> int:
        return len(self.position)

    @classmethod
    def draw(
        cls,
        rng: np.random.Generator,
        *,
        position: ArrayLike,
        waypoints: ArrayLike,
        desired_speed: ArrayLike | None = None,
        radius: ArrayLike | None = None,
        relaxation_time: ArrayLike | None = None,
        mass: ArrayLike | None = None,
        model: ModelChoice = "social_force",
        group: ArrayLike = ALONE,
    ) -> Pedestrians:
        """Draw adults who are already walking towards their first waypoint.

        Desired speeds are normal with mean 1.34 and deviation 0.26 m/s (Weidmann 1993), clipped
        to 0.5 to 2.2 m/s. Radii are uniform in 0.2 to 0.3 m. Relaxation times are normal with mean
        0.5 s (Helbing and Molnár 1995), clipped to 0.35 to 0.65 s; nobody has measured how far
        people differ in it, the deviation of 0.05 s is the uncertainty of the 0.54 s of Moussaïd
        et al. 2009. Masses are normal with mean 73.5 and deviation 10 kg, clipped to 45 to 110 kg:
        half men of 80 ± 8, half women of 67 ± 6.7 kg, the body types of the simulator
        crowddynamics.

        Each aspect has a random stream of its own, so that adding a pedestrian or giving the
        speeds changes no other draw. Members of a group walk at their mean desired speed.

        Args:
            rng: source of all draws.
            position: `(N, 2)` starts [m].
            waypoints: `(N, G, 2)`, or `(N, 2)` for a single goal each [m].
            desired_speed: `(N,)` or one for all [m/s], instead of drawn ones.
            radius: `(N,)` or one for all [m], instead of drawn ones.
            relaxation_time: `(N,)` or one for all [s], instead of drawn ones.
            mass: `(N,)` or one for all [kg], instead of drawn ones.
            model: the motion model of all, or the share of each (see `draw_models`).
            group: `(N,)` who walks with whom (see `draw_groups`), or `ALONE` for all.

        Raises:
            ValueError: if the arrays do not agree in shape or are not finite, or a model is
                unknown.
        """
        start = np.array(position, dtype=np.float64).reshape(-1, 2)
        route = np.array(waypoints, dtype=np.float64)
        route = route[:, None, :] if route.ndim == 2 else route  # (N, G, 2)
        speed_rng, radius_rng, model_rng, relaxation_rng, mass_rng = rng.spawn(5)
        if desired_speed is None:
            desired_speed = np.clip(speed_rng.normal(1.34, 0.26, len(start)), 0.5, 2.2)
        if radius is None:
            radius = radius_rng.uniform(0.2, 0.3, len(start))
        if relaxation_time is None:
            relaxation_time = np.clip(relaxation_rng.normal(0.5, 0.05, len(start)), 0.35, 0.65)
        if mass is None:
            mass = np.clip(mass_rng.normal(73.5, 10.0, len(start)), 45.0, 110.0)
        together = np.broadcast_to(np.asarray(group, dtype=np.int64), (len(start),)).copy()
        speed = _shared(_column(desired_speed, len(start)), together)
        return cls(
            position=start,
            velocity=speed[:, None] * _unit(route[:, 0] - start),
            waypoints=route,
            desired_speed=speed,
            relaxation_time=_column(relaxation_time, len(start)),
            radius=_column(radius, len(start)),
            mass=_column(mass, len(start)),
            group=together,
            model=draw_models(model_rng, len(start), model),
        )


def _column(value: ArrayLike, count: int) -> FloatArray:
    return np.broadcast_to(np.asarray(value, dtype=np.float64), (count,)).copy()


def _shared(values: FloatArray, group: IntArray) -> FloatArray:
    """Give the members of each group the mean of their values `(N,)`."""
    shared = values.copy()
    for number in np.unique(group[group != ALONE]):
        shared[group == number] = values[group == number].mean()
    return shared


def _refuse_scattered_groups(group: IntArray) -> None:
    starts = group[np.flatnonzero(np.diff(group, prepend=ALONE - 1))]
    numbers, runs = np.unique(starts[starts != ALONE], return_counts=True)
    if (runs > 1).any():
        raise ValueError(
            f"group: expected consecutive rows for the members of each, "
            f"found those of {numbers[runs.argmax()]} in {runs.max()} places"
        )


def _unit(vectors: FloatArray) -> FloatArray:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    unit: FloatArray = np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)
    return unit


def _check_column(name: str, values: FloatArray, shape: tuple[int, ...]) -> None:
    if values.shape != shape:
        raise ValueError(f"{name}: expected shape {shape}, found {values.shape}")
    if not np.isfinite(values).all():
        raise ValueError(f"{name}: expected finite values, found NaN or infinity")
