"""The bar that long commands show."""

import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Final

from tqdm import tqdm

LOG_SECONDS: Final = 10.0
"""Time between two lines where nobody watches [s]."""


@contextmanager
def episodes_bar() -> Iterator[Callable[[int, int], None]]:
    """Yield a function that takes the numbers of finished and of all episodes.

    The bar appears with its first call, so that bad input is answered by one line and no bar.
    """
    interval = 0.1 if sys.stderr.isatty() else LOG_SECONDS
    with ExitStack() as stack:
        bars: list[tqdm[None]] = []

        def show(done: int, total: int) -> None:
            if not bars:
                bar = tqdm(total=total, unit="episode", mininterval=interval)
                bars.append(stack.enter_context(bar))
            bars[0].update(done - bars[0].n)

        yield show
