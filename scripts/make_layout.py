"""Writes models/advantagescope/layout.json: AdvantageScope's tabs for REBUILT, live and for a log.

    python scripts/make_layout.py [FILE.json]

One layout serves both, for both call the keys `NT:/Sim/...`. Load it with File > Import Layout.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from games.rebuilt.fuel import FUEL

OUTPUT = Path(__file__).resolve().parents[1] / "models" / "advantagescope" / "layout.json"
ROBOT_NAME, FIELD_NAME = "Simcore Rebuilt", "Simcore REBUILT"
"""As in the config.json files that scripts/make_models.py writes."""

CAMERAS = ("limelight-two", "limelight-five", "limelight-one")
"""Lines of these appear once cameras publish them."""

SCORES = {"Sim/Score/Blue": "#2b66a2", "Sim/Score/Red": "#af2437"}
COUNTS = {"Sim/Intake/HeldCount": "#e5b31b", "Sim/Shots": "#80588e", "Sim/Hits": "#3b875a"}
SHOOTER = {
    "Sim/Debug/ShooterVelocityRPS": "#e48b32",
    "Sim/Debug/FeederVelocityRPS": "#2b66a2",
    "Sim/Debug/SpindexerVelocityRPS": "#3b875a",
    "Sim/Debug/IntakeRollerVelocityRPS": "#80588e",
}
TABLE = (
    "Sim/Match/Time", "Sim/Match/TimeLeft", "Sim/Match/Period", "Sim/Match/Enabled", "Sim/Match/BlueHubActive",
    "Sim/Match/RedHubActive", "Sim/Score/Blue", "Sim/Score/Red", "Sim/Score/BlueHub", "Sim/Score/RedHub",
    "Sim/Shots", "Sim/Hits", "Sim/Intake/HeldCount", "Sim/Debug/BatteryVoltage", "Sim/Robot/GroundClearance",
    "Sim/Robot/IsAirborne", "Sim/Debug/IntakeDeployExtendedPct", "Sim/Performance/TickMs",
    "Sim/Performance/AwakePieces",
)  # fmt: skip


def key(name: str) -> str:
    """As AdvantageScope calls it, live and in our logs."""
    return f"NT:/{name}"


def thing(kind: str, name: str, log_type: str, **options: str) -> dict[str, Any]:
    """Something on the 3D field."""
    return {"type": kind, "logKey": key(name), "logType": log_type, "visible": True, "options": options}


def line(name: str, color: str, *, log_type: str = "Number", kind: str = "stepped") -> dict[str, Any]:
    """A line of a graph."""
    options = {"color": color, "size": "normal"}
    return {"type": kind, "logKey": key(name), "logType": log_type, "visible": True, "options": options}


def tab(kind: int, title: str, controller: Any, *, height: int = 200, renderer: Any = None) -> dict[str, Any]:
    """A tab; the numbers of the kinds are AdvantageScope's."""
    uuid = "simcore-" + title.lower().replace(" ", "-")
    return {
        "type": kind,
        "title": title,
        "controller": controller,
        "controllerUUID": uuid,
        "renderer": renderer,
        "controlsHeight": height,
    }


def graph(
    title: str,
    left: dict[str, str],
    right: dict[str, str],
    *,
    left_range: tuple[float, float] | None = None,
    discrete: dict[str, str] | None = None,
) -> dict[str, Any]:
    """A line graph with two axes."""
    plain = {"autoTarget": None, "preset": None}
    flags = (discrete or {}).items()
    controller = {
        "leftSources": [line(name, color) for name, color in left.items()],
        "rightSources": [line(name, color) for name, color in right.items()],
        "discreteSources": [line(name, color, log_type="Boolean", kind="stripes") for name, color in flags],
        "leftLockedRange": None if left_range is None else list(left_range),
        "rightLockedRange": None,
        "leftUnitConversion": plain,
        "rightUnitConversion": plain,
        "leftFilter": 0,
        "rightFilter": 0,
    }
    return tab(1, title, controller, height=220)


def layout() -> dict[str, Any]:
    """The whole file."""
    things = [
        thing("robot", "Sim/Robot/Pose3d", "Pose3d", model=ROBOT_NAME),
        thing("component", "Sim/Robot/ComponentPoses", "Pose3d[]"),  # a child of the robot before it
        thing("gamePiece", f"Sim/GamePieces/{FUEL.name}", "Pose3d[]", variant=FUEL.name),
        thing("gamePiece", f"Sim/Held/{FUEL.name}", "Pose3d[]", variant=FUEL.name),
        *(
            thing("trajectory", f"Sim/Limelights/{name}/DirectionLine", "Pose3d[]", color="#00c080", size="normal")
            for name in CAMERAS
        ),
    ]
    view = {"cameraIndex": -1, "orbitFov": 50, "cameraPosition": [0, 9, 10.5], "cameraTarget": [0, 0.5, 0]}
    tabs = [
        tab(3, "3D Field", {"game": f"FRC:{FIELD_NAME}", "sources": things}, renderer=view),
        graph("Score", SCORES, COUNTS),
        graph("Battery", {"Sim/Debug/BatteryVoltage": "#e48b32"}, {}, left_range=(6.0, 13.5)),
        graph("Tick time", {"Sim/Performance/TickMs": "#2b66a2"}, {"Sim/Performance/AwakePieces": "#aaaaaa"}),
        graph(
            "Shooter",
            SHOOTER,
            {"Sim/Debug/HoodAngleDeg": "#af2437"},
            discrete={"Sim/Debug/ShootingGateOpen": "#3b875a", "Sim/Debug/IntakeZoneActive": "#e5b31b"},
        ),
        tab(4, "Table", [key(name) for name in TABLE]),
    ]
    expanded = ["/Sim", "/Sim/Robot", "/Sim/Score", "NT:", "NT:/Sim", "NT:/Sim/Robot", "NT:/Sim/Score"]
    state = {"sidebar": {"width": 300, "expanded": expanded}, "tabs": {"selected": 0, "tabs": tabs}}
    hub = {"x": 60, "y": 60, "width": 1400, "height": 900, "state": state}
    return {"version": "26.0.2", "hubs": [hub], "satellites": []}


def main() -> int:
    """Write the file."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("file", nargs="?", type=Path, default=OUTPUT, help="default: %(default)s")
    output: Path = parser.parse_args().file
    output.write_text(json.dumps(layout(), indent=1) + "\n", encoding="utf-8", newline="\n")
    print(output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
