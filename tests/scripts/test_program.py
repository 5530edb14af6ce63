"""What holds for every subcommand: quick help, bad input in one line, configuration files."""

import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from command_line import Crowdnav

import scripts.__main__ as program
from scripts.__main__ import COMMANDS

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("command", [None, *COMMANDS])
def test_help_answers_within_a_second(command: str | None) -> None:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    arguments = ["--help"] if command is None else [command, "--help"]
    process = subprocess.run(
        [sys.executable, "-m", "scripts", *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    # Processor time: what else runs on this machine does not count.
    assert after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime < 1.0
    assert "usage: crowdnav" in process.stdout


REQUIRED = {"convert": ("crowd.txt", "out")}
"""Arguments that a command cannot do without."""
UNSEEDED = ("convert", "calibrate-predictor", "explain-predictor", "export-predictor")
SEEDED = [command for command in COMMANDS if command not in UNSEEDED]
"""Commands that draw anything."""


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_the_shared_options(command: str, crowdnav: Crowdnav) -> None:
    text = crowdnav(command, "--help").out
    for option in ("--config", "--print_config", *(["--seed"] if command in SEEDED else [])):
        assert option in text


@pytest.mark.parametrize("command", COMMANDS)
def test_printed_configuration_reads_back_as_itself(
    command: str, crowdnav: Crowdnav, tmp_path: Path
) -> None:
    file = tmp_path / "options.yaml"
    arguments = [*REQUIRED.get(command, ()), *(["--seed", 41] if command in SEEDED else [])]
    first = crowdnav(command, *arguments, "--print_config")
    file.write_text(first.out)
    if command in SEEDED:
        assert yaml.safe_load(first.out)["seed"] == 41
    assert crowdnav(command, "--config", file, "--print_config") == first


def test_command_line_wins_over_the_configuration_file(crowdnav: Crowdnav, tmp_path: Path) -> None:
    file = tmp_path / "options.yaml"
    file.write_text("seed: 7\nworkers: 2\n")
    options = yaml.safe_load(
        crowdnav("generate", "--config", file, "--workers", 3, "--print_config").out
    )
    assert (options["seed"], options["workers"]) == (7, 3)


@pytest.mark.parametrize("flag", ["--resume", "--resume true", "--resume=yes"])
def test_what_is_true_or_false_is_set_by_its_name(flag: str, crowdnav: Crowdnav) -> None:
    options = crowdnav("generate", *flag.split(), "--seed", 3, "--print_config").out
    assert (yaml.safe_load(options)["resume"], yaml.safe_load(options)["seed"]) == (True, 3)


BAD_INPUTS = [  # {} stands for a folder with the files of `bad_folder`; then a part of the answer
    ("", "demo"),
    ("simulate", "simulate"),
    ("evaluate --sceanrios circular_crossing", "--sceanrios"),
    ("generate --seed three", "three"),
    ("generate --seed -1 --out {}/new", "-1"),
    ("generate --workers -1", "-1"),
    ("generate --hours inf --out {}/new", "inf"),
    ("generate --scenario moon --out {}/new", "moon"),
    ("generate --scenario {}/unknown.yaml --out {}/new", "unknown.yaml"),
    ("generate --model teleport --out {}/new", "teleport"),
    ("generate --resume perhaps --out {}/new", "perhaps"),
    ("convert {}/nowhere.txt {}/new", "nowhere"),
    ("convert {}/file {}/new", "neither results"),
    ("convert {}/empty {}/new", "empty"),
    ("convert {}/crowd.txt {}/new.mp3", ".mp3"),
    ("convert {}/crowd.txt {}/new", "0.28 s (at 25 fps)"),
    ("convert {}/crowd.txt {}/new --dt 0.01", "30.00 m/s"),
    ("convert {}/crowd.txt {}/new.csv --dt 0.4", "metres per pixel"),
    ("train-predictor --variant resnet9000", "resnet9000"),
    ("train-predictor --data {}/nowhere", "nowhere"),
    ("train-predictor --data eth_ucy:mars", "mars"),
    ("train-predictor --data {}/file", "file"),
    ("train-predictor --config_name best", "best"),
    ("evaluate-predictor --forecaster constant_velocity --data {}/empty", "empty"),
    ("evaluate-predictor --forecaster crystal_ball --data {}/empty", "crystal_ball"),
    ("evaluate-predictor --forecaster {}/file --data {}/empty", "file"),
    ("evaluate-predictor --forecaster iterative_attention@no_mpa --data {}/empty", "@no_mpa"),
    ("evaluate-predictor --horizon 1 --data {}/empty", "multiple of 0.4"),
    ("train-predictor --horizon 0.5", "multiple of 0.4"),
    ("explain-predictor --out {}/new.jpg", "new.jpg"),
    ("explain-predictor --forecaster constant_velocity --out {}/new.png", "attends"),
    ("calibrate-predictor --forecaster {}/empty", "best.json"),
    ("evaluate --seeds 0", "'0'"),
    ("evaluate --seeds 1 --out {}/new --scenarios moon", "moon"),
    ("evaluate --seeds 1 --out {}/new --forecasters crystal_ball", "crystal_ball"),
    ("evaluate --seeds 1 --out {}/new --policies teleport", "teleport"),
    ("evaluate --seeds 1 --out {}/file", "file"),
    ("evaluate --seeds 1 --out {}/new --json {}/empty", "empty"),
    ("stress --config {}/none.yaml", "none.yaml"),
    ("stress --config {}/garbage.yaml", "parsing config"),
    ("stress --config {}/binary.yaml", "utf-8"),
    ("stress --config {}/unknown.yaml", "sed"),
    ("stress --scenario moon --out {}/new", "moon"),
    ("render --scenario moon --out {}/new.png", "moon"),
    ("render --out {}/new.mp3", ".mp3"),
    ("benchmark --only crowd,weather", "weather"),
    ("benchmark --json {}", "folder"),
]


@pytest.fixture
def bad_folder(tmp_path: Path) -> Path:
    (tmp_path / "file").write_text("neither results nor weights")
    (tmp_path / "garbage.yaml").write_text("seed: [unclosed\n: :")
    (tmp_path / "unknown.yaml").write_text("sed: 3\n")
    (tmp_path / "binary.yaml").write_bytes(bytes(range(256)))
    (tmp_path / "crowd.txt").write_text("0 1 0.0 0.0\n7 1 0.3 0.0\n14 1 0.6 0.0\n")
    (tmp_path / "empty").mkdir()
    return tmp_path


@pytest.mark.parametrize(("line", "part"), BAD_INPUTS)
def test_bad_input_gives_status_2_one_line_and_no_file(
    line: str, part: str, crowdnav: Crowdnav, bad_folder: Path
) -> None:
    before = sorted(bad_folder.rglob("*"))
    outcome = crowdnav(*line.replace("{}", str(bad_folder)).split())
    assert outcome.status == 2
    assert outcome.err.startswith("crowdnav: error: ")
    assert outcome.err.count("\n") == 1
    assert part in outcome.err
    assert sorted(bad_folder.rglob("*")) == before


def test_mistakes_of_the_program_keep_their_traceback(
    crowdnav: Crowdnav, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(**options: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setitem(program.COMMANDS, "stress", broken)
    with pytest.raises(ZeroDivisionError):
        crowdnav("stress")


def test_an_interrupt_is_one_line_and_status_130(
    crowdnav: Crowdnav, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(**options: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setitem(program.COMMANDS, "stress", interrupted)
    outcome = crowdnav("stress")
    assert (outcome.status, outcome.err) == (130, "crowdnav: stopped: interrupted\n")


def test_a_foreign_package_named_envs_is_noticed(tmp_path: Path) -> None:
    (tmp_path / "envs").mkdir()
    (tmp_path / "envs" / "__init__.py").touch()
    process = subprocess.run(
        [sys.executable, "-m", "scripts", "benchmark", "--only", "crowd_peers"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert process.returncode == 2
    assert process.stderr.startswith("crowdnav: error: expected the package 'envs'")
    assert process.stderr.count("\n") == 1
