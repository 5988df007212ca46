import io
import json
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from each_case import each
from rich.console import Console

from simcore.errors import NonFiniteError
from simcore.match.match import Match
from simcore.match.run_record import PieceCount, RunRecord, TickTimes, TrajectoryDigest
from simcore.match.runner import RunReport, Spread, print_report
from simcore.match.scoring import Score

FIGURES: dict[str, Any] = dict(
    game="rebuilt",
    auto="depot",
    alliance="blue",
    engine="bullet",
    seed=7,
    startup_seconds=0.4,
    sim_seconds=20.0,
    wall_seconds=2.34,
    realtime_factor=8.547,
    ticks=1000,
    score=Score(red=0, blue=27, total=27),
    match_state={
        "Time": 20.0,
        "TimeLeft": 143.0,
        "Enabled": False,
        "BlueHubActive": True,
        "Game": "rebuilt",
        "Period": "pause",
    },
    pieces=PieceCount(staged=408, on_field=377, in_flight=1, held=3, scored=27, off_field=0),
    piece_name="fuel",
    breakdown={"BlueHub": 27},
    fouls=("1.20 s: G7, red robot 1 pushes: blue +6",),
    shots=31,
    hits=27,
    taken_in=23,
    distance_m=14.33,
    tick_ms=TickTimes(median=1.83, p95=3.2, p99=4.1, max=9.77),
    substeps=Spread(mean=4.2, max=11),
    awake=Spread(mean=33.4, max=88),
    min_battery_v=9.87,
    brownouts=0,
    resets=0,
    digest="ab" * 32,
    outputs={"log": "out/run.wpilog"},
)


def report_of(**figures: object) -> RunReport:
    """Return a report of a match of one tick, with given figures."""
    with Match.bare() as match:
        match.tick()
        report = RunReport(match, "depot", startup_seconds=0.4, wall_seconds=2.34, ticks=[(0.001, 4, 33)])
    assert set(FIGURES) <= set(vars(report))
    vars(report).update(FIGURES | figures)
    return report


REPORT = report_of()


def printed(report: RunReport, encoding: str, *, verbose: bool = False) -> str:
    raw = io.BytesIO()
    stream = io.TextIOWrapper(raw, encoding=encoding)
    print_report(report, Console(file=stream, width=80), verbose=verbose)
    stream.flush()
    return raw.getvalue().decode(encoding)


def test_record_columns_change_only_with_events_and_show_the_last_second() -> None:
    """Columns that were read before stay unchanged; a row has the number and position [mm] of an event."""
    state = SimpleNamespace(pos=np.array([[1.0, 2.0, 0.1], [3.0, 4.5, 0.1]]))
    record = RunRecord(SimpleNamespace(state=state), [], 0.02)  # type: ignore[arg-type]
    record.note_taken_in(np.array([0]), 0)
    first = record.columns
    assert record.columns is first and first.taken_in.tolist() == [1, 1000, 2000]
    record.after_tick(0.98)
    record.note_taken_in(np.array([1]), 0)
    assert record.columns.taken_in.tolist() == [1, 1000, 2000, 2, 3000, 4500]
    assert first.taken_in.tolist() == [1, 1000, 2000]
    record.after_tick(1.2)
    assert record.columns.taken_in.tolist() == [1, 1000, 2000, 2, 3000, 4500], "until the next one"
    record.note_taken_in(np.array([0]), 0)
    assert record.columns.taken_in.tolist() == [2, 3000, 4500, 3, 1000, 2000]


