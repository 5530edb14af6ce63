"""Errors that papers report, with what is known to differ from the protocol here.

None of these numbers was measured by this code, and most cannot be compared with those that were.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from predictor.datasets import crowd_name

PUBLISHED: Final = Path(__file__).with_name("published.json")


@dataclass(frozen=True, kw_only=True)
class PublishedRow:
    """One method as published.

    Attributes:
        name: Of the method.
        ade_fde: ADE/FDE as printed, one for each column; empty where none was printed.
        differs: How its protocol is known to differ.
        source: Where the numbers were read.
    """

    name: str
    ade_fde: tuple[str, ...]
    differs: str
    source: str


@dataclass(frozen=True, kw_only=True)
class PublishedTable:
    """What papers report on one data set.

    Attributes:
        unit: Of the errors.
        columns: Folds, and perhaps their mean.
        rows: The methods.
        missing: What could not be confirmed and is left out.
    """

    unit: str
    columns: tuple[str, ...]
    rows: tuple[PublishedRow, ...]
    missing: str


def read_published(data: str) -> PublishedTable | None:
    """Published errors on a data set; None where there are none.

    Args:
        data: As `predictor.datasets.read_tests`.
    """
    table = json.loads(PUBLISHED.read_text(encoding="utf-8")).get(crowd_name(data))
    if table is None:
        return None
    rows = tuple(PublishedRow(**{**row, "ade_fde": tuple(row["ade_fde"])}) for row in table["rows"])
    return PublishedTable(**{**table, "columns": tuple(table["columns"]), "rows": rows})
