"""The tables that `crowdnav evaluate-predictor` prints."""

from typing import Any, Final

from rich.box import SIMPLE
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from predictor.published import PublishedTable

MEASURES: Final = {
    "miss_rate@2m": "ends > 2 m off [%]",
    "collision_1": "meets forecasts [%]",
    "collision_2": "meets true paths [%]",
    "off_walkable": "off the ground [%]",
    "coverage@0.9": "coverage@0.9 [%]",
    "region_coverage@0.9": "region_coverage@0.9 [%]",
}
"""Shares in the second table, where a column has them, by their keys in a row."""

NEAREST: Final = ("min_ade_", "min_joint_ade_")
"""How the keys begin of what is measured of the nearest of several futures."""

TRUTHS: Final = {"collision_2": "collision_truth", "off_walkable": "off_walkable_truth"}
"""What the truth itself has of a measure."""


def print_errors(found: dict[str, Any]) -> None:
    """Print ADE/FDE of each column, a row for each fold and one for their mean.

    Args:
        found: As the table of `predictor.comparison.compare`.
    """
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
    Console().print(_measures(found))


def print_published(table: PublishedTable) -> None:
    """Print what papers report, apart from what was measured."""
    title = f"As published, not measured here: ADE/FDE [{table.unit}]"
    printed = Table("method", title=escape(title), caption=escape(table.missing))
    for column in table.columns:
        printed.add_column(column, justify="right")
    printed.add_column("known to differ; source", overflow="fold")
    for row in table.rows:
        printed.add_row(row.name, *row.ade_fde, escape(f"{row.differs} ({row.source})"))
    Console().print(printed)


def _measures(found: dict[str, Any]) -> Table:
    """The mean over folds of what can be told besides the errors."""
    columns = found["columns"]
    rows = [_row(column, "mean", moving=False) for column in columns.values()]
    known = [key for key in MEASURES if any(key in row for row in rows)]
    table = Table("mean of folds", box=SIMPLE, show_edge=False)
    for name in columns:
        table.add_column(escape(name), justify="right", overflow="fold")
    if any(key in rows[0] for key in TRUTHS.values()):
        table.add_column("truth", justify="right")
    for key in known:
        truth = rows[0].get(TRUTHS.get(key, ""))
        cells = [_percent(row.get(key)) for row in rows]
        table.add_row(escape(MEASURES[key]), *cells, _percent(truth))
    for label, cells in _futures(rows, found["protocol"]["unit"]):
        table.add_row(escape(label), *cells)
    return table


def _futures(rows: list[dict[str, Any]], unit: str) -> list[tuple[str, list[str]]]:
    """Density at the truth, and the best of k most probable modes; each minimum by itself."""
    lines = [("nll [nat]", ["" if "nll" not in row else f"{row['nll']:.3f}" for row in rows])]
    for ade in dict.fromkeys(key for row in rows for key in row if key.startswith(NEAREST)):
        if ade.endswith("_sd"):
            continue
        fde = ade.replace("_ade_", "_fde_")
        of_columns = [{"ade": row.get(ade), "fde": row.get(fde)} for row in rows]
        lines.append((f"{ade} / fde [{unit}]", [_cell(row, unit) for row in of_columns]))
    return lines


def _percent(share: float | None) -> str:
    return "" if share is None else f"{100.0 * share:.1f}"


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
    # what is the same for all seeds has no deviation
    return f"{cell}\n±{row['ade_sd']:.{digits}f}/{row.get('fde_sd', 0.0):.{digits}f}"


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
