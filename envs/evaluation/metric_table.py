"""Names, units, definitions and sources of the metrics, for tables and the report."""

from dataclasses import dataclass
from typing import Literal

Better = Literal["higher", "lower", "neither"]


@dataclass(frozen=True, kw_only=True)
class Metric:
    """How one column of the episode table is to be read.

    Attributes:
        label: What a table says.
        unit: SI unit; "" for counts, ratios and shares.
        better: Which direction is the better one.
        definition: What it measures, in one sentence, with its source.
        kind: `share` for booleans (aggregated as a proportion), else `mean`.
        aggregate: Name of its aggregate, where that has to say more than the column does.
    """

    label: str
    definition: str
    unit: str = ""
    better: Better = "lower"
    kind: Literal["share", "mean"] = "mean"
    aggregate: str = ""


METRICS: dict[str, Metric] = {
    "success": Metric(
        label="success",
        better="higher",
        kind="share",
        definition="Goal reached in time without contact.",
    ),
    "collision_pedestrian": Metric(
        label="pedestrian collision",
        kind="share",
        definition="The episode ended in contact with a pedestrian.",
    ),
    "collision_wall": Metric(
        label="wall collision",
        kind="share",
        definition="The episode ended in contact with a wall or an obstacle.",
    ),
    "timeout": Metric(label="timeout", kind="share", definition="The time limit was reached."),
    "time_to_goal": Metric(
        label="time to goal (successes only)",
        unit="s",
        aggregate="time_to_goal_on_success",
        definition="Time until the goal; failures have none and are left out. In a mission the "
        "mean over the ways that led to their goals.",
    ),
    "time_to_goal_penalized": Metric(
        label="time to goal (failures at limit)",
        unit="s",
        definition="Time until the goal; every failure counts as the whole time limit. In a "
        "mission the mean over all ways.",
    ),
    "goals_reached": Metric(
        label="goals reached in a mission",
        better="higher",
        definition="Number of ways of a mission that led to their goals; none for a single way.",
    ),
    "time_without_contact": Metric(
        label="mission time without contact",
        unit="s",
        better="higher",
        definition="Time of a mission until the first contact, or until its end without one, "
        "which makes it a lower bound; none for a single way.",
    ),
    "path_length": Metric(
        label="path length",
        unit="m",
        better="neither",
        definition="Length of the path travelled, until the end of the episode however it ended.",
    ),
    "spl": Metric(
        label="SPL",
        better="higher",
        definition="Success weighted by shortest path over path length, the shortest path taken on "
        "the map (Anderson et al. 2018); 0 for a failure. In a mission the mean over all ways.",
    ),
    "path_irregularity": Metric(
        label="path irregularity",
        unit="rad/m",
        definition="Rotation beyond what the shortest path asks for, per metre (Guzzi 2013).",
    ),
    "speed_mean": Metric(
        label="speed, mean", unit="m/s", better="neither", definition="Robot's mean speed."
    ),
    "speed_max": Metric(
        label="speed, max", unit="m/s", better="neither", definition="Robot's highest speed."
    ),
    "acceleration_mean": Metric(
        label="acceleration, mean",
        unit="m/s²",
        definition="Mean norm of the change of velocity per policy step.",
    ),
    "acceleration_max": Metric(
        label="acceleration, max", unit="m/s²", definition="Largest norm of that change."
    ),
    "jerk_mean": Metric(
        label="jerk, mean",
        unit="m/s³",
        definition="Mean norm of the change of acceleration per policy step.",
    ),
    "jerk_max": Metric(label="jerk, max", unit="m/s³", definition="Largest norm of that change."),
    "cumulative_heading_change": Metric(
        label="heading change",
        unit="rad",
        definition="Sum of the absolute changes of heading.",
    ),
    "clearance_min": Metric(
        label="clearance, min",
        unit="m",
        better="higher",
        definition="Smallest distance to any pedestrian, surface to surface, over physics steps.",
    ),
    "clearance_mean": Metric(
        label="clearance, mean",
        unit="m",
        better="higher",
        definition="Mean over time of the distance to the nearest pedestrian, surface to surface.",
    ),
    "wall_clearance_min": Metric(
        label="wall clearance, min",
        unit="m",
        better="higher",
        definition="Smallest distance to walls and obstacles, surface to surface.",
    ),
    "wall_clearance_mean": Metric(
        label="wall clearance, mean",
        unit="m",
        better="higher",
        definition="Mean over time of the distance to the nearest wall or obstacle.",
    ),
    "time_to_collision_min": Metric(
        label="time to collision, min",
        unit="s",
        better="higher",
        definition="Smallest time to contact of the discs if all kept their velocity; 10 s where "
        "there was never a collision course within 10 s.",
    ),
    "space_compliance_0.5": Metric(
        label="space compliance 0.5 m",
        better="higher",
        definition="Share of time with more than 0.5 m of clearance to every pedestrian "
        "(Francis et al. 2023).",
    ),
    "intimate_zone_share": Metric(
        label="in intimate zone",
        definition="Share of time within 0.45 m of a pedestrian, surface to surface (Hall 1966).",
    ),
    "personal_zone_share": Metric(
        label="in personal zone",
        definition="Share of time within 1.2 m of a pedestrian, the intimate zone included.",
    ),
    "social_zone_share": Metric(
        label="in social zone",
        definition="Share of time within 3.6 m of a pedestrian, the nearer zones included.",
    ),
    "intrusion_ratio@1.2": Metric(
        label="intrusion ratio, 1.2 s",
        definition="Share of steps in which the robot touches the strip that a pedestrian truly "
        "sweeps over the next 1.2 s (after Liu et al. 2023).",
    ),
    "social_distance@1.2": Metric(
        label="social distance, 1.2 s",
        unit="m",
        better="higher",
        definition="Clearance to the nearest pedestrian during 1.2 s intrusions; none without.",
    ),
    "intrusion_ratio@4.8": Metric(
        label="intrusion ratio, 4.8 s",
        definition="The same over the next 4.8 s.",
    ),
    "social_distance@4.8": Metric(
        label="social distance, 4.8 s",
        unit="m",
        better="higher",
        definition="Clearance to the nearest pedestrian during 4.8 s intrusions; none without.",
    ),
    "stalled_time": Metric(label="stalled time", unit="s", definition="Time spent below 0.05 m/s."),
    "failure_to_progress": Metric(
        label="failures to progress",
        definition="Number of successive 5 s windows that bring the robot less than 0.5 m nearer "
        "to its goal along the map (Francis et al. 2023).",
    ),
    "social_work": Metric(
        label="social work",
        unit="m/s",
        definition="Social force on the robot plus that of the robot on people, per unit mass, "
        "summed over time (after HuNavSim, Pérez-Higueras et al. 2023).",
    ),
    "pedestrian_delay": Metric(
        label="pedestrian delay",
        unit="s",
        definition="How much later people are on their own path than in the twin run without the "
        "robot, mean over people at the end; unknown in a replay, whose people cannot react, and "
        "in a mission.",
    ),
    "pedestrian_displacement": Metric(
        label="pedestrian displacement",
        unit="m",
        definition="Mean distance of people from where they are at the same time in the twin run "
        "without the robot; unknown in a replay and in a mission.",
    ),
    "forecast_ade": Metric(
        label="forecast ADE",
        unit="m",
        definition="Mean error of the forecasts the robot saw against what people then did, over "
        "forecasts whose whole horizon lies within the episode.",
    ),
    "forecast_fde": Metric(
        label="forecast FDE", unit="m", definition="The same at the end of the horizon."
    ),
    "forecast_ms": Metric(
        label="forecast time",
        unit="ms",
        definition="Wall-clock time of the forecaster per policy step, shared over the batch.",
    ),
}


HEADLINE = (
    "success",
    "collision_pedestrian",
    "time_to_goal_penalized",
    "intrusion_ratio@4.8",
    "clearance_min",
    "pedestrian_delay",
    "forecast_fde",
)
"""Columns that any two arms are compared in; the others are compared with the reference only."""


def aggregate_name(key: str) -> str:
    """Name of a column's aggregate: the column's own, unless that would hide what it leaves out."""
    aggregate = METRICS[key].aggregate
    return aggregate if aggregate else key
