"""Several forecasters on the same tests: the columns of the table of results.

A forecaster that was trained for each fold, or with several seeds, is named by a pattern of paths:
`{fold}` and `{seed}` in it stand for each of them.
"""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any, Final

import numpy as np

from predictor.datasets import fold_names, read_tests
from predictor.evaluate import checked_min_ped, evaluate_folds
from predictor.forecaster import Forecaster, make_forecaster

BASELINE: Final = "constant_velocity"
"""Stands in every table."""


def compare(
    specs: Sequence[str],
    data: str,
    *,
    seeds: Sequence[int] = (0,),
    min_ped: int | None = None,
    progress: bool = False,
) -> dict[str, Any]:
    """Errors of forecasters, and of constant velocity, on the test parts of a data set.

    Args:
        specs: As `predictor.forecaster.make_forecaster`, where `{fold}` and `{seed}` stand for each
            fold and each seed. They name the columns.
        data: As `predictor.datasets.read_tests`.
        seeds: What `{seed}` stands for.
        min_ped: As `predictor.evaluate.evaluate`.
        progress: Show progress bars.

    Returns:
        The first column, and under `columns` each by its name: what
        `predictor.evaluate.evaluate_folds` returns, errors averaged over seeds; with several seeds
        each `ade` and `fde` has its standard deviation beside it (`ade_sd`, `fde_sd`), and
        `by_seed` has the tables of the seeds.

    Raises:
        FileNotFoundError: The data or a checkpoint is not there.
        ValueError: The data or a checkpoint is unfit, or a forecaster does not forecast.
    """
    limit = checked_min_ped(min_ped, data)
    folds = fold_names(data)
    # all are loaded before anything is forecast: what cannot be is told at once
    forecasters = {
        spec: _forecasters(spec, folds, seeds) for spec in dict.fromkeys((BASELINE, *specs))
    }
    tests = read_tests(data)
    columns = {
        spec: _column(
            {
                seed: evaluate_folds(by_fold, tests, data=data, min_ped=limit, progress=progress)
                for seed, by_fold in by_seed.items()
            }
        )
        for spec, by_seed in forecasters.items()
    }
    return {**columns[specs[0]], "columns": columns}


def _forecasters(
    spec: str, folds: Sequence[str], seeds: Sequence[int]
) -> dict[int, dict[str, Forecaster]]:
    """By seed and fold, what the pattern names; one seed where it names none."""
    return {
        seed: {
            fold: _load(spec.replace("{seed}", str(seed)).replace("{fold}", fold)) for fold in folds
        }
        for seed in (seeds if "{seed}" in spec else seeds[:1])
    }


@lru_cache(maxsize=64)
def _load(spec: str) -> Forecaster:
    forecaster = make_forecaster(spec)
    if forecaster is None:
        raise ValueError(f"expected a forecaster that forecasts, found {spec!r}")
    return forecaster


def _column(by_seed: Mapping[int, dict[str, Any]]) -> dict[str, Any]:
    """One table of several: errors averaged over seeds, with their spread."""
    tables = list(by_seed.values())
    if len(tables) == 1:
        return {**tables[0], "seeds": list(by_seed)}
    averaged: dict[str, Any] = _averaged(tables)
    return {**averaged, "seeds": list(by_seed), "by_seed": {str(k): v for k, v in by_seed.items()}}


def _averaged(values: Sequence[Any]) -> Any:
    """Average what differs between seeds, all through nested tables."""
    first = values[0]
    if isinstance(first, dict):
        found = {key: _averaged([value[key] for value in values]) for key in first}
        for key in ("ade", "fde"):
            if isinstance(found.get(key), float):
                found[f"{key}_sd"] = float(np.std([value[key] for value in values], ddof=1))
        return found
    if isinstance(first, list):
        return [_averaged(items) for items in zip(*values, strict=True)]
    # what does not differ is no measurement, and its mean may be rounded
    differs = isinstance(first, float) and any(value != first for value in values)
    return float(np.mean(values)) if differs else first
