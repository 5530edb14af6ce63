"""The single environment: one episode behind Gymnasium's five methods."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.utils import EzPickle
from numpy.typing import ArrayLike, NDArray

from envs.config import make_config
from envs.episodes import Episodes, StepResult
from envs.observation import Observation, flattened, flattened_space
from envs.rendering import render_world
from envs.robots import action_space
from envs.trace import Trace


class CrowdNav(gymnasium.Env[Observation, NDArray[np.float32]], EzPickle):
    """A robot on its way through a crowd that reacts to it.

    Keywords are the fields of `envs.config.CrowdNavConfig`, `render_mode` and `record`.

    * **Observation**: a flat Dict of Boxes in the robot's frame, see `envs.observation`.
    * **Action**: (2,) in [-1, 1]. `unicycle`: speed (from 0 to `max_speed`) and angular speed.
      `holonomic`: velocity ahead and to the left, shortened to the unit disc. `bicycle`: speed and
      steering angle. Values beyond are clipped; a value that is not finite is a ValueError.
    * **Reward**: the sum of the terms in `info["rewards"]`, see `envs.rewards`.
    * **Start**: drawn by the scenario from `np_random`; a seed fixes every bit that follows.
    * **Terminated**: the robot touched a person or a wall, or reached its goal; in a mission, the
      one at which it ends.
    * **Truncated**: the time limit, in a mission that of the present way, has passed.
    * **Info**: `rewards`; at the end also `is_success`, `termination_reason` (goal,
      collision_pedestrian, collision_wall, timeout) and `forecast_seconds`, the mean wall-clock
      time of a forecast in this episode.

    A copy or pickle is a new environment of the same configuration that waits for its reset.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 5}  # noqa: RUF012
    flat = False

    def __init__(self, *, render_mode: str | None = None, record: bool = False, **keywords: Any):
        """Builds the environment; `record` keeps a `Trace` of every episode.

        Raises:
            ValueError: An unknown keyword or a bad value.
        """
        EzPickle.__init__(self, render_mode=render_mode, record=record, **keywords)
        config = make_config(**keywords)
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise ValueError(f"render_mode must be None or 'rgb_array', got {render_mode!r}")
        self.metadata = self.metadata | {"render_fps": round(1.0 / config.policy_dt)}
        self.render_mode = render_mode
        self.episodes = Episodes(config, 1, record=record)
        space = self.episodes.observer.space
        self.observation_space: spaces.Dict = flattened_space(space) if self.flat else space  # type: ignore[assignment]
        self.action_space: spaces.Box = action_space(config)  # type: ignore[assignment]
        self._trace: Trace | None = None

    @property
    def trace(self) -> Trace:
        """Trace of the last episode that ended.

        Raises:
            RuntimeError: None has ended, or the environment was made without `record=True`.
        """
        if self._trace is None:
            raise RuntimeError("expected record=True and an episode that has ended, found neither")
        return self._trace

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Starts an episode; see `gymnasium.Env.reset`. There are no options."""
        super().reset(seed=seed)
        observation = self.episodes.reset([self.np_random])
        return self._single(observation), {}

    def step(self, action: ArrayLike) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Runs one policy period; see `gymnasium.Env.step`.

        Raises:
            ValueError: The action has the wrong shape, is not of real numbers, or not finite.
        """
        result = self.episodes.step(np.asarray(action)[None])
        self._trace = self.episodes.pop_traces().get(0, self._trace)
        return (
            self._single(result.observation),
            float(result.reward[0]),
            bool(result.terminated[0]),
            bool(result.truncated[0]),
            step_info(result, 0),
        )

    def render(self) -> NDArray[np.uint8] | None:
        """Returns the (H, W, 3) RGB picture of the moment, or None without a render mode."""
        if self.render_mode is None:
            return None
        return render_world(self.episodes, 0)

    def _single(self, observation: Observation) -> Observation:
        single = {key: values[0] for key, values in observation.items()}
        return flattened(single, leading=0) if self.flat else single


class CrowdNavFlat(CrowdNav):
    """`CrowdNav` with every key of the observation flattened to one dimension."""

    flat = True


def step_info(result: StepResult, world: int) -> dict[str, Any]:
    """Returns the info of one world's step."""
    info: dict[str, Any] = {
        "rewards": {name: float(values[world]) for name, values in result.rewards.items()}
    }
    reason = result.reason[world]
    if reason is not None:
        info["is_success"] = reason == "goal"
        info["termination_reason"] = reason
        info["forecast_seconds"] = float(result.forecast_seconds[world])
    return info
