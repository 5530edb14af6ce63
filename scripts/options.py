"""Option types that several subcommands share."""

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Self

from jsonargparse.typing import register_type, restricted_number_type

if TYPE_CHECKING:
    PositiveNumber = float
else:
    PositiveNumber = restricted_number_type("PositiveNumber", float, [(">", 0), ("<", math.inf)])
    """A positive number that is not infinite."""
    # Values travel to worker processes, which look their class up here.
    PositiveNumber.__module__ = __name__


class Names(tuple[str, ...]):
    """Names separated by commas on the command line, a list in a YAML file.

    Raises:
        ValueError: No name at all, an empty one, or something that is not text.
    """

    __slots__ = ()

    def __new__(cls, value: str | Iterable[str]) -> Self:
        """Split `value` at its commas, or take its items as they are."""
        names = value.split(",") if isinstance(value, str) else value
        stripped = [name.strip() if isinstance(name, str) else name for name in names]
        if not stripped or not all(isinstance(name, str) and name for name in stripped):
            raise ValueError(f"expected names separated by commas, found {value!r}")
        return super().__new__(cls, stripped)


class Seeds(tuple[int, ...]):
    """Seeds of episodes: `20` means 0 to 19, `3,5,8` these three; a number or a list in YAML.

    Raises:
        ValueError: No seed, a negative one, a repeated one, or something that is not an integer.
    """

    __slots__ = ()

    def __new__(cls, value: str | int | Iterable[int]) -> Self:
        """Count up to a single number; take several as they are."""
        try:
            seeds = _seeds(value)
        except ValueError:
            seeds = []
        if not seeds or min(seeds) < 0 or len(set(seeds)) < len(seeds):
            raise ValueError(
                f"expected a positive count or distinct non-negative seeds, found {value!r}"
            )
        return super().__new__(cls, seeds)


def _seeds(value: str | int | Iterable[int]) -> list[int]:
    if isinstance(value, int):
        return list(range(value))
    if isinstance(value, str):
        numbers = [int(part) for part in value.split(",")]
        return numbers if len(numbers) > 1 else list(range(numbers[0]))
    return [int(item) for item in value]


register_type(Names, serializer=list, deserializer=Names)
register_type(Seeds, serializer=list, deserializer=Seeds)
