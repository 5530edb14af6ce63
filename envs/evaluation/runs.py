"""Runs episodes of one policy in one configuration side by side and keeps their traces."""

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from envs.config import CrowdNavConfig
from envs.episodes import Episodes
from envs.evaluation.branches import Branches
from envs.policies import make_policy
from envs.trace import Trace


def run_episodes(
    config: CrowdNavConfig,
    policy: str,
    seeds: Sequence[int],
    width: int,
    *,
    branched: bool = False,
) -> Iterator[tuple[int, Trace]]:
    """Runs one episode per seed, each as `env.reset(seed=seed)` would start it.

    Neither the order nor `width` changes an episode.

    Args:
        config: The environment.
        policy: What `envs.policies.make_policy` takes.
        seeds: Seeds of the episodes.
        width: How many episodes run side by side.
        branched: Whether the traces have branches.

    Yields:
        Seed and trace of every episode, in the order in which they end.
    """
    running = list(seeds[:width])
    waiting = deque(seeds[width:])
    episodes = Episodes(config, len(running), record=True)
    driver = make_policy(policy, config)
    observation = episodes.reset([np.random.default_rng(seed) for seed in running])
    driver.reset()
    branches = Branches(episodes) if branched else None
    if branches is not None:
        for world in range(len(running)):
            branches.restart(world)
    left = len(seeds)
    unfinished = np.ones(len(running), dtype=np.bool_)
    while True:
        observation = episodes.step(driver.act(observation)).observation
        traces = episodes.pop_traces()
        for world, trace in traces.items():
            if unfinished[world]:
                own = () if branches is None else branches.of(world)
                yield running[world], replace(trace, branches=own)
                left -= 1
            # With nothing left to run the world repeats its episode, and nobody looks at it.
            unfinished[world] = bool(waiting)
            running[world] = waiting.popleft() if waiting else running[world]
        if left == 0:
            return
        if traces:
            ended = list(traces)
            fresh = episodes.reset([np.random.default_rng(running[w]) for w in ended], ended)
            for key, values in fresh.items():
                observation[key][ended] = values
            driver.reset(np.isin(np.arange(len(running)), ended))
        if branches is not None:
            for world in np.flatnonzero(unfinished).tolist():
                (branches.restart if world in traces else branches.advance)(world)


def run_episode(config: CrowdNavConfig, policy: str, seed: int) -> Trace:
    """Runs and records a single episode."""
    return next(run_episodes(config, policy, [seed], width=1))[1]
