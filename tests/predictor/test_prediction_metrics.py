"""What is measured of forecasts besides their distance from the truth."""

from pathlib import Path

import numpy as np
import pytest
from hand_made_crowds import walkers
from trajnetplusplustools import TrackRow
from trajnetplusplustools.metrics import collision

from crowdsim.recordings import Picture, Recording, write_recordings
from crowdsim.recordings.drawn import drawn_picture, walkable_in
from predictor.constant_velocity import ConstantVelocityForecaster
from predictor.datasets import crowd_name, drawn_name
from predictor.evaluate import evaluate
from predictor.grounds import Ground, read_grounds
from predictor.metrics import collides, misses
from predictor.published import read_published

METRE = np.array([[10.0, 0.0, 0.0], [0.0, -10.0, 39.0], [0.0, 0.0, 1.0]])
"""`pixel_from_world` of 10 px/m with the origin in the lowest row of a map of 40 x 40 px."""


def rows(path: np.ndarray, person: int) -> list[TrackRow]:
    return [TrackRow(frame, person, x, y) for frame, (x, y) in enumerate(path)]


def test_a_miss_ends_more_than_2_m_off() -> None:
    errors = np.array([[5.0, 1.9], [0.0, 2.1], [0.0, 2.0]])
    assert misses(errors).tolist() == [0.0, 1.0, 0.0]


def test_collisions_by_hand() -> None:
    ahead = np.stack([np.linspace(0.0, 4.4, 12), np.zeros(12)], axis=1)
    beside, against = ahead + np.array([0.0, 0.25]), ahead[::-1] + np.array([0.0, 0.19])
    path = np.stack([ahead, beside, against], axis=1)
    assert collides(path).tolist() == [1.0, 1.0, 1.0]
    assert collides(path[:, :2]).tolist() == [0.0, 0.0]
    # they swap places within a step and are nearest in its middle
    swap = np.stack([ahead[:2], ahead[1::-1]], axis=1)
    assert collides(swap).tolist() == [1.0, 1.0]
    # one's own true path is nobody to meet
    assert collides(path[:, :2], path[:, :2] + [0.0, 0.1]).tolist() == [0.0, 1.0]
    assert np.isnan(collides(path[:, :1])).all()


def test_collisions_are_those_of_trajnet() -> None:
    rng = np.random.default_rng(0)
    met = 0
    for _ in range(60):
        steps = rng.normal(0.0, 0.3, (2, 12, 4, 2))
        forecast, future = rng.uniform(-1.0, 1.0, (2, 1, 4, 2)) + np.cumsum(steps, axis=1)
        for others, found in (
            (forecast, collides(forecast)),
            (future, collides(forecast, future)),
        ):
            expected = [
                any(
                    collision(rows(forecast[:, i], i), rows(others[:, j], j))
                    for j in range(4)
                    if j != i
                )
                for i in range(4)
            ]
            assert found.tolist() == [float(one) for one in expected]
            met += sum(expected)
    assert 40 < met < 440


def test_a_ground_knows_where_one_can_walk() -> None:
    walkable = np.ones((40, 40), dtype=np.bool_)
    walkable[:20] = False  # the half at +y
    ground = Ground(walkable=walkable, pixel_from_world=METRE)
    points = np.array([[1.0, 0.5], [1.0, 3.0], [-0.2, 1.0], [1.0, 5.0]])
    np.testing.assert_array_equal(ground.is_off(points), [0.0, 1.0, np.nan, np.nan])


def test_only_drawn_maps_tell_where_one_can_walk() -> None:
    classes = np.ones((40, 40), dtype=np.uint8)
    classes[:10], classes[10:20] = 3, 5
    photograph = Picture(np.full((40, 40, 3), 90, dtype=np.uint8), METRE)
    walkable = walkable_in(drawn_picture(photograph, classes))
    assert walkable is not None
    np.testing.assert_array_equal(walkable, classes == 1)
    assert walkable_in(photograph) is None


def test_rows_tell_what_is_measured_and_no_more(tmp_path: Path) -> None:
    recording = walkers(np.random.default_rng(0), 5, 20, "one")
    write_recordings(tmp_path / "crowds", [recording])
    row = evaluate(ConstantVelocityForecaster(), str(tmp_path / "crowds"))["mean"]
    assert {"miss_rate@2m", "collision_1", "collision_2", "collision_truth"} <= set(row)
    # the picture of these walkers is noise: nobody knows where they could not walk
    assert not any(key.startswith("off_walkable") for key in row)


def test_steps_off_the_ground_are_counted(tmp_path: Path) -> None:
    """Two walk north, 0.2 m a frame, until y = 1.6 m; one cannot walk beyond 1.95 m."""
    classes = np.ones((40, 40), dtype=np.uint8)
    classes[:20] = 3
    map_ = drawn_picture(Picture(np.zeros((40, 40, 3), dtype=np.uint8), METRE), classes)
    y = np.concatenate([0.2 * np.arange(1, 9), np.full(12, 1.6)])
    positions = np.stack([np.broadcast_to([1.0, 3.0], (20, 2)), np.stack([y, y], axis=1)], axis=-1)
    recording = Recording(
        name="one",
        positions=positions,
        valid=np.ones((20, 2), dtype=np.bool_),
        ids=np.arange(2),
        frames=np.arange(20),
        picture=map_,
    )
    write_recordings(tmp_path / "crowds", [recording])
    row = evaluate(ConstantVelocityForecaster(), str(tmp_path / "crowds"))["folds"]["crowds"]
    # forecast at y = 1.8, 2.0, ... 4.0, of which the picture shows those below 3.95
    assert row["off_walkable_per_step"] == [0.0, *[1.0] * 10, None]
    assert row["off_walkable"] == pytest.approx(10 / 11)
    assert row["off_walkable_truth"] == 0.0


def test_grounds_of_real_places_hold_the_people(data_root: Path) -> None:
    data = str(data_root / "eth_ucy") + ":hotel"
    assert (crowd_name(data), drawn_name(data)) == ("eth_ucy", data + "@drawn")
    row = evaluate(ConstantVelocityForecaster(), data)["folds"]["hotel"]
    assert 0.0 < row["off_walkable_truth"] < 0.05
    assert row["off_walkable"] > row["off_walkable_truth"]


def test_simulated_crowds_stand_on_the_map_they_have(tmp_path: Path) -> None:
    assert (crowd_name(str(tmp_path)), drawn_name(str(tmp_path))) == ("simulated", str(tmp_path))
    assert read_grounds(str(tmp_path), {"fold": [walkers(np.random.default_rng(0))]}) == {}


@pytest.mark.parametrize("data", ["eth_ucy", "eth_ucy:zara1@drawn", "sdd"])
def test_published_rows_are_whole_and_sourced(data: str) -> None:
    table = read_published(data)
    assert table is not None
    for row in table.rows:
        assert len(row.ade_fde) == len(table.columns)
        assert all(row.source and row.differs for row in table.rows)
        for entry in filter(None, row.ade_fde):
            ade, fde = map(float, entry.split("/"))
            assert 0.0 < ade < fde


def test_nothing_is_published_on_simulated_crowds(tmp_path: Path) -> None:
    assert read_published(str(tmp_path)) is None
