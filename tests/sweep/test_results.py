"""Statistics of a table of runs: success rates, percentiles and paired differences."""

import csv
from dataclasses import replace

import numpy as np
import pytest
from each_case import each
from hypothesis import given
from hypothesis import strategies as st

from simcore.errors import ConfigError, OutputError, UnknownNameError
from simcore.sweep.results import Condition, Results
from simcore.sweep.sweep_page import summary_text

from . import made_sweep


@pytest.fixture(scope="module")
def tired_battery():
    return made_sweep.tired_battery()


def test_the_success_rate_is_the_fraction_of_runs_that_meet_the_condition(tired_battery):
    share = tired_battery.success("score >= 25")
    held = [row["score"] >= 25 for row in tired_battery.rows]
    assert (share.k, share.n) == (sum(held), 120) and share.lower < share.value < share.upper
    by = tired_battery.success_by("battery.charge", "score >= 25")
    assert list(by) == [0.3, 0.65, 1.0] and sum(s.k for s in by.values()) == share.k
    assert by[0.3].value < by[1.0].value
    both = tired_battery.success("score >= 25 and battery.charge < 0.5 and hits <= shots")
    assert both.k == by[0.3].k


def test_a_run_with_an_error_is_not_a_success_and_is_excluded_from_percentiles(tired_battery):
    rows = [dict(row) for row in tired_battery.rows]
    rows[0] |= {"score": None, "error": "EngineError: no contact"}
    rows[1]["error"] = "TimeoutError"  # whatever its score is
    hurt = replace(tired_battery, rows=rows)
    assert hurt.success("score < 1000").k == 118
    assert hurt.success("score < 1000").n == 120 and len(hurt.failures) == 2
    assert hurt.percentiles("score")[2] == np.median([row["score"] for row in rows[2:]])


def test_pairing_removes_the_variation_between_seeds(tired_battery):
    """From a charge of 0.3 to 1.0, the score rises by 5 or 6 for each seed and mass, although luck is from -4 to 4."""
    found = tired_battery.paired("battery.charge", 0.3, 1.0, "score")
    assert found.n == 20 and found.less == 0 and 5.0 <= found.lower <= found.upper <= 6.0
    back = tired_battery.paired("battery.charge", 1.0, 0.3, "score")
    assert back.mean == -found.mean and back.more == found.less
    assert tired_battery.paired("battery.charge", 0.3, 1.0, "score >= 25").mean > 0.0


def test_an_incomplete_pair_is_left_out(tired_battery):
    """For one seed, only the pair with 45 kg is left out; for another, both pairs are."""
    rows = [{**row, "error": "crashed" if row["seed"] == 3 or row["run"] == 0 else ""} for row in tired_battery.rows]
    assert replace(tired_battery, rows=rows).paired("battery.charge", 0.3, 1.0, "score").n == 19


def test_all_pairs_of_a_seed_count_as_one_mean_difference():
    """From x = 0 to 1 the score rises by 1 at y = 0 and by 3 at y = 1: by 2 in each seed."""
    points = {"x": np.array([0.0, 1.0, 0.0, 1.0]), "y": np.array([0.0, 0.0, 1.0, 1.0])}
    rows = made_sweep.runs_of(points, lambda v, seed: {"score": seed + v["x"] * (1.0 + 2.0 * v["y"])}, seeds=3)
    found = Results(rows, made_sweep.described("x", "y")).paired("x", 0.0, 1.0, "score")
    assert (found.n, found.mean, found.lower, found.upper) == (3, 2.0, 2.0, 2.0)


def test_a_run_without_the_metric_is_excluded_from_pairs(tired_battery):
    rows = [{**row, "hits": None if row["seed"] == 3 or row["run"] == 0 else row["hits"]} for row in tired_battery.rows]
    hurt = replace(tired_battery, rows=rows)
    assert hurt.paired("battery.charge", 0.3, 1.0, "hits").n == 19
    assert hurt.success("hits >= 0").k == 120 - 7 and hurt.success("hits <= shots").k == 120 - 7


