"""A training that was killed goes on as if nothing had happened."""

import json
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hand_made_crowds import walkers

from crowdsim.recordings import write_recordings
from predictor.config import ModelConfig, TrainConfig, named_configuration
from predictor.initial_weights import continued_network
from predictor.train import train
from predictor.training_state import FILE, Place, batch_generator, epoch_order

SMALL = ModelConfig(latents=2, width=24, time_code=8, blocks=1, heads=2, residual=True)
BATCHES = 5
RUN = """
import os, signal, sys
from dataclasses import replace
from pathlib import Path
import torch
from torch.optim.optimizer import register_optimizer_step_post_hook
torch.set_num_threads(1)  # as in the other processes of these tests: sums depend on it
sys.path.insert(0, "tests/predictor")
from test_resuming import run

steps = 0

def kill(*_):
    global steps
    steps += 1
    if steps == int(sys.argv[2]):
        os.kill(os.getpid(), signal.SIGKILL)

register_optimizer_step_post_hook(kill)
run(Path(sys.argv[1]), sys.argv[4], resume=True, save_seconds=float(sys.argv[3]))
"""
"""Trains, and kills itself in the middle of the step of which the number is given."""


def training(**changes: object) -> TrainConfig:
    _, residual = named_configuration("residual", epochs=3)
    return replace(residual, batch_size=16, **changes)


def run(
    folder: Path,
    out: str,
    *,
    resume: bool = False,
    save_seconds: float = 60.0,
    how: TrainConfig | None = None,
    init: Path | None = None,
) -> bytes:
    """The weights after three epochs of five batches, with dropout and everything random."""
    found = train(
        data=str(folder / "crowds"),
        out=folder / out,
        model=SMALL,
        training=training() if how is None else how,
        init=init,
        resume=resume,
        device="cpu",
        save_seconds=save_seconds,
        progress=False,
    )
    return found.checkpoint.read_bytes() + (folder / out / "last.safetensors").read_bytes()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("resuming")
    rng = np.random.default_rng(0)
    write_recordings(folder / "crowds", [walkers(rng, 6, 24, name=f"{i}") for i in range(4)])
    return folder


def killed_at(folder: Path, out: str, step: int, save_seconds: float) -> None:
    arguments = [sys.executable, "-c", RUN, str(folder), str(step), str(save_seconds), out]
    root = Path(__file__).parents[2]
    done = subprocess.run(arguments, cwd=root, capture_output=True, check=False)
    assert done.returncode == -signal.SIGKILL, done.stderr.decode()


def test_killed_and_resumed_is_never_killed(folder: Path) -> None:
    """Killed three steps after the last state, then at a step with a state of its own."""
    killed_at(folder, "killed", step=BATCHES + 3, save_seconds=60.0)
    killed_at(folder, "killed", step=4, save_seconds=0.0)
    assert run(folder, "killed", resume=True) == run(folder, "whole")


def test_a_finished_training_stays_as_it_is(folder: Path) -> None:
    assert run(folder, "finished") == run(folder, "finished", resume=True)


def test_another_training_is_not_gone_on_with(folder: Path) -> None:
    run(folder, "other", how=training(seed=1))
    with pytest.raises(ValueError, match=r"expected the same training.*'seed': 1"):
        run(folder, "other", resume=True, how=training(seed=2))


def test_a_damaged_state_is_refused(folder: Path) -> None:
    run(folder, "damaged")
    state = folder / "damaged" / FILE
    content = bytearray(state.read_bytes())
    content[len(content) // 2] ^= 1
    state.write_bytes(content)
    with pytest.raises(ValueError, match="damaged"):
        run(folder, "damaged", resume=True)


def test_early_stop_counts_epochs_without_a_better_one() -> None:
    place = Place()
    for error in (0.5, 0.4, 0.4, 0.45):
        assert not place.is_over(epochs=10, patience=2)
        place.finish_epoch({"ade": error, "fde": error})
    assert (place.best_epoch, place.epoch) == (2, 5)
    assert place.is_over(epochs=10, patience=2)
    assert not place.is_over(epochs=10, patience=None)
    assert place.is_over(epochs=4, patience=None)


def test_draws_of_a_batch_and_of_the_order_are_streams_of_their_own() -> None:
    first = [batch_generator(0, 1, 0).random(), batch_generator(0, 1, 1).random()]
    first += [batch_generator(0, 2, 0).random(), batch_generator(1, 1, 0).random()]
    assert len(set(first)) == 4
    assert not np.array_equal(epoch_order(64, 0, 1), epoch_order(64, 0, 2))


def test_trained_weights_are_epoch_0_and_part_of_what_is_gone_on_with(folder: Path) -> None:
    """Steps too large to learn by leave the initial weights the best."""
    run(folder, "first")
    init = folder / "first" / "best.safetensors"
    hopeless = training(learning_rate=0.5)
    kept = run(folder, "second", how=hopeless, init=init)
    assert kept.startswith(init.read_bytes())
    about = json.loads((folder / "second" / "best.json").read_text())
    assert about["metrics"]["epoch"] == 0
    assert about["init"]["sha256"] == json.loads(init.with_suffix(".json").read_text())["sha256"]
    assert run(folder, "second", how=hopeless, init=init, resume=True) == kept
    with pytest.raises(ValueError, match=r"expected the same training.*init"):
        run(folder, "second", how=hopeless, resume=True)


def test_weights_of_another_network_are_refused(folder: Path) -> None:
    run(folder, "plain")
    with pytest.raises(ValueError, match="the same network, found latents 2 there, 3 here"):
        continued_network(replace(SMALL, latents=3), 0, folder / "plain")
