from dataclasses import replace

import numpy as np
import pytest
from test_world import CALM, SQUARE, run, scenario, world

from crowdsim.motion import MODEL_NAMES, MotionModel, draw_models
from crowdsim.pedestrians import Pedestrians
from crowdsim.robot_body import RobotBody
from crowdsim.scenarios import make_scenario

EVERY_MODEL = dict.fromkeys(MODEL_NAMES, 0.25)
CONSTANT, FORCE = MotionModel.CONSTANT_VELOCITY, MotionModel.SOCIAL_FORCE


def moving_by(models, position, waypoints, **changes):
    start = scenario(position, waypoints, **changes)
    people = replace(start.pedestrians, model=np.array(models, dtype=np.int64))
    return replace(start, pedestrians=people)


class TestDraws:
    def test_one_name_is_everybodys_model_and_draws_nothing(self):
        rng = np.random.default_rng(0)
        before = rng.bit_generator.state
        np.testing.assert_array_equal(draw_models(rng, 3, "orca"), 3 * [MotionModel.ORCA])
        assert rng.bit_generator.state == before

    def test_shares_hold_on_average(self):
        drawn = draw_models(np.random.default_rng(0), 4000, {"orca": 0.3, "social_force": 0.7})
        assert set(drawn) == {MotionModel.ORCA, FORCE}
        assert np.mean(drawn == MotionModel.ORCA) == pytest.approx(0.3, abs=0.03)

    def test_unknown_names_are_refused_with_the_known_ones(self):
        with pytest.raises(ValueError, match=r"social_force, .*constant_velocity, found 'sfm'"):
            draw_models(np.random.default_rng(0), 3, {"sfm": 1.0})

    @pytest.mark.parametrize("shares", [{"orca": 0.5}, {"orca": 1.5, "social_force": -0.5}, {}])
    def test_what_are_no_shares_is_refused(self, shares):
        with pytest.raises(ValueError, match="add up to 1"):
            draw_models(np.random.default_rng(0), 3, shares)

    def test_models_change_no_other_draw(self):
        place = np.arange(12.0).reshape(6, 2)
        plain, mixed = (
            Pedestrians.draw(
                np.random.default_rng(5), position=place, waypoints=-place, model=model
            )
            for model in ("social_force", EVERY_MODEL)
        )
        np.testing.assert_array_equal(plain.desired_speed, mixed.desired_speed)
        np.testing.assert_array_equal(plain.radius, mixed.radius)
        assert (plain.model != mixed.model).any()

    def test_unknown_codes_are_refused(self):
        with pytest.raises(ValueError, match="codes of MotionModel"):
            moving_by([9], [[0.0, 0.0]], [[1.0, 0.0]])


class TestConstantVelocity:
    def test_nobody_and_nothing_turns_it_aside(self):
        walls = np.array([[[-5.0, 0.4], [5.0, 0.4]]])
        start = moving_by(
            [CONSTANT, FORCE],
            [[-4.0, 0.0], [0.0, -0.55]],
            [[4.0, 0.0], [0.0, -0.55]],
            world_map=replace(SQUARE, walls=walls),
            desired_speed=[1.0, 0.0],
        )
        running = world(start, social_force=CALM)
        run(running, 6.0)
        np.testing.assert_allclose(running.positions[0], [2.0, 0.0], atol=1e-9)
        assert running.positions[1, 1] < -0.55

    def test_its_body_is_as_solid_as_any(self):
        meeting = [[-3.0, 0.0], [3.0, 0.0]], [[3.0, 0.0], [-3.0, 0.0]]
        running = world(moving_by([CONSTANT, CONSTANT], *meeting, desired_speed=1.3))
        gap = np.inf
        for _ in range(100):
            running.step()
            gap = min(gap, np.linalg.norm(np.subtract(*running.positions)) - 0.5)
        assert -0.03 < gap < 0.01
        assert running.positions[0, 0] < running.positions[1, 0]


class TestMixedCrowd:
    def test_a_social_force_in_mixed_company_feels_all_as_in_its_own(self):
        places = [[0.0, 0.0], [1.0, 0.2]], [[5.0, 0.0], [5.0, 0.2]]
        velocities = []
        for other in MotionModel:
            running = world(moving_by([FORCE, other], *places))
            running.step()
            velocities.append(running.velocities[0])
        np.testing.assert_array_equal(velocities, [velocities[0]] * len(MotionModel))

    @pytest.mark.parametrize("model", [*MODEL_NAMES, EVERY_MODEL], ids=[*MODEL_NAMES, "mixed"])
    @pytest.mark.parametrize("name", ["narrow_doorway", "urban_crossing"])
    def test_nobody_walks_through_walls_and_all_keep_walking(self, name, model):
        rng = np.random.default_rng(3)
        start = make_scenario(name, rng, model=model)
        running = world(start, robot=RobotBody())
        moving = []
        for _ in range(400):
            running.step((0.5, 0.3))
            people = running.positions[running.valid]
            assert start.map.walkable(people).all()
            speed = np.linalg.norm(running.velocities, axis=1) / running.desired_speed
            moving.append((speed[running.valid] > 0.1).mean())
        assert np.mean(moving) > 0.85

    def test_same_seed_gives_the_same_bits(self):
        states = []
        for _ in range(2):
            rng = np.random.default_rng(4)
            running = world(make_scenario("circular_crossing", rng, model=EVERY_MODEL))
            run(running, 10.0)
            states.append(running.positions.tobytes())
        assert states[0] == states[1]

    def test_a_forked_world_goes_on_with_the_same_bits(self):
        rng = np.random.default_rng(4)
        running = world(make_scenario("circular_crossing", rng, model=EVERY_MODEL))
        run(running, 3.0)
        twin = running.fork()
        run(running, 3.0)
        run(twin, 3.0)
        np.testing.assert_array_equal(twin.positions, running.positions)
