"""Forecasters that know more than tracks: the walls, or the simulator itself."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from envs.config import make_config
from envs.crowd_nav import CrowdNav
from envs.episodes import Episodes
from envs.forecasters.constant_velocity_map import ROOM, stop_at_walls
from envs.forecasters.oracle import Blur, delayed

WALL = np.array([[[3.0, -5.0], [3.0, 5.0]]])
FRAMES = 12


def percepts(forecaster, *, seeds=(3,), steps=0, **keywords):
    """What the robots perceive after some steps with one and the same command."""
    episodes = Episodes(make_config(forecaster=forecaster, **keywords), len(seeds))
    episodes.reset([np.random.default_rng(seed) for seed in seeds])
    for _ in range(steps):
        episodes.step(np.tile([0.2, 0.1], (len(seeds), 1)))
    return episodes, [episodes.percept(world) for world in range(len(seeds))]


@pytest.mark.parametrize("robot", ["unicycle", "holonomic", "bicycle"])
@pytest.mark.parametrize("scenario", ["circular_crossing", "narrow_doorway"])
def test_the_oracle_is_right_while_the_robot_keeps_its_command(scenario, robot):
    episodes, [(percept, row)] = percepts("oracle", scenario=scenario, robot=robot, steps=10)
    ids, forecast = percept.observed.ids[row], percept.forecast[row]
    crowd = episodes.worlds.crowd
    for frame in range(FRAMES):
        episodes.step([[0.2, 0.1]])
        episodes.step([[0.2, 0.1]])
        for place in np.flatnonzero(percept.observed.valid[row]):
            column = np.flatnonzero(crowd.ids[0] == ids[place])
            assert_array_equal(forecast[place, frame], crowd.position[0, column[0]])


def test_the_oracle_is_right_about_recorded_people(data_root):
    keywords = {"scenario": "replay", "scenario_parameters": {"data": str(data_root)}}
    episodes, [(percept, row)] = percepts("oracle", steps=3, **keywords)
    place = np.flatnonzero(percept.observed.valid[row])[0]
    person = percept.observed.ids[row, place]
    for _ in range(4):
        episodes.step([[0.2, 0.1]])
    crowd = episodes.worlds.crowd
    here = crowd.position[0, crowd.ids[0] == person][0]
    assert_allclose(percept.forecast[row, place, 1], here, atol=1e-12)


@pytest.mark.parametrize("forecaster", ["oracle", "oracle_noisy@sigma=0.5+drop=0.5"])
def test_to_look_ahead_changes_nothing(forecaster):
    plain, _ = percepts("none", steps=20)
    looking, _ = percepts(forecaster, steps=20)
    assert_array_equal(plain.worlds.crowd.position, looking.worlds.crowd.position)


@pytest.mark.parametrize(
    "forecaster",
    [
        "oracle",
        "oracle_noisy@sigma=0.5+delay=0.4+drop=0.3",
        "constant_velocity_map",
        "social_force",
    ],
)
def test_a_forecast_depends_on_its_own_world_only(forecaster):
    keywords = {"scenario": "narrow_doorway", "steps": 5}
    _, together = percepts(forecaster, seeds=(3, 4, 5), **keywords)
    for world, seed in enumerate((3, 4, 5)):
        _, [(alone, row)] = percepts(forecaster, seeds=(seed,), **keywords)
        percept, place = together[world]
        assert_array_equal(percept.forecast[place], alone.forecast[row])


def test_without_blur_the_noisy_oracle_is_the_oracle():
    _, [(exact, row)] = percepts("oracle", steps=4)
    _, [(noisy, _)] = percepts("oracle_noisy@sigma=0", steps=4)
    assert_array_equal(exact.forecast[row], noisy.forecast[row])


def test_noise_has_its_standard_deviation_at_the_end_and_grows_evenly():
    errors = []
    for seed in range(40):
        _, [(exact, row)] = percepts("oracle", seeds=(seed,))
        _, [(noisy, _)] = percepts("oracle_noisy@sigma=0.5", seeds=(seed,))
        valid = exact.observed.valid[row]
        errors.append((noisy.forecast - exact.forecast)[row][valid])
    error = np.concatenate(errors)  # (P, F, 2)
    assert error[:, -1].std() == pytest.approx(0.5, rel=0.1)
    assert_allclose(error[:, 5], error[:, -1] / 2, atol=1e-12)


def test_all_dropped_people_are_forecast_to_stand():
    _, [(percept, row)] = percepts("oracle_noisy@drop=1", steps=6)
    valid = percept.observed.valid[row]
    here = percept.history[row, valid, -1]
    assert_array_equal(percept.forecast[row, valid], np.repeat(here[:, None], FRAMES, axis=1))


def test_a_delay_shifts_paths_in_time():
    path = np.arange(1.0, 5.0)[None, :, None, None] * np.ones((1, 4, 1, 2))
    now = np.zeros((1, 1, 1, 2))
    assert_allclose(delayed(path, now, 1.0)[0, :, 0, 0], [0.0, 1.0, 2.0, 3.0])
    assert_allclose(delayed(path, now, 0.5)[0, :, 0, 0], [0.5, 1.5, 2.5, 3.5])
    assert_allclose(delayed(path, now, 9.0)[0, :, 0, 0], 0.0)


@pytest.mark.parametrize(
    "spec", ["oracle_noisy@", "oracle_noisy@sigma", "oracle_noisy@size=1", "oracle_noisy@sigma=-1"]
)
def test_a_malformed_blur_is_refused(spec):
    with pytest.raises(ValueError, match="oracle_noisy@sigma=METRES"):
        Blur.parse(spec)


def test_a_share_above_one_is_refused():
    with pytest.raises(ValueError, match="drop: expected a share from 0 to 1, found 2"):
        Blur.parse("oracle_noisy@drop=2")


def test_paths_end_before_the_wall():
    path = np.linspace(0.5, 6.0, FRAMES)[:, None, None] * np.array([[[1.0, 0.0], [-1.0, 0.0]]])
    stopped = stop_at_walls(WALL, np.zeros((2, 2)), path)
    assert_allclose(stopped[:, 0, 0], np.minimum(path[:, 0, 0], 3.0 - ROOM))
    assert_array_equal(stopped[:, 1], path[:, 1])


def test_who_stands_stays():
    still = np.ones((FRAMES, 1, 2))
    assert_array_equal(stop_at_walls(WALL, np.ones((1, 2)), still), still)


def test_nobody_is_forecast_beyond_a_wall():
    env = CrowdNav(scenario="narrow_doorway", forecaster="constant_velocity_map")
    env.reset(seed=0)
    for _ in range(30):
        env.step(np.array([-1.0, 0.0]))
        percept, row = env.episodes.percept(0)
        ends = percept.forecast[row, percept.observed.valid[row], -1]
        assert env.episodes.scenarios[0].map.walkable(ends).all()
