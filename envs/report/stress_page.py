"""Builds the report of a stress test: a section per knob, and failures to look at."""

from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

from envs.evaluation.knobs import value_text
from envs.evaluation.stress import Stress
from envs.report import tables
from envs.report.curve_plots import curve_plot, line_colors, overview_plot
from envs.report.document import section, sentences, write_document
from envs.report.stress_files import shown_of

NOTE = (
    "One knob is turned at a time and all else stays; every point of every curve runs the same "
    "seeds. Bands and brackets are 95 % intervals, not corrected for the number of comparisons. "
    "The replays show a failure of each arm where its success falls most, beside an arm that "
    "mastered the same episode, if there is one."
)


def build_stress_report(result: Stress, out: Path) -> Path:
    """Writes the report of a stress test.

    Args:
        result: What `envs.evaluation.stress.stress` returned.
        out: File to write; it appears under its name only when it is complete.

    Returns:
        The file.
    """
    table = result.table
    return write_document(
        out,
        title="Crowd navigation stress test",
        lead=f"{len(result.rows)} episodes in {table['scenario']}, all from the same seeds, with "
        f"{len(table['knobs'])} knob{'s' if len(table['knobs']) > 1 else ''} turned one at a time.",
        run=table["run"],
        sections=[_found(table), *(_knob(name, own) for name, own in table["knobs"].items())],
        recorded=result.recorded,
        reference=table["reference"],
    )


def _found(table: Mapping[str, Any]) -> str:
    """What was found, knob by knob."""
    knobs = table["knobs"]
    parts = [
        f'<h3>{escape(entry["label"])} <a href="#{name}">more</a></h3>'
        f"{sentences(entry['findings'])}"
        for name, entry in knobs.items()
    ]
    overview = [f'<div class="plot">{overview_plot(knobs)}</div>'] if len(knobs) > 1 else []
    note = f'<p class="note">{escape(NOTE)}</p>'
    return section("findings", "What was found", *overview, *parts, note)


def _knob(name: str, entry: Mapping[str, Any]) -> str:
    """One knob's curves and, folded away, their numbers."""
    curves = entry["curves"]
    plot = f'<div class="plot">{curve_plot(curves, entry["label"], shown_of(name))}</div>'
    numbers = tables.change_table(curves, value_text, line_colors(curves))
    return section(
        name, entry["label"], plot, f"<details><summary>As a table</summary>{numbers}</details>"
    )
