import math
from dataclasses import replace

import numpy as np
import pytest
from test_world import CALM, run, scenario, world

from crowdsim.headed import HeadedSocialForce, along_heading, turn, walk_ahead
from crowdsim.motion import MotionModel


def headed(position, waypoints, **changes):
    start = scenario(position, waypoints, **changes)
    model = np.full(len(position), MotionModel.HEADED_SOCIAL_FORCE)
    return replace(start, pedestrians=replace(start.pedestrians, model=model))


def headings(running):
    return running._crowd.turning[:, 0]


def test_forces_by_hand_of_somebody_who_faces_up():
    ahead = along_heading(0.5, 2.0, 0.3, 0.1, 0.2, math.pi / 2, 0.8, 6.0)
    # Forward is +y and left is -x: 2.0 + 0.1 ahead, 0.8 * -0.3 - 6.0 * 0.2 to the left.
    assert ahead == pytest.approx((0.8 * 0.3 + 6.0 * 0.2, 2.1))


def test_heading_settles_as_the_equation_says():
    stiffness, alpha, dt = 12.0, 3.0, 1e-4
    rate = math.sqrt(stiffness / alpha)
    heading, turning = 1.0, 0.0
    for _ in range(5000):
        heading, turning = turn(heading, turning, 0.0, stiffness, alpha, dt)
    time = 5000 * dt
    exact = (alpha * math.exp(-rate * time) - math.exp(-alpha * rate * time)) / (alpha - 1)
    assert heading == pytest.approx(exact, abs=1e-3)


def test_heading_takes_the_shorter_way_round():
    heading, rate = turn(math.pi - 0.1, 0.0, -math.pi + 0.1, 10.0, 3.0, 0.05)
    assert rate > 0
    assert heading == pytest.approx(math.pi - 0.1 + 0.05 * rate)


def test_no_stiffness_makes_the_heading_swing():
    heading, rate, headings = 1.0, 0.0, []
    for _ in range(100):
        heading, rate = turn(heading, rate, 0.0, 300.0, 3.0, 0.05)
        headings.append(heading)
    assert min(headings) > -0.2
    assert abs(headings[-1]) < 1e-6


def test_turning_the_scene_turns_accelerations_and_headings():
    rng = np.random.default_rng(0)
    angle = 0.7
    turned = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    bodies, direction, forces = (
        rng.normal(size=(6, 4)),
        rng.normal(size=(6, 2)),
        rng.normal(size=(6, 2)),
    )
    facing = rng.uniform(-2, 2, 6)
    results = []
    for rotation, offset in ((np.eye(2), 0.0), (turned, angle)):
        acceleration = forces @ rotation
        turning = np.stack([facing + offset, np.full(6, 0.3)], axis=1)
        walk_ahead(
            np.arange(6),
            np.concatenate([bodies[:, :2] @ rotation, bodies[:, 2:] @ rotation], axis=1),
            np.ones(6, dtype=bool),
            direction @ rotation,
            np.full(6, 1.3),
            np.full(6, 0.5),
            np.full(6, 80.0),
            0.05,
            HeadedSocialForce().record(),
            turning,
            acceleration,
        )
        results.append((acceleration @ rotation.T, turning - [offset, 0.0]))
    np.testing.assert_allclose(results[1][0], results[0][0], atol=1e-12)
    off = results[1][1] - results[0][1]
    np.testing.assert_allclose(np.exp(1j * off[:, 0]), 1.0, atol=1e-12)
    np.testing.assert_allclose(off[:, 1], 0.0, atol=1e-12)


def test_somebody_alone_walks_straight_as_by_the_plain_social_force():
    running = world(headed([[-5.0, 0.0]], [[5.0, 0.0]], desired_speed=1.2), social_force=CALM)
    run(running, 4.0)
    np.testing.assert_allclose(running.positions, [[-0.2, 0.0]], atol=1e-9)


def test_people_turn_before_they_walk_another_way():
    corner = headed([[-4.0, 0.0]], [[[0.0, 0.0], [0.0, 6.0]]], desired_speed=1.3)
    running = world(corner, social_force=CALM)
    sideways, speed = [], []
    for _ in range(120):
        running.step()
        (vx, vy), heading = running.velocities[0], headings(running)[0]
        sideways.append(abs(vy * math.cos(heading) - vx * math.sin(heading)))
        speed.append(math.hypot(vx, vy))
    assert headings(running)[0] == pytest.approx(math.pi / 2, abs=0.1)
    assert 0.05 < max(sideways) < 0.6
    assert min(speed) < 1.2


def test_who_stops_still_faces_the_goal():
    running = world(headed([[0.0, 0.0]], [[4.0, 0.0]]), social_force=CALM)
    for _ in range(400):
        running.step()
        assert abs(headings(running)[0]) < 0.05
    np.testing.assert_allclose(running.positions, [[4.0, 0.0]], atol=0.05)


def test_who_enters_anew_does_not_face_the_way_that_the_last_one_did():
    start = headed([[0.0, 0.0]], [[[4.0, 0.0], [4.0, 5.0]]], on_arrival="respawn")
    running = world(start)
    while running.valid[0]:
        running.step()
    assert headings(running)[0] == pytest.approx(math.pi / 2, abs=0.2)
    running.step()
    assert np.isnan(headings(running)[0])
    running.step()
    assert headings(running)[0] == pytest.approx(0.0, abs=0.05)


@pytest.mark.parametrize("broken", [{"sideways": -1.0}, {"damping": np.nan}, {"alpha": 0.0}])
def test_broken_parameters_are_refused(broken):
    with pytest.raises(ValueError, match=f"{next(iter(broken))}: expected"):
        HeadedSocialForce(**broken)
