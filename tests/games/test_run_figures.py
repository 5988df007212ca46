"""Figures of a run agree on console, JSON, page, log, layout and a row of a sweep."""

from __future__ import annotations

import io
import json
import math
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass, replace
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path

import pytest
from game_table import GAMES
from page_reader import PageReader
from rich.console import Console

import simcore
from simcore.match.game import Auto
from simcore.match.match import Match
from simcore.match.runner import play_auto, print_report
from simcore.show.charts import charts_of
from simcore.show.log_page import recording_of, scene_of_log
from simcore.show.page import write_page
from simcore.show.run_track import RunTrack
from simcore.show.scene import scene_of
from simcore.show.scope_layout import scope_layout
from simcore.show.view_models import ViewModels
from simcore.sweep.run_metrics import measure
from simcore.telemetry.recording import Recording
from simcore.telemetry.wpilog import WpilogSink, read_log

PACKAGES = Path(simcore.__file__).resolve().parents[1]
EXAMPLE = PACKAGES / "examples" / "rebuilt_robot"


@dataclass(frozen=True)
class Figures:
    """Figures as printed; None if an output does not show the figure."""

    blue: int | None = None
    red: int | None = None
    shots: int | None = None
    hits: int | None = None
    taken: int | None = None
    driven: str | None = None
    volts: str | None = None
    brownouts: int | None = None


def require_same(told: dict[str, Figures]) -> None:
    """Check that outputs agree and that at least two show each figure."""
    for name in Figures.__dataclass_fields__:
        values = {output: getattr(figures, name) for output, figures in told.items()}
        values = {output: value for output, value in values.items() if value is not None}
        assert len(values) >= 2 and len(set(values.values())) == 1, (name, values)


def number(pattern: str, text: str) -> int:
    """Return the number that a pattern captures in a text; 0 without a match."""
    found = re.search(pattern, text)
    return int(next(filter(None, found.groups()))) if found else 0


def of_match(match: Match) -> Figures:
    record, own = match.record, match.record.robots[0]
    return Figures(
        blue=match.score.blue,
        red=match.score.red,
        shots=len(record.shots),
        hits=len([shot for shot in record.shots if shot.scored]),
        taken=len(record.taken_in),
        driven=f"{own.distance:.1f}",
        volts=f"{own.battery.min_voltage:.2f}",
        brownouts=own.battery.brownouts,
    )


def of_page(path: Path) -> Figures:
    page = PageReader(path)
    facts = {name.removesuffix(", robot 0"): value for name, value in page.facts.items()}
    hits, shots = map(int, facts.get("shots hit", "0 of 0").split(" of "))
    taken = next((int(value) for name, value in facts.items() if name.endswith("taken in")), 0)
    # also in the table of shots, and in the drawn shots
    results = [shot["result"] for shot in page.meta["shots"]]
    assert shots == len(results) and hits == results.count("hit")
    assert taken == len(page.meta["taken"])
    for table in page.meta["tables"]:
        rows = {row[0]: row[1:] for row in table["rows"] if isinstance(row[0], str)}
        if "hits" in rows:
            assert hits == sum(int(cell.split()[0]) for cell in rows["hits"])
            assert shots == sum(map(int, rows["shots"])) == number(r"(\d+)", table["title"])
    return Figures(
        blue=int(facts["score blue"]),
        red=int(facts["score red"]),
        shots=shots,
        hits=hits,
        taken=taken,
        driven=facts["driven"].split()[0],
        volts=facts["lowest battery voltage"].split()[0],
        brownouts=int(facts.get("brownouts", 0)),
    )


def of_log(path: Path) -> Figures:
    log = read_log(path)
    last = log.snapshot_at(log.span[1])
    recording = recording_of(log)
    for event in ("Shots", "Hits", "TakenIn"):
        assert len(recording.events(f"Sim/Newest{event}")) == last.integers[f"Sim/{event}"]
    return Figures(
        blue=last.integers["Sim/Score/Blue"],
        red=last.integers["Sim/Score/Red"],
        shots=last.integers["Sim/Shots"],
        hits=last.integers["Sim/Hits"],
        taken=last.integers["Sim/TakenIn"],
        driven=f"{last.doubles['Sim/Robot/DistanceDriven']:.1f}",
        volts=f"{last.doubles['Sim/Debug/BatteryVoltageLowest']:.2f}",
        brownouts=last.integers["Sim/Debug/Brownouts"],
    )


def of_log_volts(path: Path) -> float:
    log = read_log(path)
    return float(log.snapshot_at(log.span[1]).doubles["Sim/Debug/BatteryVoltageLowest"])


