"""Fields of configurations are changed by name, or not at all."""

from dataclasses import replace

import pytest

from predictor.changes import Value, with_changes
from predictor.config import named_configuration


def test_each_change_reaches_the_configuration_that_has_the_field() -> None:
    model, training = named_configuration("residual")
    changed = with_changes(model, training, {"blocks": 2, "mirror": False, "scale": 0})
    assert changed == (replace(model, blocks=2), replace(training, mirror=False, scale=0))
    assert with_changes(model, training, {}) == (model, training)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"block": 2}, "names among.*blocks.*got 'block'"),
        ({"blocks": "two"}, "blocks is 4, got 'two'"),
        ({"blocks": True}, "blocks is 4, got True"),
        ({"mirror": 0}, "mirror is True, got 0"),
        ({"blocks": 0}, "blocks must be in"),
    ],
)
def test_what_cannot_be_is_named(changes: dict[str, Value], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        with_changes(*named_configuration("residual"), changes)
