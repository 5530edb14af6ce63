"""The `crowdnav` program, also `python -m scripts`.

Every subcommand is one typed function; its options, their checks and `--help` come from its
signature and docstring through jsonargparse. Nothing heavy is imported before a command runs.
"""

import os
import sys
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final, NoReturn

from jsonargparse import ActionYesNo, ArgumentParser

from scripts.benchmark import benchmark
from scripts.calibrate_predictor import calibrate_predictor
from scripts.convert import convert
from scripts.demo import demo
from scripts.evaluate import evaluate
from scripts.evaluate_predictor import evaluate_predictor
from scripts.explain_predictor import explain_predictor
from scripts.export_predictor import export_predictor
from scripts.generate import generate
from scripts.output import write_text
from scripts.render import render
from scripts.stress import stress
from scripts.threads import bound_threads
from scripts.train_policy import train_policy
from scripts.train_predictor import train_predictor

COMMANDS: Final[dict[str, Callable[..., None]]] = {
    "demo": demo,
    "generate": generate,
    "convert": convert,
    "train-predictor": train_predictor,
    "evaluate-predictor": evaluate_predictor,
    "calibrate-predictor": calibrate_predictor,
    "explain-predictor": explain_predictor,
    "export-predictor": export_predictor,
    "train-policy": train_policy,
    "evaluate": evaluate,
    "stress": stress,
    "render": render,
    "benchmark": benchmark,
}
DEBUG: Final = "CROWDNAV_DEBUG"
LONGEST_LINE: Final = 600


class Parser(ArgumentParser):
    """A parser that answers bad input with one line instead of its usage."""

    def add_argument(self, *arguments: Any, **options: Any) -> Any:
        """Add an option; one that is true or false needs no value to be set: `--resume`."""
        if options.get("type") is bool:
            options = {key: value for key, value in options.items() if key != "type"}
            options |= {"action": ActionYesNo, "nargs": "?"}
        return super().add_argument(*arguments, **options)

    def error(self, message: str, ex: Exception | None = None) -> NoReturn:
        """Print what was expected and found, and exit with status 2."""
        self.exit(2, one_line(message))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one subcommand.

    Args:
        arguments: Command line without the program's name; `sys.argv` if None.

    Returns:
        Exit status: 0 done, 2 bad input (one line on stderr says what was expected and found),
        130 interrupted. With the variable CROWDNAV_DEBUG set, bad input shows its traceback.
    """
    bound_threads(1)
    parser, subparsers = build_parser()
    try:
        chosen = parser.parse_args(arguments)
        name = chosen.subcommand
        run(COMMANDS[name], subparsers[name], chosen[name])
    except KeyboardInterrupt as interrupt:
        hint = str(interrupt)
        sys.stderr.write(one_line(hint if hint else "interrupted", kind="stopped"))
        return 130
    except (ValueError, OSError, FloatingPointError) as error:
        # The packages raise these at their borders, where input is judged, and where a training
        # diverges. Anything else is a mistake of the program and keeps its traceback.
        if os.environ.get(DEBUG):
            raise
        sys.stderr.write(one_line(str(error)))
        return 2
    return 0


def build_parser() -> tuple[Parser, dict[str, Parser]]:
    """The parser of the program and, by name, those of its subcommands."""
    parser = Parser(
        prog="crowdnav",
        description="A crowd simulator, a trained pedestrian predictor and a robot in one loop.",
        epilog=f"Bad input exits with status 2 and one line; {DEBUG}=1 shows the traceback.",
    )
    commands = parser.add_subcommands()
    subparsers = {}
    for name, function in COMMANDS.items():
        summary, _, details = (function.__doc__ or "").partition("\n\n")
        subparser = Parser(description=summary + "\n" + details.partition("\n\n    Args:")[0])
        subparser.add_argument("--config", action="config", help="YAML file with these options.")
        subparser.add_function_arguments(function, as_group=False, as_positional=True)
        commands.add_subcommand(name, subparser, help=summary)
        subparsers[name] = subparser
    return parser, subparsers


def run(command: Callable[..., None], parser: Parser, options: Any) -> None:
    """Run a command, then put its resolved configuration beside its results.

    The configuration comes last, so that it never describes results of an earlier run.
    """
    require_own_packages()
    arguments = {key: value for key, value in options.items() if key != "config"}
    command(**arguments)
    out = arguments.get("out")
    if out is not None:
        file = out / "config.yaml" if out.is_dir() else out.with_suffix(".yaml")
        write_text(file, parser.dump(options, skip_unset=False))


def require_own_packages() -> None:
    """Fail clearly when another distribution's `envs` (PyPI has one) shadows ours.

    Raises:
        ValueError: A package of ours comes from somewhere else.
    """
    home = Path(__file__).parent.parent
    for package in ("crowdsim", "predictor", "envs"):
        spec = find_spec(package)
        found = None if spec is None or spec.origin is None else Path(spec.origin)
        if found is None or found.parent.parent != home:
            raise ValueError(
                f"expected the package {package!r} in {home}, found {found}: another distribution "
                "of that name shadows it; uninstall it or use a fresh virtual environment"
            )


def one_line(message: str, *, kind: str = "error") -> str:
    """A message of any shape as one line that names the program."""
    text = " ".join(message.split())
    if len(text) > LONGEST_LINE:
        text = text[:LONGEST_LINE] + "…"
    return f"crowdnav: {kind}: {text}\n"


if __name__ == "__main__":
    sys.exit(main())
