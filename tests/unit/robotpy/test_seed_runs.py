"""How runs of many seeds are judged together: made reports, no process."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from simcore.errors import ConfigError
from simcore.robotpy.seed_runs import RUN, SeededRun, judge_runs, play_seeds, seeds_of

AUTO = {"what": "", "at_least": 0.9, "sure": False}


def run(seed, held=True, *, outcome="passed", refuted=False, claims=None, points=0, when="call"):
    """A run whose test has asked `sim.success` once, if nothing else is said."""
    claims = [{**AUTO, "held": held}] if claims is None else claims
    said = {"claims": claims, "points": points, "summary": f"score blue {points}", "digest": f"d{seed}",
            "is_refuted": refuted}  # fmt: skip
    reports = []
    for phase in ("setup", "call", "teardown"):
        outcomes = outcome if phase == when else "passed"
        report = pytest.TestReport("t.py::test", ("t.py", 1, "test"), {}, outcomes, None, phase, duration=2.0)
        if phase == when:
            report.longrepr = "assert 3 > 4" if outcome == "failed" else None
            report.user_properties.append((RUN, said))
            report.sections.append(("simcore", f"look at the run: page seed_{seed}/run.html\nat its end"))
        reports.append(report)
    return SeededRun.of(seed, reports)


def judged(runs, folder):
    """Outcome and text of the test, and what is left of its files."""
    for one in runs:
        (folder / f"seed_{one.seed}").mkdir()
    setup, call, teardown = judge_runs(runs, "t.py::test", folder)
    assert (setup.outcome, teardown.outcome) == ("passed", "passed")
    text = call.longrepr if call.failed else dict(call.sections)["simcore"]
    return call, text.splitlines(), sorted(path.name for path in folder.iterdir())


def test_too_few_successes_fail_with_share_bound_and_the_worst_three_runs(tmp_path):
    runs = [run(seed, held=seed >= 12, points=100 - seed if seed < 12 else 500) for seed in range(50)]
    call, lines, left = judged(runs, tmp_path)
    assert call.failed and lines[0] == "38 of 50 (lower bound 0.63) < 0.9"
    assert lines[1] == "without success: seed 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11"
    assert left == ["seed_10", "seed_11", "seed_9"]  # fewest points
    assert next(line for line in lines if line.startswith("seed ")) == "seed 11: score blue 89"
    assert "look at the run: page seed_11/run.html" in lines and "at its end" not in lines
    assert lines[-1] == 'alone: pytest "t.py::test" --sim-seed=11' and call.duration == 100.0
    assert dict(call.user_properties)["seeds"]["49"] == "d49"


def test_enough_successes_pass_and_leave_nothing(tmp_path):
    call, lines, left = judged([run(seed, held=seed != 4) for seed in range(50)], tmp_path)
    assert call.passed and lines == ["49 of 50 (lower bound 0.90) >= 0.9", "without success: seed 4"] and left == []


def test_who_wants_to_be_sure_asks_the_lower_bound(tmp_path):
    claims = [{**AUTO, "held": True, "sure": True, "what": "scores 8"}]
    call, lines, _ = judged([run(seed, claims=claims) for seed in range(20)], tmp_path)
    assert call.failed and lines == ["20 of 20 (lower bound 0.84) < 0.9: scores 8"]


def test_a_failed_assertion_is_no_success_of_any_claim_and_without_claims_all_have_to_hold(tmp_path):
    two = [{**AUTO, "held": True}, {**AUTO, "held": True, "at_least": 0.5, "what": "again"}]
    runs = [run(0, claims=two), run(1, claims=two), run(2, claims=two[:1], outcome="failed", refuted=True)]
    call, lines, _ = judged(runs, tmp_path)
    assert call.failed and lines[0].startswith("2 of 3 ") and lines[1] == "2 of 3 (lower bound 0.21) >= 0.5: again"
    assert "assert 3 > 4" in lines
    (tmp_path / "plain").mkdir()
    plain = [run(0, claims=[]), run(1, claims=[], outcome="failed", refuted=True)]
    call, lines, _ = judged(plain, tmp_path / "plain")
    assert call.failed and lines[0] == "1 of 2 (lower bound 0.09) < 1"


def test_a_run_that_ends_with_an_error_fails_the_test_whatever_the_share(tmp_path):
    runs = [run(0), run(1, outcome="failed"), run(2)]
    reports = judge_runs(runs, "t.py::test", tmp_path)
    call = reports[1]
    assert call.failed and call.longrepr == "assert 3 > 4"
    assert dict(call.sections)["simcore"] == "1 of 3 runs ended with an error; this is seed 1"


def test_the_first_run_is_the_only_one_if_it_errs_or_skips():
    for first in (run(7, outcome="failed"), run(7, outcome="failed", when="setup"), run(7, outcome="skipped")):
        asked = []
        runs = list(play_seeds(lambda seed, f=first, a=asked: a.append(seed) or f.reports, (7, 8, 9), 2))
        assert asked == [7] and (runs[0].is_error or runs[0].is_skipped)
    ran = list(play_seeds(lambda seed: run(seed, held=False).reports, (7, 8, 9), 2))
    assert [one.seed for one in ran] == [7, 8, 9]


def item(*arguments, most=None, **named):
    marker = SimpleNamespace(args=arguments, kwargs=named)
    config = SimpleNamespace(getoption=lambda name: most)
    return SimpleNamespace(get_closest_marker=lambda name: marker, config=config)


def test_seeds_are_a_number_or_a_list_and_can_be_shortened():
    assert (
        seeds_of(item(3)) == (0, 1, 2)
        and seeds_of(item([5, 2, 5])) == (5, 2)
        and seeds_of(item(range(50), most=2)) == (0, 1)
    )
    for wrong in ((), (0,), (-1,), (True,), ([],), ([-1],), ("50",), (1.5,)):
        with pytest.raises(ConfigError, match="wants how many"):
            seeds_of(item(*wrong))
    with pytest.raises(ConfigError, match=r"scatter='\.\.\.' only, got spread"):
        seeds_of(item(3, spread=1))
