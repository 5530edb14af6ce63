"""What a long command leaves when it is interrupted, and what it tells then."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from envs.evaluation.finished_tasks import FinishedTasks


@contextmanager
def resumable(hint: str = "interrupted; the same command with --resume goes on") -> Iterator[None]:
    """Tell who interrupts what is done inside how to go on.

    Raises:
        KeyboardInterrupt: Again, with the hint.
    """
    try:
        yield
    except KeyboardInterrupt:
        raise KeyboardInterrupt(hint) from None


@contextmanager
def kept_tasks(out: Path, resume: bool) -> Iterator["FinishedTasks"]:
    """Yield the finished tasks of an evaluation in `out`; they go when it comes to its end.

    Args:
        out: Folder of the results.
        resume: Whether to take over those that an interrupted run has left.

    Raises:
        KeyboardInterrupt: Again, with a hint at how to go on.
    """
    from envs.evaluation.finished_tasks import FinishedTasks

    finished = FinishedTasks(out / "finished-tasks")
    if not resume:
        finished.forget()
    with resumable():
        yield finished
    finished.forget()
