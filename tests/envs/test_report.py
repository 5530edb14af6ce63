import base64
import dataclasses
import json
import re
import zlib
from html import escape
from itertools import chain
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hand_made_traces import DT, make_trace, walk

from crowdsim.map import Map
from crowdsim.recordings import Picture
from envs.evaluation.comparison import Arm, EvaluationConfig, ScenarioChoice
from envs.evaluation.curves import setting_curves
from envs.evaluation.dose_response import rank_correlation
from envs.evaluation.episode_rows import Row
from envs.evaluation.evaluate import Evaluation
from envs.evaluation.findings import HELP, HOW_TO_ASK, IN_THE_LOOP, ROBOT_PART, findings
from envs.evaluation.forecast_breakdown import forecast_breakdown
from envs.evaluation.forecast_cells import forecast_cells
from envs.evaluation.metrics import navigation_metrics
from envs.evaluation.replays import RecordedEpisode
from envs.evaluation.summary import as_json, summarize
from envs.report import build_report, write_picture, write_video
from envs.report.document import embedded_json
from envs.report.records import pack, pack_episode, view_bounds, view_image
from envs.report.replay import busiest_row, history
from envs.trace import Trace

CHROMIUM = Path("/usr/bin/chromium")


def crossing(speed: float, reason: str = "goal", *, forecast: bool = False) -> Trace:
    """A robot that crosses the way of one person while another stands by."""
    steps = 30
    robot = walk((-3.0, 0.0), (speed, 0.0), steps)
    person = walk((0.0, -3.0), (0.0, 1.2), steps)
    changes: dict[str, Any] = {"termination_reason": reason}
    if forecast:
        ahead = 0.4 * np.arange(1, 4)[:, None] * np.array([0.0, 1.2])
        changes["forecast"] = np.stack([person[:, None] + ahead, np.zeros((31, 3, 2))], axis=1)
        changes["forecast_ids"] = np.tile([0, -1], (31, 1))
    return make_trace(robot, [person, walk((2.0, 2.0), (0.0, 0.0), steps)], **changes)


def about_episode(scenario: str, arm: Arm, seed: int) -> Row:
    """The columns that tell an episode from others."""
    return {
        "scenario": scenario,
        "place": scenario,
        "model": "",
        "robot_visible": True,
        "arm": arm.name,
        "policy": arm.policy,
        "forecaster": arm.forecaster,
        "horizon": 1.2,
        "seed": seed,
    }


def varied(rows: list[Row]) -> dict[str, Any]:
    """The parts of a summary on what was varied."""
    outcomes = ("success", "collision_pedestrian", "time_to_goal_penalized")
    rng = np.random.default_rng(0)
    return {
        "dose_response": {key: as_json(rank_correlation(rows, key, rng)) for key in outcomes},
        "settings": setting_curves(rows),
    }


def answers(summary: dict[str, Any]) -> list[str]:
    """All sentences of the findings."""
    return list(chain(*summary["findings"].values()))


@pytest.fixture(scope="module")
def evaluation() -> Evaluation:
    """Two arms in two scenarios, four hand-made episodes each."""
    config = EvaluationConfig(
        arms=(Arm(policy="straight"), Arm(policy="mppi", forecaster="constant_velocity")),
        scenarios=(ScenarioChoice(scenario="crossing"), ScenarioChoice(scenario="<replay> & co")),
        seeds=(0, 1, 2, 3),
    )
    rows, recorded = [], []
    cells: list[Row] = []
    for choice in config.scenarios:
        for arm in config.arms:
            for seed in config.seeds:
                failed = arm.policy == "straight" and seed > 0
                trace = crossing(
                    0.8 + 0.1 * seed,
                    "collision_pedestrian" if failed else "goal",
                    forecast=arm.policy == "mppi",
                )
                about = about_episode(choice.name, arm, seed)
                rows.append({**about, **navigation_metrics(trace)})
                cells += forecast_cells(trace, about)
                if seed == 1:
                    recorded.append(
                        RecordedEpisode(scenario=choice.name, arm=arm.name, seed=seed, trace=trace)
                    )
    summary = {
        "run": {"command": "crowdnav evaluate --seeds 4", "episodes": len(rows)},
        "config": {"note": "</script><b>"},
        **summarize(rows, reference="straight/none"),
        "forecast_errors": forecast_breakdown(cells),
        **varied(rows),
    }
    summary["findings"] = findings(summary)
    return Evaluation(config=config, rows=rows, cells=cells, summary=summary, recorded=recorded)


