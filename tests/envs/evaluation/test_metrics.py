import numpy as np
import pytest
from hand_made_traces import DT, make_trace, make_twin, walk

from envs.evaluation.forecast_scores import scored_forecasts
from envs.evaluation.metric_table import METRICS, aggregate_name
from envs.evaluation.metrics import (
    COLLISION_COURSE_LIMIT,
    distance_to_true_paths,
    navigation_metrics,
    pedestrian_delay,
    pedestrian_displacement,
    time_to_collision,
)

ROBOT = walk((0.0, 0.0), (1.0, 0.0), 25)  # 5 m along x in 5 s
BYSTANDER = walk((2.5, 1.0), (0.0, 0.0), 25)


def test_every_metric_is_named_and_defined() -> None:
    twin = make_twin([BYSTANDER])
    row = navigation_metrics(make_trace(ROBOT, [BYSTANDER]), twin)
    assert set(row) - set(METRICS) == {"collision_role", "forecast_count"}
    assert set(METRICS) <= set(row)


def test_a_straight_run_past_a_bystander() -> None:
    row = navigation_metrics(make_trace(ROBOT, [BYSTANDER]))
    assert row["success"] is True
    assert row["time_to_goal"] == row["time_to_goal_penalized"] == pytest.approx(5.0)
    assert row["path_length"] == pytest.approx(5.0)
    assert row["spl"] == pytest.approx(1.0)
    assert row["path_irregularity"] == pytest.approx(0.0, abs=1e-3)
    assert (row["speed_mean"], row["speed_max"]) == pytest.approx((1.0, 1.0))
    assert row["acceleration_max"] == pytest.approx(0.0, abs=1e-9)
    # 1 m between the centres, less 0.3 m and 0.2 m of radius, met at x = 2.4 and 2.6.
    assert row["clearance_min"] == pytest.approx(np.hypot(0.1, 1.0) - 0.5)
    assert row["stalled_time"] == 0.0
    assert row["failure_to_progress"] == 0


def test_zones_are_shares_of_time_by_clearance() -> None:
    row = navigation_metrics(make_trace(ROBOT, [BYSTANDER]))
    clearance = np.hypot(ROBOT[:, 0] - 2.5, 1.0) - 0.5
    assert row["intimate_zone_share"] == 0.0
    assert row["personal_zone_share"] == pytest.approx((clearance < 1.2).mean())
    assert row["social_zone_share"] == 1.0
    assert row["space_compliance_0.5"] == pytest.approx((clearance > 0.5).mean())


def test_a_failure_is_charged_the_limit_and_earns_no_spl() -> None:
    trace = make_trace(
        ROBOT,
        [BYSTANDER],
        termination_reason="collision_pedestrian",
        collision_role="robot_on_person",
    )
    row = navigation_metrics(trace)
    assert row["success"] is False
    assert row["collision_pedestrian"] is True
    assert np.isnan(row["time_to_goal"])
    assert row["time_to_goal_penalized"] == 30.0
    assert row["spl"] == 0.0
    assert row["collision_role"] == "robot_on_person"


def test_a_detour_halves_spl() -> None:
    trace = make_trace(ROBOT, [], shortest_path_lengths=np.array([2.5]))
    assert navigation_metrics(trace)["spl"] == pytest.approx(0.5)


def test_an_empty_world_leaves_distances_unknown() -> None:
    row = navigation_metrics(make_trace(ROBOT, []))
    assert np.isnan(row["clearance_min"])
    assert np.isnan(row["wall_clearance_min"])
    assert row["intrusion_ratio@4.8"] == 0.0
    assert row["space_compliance_0.5"] == 1.0
    assert row["time_to_collision_min"] == COLLISION_COURSE_LIMIT


def test_time_to_collision_counts_both_radii() -> None:
    oncoming = walk((10.0, 0.0), (-1.0, 0.0), 10)
    seconds = time_to_collision(make_trace(ROBOT[:11], [oncoming]))
    # 10 m between the centres, contact at 0.5 m, closing at 2 m/s.
    assert seconds[0] == pytest.approx((10.0 - 0.5) / 2.0)
    assert seconds[5] == pytest.approx((10.0 - 2.0 - 0.5) / 2.0)


