"""Fixtures shared by all tests."""

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def data_root() -> Path:
    """Folder with the real data (`eth_ucy/`, `sdd/`): `$CROWDNAV_DATA` or `../shared/data`."""
    root = Path(os.environ.get("CROWDNAV_DATA", Path(__file__).parents[2] / "shared" / "data"))
    if not (root / "eth_ucy").is_dir():
        pytest.skip(f"needs the real ETH/UCY data, not found at {root} (set CROWDNAV_DATA)")
    return root
