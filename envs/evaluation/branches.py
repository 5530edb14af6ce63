"""What would have happened without the robot, from several moments of running episodes on."""

from envs.episodes import Episodes
from envs.evaluation.twin import branch_off
from envs.trace import Branch

INTERVAL = 4.8
"""Episodes are branched off when histories can be full and this often [s] from then on.

Not at the start, where forecasts know a single frame: each episode would count one such moment.
"""


class Branches:
    """Branches off W running episodes at every `INTERVAL`, for two rollouts each.

    Recorded people react to nobody: replays have no branches.
    """

    def __init__(self, episodes: Episodes):
        self._episodes = episodes
        config = episodes.config
        self._first = (config.history_steps - 1) * config.policy_steps_per_frame
        self._every = round(INTERVAL / config.policy_dt)
        self._row = [0] * len(episodes)
        self._branches: list[list[Branch]] = [[] for _ in range(len(episodes))]

    def restart(self, world: int) -> None:
        """Begins the episode of one world, which has been reset."""
        self._row[world] = 0
        self._branches[world] = []

    def advance(self, world: int) -> None:
        """Follows the episode of one world, which has been stepped and has not ended."""
        self._row[world] += 1
        since = self._row[world] - self._first
        if since >= 0 and since % self._every == 0:
            self._look(world)

    def of(self, world: int) -> tuple[Branch, ...]:
        """Returns the branches of the episode of one world so far."""
        return tuple(self._branches[world])

    def _look(self, world: int) -> None:
        config = self._episodes.config
        if config.forecaster == "none" or self._episodes.scenarios[world].replay is not None:
            return
        self._branches[world].append(
            branch_off(
                self._episodes.worlds.running(world),
                self._row[world],
                forecast_steps=config.forecast_steps,
                frame_dt=config.frame_dt,
            )
        )
