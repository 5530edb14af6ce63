"""The part of docs/validation.md that compares single people's motion with recorded crowds."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import real_crowds
import resimulation

from crowdsim.forces import ELLIPTICAL, ETH_UCY, MOUSSAID_2009, SocialForce

FIGURES = Path(__file__).parents[2] / "docs" / "validation"
MEASURED, SIMULATED, FITTED = "#9a9a9a", "#2654a4", "#e26016"

STREET = """
## Motion of single people

![Distributions of motion on a simulated street and a recorded one](validation/motion.png)

People on a simulated street, 70 % of them in groups, and in ETH/UCY's crowds_zara01, both sampled
every 0.4 s: medians are

"""

ANEW = """
## Recorded crowds simulated anew

`ETH_UCY` of `crowdsim.forces` is fitted to recorded crowds (`python tests/validation/fit.py`, on
{fitted}) and held against others ({held_out}). Every 10 s
all who are seen start with the place and velocity that they had, on the scene's map, in the groups
that the data name, with the place where they are last seen as goal and their own mean speed as
desired speed; then 4.8 s are compared with what they did: Kolmogorov-Smirnov distances of four
distributions (0 is equal, 1 apart), and the mean distance from where they really were. Goals and
speeds come from the future, so this measures forces and is no forecast; constant velocity, which
knows neither, stands beside it. Recorded tracks were drawn as smooth curves through points that
annotators set, which makes their accelerations and curvatures smaller than people's.

"""

FIGURE = """
![Distributions of motion: recorded, with defaults, and fitted](validation/resimulation.png)

The same four distributions of {held_out}: recorded, and simulated anew with the defaults and with
`ETH_UCY`.

The forces within groups, as published, do not help here: without them speeds, distances and places
fit better. And with known goals, over 4.8 s, people without any force between them end up as near
to the recorded places as fitted ones; what the fit gains is the distance that people keep.
"""

NO_FORCE = SocialForce(repulsion=0.0, hold_back=0.0, whim=0.0)
MODELS = {
    "defaults": (SocialForce(), True),
    "`ETH_UCY`": (ETH_UCY, True),
    "`ETH_UCY`, nobody in groups": (ETH_UCY, False),
    "`ELLIPTICAL`": (ELLIPTICAL, True),
    "`MOUSSAID_2009`": (MOUSSAID_2009, True),
    "no forces between people, nobody in groups": (NO_FORCE, False),
}
"""Parameters, and whether people are in the groups that the data name."""


def draw_histograms(axes, samples):
    """One histogram per quantity of `{label: (color, samples)}`, the first one filled."""
    for index, (axis, name) in enumerate(zip(axes, real_crowds.QUANTITIES, strict=True)):
        values = [quantities[index] for _, quantities in samples.values()]
        bins = np.linspace(0, np.percentile(np.concatenate(values), 97), 30)
        for number, (label, (color, quantities)) in enumerate(samples.items()):
            kind = "bar" if number == 0 else "step"
            axis.hist(
                quantities[index], bins, density=True, color=color, label=label, histtype=kind
            )
        axis.set(xlabel=name, yticks=[])
    axes[0].legend(frameon=False, fontsize=8)


def save_histograms(name, samples):
    figure, axes = plt.subplots(1, 4, figsize=(12, 3))
    draw_histograms(axes, samples)
    figure.tight_layout()
    figure.savefig(FIGURES / f"{name}.png", dpi=90)
    plt.close(figure)


def street():
    """Section on the simulated street, and its figure."""
    real, made = real_crowds.recorded("crowds_zara01"), real_crowds.simulated(0)
    save_histograms("motion", {"crowds_zara01": (MEASURED, real), "simulated": (SIMULATED, made)})
    table = "| quantity | recorded | simulated |\n|---|---|---|\n"
    for name, a, b in zip(real_crowds.QUANTITIES, real, made, strict=True):
        table += f"| {name} | {np.median(a):.2f} | {np.median(b):.2f} |\n"
    return STREET + table


def comparison_row(name, scenes, comparison):
    distances = " | ".join(f"{distance:.2f}" for distance in comparison.distances())
    return f"| {scenes} | {name} | {distances} | {comparison.error:.2f} |\n"


def anew():
    """Section on recorded crowds simulated anew, and its figure."""
    quantities = " | ".join(f"KS {name.split(' [')[0]}" for name in real_crowds.QUANTITIES)
    table = f"| scenes | parameters | {quantities} | mean distance [m] |\n" + "|---" * 7 + "|\n"
    for title, scenes in (("fitted", resimulation.FITTED), ("held out", resimulation.HELD_OUT)):
        compared = {
            name: resimulation.compare(scenes, model, grouped=grouped)
            for name, (model, grouped) in MODELS.items()
        }
        for name, comparison in compared.items():
            table += comparison_row(name, title, comparison)
        plain = compared["defaults"].plain_error
        table += f"| {title} | constant velocity | | | | | {plain:.2f} |\n"
    default, fitted = compared["defaults"], compared["`ETH_UCY`"]
    save_histograms(
        "resimulation",
        {
            "recorded": (MEASURED, default.real),
            "defaults": (SIMULATED, default.made),
            "ETH_UCY": (FITTED, fitted.made),
        },
    )
    names = {
        "fitted": " and ".join(resimulation.FITTED),
        "held_out": " and ".join(resimulation.HELD_OUT),
    }
    return ANEW.format(**names) + table + FIGURE.format(**names)
