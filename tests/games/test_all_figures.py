"""Figures of a run agree on page, `--json`, log, console and score sheet: match, comparison and sweep.

Figures of an auto, of a failed test and of robot code are in `test_run_figures.py`.
"""

from __future__ import annotations

import base64
import contextlib
import gzip
import io
import json
import re
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from page_reader import PageReader

from games.rebuilt import REBUILT
from games.reefscape import REEFSCAPE
from simcore import cli
from simcore.match.runner import print_report
from simcore.show.log_page import recording_of, scene_of_log
from simcore.show.page import write_page
from simcore.sweep.run_store import RunStore
from simcore.telemetry.snapshot import Snapshot, key_in_words
from simcore.telemetry.wpilog import read_log

PLAYERS = {
    "rebuilt": ("collector:3,defender:2,shuttle:2", "collector:3,collector:2,shuttle:3"),
    "reefscape": ("scorer:3,defender:2,parker:2", "scorer:3,scorer:2,algae:3"),
}
"""Players of red and blue, by game."""
SECONDS = 6.0


@dataclass
class Told:
    """Outputs of one run."""

    data: dict[str, Any]
    """Output of `--json`."""
    console: str
    page: PageReader
    page_of_log: PageReader
    end: Snapshot
    """Last snapshot of the log."""


@pytest.fixture(scope="module", params=[REBUILT, REEFSCAPE], ids=lambda game: game.name)
def told(request, tmp_path_factory) -> Told:
    """Play a short match of six robots with all outputs of `simcore play --match`."""
    game, folder = request.param, tmp_path_factory.mktemp("match")
    red, blue = PLAYERS[game.name]
    reports, out = [], io.StringIO()

    def keep(report, console, **options):
        reports.append(report)
        print_report(report, console, **options)

    words = ["play", game.name, "--match", "--red", red, "--blue", blue, "--seconds", f"{SECONDS:g}", "--seed", "1"]
    files = [f"--{kind}={folder / name}" for kind, name in (("log", "a.wpilog"), ("page", "a.html"))]
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(out):
        patch.setattr("simcore.show.play_command.print_report", keep)
        assert cli.main([*words, *files, "--verbose"]) == 0
    found = read_log(folder / "a.wpilog")
    again = recording_of(found)
    write_page(folder / "b.html", again, scene_of_log(again))
    pages = (PageReader(folder / f"{name}.html") for name in ("a", "b"))
    (report,) = reports
    return Told(json.loads(report.to_json()), out.getvalue(), *pages, found.snapshot_at(found.span[1]))


def cells(console: str, name: str) -> list[str]:
    """Return the cells of a named row of the console report."""
    (row,) = (line for line in console.splitlines() if re.match(rf"\W*{re.escape(name)}\s+│", line))
    return [cell.strip() for cell in row.strip("│ ").split("│")[1:]]


def test_every_output_has_the_same_score_sheet(told):
    data, end, page = told.data, told.end, told.page
    assert {key: end.integers[f"Sim/Score/{key}"] for key in data["breakdown"]} == data["breakdown"]
    assert data["score"] == {name: end.integers[f"Sim/Score/{name.title()}"] for name in ("red", "blue", "total")}
    sheet = {row[0]: row[1:] for row in page.table("Score sheet")[1:]}
    assert sheet.pop("score") == [str(data["score"][side]) for side in ("blue", "red")]
    kinds = {re.sub("^(Blue|Red)/", "", key) for key in data["breakdown"] if "/" in key}
    assert len(kinds) > 5
    for kind in kinds:
        blue, red = (data["breakdown"].get(f"{side}/{kind}", 0) for side in ("Blue", "Red"))
        words = ": ".join(map(key_in_words, kind.split("/")))
        assert sheet.pop(words, ["0", "0"]) == [str(blue), str(red)], kind
        if blue or red:
            assert cells(told.console, kind) == [str(red), str(blue)]
    assert sheet == {}, "nothing that the game does not count"


def test_every_output_has_the_same_points_and_fouls(told):
    data, page = told.data, told.page
    score, fouls = data["score"], data["fouls"]
    for side in ("blue", "red"):
        assert page.facts[f"score {side}"] == page.board(side, SECONDS) == str(score[side])
        assert re.search(rf"{side} {score[side]}\b", told.console)
        assert page.curve("Score", side)[1][-1] == pytest.approx(score[side], abs=0.01)
    winner = max(("blue", "red"), key=score.__getitem__)
    wanted = "a tie" if score["blue"] == score["red"] else f"{winner} wins"
    assert page.facts["result"].startswith(wanted) and page.meta["verdict"] == page.facts["result"]
    assert len([event for event in page.meta["events"] if event[1] == "foul"]) == len(fouls)
    state = data["match_state"]
    assert page.meta["phases"][-1][1].partition(",")[0] == state["Period"] == told.end.strings["Sim/Match/Period"]
    assert page.facts["simulated"] == f"{data['sim_seconds']:.2f} s"
    values = {**told.end.doubles, **told.end.integers, **told.end.booleans, **told.end.strings}
    assert {key: values[f"Sim/Match/{key}"] for key in state} == state


