"""The optimal control problem of a plan among moving obstacles, and its solver.

Direct multiple shooting (Bock and Plitt 1984, "A multiple shooting algorithm for direct solution of
optimal control problems"), solved by FATROP (Vanroye et al. 2023, "FATROP: a fast constrained
optimal control problem solver for robot trajectory optimization and control") within CasADi, which
the extra `nmpc` installs. What a plan costs is, made smooth, what it costs the sampling planner.
"""

from __future__ import annotations

import math
from typing import Any

import casadi
import numpy as np
from numpy.typing import NDArray

from envs.policies.robot_motion import Limits
from envs.policies.rollouts import Costs

Floats = NDArray[np.float64]

ITERATIONS, TOLERANCE = 40, 1e-3
"""Of the solver."""

POSE, STATE, CONTROL = 3, 5, 2
"""Sizes: x, y, heading; these and the last control; a control."""


class Program:
    """The optimal control problem of one plan of H steps among M obstacles."""

    def __init__(self, limits: Limits, costs: Costs, steps: int, obstacles: int):
        self._limits, self._steps = limits, steps
        states = [casadi.MX.sym(f"state_{t}", STATE) for t in range(steps + 1)]
        controls = [casadi.MX.sym(f"control_{t}", CONTROL) for t in range(steps)]
        start = casadi.MX.sym("start", STATE)
        asked = casadi.MX.sym("asked", 2 + 6 * obstacles, steps)
        move, cost = motion(limits), step_cost(limits, costs, obstacles)
        rules: list[tuple[Any, float, float]] = []
        total = 0.0
        for t in range(steps):
            rules += [(states[t + 1] - move(states[t], controls[t]), 0.0, 0.0)]
            if t == 0:
                rules += [(states[0] - start, 0.0, 0.0)]
            rules += restrictions(states[t], controls[t], limits)
            total += cost(states[t], controls[t], states[t + 1], asked[:, t])
        target = states[-1][:2] - asked[:2, -1]
        total += costs.terminal * smooth_length(target)
        self._bounds = _bounds(limits, steps, rules)
        variables = [each for pair in zip(states, controls, strict=False) for each in pair]
        self._solver = casadi.nlpsol(
            "plan",
            "fatrop",
            {
                "x": casadi.vertcat(*variables, states[-1]),
                "p": casadi.vertcat(start, casadi.vec(asked)),
                "f": total,
                "g": casadi.vertcat(*(rule for rule, _, _ in rules)),
            },
            {
                "structure_detection": "auto",
                "equality": [
                    low == high for rule, low, high in rules for _ in range(rule.shape[0])
                ],
                "fatrop": {
                    "print_level": 0,
                    "max_iter": ITERATIONS,
                    "tol": TOLERANCE,
                    "mu_init": 1e-2,
                },
                "expand": True,
                "print_time": False,
                "error_on_fail": False,
            },
        )

    def solve(self, guess: Floats, asked: Floats) -> tuple[float, Floats]:
        """Improves a plan.

        Args:
            guess: (H + 1, 7) states, and the control that follows each of them.
            asked: (H, 2 + 6 M) targets and obstacles, as `step_cost` reads them.

        Returns:
            Its cost, infinite if it cannot be followed, and its controls (H, 2).
        """
        found = self._solver(
            x0=guess.ravel()[:-CONTROL],
            p=np.concatenate((guess[0, :STATE], asked.ravel())),
            **self._bounds,
        )
        values = np.append(np.asarray(found["x"]).ravel(), np.zeros(CONTROL))
        controls = values.reshape(self._steps + 1, -1)[:-1, STATE:]
        if not np.isfinite(values).all():
            return math.inf, np.zeros_like(controls)
        rules = np.asarray(found["g"]).ravel()
        excess = np.maximum(rules - self._bounds["ubg"], self._bounds["lbg"] - rules).max()
        return float(found["f"]) + 100.0 * max(float(excess) - TOLERANCE, 0.0), controls


def motion(limits: Limits) -> Any:
    """The function of a state and a control that gives the next state; see `advance`."""
    state, control = casadi.SX.sym("state", STATE), casadi.SX.sym("control", CONTROL)
    if limits.holonomic:
        pose = casadi.vertcat(state[:2] + limits.dt * control, state[2])
    else:
        middle = state[2] + 0.5 * limits.dt * control[1]
        way = limits.dt * control[0] * casadi.vertcat(casadi.cos(middle), casadi.sin(middle))
        pose = casadi.vertcat(state[:2] + way, state[2] + limits.dt * control[1])
    return casadi.Function("motion", [state, control], [casadi.vertcat(pose, control)])


def restrictions(state: Any, control: Any, limits: Limits) -> list[tuple[Any, float, float]]:
    """What a control must keep to after the last one: expressions and their bounds."""
    last, change = state[POSE:], limits.acceleration * limits.dt
    if limits.holonomic:
        gain = casadi.sumsqr(control - last)
        return [(gain, -math.inf, change**2), (casadi.sumsqr(control), -math.inf, limits.speed**2)]
    rules = [(control[0] - last[0], -change, change)]
    if limits.curvature < math.inf:
        most = limits.curvature * control[0]
        rules += [(control[1] - most, -math.inf, 0.0), (control[1] + most, 0.0, math.inf)]
    return rules


def step_cost(limits: Limits, costs: Costs, obstacles: int) -> Any:
    """The function of a state, a control, the next state and a row of parameters.

    The row holds the target, then of M obstacles the places, reaches and margins [m], and the
    weights of being near and in contact.
    """
    state, control = casadi.SX.sym("state", STATE), casadi.SX.sym("control", CONTROL)
    after, asked = casadi.SX.sym("after", STATE), casadi.SX.sym("asked", 2 + 6 * obstacles)
    target, place, reach, margin, weight = casadi.vertsplit(
        asked, np.cumsum([0, 2, 2 * obstacles, obstacles, obstacles, 2 * obstacles]).tolist()
    )
    rate = costs.distance * smooth_length(after[:2] - target)
    for m in range(obstacles):
        clearance = smooth_length(after[:2] - place[2 * m : 2 * m + 2]) - reach[m]
        near = casadi.fmax(0.0, (margin[m] - clearance) / (margin[m] - costs.slack))
        contact = casadi.fmax(0.0, 1.0 - clearance / costs.slack)
        rate += weight[2 * m] * near**2 + weight[2 * m + 1] * contact**2
    turning = limits.speed if limits.holonomic else limits.angular_speed
    jerk = (control - state[POSE:]) / np.array([limits.speed, turning])
    total = limits.dt * rate + costs.smoothness * casadi.sumsqr(jerk)
    return casadi.Function("step_cost", [state, control, after, asked], [total])


def smooth_length(vector: Any) -> Any:
    """Length of a vector, rounded off within a few centimetres of 0 [m]."""
    return casadi.sqrt(casadi.sumsqr(vector) + 1e-3)


def _bounds(limits: Limits, steps: int, rules: list[tuple[Any, float, float]]) -> dict[str, Floats]:
    """Bounds of the variables and of the rules."""
    turning = limits.speed if limits.holonomic else limits.angular_speed
    most = np.array([math.inf] * STATE + [limits.speed, turning])
    least = -most
    if not limits.holonomic:
        least[STATE] = 0.0
    wide = {
        side: np.concatenate([np.full(rule.shape[0], bound[k]) for rule, *bound in rules])
        for k, side in enumerate(("lbg", "ubg"))
    }
    return {
        "lbx": np.append(np.tile(least, steps), least[:STATE]),
        "ubx": np.append(np.tile(most, steps), most[:STATE]),
        **wide,
    }
