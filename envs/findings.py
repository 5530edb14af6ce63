"""What an evaluation found, one sentence each, inconclusive ones included."""

from collections.abc import Mapping
from typing import Any

from envs.metric_table import HEADLINE, METRICS, Metric, aggregate_name
from envs.summary import ALL_SCENARIOS


def findings(summary: Mapping[str, Any]) -> list[str]:
    """Sentences with numbers, intervals and counts from the summary of an evaluation.

    Per arm: its success against the reference, then which other differences are conclusive; then
    the arms with forecasts against one another, how far off their forecasts were, and whether that
    tells how they drive.
    """
    scenarios = summary["scenarios"]
    pooled = ALL_SCENARIOS in scenarios
    group = scenarios[ALL_SCENARIOS] if pooled else next(iter(scenarios.values()))
    reference = summary["reference"]
    sentences = [_reference_sentence(reference, group)]
    for arm, differences in group["differences"].items():
        sentences.append(_success_sentence(arm, reference, group, differences))
        sentences.append(f"{arm} against {reference} otherwise: {_compared(differences)}.")
    for arm, earlier in group["between"].items():
        for other, differences in earlier.items():
            if differences["forecast_fde"]["mean"] is not None:
                success = difference_text(differences["success"], METRICS["success"])
                sentences.append(
                    f"{arm} against {other}: success {success}, "
                    f"{_verdict_words(differences['success']['verdict'])}; "
                    f"{_compared(differences)}."
                )
                if pooled:
                    sentences.append(_by_scenario(arm, other, scenarios))
    sentences += _forecast_sentences(group)
    sentences += _distance_sentences(summary.get("forecast_errors", {}))
    sentences += _robot_sentences(summary.get("forecast_errors", {}))
    return sentences + _dose_sentences(summary.get("dose_response", {}))


def _reference_sentence(reference: str, group: Mapping[str, Any]) -> str:
    metrics = group["arms"][reference]["metrics"]
    return (
        f"The reference {reference} (n = {metrics['success']['n']} episodes) reached its goal in "
        f"{share(metrics['success'])} and ended in contact with a pedestrian in "
        f"{share(metrics['collision_pedestrian'])}; brackets hold 95 % intervals."
    )


def _success_sentence(
    arm: str, reference: str, group: Mapping[str, Any], differences: Mapping[str, Any]
) -> str:
    success, difference = group["arms"][arm]["metrics"]["success"], differences["success"]
    return (
        f"{arm} reached its goal in {share(success)}: "
        f"{difference_text(difference, METRICS['success'])} against {reference} "
        f"(n = {difference['n']} pairs), {_verdict_words(difference['verdict'])}."
    )


def _compared(differences: Mapping[str, Any]) -> str:
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
        conclusive.append(f"inconclusive in {_listed(unclear)}")
    return "; ".join(conclusive)


def _by_scenario(arm: str, other: str, scenarios: Mapping[str, Any]) -> str:
    """Whose forecasts are better where: a pooled error hides that scenarios may disagree."""
    parts = []
    for name, group in scenarios.items():
        difference = group["between"][arm][other]["forecast_fde"]
        if name != ALL_SCENARIOS and difference["mean"] is not None:
            text = difference_text(difference, METRICS["forecast_fde"])
            parts.append(f"{name} {text} ({difference['verdict']})")
    return f"{arm} against {other} by scenario, forecast FDE: {'; '.join(parts)}."


def _forecast_sentences(group: Mapping[str, Any]) -> list[str]:
    errors = {
        arm: entry["metrics"]["forecast_fde"]
        for arm, entry in group["arms"].items()
        if entry["metrics"]["forecast_fde"]["mean"] is not None
    }
    if not errors:
        return []
    listed = _listed(
        [f"{arm} {number(error, METRICS['forecast_fde'])}" for arm, error in errors.items()]
    )
    return [f"Closed-loop error at the end of the forecast horizon (FDE): {listed}."]