def of_layout(path: Path) -> set[str]:
    """Return the keys whose values AdvantageScope shows."""
    log = read_log(path)
    text = json.dumps(scope_layout(log.snapshot_at(log.span[1]), ViewModels()))
    return {key for key in re.findall(r"NT:/(Sim/[\w/]+)", text)}


def of_chart(recording: Recording, scene, lowest: float, *, within: float = 6e-4) -> Figures:
    """Return the lowest voltage to two decimals after comparing the battery chart, which has millivolts."""
    (battery,) = (chart for chart in charts_of(RunTrack(recording, scene)) if chart.title.startswith("Battery"))
    assert battery.curves[0].values.min() == pytest.approx(lowest, abs=within)
    return Figures(volts=f"{lowest:.2f}")


def files_of(recording: Recording, scene, folder: Path, log: Path) -> dict[str, Figures]:
    """Return figures of page and log of a run, and of the page made from the log."""
    write_page(folder / "a.html", recording, scene)
    again = recording_of(read_log(log))
    write_page(folder / "b.html", again, scene_of_log(again))
    shown = of_layout(log)
    assert {"Sim/Shots", "Sim/Hits", "Sim/TakenIn", "Sim/Robot/DistanceDriven"} <= shown
    assert {"Sim/Debug/BatteryVoltageLowest", "Sim/Debug/Brownouts", "Sim/Score/Blue", "Sim/Score/Red"} <= shown
    return {
        "page": of_page(folder / "a.html"),
        "log": of_log(log),
        "page of the log": of_page(folder / "b.html"),
        "chart": of_chart(recording, scene, of_log_volts(log)),
    }


def of_report(report) -> dict[str, Figures]:
    out = io.StringIO()
    print_report(report, Console(file=out, width=100, force_terminal=False))
    text = out.getvalue()
    spoken = Figures(
        blue=number(r"blue (\d+)", text),
        red=number(r"red (\d+)", text),
        shots=number(r"\d+ of (\d+) shots", text),
        hits=number(r"(\d+) of \d+ shots", text),
        taken=number(r"taken in\D+(\d+)", text),
        driven=re.search(r"distance driven\D+([\d.]+) m", text)[1],
        volts=re.search(r"lowest battery\D+([\d.]+) V", text)[1],
        brownouts=number(r"(\d+) brownouts", text),
    )
    data = json.loads(report.to_json())
    told = Figures(
        blue=data["score"]["blue"],
        red=data["score"]["red"],
        **{name: data[name] for name in ("shots", "hits", "brownouts")},
        taken=data["taken_in"],
        driven=f"{data['distance_m']:.1f}",
        volts=f"{data['min_battery_v']:.2f}",
    )
    return {"console": spoken, "json": told}


def of_row(row) -> Figures:
    return Figures(
        shots=row["shots"],
        hits=row["hits"],
        taken=row["taken_in"],
        driven=f"{row['distance_m']:.1f}",
        volts=f"{row['min_battery_v']:.2f}",
        brownouts=row["brownouts"],
    )


def played(tmp_path: Path, game: str, auto: Auto | str, *, seconds: float, alliance="blue", **settings):
    """Return the figures of an auto from all outputs, with distance and lowest voltage as observed at each tick."""
    recording, log = Recording(), tmp_path / "run.wpilog"
    places, volts = [], []

    def look(match: Match) -> None:
        if not places:
            places.append(match.record.robots[0].placements[0].pose[:2])
        places.append(match.robots[0].chassis.pose[:2])
        volts.append(match.robots[0].battery.tick_min_voltage)

    run = play_auto(
        *(GAMES[game], auto), alliance=alliance, seconds=seconds, seed=3, sinks=[recording, WpilogSink(log)],
        on_tick=look, **settings,
    )  # fmt: skip
    steps = [math.dist(a, b) for a, b in pairwise(places)]
    seen = Figures(driven=f"{sum(step for step in steps if step < 0.3):.1f}", volts=f"{min(volts):.2f}")
    with run.match as match:
        told = {"match": of_match(match), "seen": seen, **of_report(run.report)}
        told["sweep"] = of_row(measure(match, ()))
        scene = scene_of(match)
    return told | files_of(recording, scene, tmp_path, log)


@pytest.mark.parametrize(
    ("game", "auto", "alliance", "seconds"),
    [
        ("rebuilt", "depot", "blue", 11.0),
        ("rebuilt", "depot", "red", 9.0),
        ("reefscape", "three_l4", "blue", 8.0),
    ],
)
def test_all_outputs_of_an_auto_report_equal_figures(tmp_path, game, auto, alliance, seconds):
    told = played(tmp_path, game, auto, seconds=seconds, alliance=alliance)
    require_same(told)
    assert float(told["console"].driven) > 1.0 and (game == "reefscape" or told["console"].shots > 5)


