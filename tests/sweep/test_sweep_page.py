"""Contents of the page and the summary of a sweep; how blocks look is tested for `simcore.show.report`."""

import re
from dataclasses import replace

import numpy as np
import pytest

from simcore.sweep.sweep_page import _bin_edges, comparison_page, summary_text, sweep_page

from . import made_sweep

CONDITION = "score >= 25"


@pytest.fixture(scope="module")
def results():
    """Return 120 runs, including a failed run."""
    results = made_sweep.tired_battery()
    rows = [dict(row) for row in results.rows]
    rows[5]["error"] = "TimeoutError: <b>took more than 60 s</b>"
    return replace(results, rows=rows)


def test_the_page_shows_the_success_rate_before_factors_and_metrics(results, tmp_path):
    page = sweep_page(results, CONDITION, tmp_path / "two words")
    head, bar, *blocks = made_sweep.blocks_of(page)
    share = results.success(CONDITION)
    assert head["text"] == f"{share.k} of 120, {share.interval}" and head["detail"].startswith("score >= 25; 95 %")
    assert (bar["kind"], bar["value"], bar["low"], bar["high"]) == ("share", share.value, share.lower, share.upper)
    assert [block.get("title") or block.get("caption").partition(";")[0] for block in blocks] == [
        "score >= 25 over battery.charge", "points over battery.charge", "score >= 25 over robot.mass",
        "points over robot.mass", "points of all runs",
        "lowest battery voltage [V] of all runs",  # hits are the score here, and not drawn again
        "Metrics of all runs", "Runs with the lowest points", "Runs that ended with an error",
    ]  # fmt: skip
    (over,) = (block["series"] for block in blocks if block.get("title") == "points over battery.charge")
    scores = [row["score"] for row in results.finished if row["battery.charge"] == 0.65]
    assert over[0]["x"] == [0.3, 0.65, 1.0] and over[0]["y"][1] == np.median(scores)
    assert (over[0]["low"][1], over[0]["high"][1]) == tuple(np.percentile(scores, (5, 95)))
    (bars,) = (block["series"] for block in blocks if block.get("title") == "points of all runs")
    assert sum(bars[0]["y"]) == 119
    assert f"--out '{tmp_path / 'two words'}' --repeat RUN" in blocks[-1]["caption"]
    assert "<b>took" not in page and blocks[-1]["rows"] == [
        [5, 5, 0.3, 45.0, "TimeoutError: <b>took more than 60 s</b>"]
    ]


def test_two_variants_are_drawn_in_the_same_charts(results, tmp_path):
    rows = [{**row, "auto": "old" if row["battery.charge"] == 0.3 else "new"} for row in results.rows]
    both = replace(results, rows=[row for row in rows if row["battery.charge"] != 0.65],
                   experiment=made_sweep.described("auto", "robot.mass"))  # fmt: skip
    difference = both.paired("auto", "old", "new", "score")
    head, *blocks = made_sweep.blocks_of(comparison_page(both, "score", difference, tmp_path))
    table = next(block for block in blocks if block["kind"] == "table")
    assert head["text"] == f"A clear difference: score {difference.mean:+.3g}" and str(difference) in head["detail"]
    assert [row[0] for row in table["rows"]] == ["old", "new"] and [row[-1] for row in table["rows"]] == [39, 40]
    charts = [block for block in blocks if block["kind"] == "chart"]
    assert len(charts) >= 2
    for one in charts:
        assert [curve["name"] for curve in one["series"]] == ["old", "new"]


def test_the_summary_contains_differences_success_rates_and_percentiles(results):
    said = summary_text(results, CONDITION).splitlines()
    assert said[0] == "120 runs at 6 points of battery.charge, robot.mass, 20 seeds; 1 ended with an error"
    assert re.match(r"score >= 25: \d+ of 120 = \d+ % \(95 % interval \d+ to \d+ %\)$", said[2])
    assert any(row.startswith("  battery.charge = 0.65: ") and " of 40 = " in row for row in said)
    at = said.index("score with the same seeds:")
    assert said[at + 1].startswith("  battery.charge = 0.65 against 0.3: +3 (95 % interval +")
    assert any(row.split() == ["metric", "5", "%", "25", "%", "median", "75", "%", "95", "%"] for row in said)
    assert said[-1] == "  TimeoutError: <b>took more than 60 s</b> (1 run)"


def test_the_page_of_a_sweep_without_successes_shows_a_success_rate_of_zero(tmp_path):
    results = made_sweep.tired_battery()
    names = ("run", "point", "seed", "battery.charge", "robot.mass", "cpu_seconds")
    rows = [{**{name: row[name] for name in names}, "error": "ConfigError: no auto"} for row in results.rows]
    results = replace(results, rows=rows)
    head, *_ = made_sweep.blocks_of(sweep_page(results, CONDITION, tmp_path))
    assert head["text"] == "0 of 120, 0 to 3 %" and "no auto (120 runs)" in summary_text(results)
    head, *_ = made_sweep.blocks_of(sweep_page(results, "", tmp_path))
    assert head["text"].startswith("120 runs at 6 points")


def test_word_values_are_drawn_side_by_side_and_many_numbers_as_one_point_per_run(tmp_path):
    points = {"robot.mass": np.linspace(40.0, 60.0, 40)}
    rows = made_sweep.runs_of(points, lambda values, seed: {"score": values["robot.mass"] // 1})
    many = made_sweep.Results(rows, made_sweep.described("robot.mass"))
    over = made_sweep.blocks_of(sweep_page(many, "", tmp_path))[1]
    assert over["series"][0]["x"] == pytest.approx(points["robot.mass"])
    assert over["series"][0]["y"] == [row["score"] for row in rows]
    words = [{**row, "auto": "left" if row["run"] % 2 else "right"} for row in rows]
    named = made_sweep.Results(words, made_sweep.described("auto"))
    over = made_sweep.blocks_of(sweep_page(named, "", tmp_path))[1]
    assert over["xNames"] == ["right", "left"] and over["series"][0]["x"] == [0, 1]


def test_each_whole_number_has_a_bar_and_the_bars_contain_all_runs():
    assert _bin_edges(np.array([3.0, 4.0, 4.0, 7.0])).tolist() == [2.5, 3.5, 4.5, 5.5, 6.5, 7.5]
    for values in (np.full(9, 12.25), np.linspace(0.0, 1.3, 50), np.arange(1000.0), np.array([])):
        assert np.histogram(values, _bin_edges(values))[0].sum() == len(values)