def test_the_json_report_has_the_documented_fields() -> None:
    got = json.loads(REPORT.to_json())
    assert list(got) == [
        *(
            "game",
            "auto",
            "alliance",
            "players",
            "seed",
            "scatter",
            "engine",
            "sim_seconds",
            "startup_seconds",
            "wall_seconds",
            "realtime_factor",
            "ticks",
        ),
        *("score", "match_state", "pieces", "piece_name", "breakdown", "placed", "fouls", "shots", "hits"),
        *("taken_in", "shortfalls"),
        *("distance_m", "tick_ms", "substeps", "awake", "min_battery_v", "brownouts", "resets", "digest", "outputs"),
    ]
    assert got["score"] == {"red": 0, "blue": 27, "total": 27}
    assert list(got["pieces"]) == ["staged", "on_field", "in_flight", "held", "scored", "placed", "off_field"]
    assert got["tick_ms"] == {"median": 1.83, "p95": 3.2, "p99": 4.1, "max": 9.77}
    assert got["substeps"] == {"mean": 4.2, "max": 11}
    assert got["match_state"]["Period"] == "pause" and got["match_state"]["BlueHubActive"] is True
    assert got["fouls"] == ["1.20 s: G7, red robot 1 pushes: blue +6"]
    assert "\n" not in REPORT.to_json()


def test_numpy_numbers_become_plain_numbers_in_json() -> None:
    report = report_of(shots=np.int64(5), min_battery_v=np.float64(9.5), distance_m=np.float32(0.5))
    got = json.loads(report.to_json())
    assert (got["shots"], got["min_battery_v"], got["distance_m"]) == (5, 9.5, 0.5)


def test_the_error_names_the_report_field_that_is_nan() -> None:
    with pytest.raises(NonFiniteError, match=r"report\.tick_ms\.max"):
        report_of(tick_ms=TickTimes(median=1.0, p95=1.0, p99=1.0, max=float("nan"))).to_json()


@each("encoding", ["utf-8", "cp1252", "ascii"])
def test_the_report_fits_80_columns_in_any_terminal(encoding: str) -> None:
    report = report_of(outputs={"log": "out/" + "長い/" * 40 + " [bold]run.wpilog"})
    text = printed(report, encoding, verbose=True)
    assert all(len(line) <= 80 for line in text.splitlines())
    for part in (
        "27 points",
        "27 of 31 shots scored (87%)",
        "all 408",
        "377",
        "9.87 V",
        "8.5 times as",
        "[bold]",
        "G7, red robot 1",
    ):
        assert part in text
    rows = [line.strip("|\u2502 ").split(maxsplit=3) for line in text.splitlines()]
    assert ["blue", "hub", "active"] in [row[:3] for row in rows]
    assert "20.0 s, 143.0 s left" in text and "pause; robots are disabled" in text
    for part in ("p95 3.20", "abababab", "mean 4.2"):
        assert part in text and part not in printed(report, encoding)


def test_the_report_names_lost_pieces() -> None:
    assert "accounted for" not in printed(REPORT, "utf-8")
    lost = report_of(pieces=replace(REPORT.pieces, on_field=376))
    assert "407 of 408 pieces accounted for" in printed(lost, "utf-8")


# --- digest ---------------------------------------------------------------------------------------------------------


def digest(*ticks: tuple[object, ...]) -> str:
    recorder = TrajectoryDigest()
    for arrays in ticks:
        recorder.update(*(np.asarray(array) for array in arrays))
    return recorder.hexdigest()


def test_the_digest_of_a_known_state_is_fixed() -> None:
    """Another value means that digests of old reports can no longer be compared."""
    assert digest(([1.0, 2.0],)) == "f2942cc692d15d574dc0dd7f6b46695441e9fedd690d3b7ce38ad1f5127d1924"


def test_tick_times_are_summarized_by_percentiles() -> None:
    assert TickTimes.of([k / 1000.0 for k in range(101)]) == TickTimes(
        median=pytest.approx(50.0), p95=pytest.approx(95.0), p99=pytest.approx(99.0), max=pytest.approx(100.0)
    )
    assert TickTimes.of([]) == TickTimes(median=0.0, p95=0.0, p99=0.0, max=0.0)
    assert Spread.of([1, 2, 6]) == Spread(mean=3.0, max=6) and Spread.of([]) == Spread(mean=0.0, max=0)


def test_memory_layout_and_the_sign_of_zero_do_not_change_the_digest() -> None:
    values = np.arange(12.0).reshape(3, 4)
    assert digest((values,)) == digest((np.asfortranarray(values),)) == digest((values.astype(">f8"),))
    assert digest(([0.0],)) == digest(([-0.0],))
