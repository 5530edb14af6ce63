"""Values of scenario files, checked; every error begins with where the value stands."""

import math
from collections.abc import Mapping, Sequence
from typing import Any


def section(
    where: str, content: Any, required: Sequence[str], optional: Sequence[str]
) -> dict[str, Any]:
    """Keys and values of a part of the file, all required ones there and no unknown ones."""
    if not isinstance(content, Mapping):
        raise ValueError(f"{where}: expected keys {', '.join(required)}, found {content!r}")
    refuse_unknown(where, content, (*required, *optional))
    missing = [key for key in required if key not in content]
    if missing:
        raise ValueError(f"{where}: expected the key {missing[0]!r}, found only {list(content)}")
    return dict(content)


def refuse_unknown(where: str, content: Mapping[str, Any], known: Sequence[str]) -> None:
    """Raise ValueError, which lists the known keys, where there is another one."""
    unknown = [key for key in content if key not in known]
    if unknown:
        raise ValueError(f"{where}: expected keys among {', '.join(known)}, found {unknown[0]!r}")


def whole_numbers(where: str, content: Any, most: int) -> tuple[int, int]:
    """The least and the greatest of a whole number, from one or from both of them."""
    pair = content if isinstance(content, list) and len(content) == 2 else [content, content]
    if not all(isinstance(value, int) and not isinstance(value, bool) for value in pair):
        raise ValueError(
            f"{where}: expected a whole number or [least, greatest], found {content!r}"
        )
    low, high = pair
    if not 0 <= low <= high <= most:
        raise ValueError(f"{where}: expected 0 <= least <= greatest <= {most}, found {content}")
    return low, high


def numbers(where: str, content: Any, lengths: Sequence[int]) -> tuple[float, ...]:
    """A list of numbers that is as long as one of the lengths."""
    found = items(where, content)
    if len(found) not in lengths:
        known = " or ".join(map(str, lengths))
        raise ValueError(f"{where}: expected {known} numbers, found {content}")
    return tuple(number(where, value) for value in found)


def number(where: str, content: Any) -> float:
    """A finite number."""
    if not is_number(content) or not math.isfinite(content):
        raise ValueError(f"{where}: expected a number, found {content!r}")
    return float(content)


def is_number(content: Any) -> bool:
    """Whether a value is a number; true and false are none."""
    return isinstance(content, int | float) and not isinstance(content, bool)


def items(where: str, content: Any) -> list[Any]:
    """The items of a list."""
    if not isinstance(content, list):
        raise ValueError(f"{where}: expected a list, found {content!r}")
    return content