def test_a_clear_difference_is_listed_first_despite_large_variation_between_seeds():
    """One factor adds a point in each of ten pairs; another moves more, but up in some seeds and down in others."""
    grid = np.array([(x, y) for x in (0.0, 1.0) for y in (0.0, 1.0)])

    def play(values, seed):
        luck = np.random.default_rng(seed).normal(0.0, 30.0, 2)
        return {"score": luck[0] + values["sure"] + 0.2 * luck[1] * values["unsure"]}

    rows = made_sweep.runs_of({"unsure": grid[:, 0], "sure": grid[:, 1]}, play, seeds=10)
    results = Results(rows, made_sweep.described("unsure", "sure"))
    (factor, first, value, found), (other, *_, unclear) = results.differences("score")
    assert (factor, first, value, other) == ("sure", 0.0, 1.0, "unsure") and not unclear.is_clear
    assert (found.n, found.more, found.is_clear) == (10, 10, True)
    assert (found.lower, found.upper) == pytest.approx((1.0, 1.0))
    said = summary_text(results).splitlines()
    assert said[2] == "score with the same seeds:"
    assert said[3].startswith("  sure = 1 against 0: +1 (95 % interval +1 to +1), 10 seeds: 10 more, 0 less")


def test_the_order_of_rows_does_not_change_the_results(tired_battery):
    assert replace(tired_battery, rows=tired_battery.rows[::-1]).rows == tired_battery.rows


def test_the_error_for_an_unknown_name_lists_the_known_names(tired_battery):
    with pytest.raises(UnknownNameError, match=r"no column named 'scroe'\. Did you mean 'score'"):
        tired_battery.success("scroe >= 30")
    with pytest.raises(UnknownNameError, match=r"no factor named 'battery'\. Did you mean 'battery.charge'"):
        tired_battery.paired("battery", 0.3, 1.0, "score")
    with pytest.raises(UnknownNameError, match=r"no value of battery.charge named '0.5'.*0.65"):
        tired_battery.paired("battery.charge", 0.3, 0.5, "score")
    with pytest.raises(ConfigError, match="'score >= 3 and digest != error' compares words"):
        tired_battery.success("score >= 3 and digest != error")
    with pytest.raises(ConfigError, match="'digest' is text"):
        tired_battery.percentiles("digest")
    with pytest.raises(ConfigError, match="a row has no run"):
        Results([{"seed": 1, "error": ""}], tired_battery.experiment)


@each(
    "text",
    ["", "score", "score >=", ">= 3", "score = 3", "score >= 30 or hits > 3", "10 <= score <= 30", "score >= 3 and",
     "__import__('os').system('true')"],
)  # fmt: skip
def test_an_invalid_condition_is_refused(text):
    try:
        names = Condition(text).names
    except ConfigError as error:
        assert "compare columns, as in 'score >= 30" in str(error)
    else:
        assert text == "score >= 30 or hits > 3" and names == (), "never taken for one"


@given(low=st.integers(-5, 40), high=st.integers(-5, 40))
def test_a_condition_has_the_truth_value_of_the_python_expression(low, high):
    condition = Condition(f"score>={low} and score < {high} and breakdown.hub shots != hits")
    assert condition.names == ("score", "breakdown.hub shots", "hits")
    for score in range(30):
        row = {"score": score, "hits": 7, "breakdown.hub shots": score, "error": ""}
        assert condition.holds(row) == (low <= score < high and score != 7)


def test_the_csv_table_has_all_rows(tired_battery, tmp_path):
    rows = [dict(row) for row in tired_battery.rows]
    rows[3] |= {"score": None, "error": "an error, with a comma"}
    path = replace(tired_battery, rows=rows).save_table(tmp_path / "new" / "folder")
    with path.open(newline="", encoding="utf-8") as file:
        found = list(csv.DictReader(file))
    assert [{name: "" if value is None else str(value) for name, value in row.items()} for row in rows] == found
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot write the table"):
        tired_battery.save_table(tmp_path / "file")
