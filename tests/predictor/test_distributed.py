"""Several processes train as one does."""

import json
import os
import socket
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from hand_made_crowds import walkers
from safetensors.torch import load_file
from torch.optim.optimizer import register_optimizer_step_post_hook

from crowdsim.recordings import write_recordings
from predictor.config import ModelConfig, named_configuration
from predictor.distributed import ALONE, Processes
from predictor.train import TrainResult, train
from predictor.training_state import batch_generator

NO_DROPOUT = ModelConfig(
    variant="patch",
    crop_px=16,
    latents=2,
    width=24,
    time_code=8,
    blocks=1,
    heads=2,
    dropout=0.0,
    residual=True,
)
COUNT = 2
BATCH = 26
RUN = """
import sys
from pathlib import Path
import torch
torch.set_num_threads(1)
sys.path.insert(0, "tests/predictor")
from test_distributed import run
from predictor.distributed import joined_processes
with joined_processes() as processes:
    run(Path(sys.argv[1]), "together", processes)
    run(Path(sys.argv[1]), "interrupted", processes)
"""


def run(folder: Path, out: str, processes: Processes = ALONE) -> TrainResult:
    """Two epochs of batches, of which the last has a single window."""
    _, residual = named_configuration("residual", epochs=2)
    return train(
        data=str(folder / "crowds"),
        out=folder / out,
        model=NO_DROPOUT,
        training=replace(residual, batch_size=BATCH),
        resume=True,
        device="cpu",
        save_seconds=0.0,
        progress=False,
        processes=processes,
    )


def interrupt_after(steps: int, folder: Path, out: str) -> None:
    """Train alone until the given update."""
    left = [steps]

    def count(*_: object) -> None:
        left[0] -= 1
        if left[0] == 0:
            raise KeyboardInterrupt

    hook = register_optimizer_step_post_hook(count)
    with pytest.raises(KeyboardInterrupt):
        run(folder, out)
    hook.remove()


def run_together(folder: Path) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    world = {"WORLD_SIZE": str(COUNT), "MASTER_ADDR": "127.0.0.1", "MASTER_PORT": str(port)}
    started = [
        subprocess.Popen(
            [sys.executable, "-c", RUN, str(folder)],
            cwd=Path(__file__).parents[2],
            env={**os.environ, **world, "RANK": str(rank), "LOCAL_RANK": str(rank)},
            stderr=subprocess.PIPE,
            text=True,
        )
        for rank in range(COUNT)
    ]
    said = [process.communicate()[1] for process in started]
    assert [process.returncode for process in started] == [0] * COUNT, said


def weights(folder: Path) -> torch.Tensor:
    return torch.cat([w.flatten() for w in load_file(folder / "last.safetensors").values()])


def validation(folder: Path) -> dict[str, float]:
    metrics = json.loads((folder / "last.json").read_text())["metrics"]
    assert metrics["epoch"] == 2
    return metrics["validation"]


def test_several_processes_train_the_same_weights_and_go_on_for_each_other(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    crowds = [walkers(rng, 7, 24, name=f"{i}") for i in range(4)]
    write_recordings(tmp_path / "crowds", crowds)
    alone = run(tmp_path, "alone")
    interrupt_after(3, tmp_path, "interrupted")
    run_together(tmp_path)
    for out in ("together", "interrupted"):
        assert validation(tmp_path / out) == pytest.approx(validation(tmp_path / "alone"), abs=1e-6)
        # single weights whose gradient is nothing but rounding are led astray by Adam
        distance = (weights(tmp_path / out) - weights(tmp_path / "alone")).abs()
        assert distance.mean() < 1e-5
    assert alone.windows % BATCH == 1


@pytest.mark.parametrize("rows", [1, 2, 7, 32])
def test_parts_are_the_whole_batch(rows: int) -> None:
    parts = [Processes(rank=rank, count=3).part(rows) for rank in range(3)]
    assert sum(share for _, share in parts) == pytest.approx(1.0)
    taken = np.concatenate([own for own, share in parts if share > 0.0])
    assert sorted(taken) == list(range(rows))


def test_one_process_takes_and_keeps_everything() -> None:
    own, share = ALONE.part(5)
    assert (own.tolist(), share) == ([0, 1, 2, 3, 4], 1.0)
    gradient = torch.arange(3.0)
    ALONE.add_up([gradient])
    assert gradient.tolist() == [0.0, 1.0, 2.0]


def test_processes_draw_alike_and_drop_out_differently() -> None:
    drawn = []
    with torch.random.fork_rng(devices=[]):
        for rank in (0, 1):
            rng = batch_generator(0, 1, 2, rank)
            drawn.append((rng.random(), torch.rand(1).item()))
    assert drawn[0][0] == drawn[1][0]
    assert drawn[0][1] != drawn[1][1]
