"""Page, pictures and summary of a sweep: what is on them, and that they need nothing from anywhere."""

from __future__ import annotations

import re
from dataclasses import replace
from html import escape
from html.parser import HTMLParser

import numpy as np
import pytest

from simcore.errors import OutputError
from simcore.show.palette import COLORS
from simcore.show.scene import Scene
from simcore.sweep.results_page import save_results, summary_text
from simcore.sweep.sweep_charts import ChartPoint, distribution_chart, heat_map, landings_of, response_chart

from . import made_sweep

SCENE = Scene(field_size=(16.0, 8.0))


class Tags(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.open, self.links, self.titles = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        if tag not in ("meta",):
            self.open.append(tag)
        self.links += [value for name, value in attributes if name in ("src", "href", "action", "data")]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open[-1:] == ["strong"]:
            self.titles.append(data)


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    results = made_sweep.tired_battery()
    rows = [dict(row) for row in results.rows]
    rows[5]["error"] = "TimeoutError: <b>took more than 60 s</b>"
    results = replace(results, rows=rows)
    folder = tmp_path_factory.mktemp("sweep")
    return results, save_results(results, folder, "score >= 25", scene=SCENE), folder


def test_the_page_loads_nothing_and_forbids_itself_to(saved):
    text = saved[1]["page.html"].read_text(encoding="utf-8")
    page = Tags(text)
    assert page.open == [] and page.links == []
    assert re.findall(r"https?://[^\s\"']+", text) == ["http://www.w3.org/2000/svg"] * text.count("<svg ")  # a name
    assert "default-src 'none'" in text and "@import" not in text and "url(" not in text
    assert "<b>took" not in text and "&lt;b&gt;took" in text
    assert set(re.findall(r"var\(--([a-z-]+)\)", text)) <= set(COLORS)  # every color has a light and a dark value


def test_page_and_pictures_show_what_was_varied_and_measured(saved):
    _, files, folder = saved
    titles = Tags(files["page.html"].read_text(encoding="utf-8")).titles
    assert titles == [
        "score >= 25 over battery.charge", "score >= 25 over robot.mass", "score over battery.charge",
        "score over robot.mass",
        "score of all runs", "lowest battery voltage of all runs",  # hits are the score here, and not drawn again
        "Where hits came down", "Where misses came down",
    ]  # fmt: skip
    assert {path.name for path in folder.glob("pictures/*.png")} == {name for name in files if name.endswith(".png")}
    assert len([name for name in files if name.endswith(".png")]) == len(titles)
    text = files["page.html"].read_text(encoding="utf-8")
    assert "<span>battery.charge = 0.65 against 0.3: +3 (95 % interval" in text  # over its chart
    assert "<summary>Mean score &gt;= 25</summary>" in text and "<th scope=col>robot.mass = 45</th>" in text
    assert escape(summary_text(saved[0], "score >= 25")) in text, "the figures of the terminal"
    assert files["score_over_robot.mass.png"].read_bytes().startswith(b"\x89PNG")


def test_the_summary_says_differences_shares_and_percentiles(saved):
    said = summary_text(saved[0], "score >= 25").splitlines()
    assert said[0] == "120 runs at 6 points of battery.charge, robot.mass, 20 seeds; 1 ended with an error"
    assert said[2] == "score with the same seeds:"
    assert said[3].startswith("  battery.charge = 0.65 against 0.3: +3 (95 % interval +3 to +3), 20 seeds: 20 more")
    assert any(
        re.match(r"score >= 25: \d+ of 120 = \d+ % \(95 % interval \d+ to \d+ % by 20 seeds\)$", row) for row in said
    )
    assert any(row.startswith("  battery.charge = 0.65: ") and " of 40 = " in row for row in said)
    assert any(row.split() == ["metric", "5", "%", "25", "%", "median", "75", "%", "95", "%"] for row in said)
    assert said[-1] == "  TimeoutError: <b>took more than 60 s</b> (1 run)"


def test_a_sweep_in_which_nothing_worked_has_a_page_that_says_so(tmp_path):
    results = made_sweep.tired_battery()
    names = ("run", "point", "seed", "battery.charge", "robot.mass", "cpu_seconds")
    rows = [{**{name: row[name] for name in names}, "error": "ConfigError: no auto"} for row in results.rows]
    results = replace(results, rows=rows)
    files = save_results(results, tmp_path, "score >= 25", scene=SCENE)
    assert "0 of 120" in files["page.html"].read_text(encoding="utf-8")
    assert "no auto (120 runs)" in summary_text(results)


def test_a_page_that_cannot_be_written_is_said(tmp_path):
    (tmp_path / "page.html").mkdir()
    with pytest.raises(OutputError, match="cannot write the page"):
        save_results(made_sweep.tired_battery(), tmp_path, scene=SCENE)


def bars(drawing):
    return [tuple(map(float, row)) for row in re.findall(r'<rect x="([\d.]+)" y="[\d.]+" width="([\d.]+)"', drawing)]


def test_whole_numbers_have_a_bar_each_and_all_runs_are_in_bars():
    drawing = distribution_chart(np.array([3.0, 4.0, 4.0, 7.0, np.nan]), "hits")
    counts = [int(count) for count in re.findall(r": (\d+) runs", drawing)]
    assert counts == [1, 2, 1] and len({width for _, width in bars(drawing)}) == 1
    assert "no run has it" in distribution_chart(np.array([np.nan]), "hits")
    assert ": 9 runs" in distribution_chart(np.full(9, 12.25), "volts")


def test_words_stand_side_by_side_and_a_value_that_is_missing_leaves_a_gap():
    points = [ChartPoint(at=name, middle=value, low=value, high=value) for name, value in
              (("depot", 3.0), ("left", np.nan), ("right", 5.0))]  # fmt: skip
    drawing = response_chart(points, "auto", "score")
    assert [drawing.count(f">{name}<") for name in ("depot", "left", "right")] == [1, 1, 1]
    assert drawing.count("<circle") == 2 and "polyline" not in drawing


def test_landings_are_counted_where_they_came_down():
    texts = ["[[1.1, 7.9, 0.1, 0], [1.2, 7.8, 0.1, 0], [9.0, 2.0, 1.8, 1]]", None, "[[-3.0, 2.0, 0.0, 0]]"]
    found = landings_of(texts)
    assert found["hits"].tolist() == [[9.0, 2.0]] and len(found["misses"]) == 3
    drawing = heat_map(SCENE, found["misses"], "miss")
    assert "2 at x 1.125 m, y 7.875 m" in drawing and "1 at x 0.125 m, y 2.125 m" in drawing
    assert '<rect x="100" y="0" width="25" height="25"' in re.sub(r"<title>.*?</title>", "", drawing)
    assert all(len(rows) == 0 for rows in landings_of([]).values())
