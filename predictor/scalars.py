"""Scalars of a training for TensorBoard, if it is installed and asked for."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol


class WriteScalars(Protocol):
    """Takes what was measured at a step, by name."""

    def __call__(self, step: int, values: Mapping[str, float]) -> None:
        """Write `values` of `step`."""


@contextmanager
def scalar_writer(folder: Path | None, first_step: int) -> Iterator[WriteScalars]:
    """Yield what writes scalars into `folder`; None writes nothing.

    Args:
        folder: Of the event files.
        first_step: Events of a killed training from this step on are hidden.

    Raises:
        ValueError: TensorBoard is not installed.
    """
    if folder is None:
        yield lambda step, values: None
        return
    try:
        from torch.utils.tensorboard import SummaryWriter
    except ImportError as error:
        raise ValueError(
            "expected the package tensorboard for --tensorboard, found none; "
            "pip install 'crowdnav-testbed[tensorboard]'"
        ) from error
    with SummaryWriter(str(folder), purge_step=first_step) as writer:

        def write(step: int, values: Mapping[str, float]) -> None:
            for name, value in values.items():
                writer.add_scalar(name, value, step)

        yield write