def test_every_output_has_the_same_shots_and_pieces(told):
    data, page, end = told.data, told.page, told.end
    shots, results = data["shots"], [shot["result"] for shot in page.meta["shots"]]
    hits, passes = data["hits"], results.count("pass")
    assert (end.integers["Sim/Shots"], end.integers["Sim/Hits"], end.integers["Sim/TakenIn"]) == (
        shots, hits, data["taken_in"],
    )  # fmt: skip
    assert (len(results), results.count("hit"), len(page.meta["taken"])) == (shots, hits, data["taken_in"])
    taken = [value for name, value in page.facts.items() if name.endswith("taken in")]
    assert taken == ([str(data["taken_in"])] if data["taken_in"] else [])
    if data["taken_in"]:
        assert cells(told.console, "pieces taken in") == [str(data["taken_in"])]
    rows = {row[0]: row[1:] for row in page.table("Robots")[1:]}
    assert rows["alliance"] == ["blue"] * 3 + ["red"] * 3
    assert [" ".join(both) for both in zip(rows["alliance"], rows["plays"], strict=True)] == data["players"]
    prefixes = ("Sim", *(f"Sim/Robots/{k}" for k in range(1, 6)))
    assert page.board("held", SECONDS) == ", ".join(
        f"robot {k} {end.integers[f'{prefix}/Intake/HeldCount']}" for k, prefix in enumerate(prefixes)
    )
    if not shots:
        assert "shots hit" not in page.facts and "hits" not in rows
        return
    assert page.facts["shots hit"] == f"{hits} of {shots}" and f"{hits} of {shots} shots" in told.console
    assert page.facts.get("of the shots passed on", "0") == str(passes)
    assert sum(map(int, rows["shots"])) == shots
    assert sum(int(cell.split()[0]) for cell in rows["hits"]) == hits
    assert (
        sum(map(int, rows["passed on"])) == passes
        if passes
        else "passed on" not in rows or {*rows["passed on"]} == {"0"}
    )


def test_every_output_has_the_same_figures_of_each_robot(told):
    data, page, end = told.data, told.page, told.end
    assert page.facts["driven, robot 0"] == f"{data['distance_m']:.1f} m" == cells(told.console, "distance driven")[0]
    lowest = f"{data['min_battery_v']:.2f} V"
    assert page.facts["lowest battery voltage, robot 0"] == lowest
    assert cells(told.console, "lowest battery")[0].partition(";")[0] == lowest
    assert int(page.facts.get("brownouts, robot 0", 0)) == data["brownouts"] == end.integers["Sim/Debug/Brownouts"]
    for number in range(6):
        prefix = "Sim" if number == 0 else f"Sim/Robots/{number}"
        volts = page.curve("Battery, by robot", str(number))[1]
        assert volts.min() == pytest.approx(end.doubles[f"{prefix}/Debug/BatteryVoltageLowest"], abs=6e-4)
        pose, _ = page.robot(number, SECONDS)
        assert pose[:2] == pytest.approx(end.poses[f"{prefix}/Robot/Pose3d"][:2], abs=6e-4)


def test_a_page_made_from_the_log_has_the_contents_of_the_page_of_the_run(told):
    """The pages are equal word for word, except for computation times."""
    one, two = told.page.meta, told.page_of_log.meta
    assert told.page.facts == told.page_of_log.facts
    for part in ("verdict", "tables", "phases", "looks", "levels", "cells", "board"):
        assert one[part] == two[part], part
    for part in ("shots", "taken", "events"):
        assert len(one[part]) == len(two[part]), part
    assert [event[1:] for event in one["events"]] == [event[1:] for event in two["events"]]
    fell_short = told.data["shortfalls"]
    assert (
        [note.splitlines() for note in (one["notes"][-1], two["notes"][-1])] == [fell_short] * 2 if fell_short else True
    )


# --- comparison and sweep -----------------------------------------------------------------------------------------


def rows_of(folder: Path) -> list[dict[str, Any]]:
    with closing(RunStore(folder, must_exist=True)) as store:
        experiment = store.experiment()
        found = store.rows(experiment.run_keys(experiment.runs())).values()
    return sorted(found, key=lambda row: int(row["run"]))


