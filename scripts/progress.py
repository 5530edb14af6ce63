"""The bar that long commands show."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

from tqdm import tqdm


@contextmanager
def episodes_bar() -> Iterator[Callable[[int, int], None]]:
    """Yield a function that takes the numbers of finished and of all episodes.

    The bar appears with its first call, so that bad input is answered by one line and no bar.
    """
    with ExitStack() as stack:
        bars: list[tqdm[None]] = []

        def show(done: int, total: int) -> None:
            if not bars:
                bars.append(stack.enter_context(tqdm(total=total, unit="episode")))
            bars[0].update(done - bars[0].n)

        yield show
