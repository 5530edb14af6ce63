"""Runs the program inside the test's own process, which is quick."""

import pytest
from command_line import Crowdnav, Outcome

from scripts.__main__ import main


@pytest.fixture
def crowdnav(capsys: pytest.CaptureFixture[str]) -> Crowdnav:
    """Runs one command line and tells its exit status and what it printed."""

    def run(*arguments: object) -> Outcome:
        try:
            status = main([str(argument) for argument in arguments])
        except SystemExit as exit_:
            status = exit_.code if isinstance(exit_.code, int) else 1
        captured = capsys.readouterr()
        return Outcome(status, captured.out, captured.err)

    return run
