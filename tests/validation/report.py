"""Write docs/validation.md and its figures: `python tests/validation/report.py`."""

import sys
import warnings
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))

import matplotlib  # noqa: E402

matplotlib.use("Agg")

import counterflow  # noqa: E402
import crowds  # noqa: E402
import flow  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402
import motion_report  # noqa: E402
import numpy as np  # noqa: E402
from cases import CASES  # noqa: E402
from tqdm import tqdm  # noqa: E402

from crowdsim.forces import ETH_UCY, SocialForce  # noqa: E402

PAGE = ROOT / "docs" / "validation.md"
FIGURES = ROOT / "docs" / "validation"
MEASURED, SIMULATED = "#9a9a9a", "#2654a4"

HEAD = """# Validation against pedestrian dynamics

The simulator with its default social force, against the RiMEA test cases and against measured
crowds (`shared/data/pedestrian_dynamics`, experiments of the Jülich and Wuppertal groups and of the
authors named there). Densities, speeds and flows are measured with
[PedPy](https://pedpy.readthedocs.io). This page is written, in some five minutes of one processor
core, by

```
make validation        # or: python tests/validation/report.py
```

and the same cases are tests: `python -m pytest tests/validation --override-ini=addopts=`. Seeds are
100 and up, 5 for each case (lanes 10); parameters were chosen on smaller ones.

| case | value | band | seeds | verdict |
|---|---|---|---|---|
"""

NOTES = """
How to read it: two halves of one experiment are 0.09 apart in the two-dimensional
Kolmogorov-Smirnov distance, Weidmann's curve and the one-way points 0.23, one-way and counterflow
0.36. Simulated points are drawn at the densities of the measured ones, so that the distance tells
about speeds. Bands of flow are the measured range at that width, 0.5 /s wider on both sides.

"""

PICTURES = """
![Speed against density: simulated and measured](validation/density_speed.png)

Left: one-way corridor of 1.8 m. Right: single file.

![Flow through bottlenecks against their width](validation/bottleneck.png)

![Lanes in counterflow](validation/lanes.png)

Two streams in a corridor of 4 m at 0.8 /m², at the start and after a minute.
"""


TRADE = """
## What other parameters would do

With one seed. A wider or a more one-sided repulsion slows people down earlier, as measured
crowds do, and lets fewer people through doors; a narrower one lets dense crowds walk too fast.
Without a time gap (`hold_back=0`) people follow too fast in single file.

| parameters | KS one-way | Weidmann RMSE [m/s] | flow at 0.8 m | 1.0 m | 1.2 m | KS single file |
|---|---|---|---|---|---|---|
"""

VARIANT_SEEDS = (3,)
VARIANTS = {
    "defaults": SocialForce(),
    "`anisotropy=0.1`": SocialForce(anisotropy=0.1),
    "`repulsion_range=0.25`": SocialForce(repulsion_range=0.25),
    "`repulsion_range=0.45`": SocialForce(repulsion_range=0.45),
    "`repulsion=2.5`": SocialForce(repulsion=2.5),
    "`hold_back=0`": SocialForce(hold_back=0.0),
    "`time_gap=0.6`": SocialForce(time_gap=0.6),
    "`ETH_UCY`": ETH_UCY,
}


def number(value):
    return f"{value:.3g}"


def band(case):
    if np.isinf(case.low):
        return f"≤ {case.high:.4g}"
    return f"≥ {case.low:.4g}" if np.isinf(case.high) else f"{case.low:.4g} to {case.high:.4g}"


def row(case):
    values, hits = case.values, case.hits()
    shown = ", ".join(number(value) for value in values)
    if hits >= case.wanted:
        verdict = "holds" if hits == case.seeds else f"holds ({hits} of {case.seeds})"
    else:
        verdict = f"**missed** ({hits} of {case.seeds} in the band): {case.miss}"
    return f"| {case.name} | {case.value} | {band(case)} | {shown} | {verdict} |\n"


def save(figure, name):
    figure.tight_layout()
    figure.savefig(FIGURES / f"{name}.png", dpi=90)
    plt.close(figure)


def draw_density_and_speed():
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), sharey=True)
    one_way = flow.measured("unidirectional_*.txt"), flow.one_way_cloud(0)
    single = flow.measured("single_file_*.txt"), flow.single_file_cloud(0)
    for axis, (real, made), unit in zip(axes, (one_way, single), ("1/m²", "1/m"), strict=True):
        axis.scatter(*real.T, s=6, color=MEASURED, label="measured")
        axis.scatter(*made.T, s=8, color=SIMULATED, alpha=0.6, label="simulated")
        axis.set(xlabel=f"density [{unit}]", ylim=(-0.1, 1.9))
        axis.legend(frameon=False)
    density = np.linspace(0.1, 5.3, 100)
    axes[0].plot(density, flow.weidmann(density), "k--", lw=1, label="Weidmann 1993")
    axes[0].set(ylabel="speed [m/s]")
    axes[0].legend(frameon=False)
    save(figure, "density_speed")


def draw_bottleneck():
    figure, axis = plt.subplots(figsize=(5, 3.6))
    points = flow.measured("bottleneck_*.txt")
    axis.scatter(*points[points[:, 0] <= 1.5].T, s=14, color=MEASURED, label="measured")
    for width in flow.DOORS:
        flows = [flow.bottleneck(seed, width)[0] for seed in range(5)]
        label = "simulated" if width == flow.DOORS[0] else None
        axis.scatter([width] * 5, flows, s=18, color=SIMULATED, marker="x", label=label)
    axis.set(xlabel="width [m]", ylabel="flow [1/s]")
    axis.legend(frameon=False)
    save(figure, "bottleneck")


def draw_lanes():
    tracks, right = counterflow.counterflow(0)
    figure, axes = plt.subplots(2, 1, figsize=(8, 3.4), sharex=True)
    for axis, index in zip(axes, (0, -1), strict=True):
        order = counterflow.lane_order(tracks.positions[[index]], right)[0]
        for people, color in ((right, SIMULATED), (~right, "#e26016")):
            axis.scatter(*tracks.positions[index, people].T, s=40, color=color)
        axis.set(xlim=(-12, 12), ylim=(-2.1, 2.1), aspect="equal", ylabel=f"lane order {order:.2f}")
    save(figure, "lanes")


def cloud_with(model):
    """Row of the table of variants."""
    crowds.MODEL = model
    for measure in (flow.one_way_cloud, flow.bottleneck, flow.single_file_cloud):
        measure.cache_clear()
    cells = [
        [flow.one_way_distance(seed) for seed in VARIANT_SEEDS],
        [flow.weidmann_error(seed) for seed in VARIANT_SEEDS],
        *([flow.bottleneck(seed, width)[0] for seed in VARIANT_SEEDS] for width in flow.DOORS),
        [flow.single_file_distance(seed) for seed in VARIANT_SEEDS],
    ]
    return " | ".join(number(np.mean(values)) for values in cells)


def variants():
    """Table of what other parameters would do."""
    table = "".join(f"| {name} | {cloud_with(model)} |\n" for name, model in VARIANTS.items())
    crowds.MODEL = SocialForce()
    return table


def main():
    warnings.simplefilter("ignore")
    FIGURES.mkdir(exist_ok=True)
    rows = "".join(row(case) for case in tqdm(CASES, unit="case"))
    draw_density_and_speed()
    draw_bottleneck()
    draw_lanes()
    page = HEAD + rows + NOTES + PICTURES.lstrip("\n") + motion_report.street()
    page += motion_report.anew() + TRADE + variants()
    PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