def _distance_sentences(breakdown: Mapping[str, Any]) -> list[str]:
    """Per arm, how far off forecasts are by distance, and whether their radii hold."""
    metric = METRICS["forecast_fde"]
    sentences = []
    for arm, entry in _pooled(breakdown).items():
        parts = [
            f"{name.rstrip('-')} m{' and more' if name.endswith('-') else ''} "
            f"{number(numbers['fde'], metric)}"
            for name, numbers in entry["by_distance"].items()
        ]
        last = entry["by_step"][-1]
        sentences.append(
            f"{arm}, FDE by the distance to the robot when forecast: {_listed(parts)}; "
            f"{share(last['coverage'])} of the positions {last['seconds']:g} s ahead "
            "lay within the forecast's radius."
        )
    return sentences


def _robot_sentences(breakdown: Mapping[str, Any]) -> list[str]:
    """Per arm, how much of its forecast error the robot caused; nothing without twins."""
    metric = METRICS["forecast_fde"]
    sentences = []
    for arm, entry in _pooled(breakdown).items():
        for last in entry["robot_part"][-1:]:
            sentences.append(
                f"{arm}, {last['seconds']:g} s ahead: of an error of "
                f"{number(last['error'], metric)} the forecast would have made "
                f"{number(last['model_error'], metric)} without a robot; the robot moved people by "
                f"{number(last['displacement'], metric)} and changed the error by "
                f"{difference_text(last['caused'], metric)} (n = {last['error']['n']} forecasts)."
            )
    return sentences


def _pooled(breakdown: Mapping[str, Any]) -> Mapping[str, Any]:
    """The arms of all scenarios together, or of the only one; none without forecasts."""
    if not breakdown:
        return {}
    scenario = ALL_SCENARIOS if ALL_SCENARIOS in breakdown else next(iter(breakdown))
    arms: Mapping[str, Any] = breakdown[scenario]
    return arms


def _dose_sentences(correlations: Mapping[str, Any]) -> list[str]:
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
        f"{_listed(parts)}; mean over {count} policies × scenarios."
    ]


def share(entry: Mapping[str, Any]) -> str:
    """A proportion with its interval in percent."""
    if entry["low"] is None:
        return f"{100 * entry['mean']:.0f} %{_interval_text(entry, 100.0, '.0f')}"
    return f"{100 * entry['mean']:.0f} % [{100 * entry['low']:.0f}, {100 * entry['high']:.0f}]"


def number(entry: Mapping[str, Any], metric: Metric) -> str:
    """A mean with its unit and interval."""
    style = f"z.{_decimals(entry)}f"
    return f"{entry['mean']:{style}}{_unit(metric)}{_interval_text(entry, 1.0, style)}"


def difference_text(entry: Mapping[str, Any], metric: Metric) -> str:
    """A signed difference with its interval; proportions in percentage points."""
    if metric.kind == "share":
        return f"{100 * entry['mean']:+z.1f} points{_interval_text(entry, 100.0, '+z.1f')}"
    style = f"+z.{_decimals(entry)}f"
    return f"{entry['mean']:{style}}{_unit(metric)}{_interval_text(entry, 1.0, style)}"


def _decimals(entry: Mapping[str, Any]) -> int:
    """Enough to tell the number and its interval from zero."""
    ends = [entry[key] for key in ("mean", "low", "high") if entry[key] is not None]
    return 3 if any(0 < abs(end) < 0.05 for end in ends) else 2


def _unit(metric: Metric) -> str:
    return f" {metric.unit}" if metric.unit else ""


def _interval_text(entry: Mapping[str, Any], factor: float, style: str) -> str:
    """Bracketed interval, or why there is none."""
    if entry["low"] is None:
        return " (too few episodes for an interval)"
    return f" [{factor * entry['low']:{style}}, {factor * entry['high']:{style}}]"


def _verdict_words(verdict: str) -> str:
    return "inconclusive" if verdict == "inconclusive" else f"which is {verdict}"


def _listed(items: list[str]) -> str:
    """The items with commas and a last `and`."""
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} and {items[-1]}"
