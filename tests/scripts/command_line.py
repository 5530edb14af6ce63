"""What running a command line leads to."""

from collections.abc import Callable
from typing import NamedTuple


class Outcome(NamedTuple):
    status: int
    out: str
    err: str


Crowdnav = Callable[..., Outcome]
