"""One HTML file that asks the network for nothing: head, facts, sections and the player."""

import json
from collections.abc import Mapping, Sequence
from html import escape
from importlib import resources
from pathlib import Path
from string import Template
from typing import Any

from crowdsim.recordings.store import write_atomic
from envs.evaluation.replays import RecordedEpisode
from envs.report.records import player_records

SENTENCES_SHOWN = 3
"""More sentences than these are folded away."""


def write_document(
    out: Path,
    *,
    title: str,
    lead: str,
    run: Mapping[str, Any],
    sections: Sequence[str],
    recorded: Sequence[RecordedEpisode],
    reference: str,
) -> Path:
    """Writes the page; the player, if there are episodes to play, comes after the first section.

    Args:
        out: File to write; it appears under its name only when it is complete.
        title: Its title.
        lead: The sentence below it.
        run: What was run, as terms and their values.
        sections: HTML.
        recorded: Episodes that the player plays.
        reference: Arm that the player shows beside others.

    Returns:
        The file.
    """
    shown = [sections[0], read("player.html") if recorded else "", *sections[1:]]
    fields = {
        "title": escape(title),
        "style": read("style.css"),
        "lead": escape(lead),
        "facts": _facts(run),
        "sections": "\n".join(section for section in shown if section),
        "script": _script(recorded, reference) if recorded else "",
    }
    out.parent.mkdir(parents=True, exist_ok=True)
    write_atomic(out, Template(read("template.html")).substitute(fields).encode())
    return out


def section(name: str, heading: str, *parts: str) -> str:
    """A section with a heading; links find it under `name`."""
    body = "\n".join(part for part in parts if part)
    return (
        f'<section aria-labelledby="{name}">\n<h2 id="{name}">{escape(heading)}</h2>\n'
        f"{body}\n</section>"
    )


def sentences(found: Sequence[str]) -> str:
    """A list of sentences; of a long one only the first are seen at once."""
    items = [f"<li>{escape(sentence)}</li>" for sentence in found]
    shown = f'<ul class="findings">{"".join(items[:SENTENCES_SHOWN])}</ul>'
    rest = items[SENTENCES_SHOWN:]
    if not rest:
        return shown
    return (
        f"{shown}<details><summary>{len(rest)} more</summary>"
        f'<ul class="findings">{"".join(rest)}</ul></details>'
    )


def read(name: str) -> str:
    """A file that ships beside this module."""
    return resources.files("envs.report").joinpath(name).read_text(encoding="utf-8")


def embedded_json(value: Any) -> str:
    """JSON that can stand inside a script element, whatever its strings hold."""
    return json.dumps(value, separators=(",", ":")).replace("<", "\\u003c")


def _facts(run: Mapping[str, Any]) -> str:
    """What was run, as term and description pairs."""
    items = []
    for term, value in run.items():
        wide = ' class="wide"' if term == "command" else ""
        shown = f"<code>{escape(str(value))}</code>" if term == "command" else escape(str(value))
        items.append(f"<div{wide}><dt>{escape(term)}</dt><dd>{shown}</dd></div>")
    return "".join(items)


def _script(recorded: Sequence[RecordedEpisode], reference: str) -> str:
    records = embedded_json(player_records(recorded, reference))
    return (
        f'<script type="application/json" id="records">{records}</script>\n'
        f"<script>\n{read('player.js')}</script>"
    )
