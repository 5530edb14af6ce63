"""What the environment hands the predictor is what the predictor was trained on."""

from dataclasses import fields

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from crowdsim.recordings import Picture, Recording
from crowdsim.render import render_map
from envs.crowd_nav import CrowdNav
from predictor.config import ModelConfig
from predictor.constant_velocity import ConstantVelocityForecaster
from predictor.inputs import AgentInputs, build_inputs
from predictor.scenes import scenes
from predictor.windows import extract_windows

MODEL = ModelConfig(variant="patch", crop_px=32)
PER_FRAME = 2
ROBOT_ID = 10_000


class Listening(ConstantVelocityForecaster):
    """Keeps what it is handed."""

    def __init__(self):
        super().__init__(forecast_steps=12)
        self.heard = []

    def forecast(self, history, valid, map_images=None, pixel_from_world=None, select=None):
        world = history[0].copy(), valid[0].copy(), map_images[0], pixel_from_world[0]
        self.heard.append(world)
        return super().forecast(history, valid, map_images, pixel_from_world, select)


@pytest.fixture
def listening():
    return Listening()


def recorded(trace, *, with_robot):
    """The world of a trace as a training recording: a row every frame, a track for each id."""
    rows = np.arange(0, len(trace.position), PER_FRAME)
    frame, column = np.nonzero(trace.valid[rows])
    ids = trace.ids[rows][frame, column]
    position = trace.position[rows][frame, column]
    if with_robot:
        frame = np.append(frame, np.arange(len(rows)))
        ids = np.append(ids, np.full(len(rows), ROBOT_ID))
        position = np.concatenate([position, trace.robot_position[rows]])
    picture = Picture(*render_map(trace.scenario.map))
    return Recording.from_rows("trace", frame, ids, position, picture=picture)


def windows_of(recording):
    """First row and the agents' ids of each training window, in the order of the data set."""
    for start in recording.windows(8, 12):
        seen = recording.valid[start : start + 8].any(axis=0)
        stays = recording.valid[start : start + 20].all(axis=0)
        if stays.any():
            yield start, recording.ids[seen & stays]


def picked(inputs, rows):
    return {field.name: getattr(inputs, field.name)[rows] for field in fields(AgentInputs)}


@pytest.mark.parametrize("visible", [False, True])
@pytest.mark.parametrize("scenario", ["circular_crossing", "parallel_traffic", "narrow_doorway"])
def test_inputs_equal_those_of_the_training_data(scenario, visible, listening):
    env = CrowdNav(
        scenario=scenario,
        robot_visible=visible,
        sensor_range=500.0,
        forecaster=listening,
        record=True,
        time_limit=10.0,
    )
    ended, seed = False, 0
    while not ended or len(env.trace.position) < 40:
        listening.heard.clear()
        env.reset(seed=seed)
        ended, seed = False, seed + 1
        while not ended:
            ended = any(env.step((-0.8, 0.1))[2:4])
    recording = recorded(env.trace, with_robot=visible)
    training, _ = extract_windows([recording], MODEL).batch(np.arange(_agents(recording)))
    done = 0
    for start, ids in windows_of(recording):
        step = (start + 7) * PER_FRAME
        history, valid, image, homography = listening.heard[step]
        people = np.isin(ids, env.trace.ids[step])
        columns = [np.flatnonzero(env.trace.ids[step] == own)[0] for own in ids[people]]
        serving = build_inputs(history, valid, np.array(columns), image, homography, MODEL)
        rows = done + np.flatnonzero(people)
        for name, expected in picked(training, rows).items():
            assert_array_equal(getattr(serving, name), expected, err_msg=name)
        done += len(ids)
    assert done == len(training) > 10


def _agents(recording):
    config = {"history_steps": 8, "forecast_steps": 12}
    return sum(len(scene.agents) for scene in scenes(recording, **config))
