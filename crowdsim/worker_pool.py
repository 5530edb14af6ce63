"""Worker processes that end at once when something ends their work early.

Workers are spawned, not forked: a fork after a library has used its threads can deadlock.
"""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any


@contextmanager
def worker_pool(
    workers: int, prepare: Callable[..., None], *arguments: Any
) -> Iterator[ProcessPoolExecutor]:
    """Yield a pool whose workers end when its block is left by an exception, whatever they do.

    They leave interrupts to this process, and end when it is killed.

    Args:
        workers: Number of processes.
        prepare: Called once in each of them; at module level, so that they can import it.
        *arguments: Its arguments.
    """
    context = multiprocessing.get_context("spawn")
    strangers = set(multiprocessing.active_children())
    with ProcessPoolExecutor(
        workers, mp_context=context, initializer=_start, initargs=(prepare, *arguments)
    ) as pool:
        try:
            yield pool
        except BaseException:
            # Nothing is cancelled: a pool whose workers end trips over cancelled tasks.
            for worker in set(multiprocessing.active_children()) - strangers:
                worker.terminate()
            raise


def _start(prepare: Callable[..., None], *arguments: Any) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    prepare(*arguments)


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
