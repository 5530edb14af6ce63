"""What a stress test leaves beside its report: rows, numbers, a Markdown table and plots."""

import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from matplotlib.figure import Figure

from crowdsim.recordings.store import write_atomic
from envs.evaluation.episode_rows import rows_as_parquet
from envs.evaluation.forecast_cells import CELL_COLUMNS
from envs.evaluation.knobs import value_text
from envs.evaluation.metric_table import METRICS, aggregate_name
from envs.evaluation.stress import Stress
from envs.evaluation.wording import number, share
from envs.report import plots
from envs.report.curve_plots import SHOWN, curve_figure, overview_figure

SHOWN_OF_MISSIONS: Final = (
    "success",
    "collision_pedestrian",
    "goals_reached",
    "time_without_contact",
)
"""Metrics that curves over the length of missions are drawn of."""


def write_stress(result: Stress, folder: Path) -> None:
    """Writes `stress.json`, `stress.md`, both Parquet files, and plots as `.svg` and `.png`.

    The plots are those of each knob, and of several the one of all, `overview`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps(result.table, indent=2, allow_nan=False) + "\n"
    write_atomic(folder / "stress.json", text.encode())
    write_atomic(folder / "stress.md", (stress_table(result.table) + "\n").encode())
    rows, cells = result.rows, result.cells
    write_atomic(folder / "episodes.parquet", rows_as_parquet(rows, list(rows[0])))
    write_atomic(folder / "forecast_errors.parquet", rows_as_parquet(cells, CELL_COLUMNS))
    knobs = result.table["knobs"]
    with plots.styled():
        for knob, entry in knobs.items():
            figure = curve_figure(entry["curves"], entry["label"], shown_of(knob))
            figure.tight_layout()
            _write_figure(figure, folder / knob)
        if len(knobs) > 1:
            _write_figure(overview_figure(knobs), folder / "overview")


def _write_figure(figure: Figure, path: Path) -> None:
    """Writes the figure as `path` with `.svg`, and with `.png`."""
    for suffix in ("svg", "png"):
        sink = io.BytesIO()
        figure.savefig(sink, format=suffix, dpi=160)
        write_atomic(path.with_suffix(f".{suffix}"), sink.getvalue())


def stress_table(table: Mapping[str, Any]) -> str:
    """The curves as Markdown tables, one per knob; brackets hold 95 % intervals."""
    return "\n\n".join(_markdown(knob, entry) for knob, entry in table["knobs"].items())


def shown_of(knob: str) -> tuple[str, ...]:
    """The metrics that a knob's curves are drawn of."""
    return SHOWN_OF_MISSIONS if knob == "mission" else SHOWN


def _markdown(knob: str, entry: Mapping[str, Any]) -> str:
    """One knob's curves."""
    shown = shown_of(knob)
    head = ["arm", entry["label"], "n", *(METRICS[key].label for key in shown)]
    lines = [head, ["---"] * len(head)]
    for arm, points in entry["curves"].items():
        lines += [[arm, value_text(point["value"]), *_cells(point, shown)] for point in points]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _cells(arm: Mapping[str, Any], shown: Sequence[str]) -> list[str]:
    """Count and shown metrics of one line of the table."""
    cells = [str(arm["n"])]
    for key in shown:
        entry = arm["metrics"][aggregate_name(key)]
        if entry["mean"] is None:
            cells.append("–")
        else:
            cells.append(
                share(entry) if METRICS[key].kind == "share" else number(entry, METRICS[key])
            )
    return cells
