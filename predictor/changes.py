"""Fields of a configuration changed by their names, one at a time: what an ablation is."""

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

from predictor.config import NetworkConfig, TrainConfig

Value = bool | int | float | str


def with_changes(
    model: NetworkConfig, training: TrainConfig, changes: Mapping[str, Value]
) -> tuple[NetworkConfig, TrainConfig]:
    """Both configurations with other values of some of their fields.

    Args:
        model: What the network is.
        training: How it is trained.
        changes: New values by the names of fields of either; no name is in both.

    Raises:
        ValueError: A name is unknown, or a value is of another type than the one that it replaces,
            or out of range.
    """
    known = {name: value for part in (model, training) for name, value in _values(part).items()}
    for name, value in changes.items():
        if name not in known:
            raise ValueError(f"changes: expected names among {sorted(known)}, got {name!r}")
        if not _fits(value, known[name]):
            raise ValueError(f"changes: {name} is {known[name]!r}, got {value!r} in its place")
    return replace(model, **_of(model, changes)), replace(training, **_of(training, changes))


def _of(part: NetworkConfig | TrainConfig, changes: Mapping[str, Value]) -> dict[str, Any]:
    return {name: changes[name] for name in _values(part) if name in changes}


def _values(part: NetworkConfig | TrainConfig) -> dict[str, object]:
    return {field.name: getattr(part, field.name) for field in fields(part)}


def _fits(value: Value, old: object) -> bool:
    """Whole numbers may stand for others; True and False are no numbers here."""
    if isinstance(old, float):
        return isinstance(value, int | float) and not isinstance(value, bool)
    return type(value) is type(old)