def test_moving_a_robot_by_hand_adds_nothing_to_its_driven_distance(tmp_path):
    """The battery is fresh afterwards; its lowest voltage before stays in the record."""
    depot = GAMES["rebuilt"].auto("depot")

    def put_twice(match, alliance):
        inner = depot.controller(match, alliance)

        def control(robot, now):
            inner(robot, now)
            if match.ticks in (200, 300):
                robot.reset((2.0, 2.0 + match.ticks / 100.0, 0.0))

        return control

    auto = replace(depot, controller=put_twice)
    told = played(tmp_path, "rebuilt", auto, seconds=7.0)
    require_same(told)
    page = PageReader(tmp_path / "a.html")
    assert "put there, reset: (2.00, 4.00) m, 0 deg" in [text for _, kind, text in page.meta["events"] if kind == "put"]
    log = read_log(tmp_path / "run.wpilog")
    assert log.snapshot_at(log.span[1]).integers["Sim/Robot/Placements"] == 3


TEST = """
import json
from pathlib import Path

from simcore import season


def live(key):
    instance = season.ntcore.NetworkTableInstance.get_default()
    return instance.get_topic(f"/Sim/{key}").generic_subscribe().get().value()


def test_scores_a_lot(sim):
    sim.alliance("red")
    sim.autonomous("depot", seconds=SECONDS)
    sim.disable(seconds=3.0)  # until the shots have been counted: NetworkTables lags by up to 0.1 s
    Path("live.json").write_text(json.dumps({
        "blue": live("Score/Blue"), "red": live("Score/Red"), "shots": live("Shots"), "hits": live("Hits"),
        "taken": live("TakenIn"), "driven": f"{live('Robot/DistanceDriven'):.1f}",
        "volts": f"{live('Debug/BatteryVoltageLowest'):.2f}", "brownouts": live("Debug/Brownouts"),
    }))
    record, own = sim.record, sim.record.robots[0]
    Path("told.json").write_text(json.dumps({
        "blue": sim.score.blue, "red": sim.score.red, "shots": len(record.shots), "hits": record.hits,
        "taken": len(record.taken_in), "driven": f"{own.distance:.1f}", "volts": f"{sim.battery.min_voltage:.2f}",
        "brownouts": sim.battery.brownouts,
    }))
    assert sim.score.red >= 800
"""


def needs_robot_packages() -> None:
    for module in ("phoenix6", "pyfrc"):
        if find_spec(module) is None:
            pytest.skip(f"needs {module}: pip install .[phoenix6,robotpy]")


@pytest.mark.slow
def test_the_page_of_a_failed_test_agrees_with_the_test_networktables_log_and_chart(tmp_path):
    """The run is recorded ten times a second: shots and the lowest battery voltage fall between two rows."""
    needs_robot_packages()
    project = tmp_path / "project"
    shutil.copytree(EXAMPLE, project, ignore=shutil.ignore_patterns("tests", "test_output", "out", "__pycache__"))
    (project / "tests").mkdir()
    (project / "tests" / "auto_test.py").write_text(TEST.replace("SECONDS", "9.0"))
    run = subprocess.run(
        [sys.executable, "-m", "robotpy", "test", "--", "-p", "no:cacheprovider"],
        cwd=project, env={**os.environ, "PYTHONPATH": str(PACKAGES)}, capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    (page,) = project.rglob("test_output/**/*.html")
    (log,) = project.rglob("test_output/**/*.wpilog")
    said = Figures(**json.loads(next(project.rglob("told.json")).read_text()))
    recording = recording_of(read_log(log))
    live = Figures(**json.loads(next(project.rglob("live.json")).read_text()))
    told = {"test": said, "live": live, "page": of_page(page), "log": of_log(log)}
    told |= {"chart": of_chart(recording, scene_of_log(recording), float(told["page"].volts), within=0.006)}
    require_same(told)
    assert said.shots > 5 and float(said.driven) < 8.0, run.stdout[-2000:]
    assert any(">= 800" in note for note in PageReader(page).meta["notes"]), "what failed"
    assert "put there, carried" in PageReader(page).words, "red's start is not where the match has begun"


@pytest.mark.slow
def test_the_figures_in_a_sweep_row_are_consistent():
    needs_robot_packages()
    from simcore.sweep.api import sweep
    from simcore.sweep.experiment import Experiment

    names = ("shots", "hits", "taken_in", "distance_m", "min_battery_v", "brownouts")
    experiment = Experiment(project=str(EXAMPLE), auto="depot", seconds=7.0, metrics=names)
    (row,) = sweep(experiment).rows
    assert row["error"] == ""
    assert row["distance_m"] > 1.0 and row["shots"] >= row["hits"] > 0