def test_passing_people_are_on_no_collision_course() -> None:
    behind = walk((-1.0, 0.0), (0.5, 0.0), 10)  # slower, following
    beside = walk((10.0, 0.51), (-1.0, 0.0), 10)  # misses by 1 cm
    seconds = time_to_collision(make_trace(ROBOT[:11], [behind, beside]))
    assert (seconds == COLLISION_COURSE_LIMIT).all()
    touching = walk((10.0, 0.49), (-1.0, 0.0), 10)
    assert (time_to_collision(make_trace(ROBOT[:11], [touching])) < 5.0).all()


def test_a_person_who_is_not_there_is_on_no_collision_course() -> None:
    oncoming = walk((10.0, 0.0), (-1.0, 0.0), 10)
    trace = make_trace(ROBOT[:11], [oncoming], valid=np.zeros((11, 1), bool))
    assert (time_to_collision(trace) == COLLISION_COURSE_LIMIT).all()


def test_standing_in_somebodys_way_intrudes_as_long_as_the_horizon_sees_it() -> None:
    standing = walk((0.0, 0.0), (0.0, 0.0), 40)
    crossing = walk((-6.0, 0.4), (1.0, 0.0), 40)  # passes at x = 0 after 6 s, 0.4 m to the side
    trace = make_trace(standing, [crossing])
    seconds = np.arange(41) * DT
    # The nearest point of the way ahead is 0.5 m off from x = -0.3 on; it is behind from 0.3 on.
    for horizon in (1.2, 4.8):
        inside = distance_to_true_paths(trace, horizon) < trace.robot_radius
        expected = (seconds > 6.0 - 0.3 - horizon) & (seconds < 6.3)
        np.testing.assert_array_equal(inside, expected)


def test_intrusion_follows_the_true_path_and_not_the_heading() -> None:
    standing = walk((3.0, 0.0), (0.0, 0.0), 10)
    turning = np.concatenate([walk((0.0, 0.0), (1.0, 0.0), 5), walk((1.0, 0.2), (0.0, 1.0), 4)])
    row = navigation_metrics(make_trace(standing, [turning]))
    assert row["intrusion_ratio@4.8"] == 0.0
    assert np.isnan(row["social_distance@4.8"])


def test_intrusion_does_not_follow_a_respawned_person() -> None:
    standing = walk((5.0, 0.0), (0.0, 0.0), 4)
    jumping = np.array([[0.0, 0.0], [0.2, 0.0], [9.0, 0.0], [9.2, 0.0], [9.4, 0.0]])
    ids = np.array([[7], [7], [8], [8], [8]])
    one_person = make_trace(standing, [jumping])
    two_people = make_trace(standing, [jumping], ids=ids)
    assert (distance_to_true_paths(one_person, 4.8) < 0).any()
    assert (distance_to_true_paths(two_people, 4.8) > 3.0).all()


def test_turning_on_the_spot_is_unnecessary_rotation() -> None:
    heading = np.zeros(26)
    heading[10:] = 2 * np.pi * np.minimum(np.arange(16), 8) / 8
    row = navigation_metrics(make_trace(ROBOT, [], robot_heading=heading))
    assert row["cumulative_heading_change"] == pytest.approx(2 * np.pi)
    assert row["path_irregularity"] == pytest.approx(2 * np.pi / 5.0, abs=1e-3)


def test_a_start_that_faces_away_must_turn() -> None:
    heading = np.concatenate([[np.pi / 2], np.zeros(25)])
    row = navigation_metrics(make_trace(ROBOT, [], robot_heading=heading))
    assert row["cumulative_heading_change"] == pytest.approx(np.pi / 2)
    assert row["path_irregularity"] == pytest.approx(0.0, abs=1e-3)


def test_standing_still_is_stalled_and_makes_no_progress() -> None:
    robot = np.concatenate([walk((0.0, 0.0), (0.0, 0.0), 50), walk((0.2, 0.0), (1.0, 0.0), 24)])
    row = navigation_metrics(make_trace(robot, []))
    assert row["stalled_time"] == pytest.approx(10.0)
    assert row["failure_to_progress"] == 2


