"""Recorded crowds, real or simulated: what they are, their store, and readers of public data."""

from crowdsim.recordings.data_folder import find_data, find_sdd
from crowdsim.recordings.eth_ucy import (
    ETH_UCY_FOLDS,
    eth_ucy_fold,
    read_scene,
)
from crowdsim.recordings.eth_ucy_text import (
    iter_eth_ucy,
    iter_obsmat,
    read_eth_ucy,
    read_obsmat,
    write_eth_ucy,
    write_obsmat,
)
from crowdsim.recordings.formats import (
    format_of_input,
    format_of_output,
    iter_format,
    write_format,
)
from crowdsim.recordings.rate import Tally, check_rate, tallied, tally
from crowdsim.recordings.recording import FRAME_DT, Picture, Recording
from crowdsim.recordings.sdd import (
    read_sdd,
    sdd_mask,
    sdd_part,
    sdd_picture,
    sdd_scales,
    sdd_walkable,
)
from crowdsim.recordings.sdd_text import iter_sdd_snippets, read_sdd_boxes, write_sdd_snippets
from crowdsim.recordings.store import (
    iter_recordings,
    iter_stretches,
    read_recordings,
    write_recordings,
)
from crowdsim.recordings.stretches import join, joined, overlapping
from crowdsim.recordings.trajnet import (
    TrajnetScene,
    iter_trajnet,
    read_trajnet,
    write_trajnet,
)

__all__ = [
    "ETH_UCY_FOLDS",
    "FRAME_DT",
    "Picture",
    "Recording",
    "Tally",
    "TrajnetScene",
    "check_rate",
    "eth_ucy_fold",
    "find_data",
    "find_sdd",
    "format_of_input",
    "format_of_output",
    "iter_eth_ucy",
    "iter_format",
    "iter_obsmat",
    "iter_recordings",
    "iter_sdd_snippets",
    "iter_stretches",
    "iter_trajnet",
    "join",
    "joined",
    "overlapping",
    "read_eth_ucy",
    "read_obsmat",
    "read_recordings",
    "read_scene",
    "read_sdd",
    "read_sdd_boxes",
    "read_trajnet",
    "sdd_mask",
    "sdd_part",
    "sdd_picture",
    "sdd_scales",
    "sdd_walkable",
    "tallied",
    "tally",
    "write_eth_ucy",
    "write_format",
    "write_obsmat",
    "write_recordings",
    "write_sdd_snippets",
    "write_trajnet",
]
