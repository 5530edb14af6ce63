"""Draws docs/policies/curves.png: how the bundled policies learned, of each arm its three seeds.

python tests/validation/learning_curves.py docs/policies/curves.png
"""

import json
import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from envs.policies.bundled import BUNDLED

POINTS = 100
"""Steps at which the curves of the seeds are compared."""

SHOWN = {"success": "success of the latest 100 episodes", "mean_return": "return of the same"}


def curves(key: str) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """By forecaster the steps (P,), and what the curve of each seed says there (seeds, P)."""
    found: dict[str, list[list[dict[str, float]]]] = {}
    for path in sorted((BUNDLED / "ppo").glob("*/curve.json")):
        forecaster = path.parent.name.rpartition("-")[0]
        found.setdefault(forecaster, []).append(json.loads(path.read_text()))
    return {name: _on_common_steps(seeds, key) for name, seeds in found.items()}


def _on_common_steps(
    seeds: list[list[dict[str, float]]], key: str
) -> tuple[np.ndarray, np.ndarray]:
    first = max(points[0]["step"] for points in seeds)
    last = min(points[-1]["step"] for points in seeds)
    steps = np.linspace(first, last, POINTS)
    values = [
        np.interp(steps, [at["step"] for at in points], [at[key] for at in points])
        for points in seeds
    ]
    return steps, np.array(values)


def draw(axes: Axes, key: str) -> None:
    """One panel: the mean over the seeds as a line, all that they span around it."""
    for name, (steps, values) in curves(key).items():
        line = axes.plot(steps / 1000, values.mean(axis=0), label=f"{name} (n={len(values)})")[0]
        axes.fill_between(
            steps / 1000, values.min(axis=0), values.max(axis=0), alpha=0.2, color=line.get_color()
        )
    axes.set_xlabel("thousand steps")
    axes.set_ylabel(SHOWN[key])
    axes.grid(alpha=0.3)


def main(out: Path) -> None:
    """Write the picture."""
    figure = Figure(figsize=(9.0, 3.4), layout="constrained")
    for axes, key in zip(figure.subplots(1, 2), SHOWN, strict=True):
        draw(axes, key)
    figure.axes[0].legend(loc="lower right")
    out.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(out, dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
