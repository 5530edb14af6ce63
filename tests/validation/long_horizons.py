"""Errors of forecasts up to 19.2 s, step by step: measured one forecaster at a time, then drawn.

`python tests/validation/long_horizons.py measure DATA FORECASTER FILE.json` forecasts every agent
who is there for 8 + 48 frames, min_ped 0 (`standing` is a forecaster here: everybody stays);
`… draw PICTURE.png FILE.json …` prints the table and draws the curves, a panel for each data set.
"""

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import torch
from matplotlib.figure import Figure
from numpy.typing import NDArray

from predictor.constant_velocity import ConstantVelocityForecaster
from predictor.datasets import read_tests
from predictor.forecaster import Forecaster, make_forecaster
from predictor.trajectory_errors import trajectory_errors

HORIZON: Final = 19.2
SHOWN: Final = (4.8, 9.6, 14.4, 19.2)
COLORS: Final = ("#7f8a99", "#16181d", "#c2410c", "#1d4f91", "#0f766e")


class Standing(ConstantVelocityForecaster):
    """Everybody stays where they are."""

    name = "standing"

    def forecast(
        self,
        history: NDArray[np.float64],
        valid: NDArray[np.bool_],
        *_: Any,
        **__: Any,
    ) -> NDArray[np.float64]:
        return np.repeat(history[:, -1:], self.forecast_steps, axis=1)


def measure(data: str, spec: str, file: Path) -> None:
    """Write errors per step, of all and of those who move, the mean over folds, and coverage."""
    torch.set_num_threads(1)
    forecaster: Forecaster | None = Standing(forecast_steps=48)
    if spec != "standing":
        forecaster = make_forecaster(spec, horizon=HORIZON)
    assert forecaster is not None
    rows = []
    for recordings in read_tests(data).values():
        found = trajectory_errors(forecaster, recordings)
        errors, moving = found.errors, found.errors[found.moving]
        row = {"n": len(errors), "moving_n": len(moving)}
        if found.radius is not None:
            row["coverage"] = (errors <= found.radius).mean(axis=0)
        rows.append(row | {"all": errors.mean(axis=0), "moving": moving.mean(axis=0)})
    table = {"data": data, "forecaster": spec, "frame_dt": forecaster.frame_dt}
    for key in rows[0]:
        values = np.array([row[key] for row in rows])
        table[key] = int(values.sum()) if key.endswith("n") else values.mean(axis=0).tolist()
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(table))


def draw(picture: Path, files: Sequence[Path]) -> None:
    """Print errors at some horizons and draw the curves of those who move."""
    tables = [json.loads(file.read_text()) for file in files]
    panels = list(dict.fromkeys(table["data"] for table in tables))
    names = list(dict.fromkeys(table["forecaster"] for table in tables))
    colors = dict(zip(names, COLORS, strict=False))
    figure = Figure(figsize=(4.8 * len(panels), 3.8), layout="constrained")
    for number, data in enumerate(panels):
        axes = figure.add_subplot(1, len(panels), number + 1)
        ours = [table for table in tables if table["data"] == data]
        for table in ours:
            print_row(table)
            times = table["frame_dt"] * np.arange(1, 1 + len(table["moving"]))
            name = table["forecaster"]
            axes.plot(times, table["moving"], color=colors[name], label=title(name))
        axes.set_title(f"{title(data)}, n = {ours[0]['moving_n']} who move", fontsize=10)
        axes.set(xlabel="ahead [s]", ylabel="displacement error [m]", xlim=(0, HORIZON), ylim=0)
        axes.set_xticks(SHOWN)
        axes.grid(alpha=0.25)
        axes.legend(fontsize=8)
    figure.savefig(picture, dpi=110)


def title(name: str) -> str:
    return Path(name).name.replace("_", " ")


def print_row(table: dict[str, Any]) -> None:
    at = [round(time / table["frame_dt"]) - 1 for time in SHOWN]
    cells = [f"{table['all'][k]:.2f} ({table['moving'][k]:.2f})" for k in at]
    held = [f"{table['coverage'][k]:.2f}" for k in at] if "coverage" in table else []
    sys.stdout.write(
        f"{table['data']:28} n {table['n']} ({table['moving_n']}) {table['forecaster']:22} "
        f"{'  '.join(cells)}  {' '.join(held)}\n"
    )


if __name__ == "__main__":
    if sys.argv[1] == "measure":
        measure(sys.argv[2], sys.argv[3], Path(sys.argv[4]))
    else:
        draw(Path(sys.argv[2]), [Path(name) for name in sys.argv[3:]])
