"""Measurements that need a process of their own."""

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

ROOT: Final = Path(__file__).parents[2]


def answer_of(
    module: str, *arguments: int, environment: Mapping[str, str] | None = None
) -> dict[str, Any]:
    """Run a module as a program in a fresh Python process; the JSON object that it prints.

    Args:
        module: Its dotted name.
        arguments: For its command line.
        environment: Variables of the process; None takes those of this one.

    Raises:
        RuntimeError: The process failed; the message has what it wrote to stderr.
    """
    variables = {**(os.environ if environment is None else environment)}
    inherited = [variables["PYTHONPATH"]] if "PYTHONPATH" in variables else []
    variables["PYTHONPATH"] = os.pathsep.join([str(ROOT), *inherited])
    process = subprocess.run(
        [sys.executable, "-m", module, *map(str, arguments)],
        env=variables,
        capture_output=True,
        text=True,
        check=False,
    )
    if process.returncode != 0:
        raise RuntimeError(f"{module} ended with {process.returncode}: {process.stderr}")
    answer: dict[str, Any] = json.loads(process.stdout)
    return answer
