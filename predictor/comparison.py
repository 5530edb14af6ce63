"""Several forecasters on the same tests: the columns of the table of results.

A forecaster that was trained for each fold, or with several seeds, is named by a pattern of paths:
`{fold}` and `{seed}` in it stand for each of them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from crowdsim.recordings import Recording
from predictor.datasets import fold_names, read_tests
from predictor.evaluate import checked_min_ped, errors_of_folds, tables
from predictor.forecaster import Forecaster, make_forecaster
from predictor.grounds import read_grounds
from predictor.trajectory_errors import TrajectoryErrors

BASELINE: Final = "constant_velocity"
"""Stands in every table."""

Make = Callable[[str], Forecaster | None]
"""Chooses a forecaster by name, as `predictor.forecaster.make_forecaster` does."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Comparison:
    """Several forecasters on the same tests.

    Attributes:
        table: The first column, and under `columns` each by its name: what
            `predictor.evaluate.tables` returns, averaged over seeds; with several seeds each value
            that differs has its standard deviation beside it (`ade_sd`), and `by_seed` has the
            tables of the seeds.
        errors: By column and fold, the trajectories of the first seed.
        forecasters: By column and fold, who made them.
        tests: By fold, the recordings.
    """

    table: dict[str, Any]
    errors: dict[str, dict[str, TrajectoryErrors]]
    forecasters: dict[str, dict[str, Forecaster]]
    tests: dict[str, list[Recording]]


def compare(
    specs: Sequence[str],
    data: str,
    *,
    seeds: Sequence[int] = (0,),
    min_ped: int | None = None,
    make: Make = make_forecaster,
    progress: bool = False,
) -> Comparison:
    """Errors of forecasters, and of constant velocity, on the test parts of a data set.

    Args:
        specs: As `predictor.forecaster.make_forecaster`, where `{fold}` and `{seed}` stand for each
            fold and each seed. They name the columns.
        data: As `predictor.datasets.read_tests`.
        seeds: What `{seed}` stands for.
        min_ped: As `predictor.evaluate.evaluate`.
        make: Chooses the forecasters.
        progress: Show progress bars.

    Raises:
        FileNotFoundError: The data or a checkpoint is not there.
        ValueError: The data or a checkpoint is unfit, or a forecaster does not forecast.
    """
    limit = checked_min_ped(min_ped, data)
    folds = fold_names(data)
    # all are loaded before anything is forecast: what cannot be is told at once
    forecasters = {
        spec: _forecasters(spec, folds, seeds, make) for spec in dict.fromkeys((BASELINE, *specs))
    }
    tests = read_tests(data)
    grounds = read_grounds(data, tests)
    columns: dict[str, dict[str, Any]] = {}
    errors: dict[str, dict[str, TrajectoryErrors]] = {}
    for spec, by_seed in forecasters.items():
        by_table = {}
        for seed, by_fold in by_seed.items():
            found = errors_of_folds(by_fold, tests, data=data, grounds=grounds, progress=progress)
            by_table[seed] = tables(found, by_fold[folds[0]], data=data, min_ped=limit)
            errors.setdefault(spec, found)
        columns[spec] = _column(by_table)
    return Comparison(
        table={**columns[specs[0]], "columns": columns},
        errors=errors,
        forecasters={spec: by_seed[seeds[0]] for spec, by_seed in forecasters.items()},
        tests=tests,
    )


def _forecasters(
    spec: str, folds: Sequence[str], seeds: Sequence[int], make: Make
) -> dict[int, dict[str, Forecaster]]:
    """By seed and fold, what the pattern names; one seed where it names none."""
    made: dict[str, Forecaster] = {}
    by_seed: dict[int, dict[str, Forecaster]] = {}
    for seed in seeds if "{seed}" in spec else seeds[:1]:
        for fold in folds:
            name = spec.replace("{seed}", str(seed)).replace("{fold}", fold)
            if name not in made:
                made[name] = _made(name, make)
            by_seed.setdefault(seed, {})[fold] = made[name]
    return by_seed


def _made(name: str, make: Make) -> Forecaster:
    forecaster = make(name)
    if forecaster is None:
        raise ValueError(f"expected a forecaster that forecasts, found {name!r}")
    return forecaster


def _column(by_seed: Mapping[int, dict[str, Any]]) -> dict[str, Any]:
    """One table of several: averaged over seeds, with the spread."""
    of_seeds = list(by_seed.values())
    if len(of_seeds) == 1:
        return {**of_seeds[0], "seeds": list(by_seed)}
    averaged: dict[str, Any] = _averaged(of_seeds)
    return {**averaged, "seeds": list(by_seed), "by_seed": {str(k): v for k, v in by_seed.items()}}


def _averaged(values: Sequence[Any]) -> Any:
    """Average what differs between seeds, all through nested tables."""
    first = values[0]
    if isinstance(first, dict):
        found = {key: _averaged([value[key] for value in values]) for key in first}
        spread = {
            f"{key}_sd": float(np.std([value[key] for value in values], ddof=1))
            for key in first
            if _differ([value[key] for value in values])
        }
        return {**found, **spread}
    if isinstance(first, list):
        return [_averaged(items) for items in zip(*values, strict=True)]
    # what does not differ is no measurement, and its mean may be rounded
    return float(np.mean(values)) if _differ(values) else first


def _differ(values: Sequence[Any]) -> bool:
    return isinstance(values[0], float) and any(value != values[0] for value in values)
