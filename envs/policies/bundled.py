"""Trained policies that come with the package, one for each forecaster and training seed."""

from __future__ import annotations

from pathlib import Path
from typing import Final

BUNDLED: Final = Path(__file__).parent / "weights"
"""Holds `ppo/FORECASTER-SEED`, each the folder of a trained policy."""


def bundled_policy(spec: str, forecaster: str) -> Path:
    """Returns the folder of the policy that was trained with a forecaster.

    Args:
        spec: `ppo`, or `ppo@SEED` for one of another training seed than 0.
        forecaster: What `CrowdNavConfig.forecaster` takes.

    Raises:
        ValueError: There is none; the message names those that there are.
    """
    name, at, seed = spec.partition("@")
    known = sorted(path.name for path in (BUNDLED / name).glob("*-*") if path.is_dir())
    wanted = f"{forecaster}-{seed if at else 0}"
    if wanted not in known:
        bundled = f"there are {', '.join(known)}" if known else "there is none at all"
        raise ValueError(
            f"expected a bundled policy {wanted} (forecaster and training seed) for {spec!r}, "
            f"{bundled}; another policy goes by its folder"
        )
    return BUNDLED / name / wanted
