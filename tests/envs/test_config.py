import json

import pytest

from envs.config import CrowdNavConfig, make_config, whole_multiple


def test_counts_of_clocks_are_rounded_not_truncated():
    # 4.8 // 0.4 is 11 and 0.6 // 0.2 is 2 in floating point.
    config = make_config(horizon=4.8, frame_dt=0.6, policy_dt=0.2, physics_dt=0.05)
    assert config.forecast_steps == 8
    assert config.policy_steps_per_frame == 3
    assert make_config(horizon=4.8).forecast_steps == 12
    assert make_config().physics_steps == 4


def test_unknown_keyword_lists_the_known_ones():
    with pytest.raises(ValueError, match=r"unknown keyword robots; known are .*robot,"):
        make_config(robots="unicycle")


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"robot": "car"}, "robot must be one of"),
        ({"policy_dt": 0.12}, r"policy_dt must be a whole multiple of physics_dt=0.05 s, got 0.12"),
        ({"frame_dt": 0.5}, "frame_dt must be a whole multiple of policy_dt"),
        ({"horizon": 1.0}, "horizon must be a whole multiple of frame_dt"),
        ({"sensor_range": float("nan")}, "sensor_range must be a positive number"),
        ({"max_speed": 0}, "max_speed must be a positive number"),
        ({"time_limit": -1.0}, "time_limit must be a positive number"),
        ({"pedestrians_observed": 2.5}, "pedestrians_observed must be a positive whole number"),
        ({"history_steps": True}, "history_steps must be a positive whole number"),
        ({"goal_weight": float("inf")}, "goal_weight must be finite"),
        ({"robot_awareness": 1.5}, "robot_awareness must be in 0..1"),
        ({"robot_visible": "yes"}, "robot_visible must be true or false"),
        ({"missed_detections": -0.1}, "missed_detections must be in 0..1"),
        ({"position_noise": float("nan")}, "position_noise must be at least 0"),
        ({"mission": -1.0}, "mission must be at least 0"),
        ({"frame_jitter": 0.3}, "frame_jitter must be at most policy_dt=0.2 s, got 0.3"),
        ({"track_memory": -1.0}, "track_memory must be at least 0"),
        ({"field_of_view": 7.0}, "field_of_view must be at most 2 pi"),
        ({"history_kept": 0}, "history_kept must be a positive whole number"),
        ({"crowd_speed": 0.0}, "crowd_speed must be a positive number"),
    ],
)
def test_bad_values_are_refused_by_name(keywords, message):
    with pytest.raises(ValueError, match=message):
        make_config(**keywords)


def test_a_clock_of_zero_steps_is_no_multiple():
    with pytest.raises(ValueError, match="whole multiple"):
        whole_multiple("policy_dt", 0.01, "physics_dt", 0.05)


def test_every_default_fits_into_json():
    assert json.loads(json.dumps(vars(CrowdNavConfig()))) == vars(CrowdNavConfig())
