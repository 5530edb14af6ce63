"""The state of a running world as plain data: taken, put back, or sent to another process.

Each part of a world that changes while it runs names what changes in a class attribute `STATE`.
"""

from __future__ import annotations

import copy
import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import Any, ClassVar, Protocol

import numpy as np


class Stateful(Protocol):
    """A part of a world.

    Attributes:
        STATE: names of the attributes (arrays, numbers, generators) that steps change or that
            random draws decided. Putting a state back replaces them, so nobody else may keep
            views of those arrays.
    """

    STATE: ClassVar[tuple[str, ...]]


@dataclass(frozen=True, kw_only=True, eq=False)
class Snapshot:
    """All that a world's future depends on, besides what it was built from; it can be pickled.

    Attributes:
        origin: what the world was built from, by name; equal where a restored world goes on alike.
        parts: per part of the world, its state by attribute name.
    """

    origin: dict[str, str]
    parts: dict[str, dict[str, Any]]

    @classmethod
    def of(cls, parts: Mapping[str, Stateful], *, origin: Mapping[str, str]) -> Snapshot:
        """Copy the state of all parts; they stay as they are."""
        states = {
            name: {key: copy.deepcopy(getattr(part, key)) for key in part.STATE}
            for name, part in parts.items()
        }
        return cls(origin=dict(origin), parts=states)

    def put(self, parts: Mapping[str, Stateful], *, origin: Mapping[str, str]) -> None:
        """Give the parts copies of the state.

        Raises:
            ValueError: if it was taken from a world that was built from something else; then
                nothing has changed.
        """
        for name in origin:
            if self.origin.get(name) != origin[name]:
                raise ValueError(
                    f"snapshot: expected one of a world that was built from the same {name} "
                    f"({origin[name]}), found {self.origin.get(name)}"
                )
        _check_names("parts", expected=parts, found=self.parts)
        for name, part in parts.items():
            _check_names(name, expected=part.STATE, found=self.parts[name])
            for key in part.STATE:
                _check_shape(f"{name}.{key}", getattr(part, key), self.parts[name][key])
        for name, part in parts.items():
            for key, value in self.parts[name].items():
                setattr(part, key, copy.deepcopy(value))


def fingerprint(description: object) -> str:
    """Tell descriptions apart by content, the same in every process.

    Args:
        description: dataclasses, tuples and lists, down to arrays, numbers, text and None.

    Returns:
        16 hexadecimal digits.
    """
    digest = hashlib.blake2b(digest_size=8)
    _feed(digest, description)
    return digest.hexdigest()


def _feed(digest: hashlib.blake2b, value: Any) -> None:
    digest.update(type(value).__name__.encode())
    if is_dataclass(value):
        for column in fields(value):
            digest.update(column.name.encode())
            _feed(digest, getattr(value, column.name))
    elif isinstance(value, tuple | list):
        digest.update(str(len(value)).encode())
        for item in value:
            _feed(digest, item)
    elif isinstance(value, np.ndarray):
        digest.update(f"{value.dtype.str}{value.shape}".encode())
        digest.update(np.ascontiguousarray(value).tobytes())
    else:
        digest.update(repr(value).encode())


def _check_names(what: str, *, expected: Iterable[str], found: Iterable[str]) -> None:
    if set(expected) != set(found):
        raise ValueError(f"snapshot: expected {what} {sorted(expected)}, found {sorted(found)}")


def _check_shape(what: str, current: Any, saved: Any) -> None:
    expected, found = np.shape(current), np.shape(saved)
    if expected != found:
        raise ValueError(f"snapshot: expected {what} of shape {expected}, found {found}")
