import pickle
import subprocess
import sys

import pytest

from scripts.options import Names, PositiveNumber, Seeds


@pytest.mark.parametrize(
    ("value", "seeds"),
    [("3", (0, 1, 2)), (3, (0, 1, 2)), ("7,4", (7, 4)), ([5], (5,)), ("0,2", (0, 2))],
)
def test_seeds_count_up_or_are_listed(value: str | int | list[int], seeds: tuple[int, ...]) -> None:
    assert Seeds(value) == seeds


@pytest.mark.parametrize("value", ["0", "-3", "1,1", "1,-2", "", "many", "1.5", 0, []])
def test_seeds_refuse_what_is_no_set_of_episodes(value: str | int | list[int]) -> None:
    with pytest.raises(ValueError, match="expected a positive count"):
        Seeds(value)


def test_names_are_the_same_from_command_line_and_yaml() -> None:
    assert Names("straight, mppi") == Names(["straight", "mppi"]) == ("straight", "mppi")


@pytest.mark.parametrize("value", ["", "a,,b", [], [3]])
def test_names_refuse_empty_ones(value: str | list[str]) -> None:
    with pytest.raises(ValueError, match="expected names"):
        Names(value)


def test_values_travel_to_a_process_that_has_imported_nothing() -> None:
    values = (Names("straight"), Seeds(3), PositiveNumber(4.8))
    code = f"import pickle; print(pickle.loads({pickle.dumps(values)!r}))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "(('straight',), (0, 1, 2), 4.8)"
