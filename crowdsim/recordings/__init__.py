"""Recorded crowds, real or simulated: what they are, their store, and readers of public data."""

from crowdsim.recordings.eth_ucy import (
    ETH_UCY_FOLDS,
    eth_ucy_fold,
    find_data,
    read_eth_ucy,
    read_obsmat,
    read_scene,
)
from crowdsim.recordings.recording import FRAME_DT, Picture, Recording, check_rate
from crowdsim.recordings.store import iter_recordings, read_recordings, write_recordings

__all__ = [
    "ETH_UCY_FOLDS",
    "FRAME_DT",
    "Picture",
    "Recording",
    "check_rate",
    "eth_ucy_fold",
    "find_data",
    "iter_recordings",
    "read_eth_ucy",
    "read_obsmat",
    "read_recordings",
    "read_scene",
    "write_recordings",
]
