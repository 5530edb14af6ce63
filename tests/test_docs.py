"""What the documents promise is there."""

import re
import shlex
from pathlib import Path

import pytest

from crowdsim.scenarios import SCENARIOS
from envs.evaluation.metric_table import METRICS
from scripts.__main__ import COMMANDS, build_parser

ROOT = Path(__file__).parents[1]
DOCUMENTS = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
EXAMPLES = [
    line.strip()
    for document in DOCUMENTS
    for line in document.read_text(encoding="utf-8").splitlines()
    if re.match(r" *(\.venv/bin/)?crowdnav [a-z-]+ --", line)
]


@pytest.mark.parametrize("line", EXAMPLES)
def test_example_command_lines_are_understood(line: str) -> None:
    parser, _ = build_parser()
    assert parser.parse_args(shlex.split(line)[1:]).subcommand in COMMANDS


def test_every_command_is_listed_and_has_an_example() -> None:
    assert {shlex.split(line)[1] for line in EXAMPLES} == set(COMMANDS)
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert all(f"| `crowdnav {name}` |" in readme for name in COMMANDS)


def test_every_metric_is_defined_in_the_same_words() -> None:
    text = (ROOT / "docs" / "metrics.md").read_text(encoding="utf-8")
    for key, metric in METRICS.items():
        assert f"| `{key}` | {metric.unit} | {metric.better} | {metric.definition} |" in text


def test_every_scenario_is_named() -> None:
    text = (ROOT / "docs" / "scenarios.md").read_text(encoding="utf-8")
    assert all(f"\n## {name}\n" in text for name in SCENARIOS)


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_links_and_pictures_lead_somewhere(document: Path) -> None:
    for target in re.findall(r"\]\((?!https?:|#)([^)#]+)", document.read_text(encoding="utf-8")):
        assert (document.parent / target).exists(), target


def test_the_example_of_the_readme_runs(capsys: pytest.CaptureFixture[str]) -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    code = readme.partition("```python\n")[2].partition("```")[0]
    assert len(code.strip().splitlines()) <= 18
    exec(compile(code.replace("range(3)", "range(1)"), "README.md", "exec"), {})
    assert capsys.readouterr().out.startswith("0 ")
