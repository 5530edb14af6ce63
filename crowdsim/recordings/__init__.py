"""Recorded crowds, real or simulated: what they are, their store, and readers of public data."""

from crowdsim.recordings.data_folder import find_data, find_sdd
from crowdsim.recordings.eth_ucy import (
    ETH_UCY_FOLDS,
    eth_ucy_fold,
    read_scene,
)
from crowdsim.recordings.eth_ucy_text import read_eth_ucy, read_obsmat
from crowdsim.recordings.rate import check_rate
from crowdsim.recordings.recording import FRAME_DT, Picture, Recording
from crowdsim.recordings.sdd import (
    read_sdd,
    sdd_mask,
    sdd_part,
    sdd_picture,
    sdd_scales,
    sdd_walkable,
)
from crowdsim.recordings.store import iter_recordings, read_recordings, write_recordings

__all__ = [
    "ETH_UCY_FOLDS",
    "FRAME_DT",
    "Picture",
    "Recording",
    "check_rate",
    "eth_ucy_fold",
    "find_data",
    "find_sdd",
    "iter_recordings",
    "read_eth_ucy",
    "read_obsmat",
    "read_recordings",
    "read_scene",
    "read_sdd",
    "sdd_mask",
    "sdd_part",
    "sdd_picture",
    "sdd_scales",
    "sdd_walkable",
    "write_recordings",
]