def test_displacement_and_delay_of_a_person_who_waited_a_second() -> None:
    undisturbed = walk((0.0, 5.0), (1.0, 0.0), 60)
    waited = np.concatenate([np.repeat(undisturbed[:1], 5, axis=0), undisturbed[:21]])
    trace = make_trace(ROBOT, [waited])
    twin = make_twin([undisturbed])
    # A quarter of a step of 0.2 m may be given away to the tolerance of the look-up.
    assert pedestrian_delay(trace, twin) == pytest.approx(1.0, abs=0.05)
    expected = np.linalg.norm(waited - undisturbed[:26], axis=1).mean()
    assert pedestrian_displacement(trace, twin) == pytest.approx(expected)


def test_people_who_are_not_disturbed_are_not_late() -> None:
    walking, standing = walk((0.0, 5.0), (1.0, 0.0), 60), walk((0.0, 8.0), (0.0, 0.0), 60)
    trace = make_trace(ROBOT, [walking[:26], standing[:26]])
    twin = make_twin([walking, standing])
    assert pedestrian_delay(trace, twin) == 0.0
    assert pedestrian_displacement(trace, twin) == 0.0


def test_a_person_pushed_on_is_early() -> None:
    undisturbed = walk((0.0, 5.0), (1.0, 0.0), 60)
    pushed = walk((0.0, 5.0), (1.2, 0.0), 25)
    delay = pedestrian_delay(make_trace(ROBOT, [pushed]), make_twin([undisturbed]))
    assert delay == pytest.approx(-1.0, abs=0.05)


def test_without_a_twin_the_effect_on_people_is_unknown() -> None:
    row = navigation_metrics(make_trace(ROBOT, [BYSTANDER]))
    assert np.isnan(row["pedestrian_delay"])
    assert np.isnan(row["pedestrian_displacement"])


def test_forecast_errors_pair_each_step_with_the_truth_at_its_time() -> None:
    person = walk((0.0, 3.0), (1.0, 0.0), 25)
    # Constant velocity is right at every step; shifted up by 0.1 m it errs by that much.
    ahead = 0.4 * np.arange(1, 4)[:, None] * np.array([1.0, 0.0])
    forecast = person[:, None, None] + ahead + np.array([0.0, 0.1])  # (T, 1, 3, 2)
    trace = make_trace(
        ROBOT, [BYSTANDER, person], forecast=forecast, forecast_ids=np.ones((26, 1), np.int64)
    )
    errors = scored_forecasts(trace).error
    assert errors.shape == (26 - 6, 3)
    np.testing.assert_allclose(errors, 0.1)
    row = navigation_metrics(trace)
    assert (row["forecast_ade"], row["forecast_fde"]) == pytest.approx((0.1, 0.1))


def test_forecasts_of_people_who_leave_do_not_count() -> None:
    person = walk((0.0, 3.0), (1.0, 0.0), 10)
    forecast = np.zeros((11, 2, 2, 2))
    forecast_ids = np.tile([0, -1], (11, 1))
    ids = np.where(np.arange(11) < 6, 0, 9)[:, None]  # somebody else from row 6 on
    trace = make_trace(ROBOT[:11], [person], forecast=forecast, forecast_ids=forecast_ids, ids=ids)
    # Two frames of 0.4 s are 4 rows: only rows 0 and 1 end before row 6.
    assert len(scored_forecasts(trace).error) == 2


def test_forecasts_of_nobody_have_no_error() -> None:
    trace = make_trace(
        ROBOT,
        [],
        forecast=np.zeros((26, 2, 3, 2)),
        forecast_ids=np.full((26, 2), -1),
    )
    row = navigation_metrics(trace)
    assert np.isnan(row["forecast_fde"])
    assert row["forecast_count"] == 0


def test_a_mean_over_successes_says_so() -> None:
    assert aggregate_name("time_to_goal") == "time_to_goal_on_success"
    assert aggregate_name("path_length") == "path_length"
