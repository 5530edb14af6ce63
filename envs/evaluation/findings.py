"""What an evaluation found, by question, one sentence each, inconclusive ones included."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from envs.evaluation.comparison import VISIBILITY_NAMES
from envs.evaluation.metric_table import HEADLINE, METRICS, Metric, aggregate_name
from envs.evaluation.summary import ALL_SCENARIOS
from envs.evaluation.wording import difference_text, listed, number, share, verdict_words

HELP: Final = "Does forecasting help?"
ROBOT_PART: Final = "How much of the forecast error is the robot's own doing?"
DOSE: Final = "Does a better forecast drive better?"
IN_THE_LOOP: Final = "How good are forecasts in the closed loop?"
HORIZON: Final = "How long a horizon pays?"
VISIBILITY: Final = "Does it matter whether people see the robot?"
OTHER_PEOPLE: Final = "Does it hold for people who move by another model?"

NLL: Final = Metric(label="nll", unit="nat", definition="Negative log density of the truth.")

HOW_TO_ASK: Final[Mapping[str, str]] = {
    HELP: "compare a policy with and without forecasts, such as "
    "--policies mppi --forecasters none,constant_velocity",
    ROBOT_PART: "--twins",
    DOSE: "three forecasters or more in the same policy, such as "
    "--forecasters constant_velocity,oracle,oracle_noisy@sigma=1",
    IN_THE_LOOP: "a forecaster, such as --forecasters constant_velocity, and episodes longer than "
    "its horizon",
    HORIZON: "--policies mppi@9.6 --horizons [0,0.4,1.2,2.4,4.8,9.6]",
    VISIBILITY: "--robot_visible [true,false]",
    OTHER_PEOPLE: "--models social_force,orca",
}
"""Every question of the report, in its order, and what an evaluation needs to answer it."""


def findings(summary: Mapping[str, Any]) -> dict[str, list[str]]:
    """Sentences with numbers, intervals and counts from the summary of an evaluation.

    Returns:
        By question of `HOW_TO_ASK`; one that was not asked has the sentence that says how to.
    """
    breakdown = summary["forecast_errors"]
    settings = summary["settings"]
    group = pooled_group(summary)
    answers = {
        HELP: _help(summary, group),
        ROBOT_PART: _robot_part(breakdown, group),
        DOSE: _dose(summary["dose_response"]),
        IN_THE_LOOP: _in_the_loop(group, breakdown),
        HORIZON: _horizon(settings["horizon"]),
        VISIBILITY: _changes(settings["robot_visible"], VISIBILITY_NAMES.__getitem__),
        OTHER_PEOPLE: _changes(settings["model"], str),
    }
    if not group["without_forecasts"]:
        answers[HELP].append(_not_asked(HELP))
    return {
        question: answers[question] if answers[question] else [_not_asked(question)]
        for question in HOW_TO_ASK
    }


def _not_asked(question: str) -> str:
    return f"Not asked here; to ask: {HOW_TO_ASK[question]}."


def pooled_group(summary: Mapping[str, Any]) -> Mapping[str, Any]:
    """The entry of all scenarios together, or of the only one."""
    scenarios = summary["scenarios"]
    name = ALL_SCENARIOS if ALL_SCENARIOS in scenarios else next(iter(scenarios))
    group: Mapping[str, Any] = scenarios[name]
    return group


def _help(summary: Mapping[str, Any], group: Mapping[str, Any]) -> list[str]:
    """Every arm against its policy without forecasts, or else against the reference."""
    arms, reference = summary["arms"], summary["reference"]
    sentences = [*_help_counts(group["without_forecasts"]), _reference_sentence(reference, group)]
    for arm in arms:
        if arm in group["without_forecasts"]:
            sentences += _compared(
                arm, "the same policy without forecasts", group, "without_forecasts"
            )
        elif arm != reference:
            sentences += _compared(arm, reference, group, "differences")
    return sentences + _between_forecasters(summary, group)


def _help_counts(gains: Mapping[str, Any]) -> list[str]:
    """In how many arms forecasts change success, as a first answer."""
    if not gains:
        return []
    verdicts = [entry["success"]["verdict"] for entry in gains.values()]
    counts = {name: verdicts.count(name) for name in ("better", "worse", "inconclusive")}
    return [
        f"Of {len(verdicts)} arms with forecasts, all scenarios together, {counts['better']} reach "
        f"their goal conclusively more often than the same policy without, {counts['worse']} less "
        f"often; {counts['inconclusive']} inconclusive."
    ]


def _reference_sentence(reference: str, group: Mapping[str, Any]) -> str:
    metrics = group["arms"][reference]["metrics"]
    return (
        f"The reference {reference} (n = {metrics['success']['n']} episodes) reached its goal in "
        f"{share(metrics['success'])} and ended in contact with a pedestrian in "
        f"{share(metrics['collision_pedestrian'])}; brackets hold 95 % intervals."
    )


def _compared(arm: str, other: str, group: Mapping[str, Any], where: str) -> list[str]:
    """An arm's success against another's, and what the other headline metrics say."""
    success, differences = group["arms"][arm]["metrics"]["success"], group[where][arm]
    difference = differences["success"]
    return [
        f"{arm} reached its goal in {share(success)}: "
        f"{difference_text(difference, METRICS['success'])} against {other} "
        f"(n = {difference['n']} pairs), {verdict_words(difference['verdict'])}; "
        f"{_otherwise(differences)}."
    ]


def _otherwise(differences: Mapping[str, Any]) -> str:
    """What the headline metrics besides success say, conclusive differences first."""
    conclusive: list[str] = []
    unclear: list[str] = []
    for key in HEADLINE[1:]:
        difference = differences[aggregate_name(key)]
        if difference["mean"] is None:
            continue
        if difference["verdict"] == "inconclusive":
            unclear.append(METRICS[key].label)
        else:
            text = difference_text(difference, METRICS[key])
            conclusive.append(f"{difference['verdict']} in {METRICS[key].label} by {text}")
    if unclear:
        conclusive.append(f"inconclusive in {listed(unclear)}")
    return "; ".join(conclusive)


def _between_forecasters(summary: Mapping[str, Any], group: Mapping[str, Any]) -> list[str]:
    """Every forecaster against the first one of the same policy and horizon."""
    sentences = []
    for arm, earlier in group["between"].items():
        for other, differences in list(earlier.items())[:1]:
            success = difference_text(differences["success"], METRICS["success"])
            sentences.append(
                f"{arm} against {other}: success {success}, "
                f"{verdict_words(differences['success']['verdict'])}; {_otherwise(differences)}."
            )
            if ALL_SCENARIOS in summary["scenarios"]:
                sentences.append(_by_scenario(arm, other, summary["scenarios"]))
    return sentences


def _by_scenario(arm: str, other: str, scenarios: Mapping[str, Any]) -> str:
    """Whose forecasts are better where: a pooled error hides that scenarios may disagree."""
    parts = []
    for name, group in scenarios.items():
        difference = group["between"][arm][other]["forecast_fde"]
        if name != ALL_SCENARIOS and difference["mean"] is not None:
            text = difference_text(difference, METRICS["forecast_fde"])
            parts.append(f"{name} {text} ({difference['verdict']})")
    return f"{arm} against {other} by scenario, forecast FDE: {'; '.join(parts)}."


def _robot_part(breakdown: Mapping[str, Any], group: Mapping[str, Any]) -> list[str]:
    """Per arm, what of its forecast error the robot caused and its delay; none without twins."""
    metric = METRICS["forecast_fde"]
    sentences = []
    for arm, entry in _pooled_errors(breakdown).items():
        for last in entry["robot_part"][-1:]:
            sentences.append(
                f"{arm}, {last['seconds']:g} s ahead: of an error of "
                f"{number(last['error'], metric)} the forecast would have made "
                f"{number(last['model_error'], metric)} without a robot; the robot moved people by "
                f"{number(last['displacement'], metric)} and changed the error by "
                f"{difference_text(last['caused'], metric)} (n = {last['error']['n']} forecasts)"
                f"{_delay(group['arms'][arm]['metrics']['pedestrian_delay'])}."
            )
    return sentences


def _delay(entry: Mapping[str, Any]) -> str:
    """By how much a robot delayed people over a whole episode; nothing where it is unknown."""
    if entry["mean"] is None:
        return ""
    delay = number(entry, METRICS["pedestrian_delay"])
    return f"; by the end of an episode it had delayed people by {delay} each"


def _dose(correlations: Mapping[str, Any]) -> list[str]:
    """Whether the forecaster that errs more also drives worse; nothing with too few of them."""
    parts = [
        f"{METRICS[key].label} {rho['mean']:+.2f} [{rho['low']:+.2f}, {rho['high']:+.2f}]"
        for key, rho in correlations.items()
        if rho["mean"] is not None
    ]
    if not parts:
        return []
    count = next(iter(correlations.values()))["n"]
    return [
        "Rank correlation (Spearman) of the forecasts' FDE over forecasters with "
        f"{listed(parts)}; mean over {count} pairs of policy and scenario. An interval that holds "
        "zero leaves it open."
    ]


def _in_the_loop(group: Mapping[str, Any], breakdown: Mapping[str, Any]) -> list[str]:
    """How far off forecasts are at their end, by distance, and whether their radii hold."""
    metric = METRICS["forecast_fde"]
    errors = {
        arm: entry["metrics"]["forecast_fde"]
        for arm, entry in group["arms"].items()
        if entry["metrics"]["forecast_fde"]["mean"] is not None
    }
    if not errors:
        return []
    ends = listed([f"{arm} {number(error, metric)}" for arm, error in errors.items()])
    sentences = [f"Closed-loop error at the end of the forecast horizon (FDE): {ends}."]
    for arm, entry in _pooled_errors(breakdown).items():
        parts = [
            f"{name.rstrip('-')} m{' and more' if name.endswith('-') else ''} "
            f"{number(numbers['fde'], metric)}"
            for name, numbers in entry["by_distance"].items()
        ]
        last = entry["by_step"][-1]
        sentences.append(
            f"{arm}, FDE by the distance to the robot when forecast: {listed(parts)}; "
            f"{share(last['coverage'])} of the positions {last['seconds']:g} s ahead "
            f"lay within the forecast's radius{_density(last['nll'])}."
        )
    return sentences


def _density(entry: Mapping[str, Any]) -> str:
    """The negative log density of the truth; nothing of who states no radius."""
    if entry["mean"] is None:
        return ""
    return f", with a negative log density of {number(entry, NLL)}"


def _horizon(lines: Mapping[str, Sequence[Mapping[str, Any]]]) -> list[str]:
    """Per policy and forecaster, success over the horizon, and the last step that helps."""
    sentences = []
    for line, points in lines.items():
        steps = [
            f"{share(point['metrics']['success'])} {_reach(point['value'])}" for point in points
        ]
        better = [point for point in points if _verdict(point) == "better"]
        worse = [point for point in points if _verdict(point) == "worse"]
        pays = "No horizon is conclusively better than the next shorter one"
        if better:
            gain = difference_text(better[-1]["change"]["success"], METRICS["success"])
            pays = f"The last step that helps conclusively is to {better[-1]['value']:g} s ({gain})"
        hurts = "none conclusively hurts"
        if worse:
            loss = difference_text(worse[0]["change"]["success"], METRICS["success"])
            hurts = f"the first that hurts is to {worse[0]['value']:g} s ({loss})"
        sentences.append(
            f"{line}: success {listed(steps)}. {pays}; {hurts} (n = {points[0]['n']} per horizon)."
        )
    return sentences


def _verdict(point: Mapping[str, Any]) -> str:
    return str(point["change"]["success"]["verdict"]) if point["change"] else "inconclusive"


def _reach(seconds: float) -> str:
    return f"at {seconds:g} s" if seconds else "without forecasts"


def _changes(
    lines: Mapping[str, Sequence[Mapping[str, Any]]], name: Callable[[Any], str]
) -> list[str]:
    """Per arm, what every other value of a setting changes against the first."""
    return [
        f"{arm}, {name(point['value'])} against {name(points[0]['value'])}: success "
        f"{difference_text(point['change']['success'], METRICS['success'])} "
        f"(n = {point['change']['success']['n']} pairs), "
        f"{verdict_words(_verdict(point))}; {_otherwise(point['change'])}."
        for arm, points in lines.items()
        for point in points[1:]
    ]


def _pooled_errors(breakdown: Mapping[str, Any]) -> Mapping[str, Any]:
    """The arms of all scenarios together, or of the only one; none without forecasts."""
    if not breakdown:
        return {}
    scenario = ALL_SCENARIOS if ALL_SCENARIOS in breakdown else next(iter(breakdown))
    arms: Mapping[str, Any] = breakdown[scenario]
    return arms
