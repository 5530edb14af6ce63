"""The page that shows every scenario says what the code says."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from crowdsim.gallery import page, picture, read_entry
from crowdsim.scenarios import SCENARIOS

DOCS = Path(__file__).parents[2] / "docs"


def test_the_page_is_up_to_date():
    assert (DOCS / "scenarios.md").read_text(encoding="utf-8") == page()


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_scenario_has_a_picture_and_explains_its_parameters(name):
    entry = read_entry(name)
    assert entry.caption.endswith(".")
    assert all(len(meaning) > 10 for _, _, meaning in entry.parameters)
    image = cv2.imread(str(DOCS / "scenarios" / f"{name}.webp"))
    assert image is not None
    assert min(image.shape[:2]) > 80


def test_the_pictures_are_small():
    assert sum(path.stat().st_size for path in (DOCS / "scenarios").iterdir()) < 3_000_000


def test_a_parameter_without_a_word_is_refused(monkeypatch):
    def silent(rng, *, pedestrians=3):
        """A scenario.

        Args:
            rng: Source of all draws.
        """

    monkeypatch.setitem(SCENARIOS, "silent", silent)
    with pytest.raises(ValueError, match="silent: expected pedestrians"):
        read_entry("silent")


def test_a_picture_shows_the_robot_where_it_drives():
    content = np.frombuffer(picture("robot_overtaking"), dtype=np.uint8)
    blue, _, red = cv2.split(cv2.imdecode(content, cv2.IMREAD_COLOR).astype(int))
    column = np.flatnonzero((red - blue > 120).any(axis=0))
    assert column.min() < 300 < 500 < column.max()  # the robot's trail, and the flag