def blocks_of(page: Path) -> list[dict[str, Any]]:
    found = re.search(r'id="report">([^<]*)<', page.read_text(encoding="utf-8"))
    assert found is not None
    blocks: list[dict[str, Any]] = json.loads(gzip.decompress(base64.b64decode(found[1])))
    return blocks


def test_console_and_both_pages_of_a_comparison_report_the_same_difference(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = ["compare", "depot", "tour", "--game", "rebuilt", "--seeds", "2", "--seconds", "4", "-j", "1"]
    assert cli.main(words) == 0
    said = capsys.readouterr().out
    rows = rows_of(Path("out/compare"))
    scores = {name: [int(row["score"]) for row in rows if row["auto"] == name] for name in ("depot", "tour")}
    assert all(len(found) == 2 for found in scores.values()) and sum(scores["depot"]) > sum(scores["tour"]) == 0
    (difference,) = re.findall(r"^score, tour minus depot: (.*)$", said, re.MULTILINE)
    assert float(difference.split()[0]) == pytest.approx(np.mean(scores["tour"]) - np.mean(scores["depot"]), rel=5e-3)
    head, *blocks = blocks_of(Path("out/compare/page.html"))
    table = next(block for block in blocks if block["kind"] == "table")
    assert head["detail"] == f"score, tour minus depot: {difference}"
    assert [(row[0], row[3]) for row in table["rows"]] == [(name, np.median(found)) for name, found in scores.items()]
    both = PageReader(Path("out/compare/both.html"))
    assert difference in both.meta["notes"][0]
    seed = int(both.meta["title"].rpartition(" ")[2])
    for number, (name, file) in enumerate((("depot", "old"), ("tour", "new"))):
        (row,) = (row for row in rows if (row["auto"], row["seed"]) == (name, seed))
        log = read_log(Path(f"out/compare/{file}.wpilog"))
        end = log.snapshot_at(log.span[1])
        assert int(row["score"]) == end.integers["Sim/Score/Blue"] == int(both.facts[f"score {name}"])
        assert f"{name}: {row['score']}" in both.meta["notes"][0]
        assert both.curve("Score", name)[1][-1] == pytest.approx(int(row["score"]), abs=0.01)
        assert both.facts[f"shots hit, {name}"] == f"{row['hits']} of {row['shots']}"
        assert f"{end.doubles['Sim/Robot/DistanceDriven']:.1f}" == f"{float(row['distance_m']):.1f}"
        assert both.facts[f"driven, {name}"] == f"{float(row['distance_m']):.1f} m"
        assert both.facts[f"lowest battery voltage, {name}"] == f"{float(row['min_battery_v']):.2f} V"
        shots = [shot for shot in both.meta["shots"] if shot["robot"] == number]
        assert len(shots) == int(row["shots"]) == end.integers["Sim/Shots"]


def test_console_page_table_and_single_runs_of_a_sweep_report_equal_figures(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = ["sweep", "rebuilt", "--seeds", "2", "--seconds", "3", "-j", "1", "--success", "score >= 1", "--out", "s"]
    assert cli.main(words) == 0
    said = capsys.readouterr().out
    blocks, rows = blocks_of(Path("s/page.html")), rows_of(Path("s"))
    (table,) = (block for block in blocks if block.get("caption") == "Metrics of all runs")
    for name, *cells in table["rows"]:
        *_, line = (line.split() for line in said.splitlines() if line.startswith(f"{name} "))
        assert [float(cell) for cell in line[1:]] == pytest.approx(cells, rel=5e-3), (
            "the page says what the console has"
        )
        assert cells[2] == pytest.approx(np.median([float(one[name]) for one in rows]))
    assert {"distance_m", "min_battery_v"} <= {row[0] for row in table["rows"]}
    held = [int(row["score"]) >= 1 for row in rows]
    assert blocks[0]["text"].startswith(f"{sum(held)} of {len(held)}, ") and f"{sum(held)} of {len(held)} = " in said
    assert cli.main(["sweep", "--out", "s", "--repeat", "1"]) == 0
    capsys.readouterr()
    (log,) = Path("s").rglob("*.wpilog")
    found = read_log(log)
    end, page, row = found.snapshot_at(found.span[1]), PageReader(log.with_suffix(".html")), rows[1]
    assert int(row["score"]) == end.integers["Sim/Score/Blue"] == int(page.facts["score blue"])
    assert page.facts["driven"] == f"{float(row['distance_m']):.1f} m"
    assert page.facts["lowest battery voltage"] == f"{float(row['min_battery_v']):.2f} V"
