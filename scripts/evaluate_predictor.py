"""`crowdnav evaluate-predictor`: displacement errors of forecasters on recorded crowds."""

from functools import partial
from pathlib import Path
from typing import Any, Literal

from jsonargparse.typing import NonNegativeInt

from scripts.options import Names, PositiveNumber, Seeds
from scripts.output import require_file, write_json


def evaluate_predictor(
    forecaster: Names = Names("iterative_attention"),
    data: str = "eth_ucy",
    horizon: PositiveNumber = 4.8,
    min_ped: Literal[0, 1] | None = None,
    json: Path | None = None,
    seeds: Seeds = Seeds("1"),
    seed: NonNegativeInt = 0,
) -> None:
    """Measure forecasters on recorded crowds, by the protocol of the literature.

    Windows of 8 + 12 (or another horizon) consecutive listed frames, stride 1, one forecast for
    each agent; the mean is over folds. Constant velocity stands beside every forecaster, and rows
    of agents that move below those of all.

    Args:
        forecaster: The columns of the table, separated by commas: `constant_velocity`,
            `iterative_attention` (the bundled weights), or the folder of a checkpoint, where
            `{fold}` and `{seed}` stand for each fold and each seed; `@no_map`, `@blank_map`,
            `@rotated_map`, `@wrong_map`, `@no_neighbors` or `@no_history` behind it say what a
            network is not shown, or shown wrongly.
        data: `eth_ucy` or a folder with that data (its five folds), `FOLDER:FOLD` (one of them),
            `sdd` or a folder with that data (in pixels), or one written by `crowdnav generate`.
        horizon: How far to forecast [s]; a multiple of 0.4. Beyond what a network was trained for
            it is rolled on its own forecasts.
        min_ped: Only windows with more agents than this count in the printed table; the JSON file
            has both. 1 if not given, 0 for SDD: what the literature does.
        json: File for the table.
        seeds: What `{seed}` stands for, counted from `seed`: a count, or numbers separated by
            commas.
        seed: Added to each of `seeds`.
    """
    require_file(json)
    from predictor.comparison import compare
    from predictor.forecaster import make_forecaster

    found = compare(
        forecaster,
        data,
        seeds=[seed + s for s in seeds],
        min_ped=min_ped,
        make=partial(make_forecaster, horizon=horizon),
        progress=True,
    )
    print_errors(found.table)
    write_json(json, found.table)


def print_errors(found: dict[str, Any]) -> None:
    """Print ADE/FDE of each column, a row for each fold and one for their mean."""
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    columns, protocol = found["columns"], found["protocol"]
    title = f"ADE/FDE [{protocol['unit']}] on {protocol['data']}"
    table = Table("fold", title=escape(title), caption=escape(_caption(found)))
    table.add_column("n", justify="right")
    for name in columns:
        table.add_column(escape(name), justify="right", overflow="fold")
    for moving in (False, True):
        for fold in [*found["folds"], "mean"] if len(found["folds"]) > 1 else found["folds"]:
            rows = [_row(column, fold, moving) for column in columns.values()]
            cells = [_cell(row, protocol["unit"]) for row in rows]
            table.add_row(f"{fold}, moving" if moving else fold, str(rows[0].get("n", "")), *cells)
        table.add_section()
    Console().print(table)


def _row(column: dict[str, Any], fold: str, moving: bool) -> dict[str, Any]:
    row: dict[str, Any] = column["mean"] if fold == "mean" else column["folds"][fold]
    return dict(row["moving"]) if moving else row


def _cell(row: dict[str, Any], unit: str) -> str:
    """ADE/FDE, and below them their standard deviation over seeds where there are several."""
    digits = 3 if unit == "m" else 2
    if row["ade"] is None:
        return ""
    cell = f"{row['ade']:.{digits}f}/{row['fde']:.{digits}f}"
    if "ade_sd" not in row:
        return cell
    return f"{cell}\n±{row['ade_sd']:.{digits}f}/{row['fde_sd']:.{digits}f}"


def _caption(found: dict[str, Any]) -> str:
    """The protocol, without which no number means anything."""
    protocol = found["protocol"]
    seeds = max((column["seeds"] for column in found["columns"].values()), key=len)
    return (
        f"Windows of {protocol['history_steps']} + {protocol['forecast_steps']} frames, "
        f"{protocol['frame_dt']} s apart: {protocol['window']}. min_ped={protocol['min_ped']}. "
        f"{protocol['samples']} forecast for each of n trajectories. Moving: "
        f"{protocol['moving']}. Mean: {protocol['mean']}. Seeds: "
        f"{', '.join(map(str, seeds))}"
        + ("; ± is their standard deviation." if len(seeds) > 1 else ".")
    )
