"""What must hold for every robot and every forecaster, whatever learns or plans on top."""

import copy
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from stable_baselines3.common.env_checker import check_env as sb3_check_env

from envs.config import CrowdNavConfig
from envs.policies import SIMPLE, make_policy
from predictor.forecaster import make_forecaster

IDS = ("crowdnav/CrowdNav-v0", "crowdnav/CrowdNavFlat-v0")
ROBOTS = ("unicycle", "holonomic", "bicycle")
FORECASTERS = (
    "none",
    "constant_velocity",
    "constant_velocity_map",
    "social_force",
    "iterative_attention",
    "fast",
    "oracle",
    "oracle_noisy@sigma=0.3+delay=0.4+drop=0.2",
)
SMALL = {"scenario_parameters": {"pedestrians": 3}, "pedestrians_observed": 2, "horizon": 1.2}
SENSORS = {
    "occlusion": True,
    "field_of_view": 4.0,
    "missed_detections": 0.3,
    "position_noise": 0.1,
    "track_loss_rate": 0.3,
    "track_memory": 1.0,
    "frame_jitter": 0.1,
    "horizon": 1.2,
}
ROLLING = np.tile(np.array([0.2, 0.1], dtype=np.float32), (3, 1))


@pytest.mark.parametrize("forecaster", FORECASTERS)
@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("env_id", IDS)
def test_the_checkers_have_nothing_to_say(env_id, robot, forecaster):
    env = gymnasium.make(env_id, robot=robot, forecaster=forecaster, **SMALL)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped)
        if env_id == "crowdnav/CrowdNavFlat-v0":
            # For keys of rank 3 it has no network of its own, and says so.
            sb3_check_env(env)


@pytest.mark.parametrize("policy", SIMPLE)
@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("people", [0, 12])
def test_every_policy_copes_with_nobody_and_with_more_than_it_observes(
    people, robot, policy, scene
):
    row, column = np.divmod(np.arange(people), 4)
    places = np.stack((3.0 + row, column - 1.5), axis=1)
    name = scene(people=places, goals=-places)
    config = CrowdNavConfig(scenario=name, robot=robot, pedestrians_observed=4)
    env = gymnasium.make("crowdnav/CrowdNav-v0", scenario=name, robot=robot, pedestrians_observed=4)
    observation, _ = env.reset(seed=0)
    assert observation["neighbors_valid"].sum() == min(people, 4)
    planner = make_policy(policy, config)
    for _ in range(4):
        action = planner.act(observation)
        assert np.isfinite(action).all()
        assert np.abs(action).max() <= 1.0 + 1e-6
        observation, *_ = env.step(action)


@pytest.mark.parametrize("forecaster", FORECASTERS)
def test_a_seed_fixes_every_bit_whatever_was_before_and_runs_beside(forecaster):
    # Robots start at y = 0 here, where the sign of a zero would tell of the episode before.
    keywords = {"scenario": "narrow_doorway", "forecaster": forecaster, **SENSORS}
    used = gymnasium.make_vec("crowdnav/CrowdNav-v0", num_envs=3, **keywords)
    used.reset(seed=90)
    for _ in range(12):
        used.step(ROLLING)
    together = watched(used, 5)
    for world in range(3):
        alone = gymnasium.make_vec("crowdnav/CrowdNav-v0", num_envs=1, **keywords)
        for (seen, reward), (one, own) in zip(together, watched(alone, 5 + world), strict=True):
            same(of(seen, world), of(one, 0))
            assert reward[world] == own[0]


@pytest.mark.parametrize("forecaster", FORECASTERS)
def test_an_episode_after_another_is_as_if_it_were_the_first(forecaster):
    keywords = {"scenario": "narrow_doorway", "forecaster": forecaster, "time_limit": 1.6}
    keywords |= SENSORS
    used = gymnasium.make_vec("crowdnav/CrowdNav-v0", num_envs=2, **keywords)
    used.reset(seed=0)
    for _ in range(7):
        used.step(ROLLING[:2])
    generator = copy.deepcopy(used.unwrapped._generators[1])
    observation, _, _, truncated, _ = used.step(ROLLING[:2])
    assert truncated.all()
    fresh = gymnasium.make("crowdnav/CrowdNav-v0", **keywords).unwrapped
    fresh.np_random = generator
    same(of(observation, 1), fresh.reset()[0])
    for _ in range(6):
        same(of(used.step(ROLLING[:2])[0], 1), fresh.step(ROLLING[1])[0])


@pytest.mark.parametrize("forecaster", FORECASTERS[1:])
def test_forecasts_of_who_walks_away_ahead_lead_along_plus_x(forecaster, scene):
    ahead = np.array([-0.6, 0.8])
    name = scene(
        people=3.0 * ahead,
        goals=12.0 * ahead,
        robot=(0.0, 0.0, np.arctan2(ahead[1], ahead[0])),
        goal=tuple(8.0 * ahead),
    )
    modal = 2 if forecaster in ("fast", "iterative_attention") else 0
    env = gymnasium.make(
        "crowdnav/CrowdNav-v0", scenario=name, forecaster=forecaster, modes_observed=modal
    )
    env.reset(seed=0)
    for _ in range(6):
        observation, *_ = env.step(np.array([-1.0, 0.0]))
    paths = [observation["forecast"][0]]
    if modal:
        paths.append(observation["forecast_modes"][0, 0])
    for path in paths:
        assert (path[:, 0] > observation["history"][0, 0, 0]).all()
        assert np.abs(path[:4, 1]).max() < 0.5


@pytest.mark.parametrize("name", ["constant_velocity", "fast"])
def test_a_forecaster_itself_is_as_good_as_its_name(name):
    envs = [
        gymnasium.make("crowdnav/CrowdNav-v0", forecaster=forecaster)
        for forecaster in (name, make_forecaster(name))
    ]
    for _ in range(2):
        by_name, itself = (env.reset(seed=3)[0] for env in envs)
        same(by_name, itself)
        for _ in range(8):
            by_name, itself = (env.step(ROLLING[0])[0] for env in envs)
            same(by_name, itself)


def test_what_cannot_forecast_is_refused():
    with pytest.raises(ValueError, match=r"forecaster must be a name, .*, got 3"):
        gymnasium.make("crowdnav/CrowdNav-v0", forecaster=3)
    with pytest.raises(ValueError, match="forecast_steps must be 12 for the forecaster constant_v"):
        gymnasium.make(
            "crowdnav/CrowdNav-v0", forecaster=make_forecaster("constant_velocity"), horizon=2.4
        )


def watched(env, seed):
    """Observations and rewards of some steps, the robot rolling along."""
    observation, _ = env.reset(seed=seed)
    found = [(observation, np.zeros(env.num_envs))]
    for _ in range(9):
        observation, reward, *_ = env.step(ROLLING[: env.num_envs])
        found.append((observation, reward))
    return found


def of(observation, world):
    return {key: values[world] for key, values in observation.items()}


def same(observation, other):
    """Equal to the bit; a zero has a sign, too."""
    assert observation.keys() == other.keys()
    for key, values in observation.items():
        assert values.dtype == other[key].dtype
        assert values.tobytes() == other[key].tobytes(), key
