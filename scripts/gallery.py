"""Writes the gallery of scenarios into `docs`: `python -m scripts.gallery [NAME ...]`."""

import sys
from collections.abc import Sequence
from pathlib import Path

from scripts.output import write_text


def gallery(names: Sequence[str], docs: Path) -> None:
    """Write the page, and the pictures of some scenarios.

    Args:
        names: Whose pictures are drawn anew; all of them if empty.
        docs: Folder of the page; the pictures go into `scenarios` in it.
    """
    from crowdsim.gallery import page, picture
    from crowdsim.recordings.store import write_atomic
    from crowdsim.scenarios import SCENARIOS

    folder = docs / "scenarios"
    folder.mkdir(parents=True, exist_ok=True)
    for name in names if names else SCENARIOS:
        write_atomic(folder / f"{name}.webp", picture(name))
    write_text(docs / "scenarios.md", page())


if __name__ == "__main__":
    gallery(sys.argv[1:], Path(__file__).parents[1] / "docs")
