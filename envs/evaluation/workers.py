"""Runs tasks in worker processes and counts what they finish.

Each takes one torch thread, since several workers with several threads each slow one another down.
"""

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from multiprocessing.sharedctypes import Synchronized
from typing import TypeVar

import torch

from crowdsim.worker_pool import worker_pool

TaskT = TypeVar("TaskT")
ResultT = TypeVar("ResultT")
Work = Callable[[TaskT, Callable[[], None]], ResultT]
"""Does a task, and calls its second argument whenever a part of it is finished."""

POLL_SECONDS = 0.25

_counter: "Synchronized[int] | None" = None


def run_tasks(
    work: Work[TaskT, ResultT],
    tasks: Sequence[TaskT],
    *,
    workers: int = 1,
    progress: Callable[[int], None] | None = None,
) -> list[ResultT]:
    """Does every task and returns the results in the order of the tasks.

    Args:
        work: A function at module level, so that workers can import it.
        tasks: Its first arguments; picklable.
        workers: Number of processes; 1 stays in this one.
        progress: Called now and then with the number of finished parts of all tasks.

    Raises:
        BaseException: Whatever a task raises, or an interrupt; all workers end at once.
    """
    if workers == 1:
        return _run_here(work, tasks, progress)
    counter = multiprocessing.get_context("spawn").Value("q", 0)
    with worker_pool(min(workers, len(tasks)), _start, counter) as pool:
        futures = [pool.submit(_run_counted, work, task) for task in tasks]
        _watch(futures, counter, progress)
        return [future.result() for future in futures]


def _run_here(
    work: Work[TaskT, ResultT], tasks: Sequence[TaskT], progress: Callable[[int], None] | None
) -> list[ResultT]:
    """All tasks in this process, one after the other."""
    done = 0

    def finished() -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(done)

    return [work(task, finished) for task in tasks]


def _watch(
    futures: Sequence[Future[ResultT]],
    counter: "Synchronized[int]",
    progress: Callable[[int], None] | None,
) -> None:
    """Reports progress until all tasks are done or one has failed."""
    waiting: set[Future[ResultT]] = set(futures)
    while waiting:
        ended, waiting = wait(waiting, timeout=POLL_SECONDS, return_when=FIRST_COMPLETED)
        for future in ended:
            future.result()
        if progress is not None:
            progress(counter.value)


def _start(counter: "Synchronized[int]") -> None:
    """Prepares a worker."""
    global _counter
    _counter = counter
    torch.set_num_threads(1)


def _run_counted(work: Work[TaskT, ResultT], task: TaskT) -> ResultT:
    """One task in a worker."""
    return work(task, _count)


def _count() -> None:
    """Adds a finished part to the count that all workers share."""
    assert _counter is not None
    with _counter.get_lock():
        _counter.value += 1
