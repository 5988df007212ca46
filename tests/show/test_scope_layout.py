"""Layouts for AdvantageScope show the values, colors and kinds of a log, and nothing that the log lacks."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from simcore.cli import main
from simcore.show.scope_layout import scope_layout
from simcore.telemetry.snapshot import Snapshot
from simcore.telemetry.wpilog import WpilogSink

POSE = np.array([1.0, 2.0, 0.0, 1.0, 0.0, 0.0, 0.0])
RUN = Snapshot(
    time=0.02,
    tick=0,
    poses={f"{robot}/Robot/Pose3d": POSE for robot in ("Sim", "Sim/Robots/10", "Sim/Robots/2")},
    pose_arrays={
        "Sim/Robot/ComponentPoses": POSE[None],
        "Sim/Robots/2/Robot/ComponentPoses": np.zeros((0, 7)),
        "Sim/GamePieces/Disc": POSE[None],
        "Sim/InFlight/Disc": np.zeros((0, 7)),
        "Sim/Limelights/front/DirectionLine": POSE[None],
    },
    doubles={
        "Sim/Match/Time": 0.02,
        "Sim/Debug/BatteryVoltage": 12.7,
        "Sim/Robots/10/Debug/BatteryVoltage": 12.6,
        "Sim/Robots/2/Debug/BatteryVoltage": 12.5,
        "Sim/Debug/LiftCurrentA": 3.0,
        "Sim/Debug/LiftHeightM": 0.3,
    },
    integers={"Sim/Score/Blue": 1, "Sim/Score/Red": 2, "Sim/Performance/AwakePieces": 3},
    booleans={"Sim/Robot/IsRed": True, "Sim/Match/RedGoalOpen": True, "Sim/Sensors/Limit": False},
    strings={"Sim/Match/Period": "auto"},
)


def tabs(layout: dict[str, Any]) -> dict[str, Any]:
    assert set(layout) == {"version", "hubs", "satellites"}
    (window,) = layout["hubs"]
    return {tab["title"]: tab["controller"] for tab in window["state"]["tabs"]["tabs"]}


def rows(sources: list[dict[str, Any]]) -> list[tuple[str, str]]:
    return [(source["type"], source["logKey"].removeprefix("NT:/")) for source in sources]


def test_a_game_without_models_is_shown_with_the_models_of_advantagescope() -> None:
    shown = tabs(scope_layout(RUN))
    field = shown["3D Field"]
    assert field["game"] == "FRC:Evergreen"
    assert rows(field["sources"]) == [
        ("robot", "Sim/Robot/Pose3d"),
        ("component", "Sim/Robot/ComponentPoses"),
        ("robot", "Sim/Robots/2/Robot/Pose3d"),
        ("robot", "Sim/Robots/10/Robot/Pose3d"),
        ("gamePiece", "Sim/GamePieces/Disc"),
        ("trajectory", "Sim/Limelights/front/DirectionLine"),
    ]
    assert field["sources"][0]["options"] == {"model": "KitBot"}
    assert [key for _, key in rows(shown["Battery"]["leftSources"])] == [
        "Sim/Debug/BatteryVoltage",
        "Sim/Robots/2/Debug/BatteryVoltage",
        "Sim/Robots/10/Debug/BatteryVoltage",
    ]
    assert rows(shown["Currents"]["leftSources"]) == [("stepped", "Sim/Debug/LiftCurrentA")]
    assert rows(shown["Mechanisms"]["rightSources"]) == [], "an axis has one unit"
    assert rows(shown["Heights"]["leftSources"]) == [("stepped", "Sim/Debug/LiftHeightM")]
    assert rows(shown["Mechanisms"]["discreteSources"]) == [("stripes", "Sim/Sensors/Limit")]
    assert rows(shown["Score"]["discreteSources"]) == [
        ("stripes", "Sim/Match/Period"),
        ("stripes", "Sim/Match/RedGoalOpen"),
    ]
    assert "NT:/Sim/Match/Period" in shown["Table"]


def test_the_command_makes_a_layout_of_a_log(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with WpilogSink(tmp_path / "run.wpilog") as log:
        log.write(RUN)
    output = tmp_path / "new" / "mine.json"
    assert main(["layout", "rebuilt", "--log", str(log.path), "--output", str(output)]) == 0
    assert "File > Import Layout" in capsys.readouterr().out
    shown = tabs(json.loads(output.read_text()))
    sources = shown["3D Field"]["sources"]
    assert sorted(rows(sources)) == sorted(rows(tabs(scope_layout(RUN))["3D Field"]["sources"]))
    models = {source["logKey"]: source["options"]["model"] for source in sources if source["type"] == "robot"}
    assert models["NT:/Sim/Robot/Pose3d"] == "Simcore Rebuilt (red)"
    assert models["NT:/Sim/Robots/2/Robot/Pose3d"] == "Simcore Rebuilt"


def test_an_impossible_layout_is_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["layout", "rebuilt", "--robots", "9", "--output", str(tmp_path / "a.json")]) == 1
    assert "a match of rebuilt has 1 to 6 robots, got 9" in capsys.readouterr().err
    (tmp_path / "file").write_text("")
    with WpilogSink(tmp_path / "run.wpilog") as log:
        log.write(RUN)
    assert main(["layout", "--log", str(log.path), "--output", str(tmp_path / "file" / "a.json")]) == 1
    assert "cannot write the layout" in capsys.readouterr().err
