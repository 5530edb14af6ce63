"""The pictures of an evaluation."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from hand_made_crowds import walkers

from crowdsim.recordings import write_recordings
from predictor.comparison import compare
from predictor.constant_velocity import ConstantVelocityForecaster
from predictor.error_plots import contour_level
from predictor.scene_picture import MOST_MOVING, liveliest
from scripts.prediction_figures import write_figures


class Standing(ConstantVelocityForecaster):
    """Everybody stays."""

    name = "standing"

    def forecast(self, history, valid, map_images=None, pixel_from_world=None, select=None):
        return np.repeat(history[..., -1:, :, :], self.forecast_steps, axis=-3)


def made(name: str) -> ConstantVelocityForecaster:
    return Standing() if name == "standing" else ConstantVelocityForecaster()


def test_pictures_of_every_kind_are_written(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    crowds = [walkers(rng, 5, 30, f"place-{index}") for index in range(3)]
    write_recordings(tmp_path / "crowds", crowds)
    found = compare(["standing"], str(tmp_path / "crowds"), make=made)
    paths = write_figures(tmp_path / "figures", found)
    assert {path.name for path in paths} == {
        "error_by_step.png",
        "final_errors.png",
        "scenes-standing.png",
    }
    for path in paths:
        picture = cv2.imread(str(path))
        assert min(picture.shape[:2]) > 300
        assert picture.std() > 10.0


def test_contours_hold_their_share() -> None:
    density = np.array([[5.0, 1.0], [3.0, 0.0]])
    assert contour_level(density, 0.4, 10) == 5.0
    assert contour_level(density, 0.8, 10) == 3.0
    # nine of ten are on the grid
    assert contour_level(density, 0.95, 10) == 0.0


def test_scenes_are_lively_but_not_crowded_and_of_different_places() -> None:
    rng = np.random.default_rng(0)
    crowds = [walkers(rng, people, 20, name) for people, name in ((3, "a-1"), (6, "a-2"), (4, "b"))]
    crowds.insert(0, walkers(rng, MOST_MOVING + 1, 20, "crowded"))
    drawn = liveliest(ConstantVelocityForecaster(), crowds, 2)
    assert [one.scene.recording.name for one in drawn] == ["a-1", "b"]
    crowd = walkers(rng, MOST_MOVING + 5, 60, "c")
    crowd.valid[:30, :8] = False
    crowd.positions[:30, :8] = 0.0
    [drawn_scene] = liveliest(ConstantVelocityForecaster(), [crowd], 1)
    assert len(drawn_scene.scene.agents) == 4


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_half_of_a_round_cloud_lies_in_a_round_contour(share: float) -> None:
    """Of a normal distribution a share p lies within sqrt(-2 ln(1 - p)) standard deviations."""
    middles = np.arange(-5.0, 5.0, 0.05) + 0.025
    x, y = np.meshgrid(middles, middles)
    density = np.exp(-0.5 * (x**2 + y**2)) / (2.0 * np.pi) * 0.05**2
    inside = density >= contour_level(density, share, 1)
    assert np.sqrt(inside.sum() * 0.05**2 / np.pi) == pytest.approx(
        np.sqrt(-2.0 * np.log(1.0 - share)), rel=0.02
    )
