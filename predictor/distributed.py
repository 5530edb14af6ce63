"""Data parallel training: processes with the same weights share each batch and add up gradients.

`torchrun` starts the processes and tells each by the environment who it is. What is drawn for a
batch is drawn by all of them alike, for the whole batch; each then takes its part of the rows.
"""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Final

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, distributed


@dataclass(frozen=True, kw_only=True)
class Processes:
    """The processes that train together.

    Attributes:
        rank: Number of this one, counted from 0.
        count: How many there are.
    """

    rank: int = 0
    count: int = 1

    @property
    def first(self) -> bool:
        """Whether this is the one that writes files and shows progress."""
        return self.rank == 0

    def part(self, rows: int) -> tuple[NDArray[np.int64], float]:
        """Which of the rows of a batch are this process's, and what share of all they are.

        A process for which there is no row takes one with the share 0, so that it has a gradient
        to add as well.
        """
        own = np.arange(self.rank, rows, self.count)
        return (own, len(own) / rows) if len(own) > 0 else (np.zeros(1, dtype=np.int64), 0.0)

    def add_up(self, tensors: Sequence[Tensor]) -> None:
        """Replace each tensor, of one device and type, by its sum over the processes."""
        if self.count == 1:
            return
        flat = torch.cat([tensor.flatten() for tensor in tensors])
        distributed.all_reduce(flat)
        for tensor, total in zip(
            tensors, flat.split_with_sizes([t.numel() for t in tensors]), strict=True
        ):
            tensor.copy_(total.view_as(tensor))


ALONE: Final = Processes()


@contextmanager
def joined_processes() -> Iterator[Processes]:
    """Join the processes that `torchrun` has started; without it there is this one alone.

    They talk through gloo on CPUs and nccl on GPUs, of which each process takes its own.
    """
    count = int(os.environ.get("WORLD_SIZE", "1"))
    if count == 1:
        yield ALONE
        return
    if torch.cuda.is_available():
        torch.cuda.set_device(int(os.environ["LOCAL_RANK"]))
    distributed.init_process_group()
    try:
        yield Processes(rank=distributed.get_rank(), count=count)
    finally:
        distributed.destroy_process_group()