@pytest.fixture(scope="module")
def page(evaluation: Evaluation, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build_report(evaluation, tmp_path_factory.mktemp("report") / "report.html")


def unpack(packed: dict[str, Any]) -> np.ndarray:
    raw = np.frombuffer(zlib.decompress(base64.b64decode(packed["data"])), "<i2")
    return np.cumsum(raw.reshape(packed["rows"], -1), axis=0, dtype=np.int16)


def test_packed_positions_come_back_to_the_centimetre() -> None:
    trace = crossing(1.0)
    packed = pack_episode(RecordedEpisode(scenario="s", arm="a", seed=0, trace=trace))
    people = unpack(packed["people"]).reshape(trace.position.shape) / 100
    np.testing.assert_allclose(people, trace.position, atol=0.0051)
    assert unpack(packed["ids"]).tolist() == trace.ids.tolist()


def test_large_jumps_survive_packing() -> None:
    values = np.array([[-30000], [30000], [-30000]])
    np.testing.assert_array_equal(unpack(pack(values)), values)


def test_absent_people_have_no_id() -> None:
    trace = crossing(1.0)
    valid = trace.valid.copy()
    valid[5:, 1] = False
    changed = make_trace(trace.robot_position, list(trace.position.swapaxes(0, 1)), valid=valid)
    packed = pack_episode(RecordedEpisode(scenario="s", arm="a", seed=0, trace=changed))
    np.testing.assert_array_equal(unpack(packed["ids"])[:, 1] >= 0, valid[:, 1])


def test_a_photograph_is_shown_from_straight_above() -> None:
    # 10 px per metre, image rows downwards; the red mark is at world (2, 1).
    image = np.full((100, 100, 3), 255, np.uint8)
    image[85:95, 15:25] = (255, 0, 0)
    matrix = np.array([[10.0, 0.0, 0.0], [0.0, -10.0, 100.0], [0.0, 0.0, 1.0]])
    map_ = Map(bounds=(0.0, 0.0, 10.0, 10.0), picture=Picture(image, matrix))
    view = view_image(map_, (1.0, 0.0, 5.0, 4.0))
    scale = view.shape[1] / 4.0
    row, column = round((4.0 - 1.0) * scale), round((2.0 - 1.0) * scale)
    assert np.ptp(view[row, column]) > 150
    assert view[row - round(scale), column].tolist() == [255, 255, 255]


def test_the_view_follows_the_robot_but_stays_on_the_map() -> None:
    near, far = crossing(1.0), make_trace(walk((15.0, 0.0), (1.0, 0.0), 10), [])
    bounds = view_bounds(near.scenario.map, [near, far])
    assert bounds == pytest.approx((-9.0, -6.0, 20.0, 6.0))


def test_the_page_asks_nobody_for_anything(page: Path) -> None:
    text = page.read_text()
    assert not re.findall(r"""(?:src|href)\s*=\s*["'](?!data:|#)[^"']+""", text)
    assert "@import" not in text
    assert "url(http" not in text


def test_names_and_configuration_cannot_break_the_page(page: Path) -> None:
    text = page.read_text()
    assert "&lt;replay&gt; &amp; co" in text
    assert "<replay>" not in text
    assert "</script><b>" not in text
    assert json.loads(embedded_json({"a": "</script>"})) == {"a": "</script>"}
    assert "</script>" not in embedded_json({"a": "</script>"})


def test_the_section_on_forecasts_names_bins_and_coverage(
    page: Path, evaluation: Evaluation
) -> None:
    text = page.read_text()
    section = text[text.index('id="forecasts"') : text.index('id="tables"')]
    assert "Forecasts by time ahead: error and coverage" in section
    assert "8 and more" in section  # frames of history that hand-made forecasts are made from
    assert "What the robot itself caused" not in section  # no twins were asked for
    assert "straight/none, ADE" not in section  # has no forecasts
    said = [line for line in answers(evaluation.summary) if "FDE by the distance" in line]
    assert len(said) == 1
    assert said[0].startswith("mppi/constant_velocity")


def test_without_forecasts_there_is_no_section(evaluation: Evaluation, tmp_path: Path) -> None:
    summary = {**evaluation.summary, "forecast_errors": {}}
    bare = dataclasses.replace(evaluation, summary=summary, recorded=[])
    assert 'id="forecasts"' not in build_report(bare, tmp_path / "report.html").read_text()


def test_the_tables_count_every_arm_and_say_what_they_show(
    page: Path, evaluation: Evaluation
) -> None:
    text = page.read_text()
    for sentence in answers(evaluation.summary):
        assert sentence.split(":")[0] in text
    assert text.count("time_to_goal_on_success") == 1
    assert text.count('<span class="note">reference</span>') == 3


def test_every_question_is_answered_or_says_how_to_ask_it(
    page: Path, evaluation: Evaluation
) -> None:
    found = evaluation.summary["findings"]
    assert list(found) == list(HOW_TO_ASK)
    text = page.read_text()
    places = [text.index(f"{number}. {escape(name)}") for number, name in enumerate(found, 1)]
    assert places == sorted(places)
    not_asked = {name for name, said in found.items() if said[-1].startswith("Not asked")}
    assert not_asked == set(HOW_TO_ASK) - {IN_THE_LOOP}
    assert found[ROBOT_PART] == ["Not asked here; to ask: --twins."]


def test_findings_call_a_small_difference_inconclusive(evaluation: Evaluation) -> None:
    sentences = answers(evaluation.summary)
    assert any("reached its goal in 25 % [" in text for text in sentences)
    assert any("+75.0 points" in text and "which is better" in text for text in sentences)


def test_arms_with_forecasts_are_compared_with_one_another() -> None:
    rows = [
        {
            **navigation_metrics(crossing(0.8 + 0.1 * seed, forecast=arm != "none")),
            **about_episode("s", Arm(policy="mppi", forecaster=arm, title=arm), seed),
            "forecast_fde": error,
        }
        for arm, error in (("none", np.nan), ("near", 0.5), ("far", 1.0))
        for seed in range(5)
    ]
    rows += [{**row, "scenario": "t", "forecast_fde": 1.5 - row["forecast_fde"]} for row in rows]
    summary = {**summarize(rows, reference="none"), "forecast_errors": {}, **varied(rows)}
    sentences = findings(summary)[HELP]
    pair = next(text for text in sentences if text.startswith("far against near"))
    assert "inconclusive in" in pair
    assert "success +0.0 points" in pair
    by_scenario = next(text for text in sentences if "by scenario" in text)
    assert "s +0.50 m [+0.50, +0.50] (worse)" in by_scenario
    assert "t -0.50 m [-0.50, -0.50] (better)" in by_scenario


def test_a_history_ends_where_the_person_was_somebody_else() -> None:
    trace = crossing(1.0)
    ids = trace.ids.copy()
    ids[20:, 0] = 9
    people = list(trace.position.swapaxes(0, 1))
    changed = make_trace(trace.robot_position, people, ids=ids)
    assert len(history(changed, 19, 0)) == 15
    assert len(history(changed, 22, 0)) == 3


def test_the_busiest_row_is_the_closest_encounter() -> None:
    trace = crossing(1.2)
    row = busiest_row(trace)
    assert abs(row * DT - 2.5) < 1.0


def test_picture_and_video_of_an_episode(tmp_path: Path) -> None:
    trace = crossing(1.0, forecast=True)
    write_picture(trace, tmp_path / "episode.png", title="test")
    assert cv2.imread(str(tmp_path / "episode.png")) is not None
    short = make_trace(trace.robot_position[:4], list(trace.position[:4].swapaxes(0, 1)))
    write_video(short, tmp_path / "episode.webm")
    video = cv2.VideoCapture(str(tmp_path / "episode.webm"))
    assert video.get(cv2.CAP_PROP_FPS) == pytest.approx(5.0)
    count = 0
    while video.read()[0]:
        count += 1
    assert count == 4 + 5


def test_the_player_plays_in_a_browser(page: Path) -> None:
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if not CHROMIUM.exists():
        pytest.skip(f"no browser at {CHROMIUM}")
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=str(CHROMIUM), args=["--no-sandbox", "--use-angle=swiftshader"]
        )
        tab = browser.new_page()
        complaints: list[str] = []
        requests: list[str] = []
        tab.on("console", lambda message: complaints.append(message.text))
        tab.on("pageerror", lambda error: complaints.append(str(error)))
        tab.on("request", lambda request: requests.append(request.url))
        tab.goto(page.as_uri())
        tab.wait_for_selector('#player[data-ready="true"]')
        scrub = tab.locator('[data-player="scrub"]')

        tab.get_by_role("button", name="Play").click()
        tab.wait_for_function('Number(document.querySelector("[data-player=scrub]").value) > 2')
        tab.get_by_role("button", name="Pause").click()
        before = tab.locator("canvas").first.screenshot()

        scrub.fill("30")
        assert "6.0 s of 6.0 s" in tab.locator('[data-player="time"]').inner_text()
        assert tab.locator("canvas").first.screenshot() != before
        captions = tab.locator("figcaption").all_inner_texts()
        assert captions[0] == "mppi/constant_velocity: goal reached at 6.0 s"
        assert captions[1] == "straight/none: contact with a pedestrian at 6.0 s"

        tab.locator("#player").focus()
        tab.keyboard.press("ArrowLeft")
        assert float(scrub.input_value()) == 29.0
        tab.locator('[data-player="group"]').select_option("1")
        tab.wait_for_function('document.querySelector("[data-player=scrub]").value === "0"')
        assert complaints == []
        assert all(url.startswith(("file:", "data:", "blob:")) for url in requests)
        browser.close()
