"""`crowdnav evaluate-predictor`: displacement errors of a forecaster on recorded crowds."""

from pathlib import Path
from typing import Any, Literal

from jsonargparse.typing import NonNegativeInt

from scripts.output import require_file, write_json


def evaluate_predictor(
    forecaster: str = "iterative_attention",
    data: str = "eth_ucy",
    min_ped: Literal[0, 1] = 1,
    json: Path | None = None,
    seed: NonNegativeInt = 0,
) -> None:
    """Measure a forecaster on recorded crowds, by the protocol of the literature.

    Windows of 8 + 12 consecutive listed frames, stride 1, one forecast for each agent; the mean is
    over folds. Rows of agents that move are given beside those of all.

    Args:
        forecaster: `constant_velocity`, `iterative_attention` (the bundled weights), or the folder
            of a checkpoint.
        data: `eth_ucy` or a folder with that data (its five folds), `FOLDER:FOLD` (one of them),
            or a folder written by `crowdnav generate`.
        min_ped: Only windows with more agents than this count in the printed table; the JSON file
            has both.
        json: File for the table.
        seed: Kept with the options; nothing here is drawn.
    """
    require_file(json)
    from predictor.evaluate import evaluate
    from predictor.forecaster import make_forecaster

    chosen = make_forecaster(forecaster)
    if chosen is None:
        raise ValueError("expected a forecaster that forecasts, found 'none'")
    found = evaluate(chosen, data, min_ped=min_ped, progress=True)
    found["protocol"]["seed"] = seed
    print_errors(found, title=f"{forecaster} on {data}, min_ped={min_ped} (m)")
    write_json(json, found)


def print_errors(found: dict[str, Any], *, title: str) -> None:
    """Print one row for each fold and one for their mean."""
    from rich.console import Console
    from rich.table import Table

    table = Table("fold", title=title)
    for heading in ("ADE", "FDE", "n", "moving ADE", "moving FDE", "moving n"):
        table.add_column(heading, justify="right")
    for fold, row in [*found["folds"].items(), ("mean of folds", found["mean"])]:
        cells = [row["ade"], row["fde"], row.get("n")]
        cells += [row["moving"]["ade"], row["moving"]["fde"], row["moving"].get("n")]
        table.add_row(fold, *map(_cell, cells))
    Console().print(table)


def _cell(value: float | int | None) -> str:
    if value is None:
        return ""
    return f"{value:.3f}" if isinstance(value, float) else str(value)
