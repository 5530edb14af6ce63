"""The crowd simulator beside other ones: the same people, the same walls, the same minutes."""

import itertools
import time
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from crowdsim.motion import MODEL_NAMES
from scripts.benchmarks import crowd
from scripts.benchmarks.peers import INSTALL, PEERS, Peer, installed_version
from scripts.benchmarks.timing import seconds_in_turn

Rows = list[dict[str, Any]]

SETTLE_SECONDS: Final = 5.0
"""Slow peers settle for so long by the clock, not for `crowd.SETTLE_STEPS`."""
SANE_SPEED: Final = (0.2, 2.5)
"""Mean speed of a crowd whose time is worth something [m/s]."""


def crowd_peers(seed: int) -> dict[str, Rows]:
    """Measure our models and each installed peer in turn, so that ratios survive a noisy machine.

    A step includes reading back all positions and velocities.

    Returns:
        `crowd`: as `crowd.crowd`. `crowd_peers`: rows with `peer`, `n`, `walls`, `version`, `dt`
        [s], `steps_per_s`, `pedestrian_steps_per_s`, `mean_speed` [m/s] as the proof of motion;
        for a peer that is missing, how to install it. `crowd_ratios`: rows with `n`, `walls`,
        `fastest_peer` and `ratio`, how many times its pedestrian-steps the default model makes:
        the median of paired repeats.

    Raises:
        RuntimeError: A peer's crowd stands still or flies: its time would mean nothing.
    """
    missing = [name for name in PEERS if installed_version(name) is None]
    tables: dict[str, Rows] = {"crowd": [], "crowd_peers": [], "crowd_ratios": []}
    settings = list(itertools.product((False, True), crowd.COUNTS))
    for walls, count in tqdm(settings, unit="crowd", leave=False):
        for table, rows in _measure(count, walls, seed).items():
            tables[table] += rows
    tables["crowd"].sort(key=lambda row: MODEL_NAMES.index(row["model"]))
    tables["crowd_peers"] += [{"peer": name, "missing": INSTALL} for name in missing]
    return tables


def _measure(count: int, walls: bool, seed: int) -> dict[str, Rows]:
    own = [crowd.own_step(count, walls, model, seed) for model in MODEL_NAMES]
    peers = {
        name: settled(peer(crowd.counterflow(count, walls, "social_force", seed)))
        for name, (_, peer) in PEERS.items()
        if installed_version(name) is not None
    }
    seconds = seconds_in_turn([*own, *(peer.step for peer in peers.values())])
    ours, theirs = seconds[: len(own)], dict(zip(peers, seconds[len(own) :], strict=True))
    return {
        "crowd": [
            crowd.crowd_row(count, walls, model, float(np.median(row)))
            for model, row in zip(MODEL_NAMES, ours, strict=True)
        ],
        "crowd_peers": [
            _peer_row(count, walls, name, peer, float(np.median(theirs[name])))
            for name, peer in peers.items()
        ],
        "crowd_ratios": ratios(count, walls, ours[0], theirs),
    }


def settled(peer: Peer) -> Peer:
    """The peer, once its people have met."""
    start = time.perf_counter()
    for _ in range(crowd.SETTLE_STEPS):
        peer.step()
        if time.perf_counter() - start > SETTLE_SECONDS:
            break
    return peer


def mean_speed(peer: Peer) -> float:
    """Mean distance walked in a step over its time [m/s].

    Raises:
        RuntimeError: It is not that of a walking crowd.
    """
    before, _ = peer.step()
    after, _ = peer.step()
    speed = float(np.linalg.norm(after - before, axis=1).mean() / peer.dt)
    least, most = SANE_SPEED
    if not least <= speed <= most:
        raise RuntimeError(
            f"{type(peer).__name__}: expected a crowd that walks at {least} to {most} m/s, "
            f"found {speed:.2f} m/s"
        )
    return speed


def _peer_row(count: int, walls: bool, name: str, peer: Peer, seconds: float) -> dict[str, Any]:
    return {
        "peer": name,
        "n": count,
        "walls": walls,
        "version": installed_version(name),
        "dt": peer.dt,
        **crowd.rates(count, seconds),
        "mean_speed": round(mean_speed(peer), 2),
    }


def ratios(
    count: int, walls: bool, ours: NDArray[np.float64], theirs: dict[str, NDArray[np.float64]]
) -> Rows:
    """One row, or none without a peer; times (`REPEATS`,) of our default model and of each peer."""
    if not theirs:
        return []
    fastest = min(theirs, key=lambda name: float(np.median(theirs[name])))
    ratio = float(np.median(theirs[fastest] / ours))
    return [{"n": count, "walls": walls, "fastest_peer": fastest, "ratio": round(ratio, 2)}]
