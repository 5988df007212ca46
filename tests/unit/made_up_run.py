"""A made-up run: one robot that drives in a circle, pieces that stand, roll or fly, and a score."""

from __future__ import annotations

import math

import numpy as np

from simcore.show.scene import PieceLook, RobotLook, Scene, ShotTrace
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot

PIECES = 100
SCENE = Scene(
    field_size=(8.0, 4.0),
    field_outlines=[
        ("blue_hub", np.array([[1.0, 1.0], [1.5, 1.0], [1.5, 1.5], [1.0, 1.5]])),
        ("box <1>", np.eye(3, 2)),
    ],
    robots=(RobotLook(alliance="red", bumpers=(0.8, 0.8)),),
    pieces={"Fuel": PieceLook(radius=0.075, color="#ffd923", air_color="#ff9800", edge_color="#7d6400")},
    shots=(
        ShotTrace(points=np.array([[3.0, 1.0, 0.5], [3.5, 1.0, 1.0], [4.0, 1.0, 0.9]]), scored=True, time=0.4),
        ShotTrace(points=np.array([[3.0, 1.0, 0.5], [3.0, 3.0, 0.1]]), scored=False, time=0.6),
    ),
    intakes=np.array([[2.0, 2.0, 0.08]]),
)


def places(time: float) -> np.ndarray:
    """Ten by ten, a fifth of a meter apart; the first row rolls, and the first of all flies."""
    x, y = np.meshgrid(np.arange(10) * 0.2 + 5.5, np.arange(10) * 0.2 + 1.0)
    rows = np.column_stack((x.ravel(), y.ravel(), np.full(PIECES, 0.075)))
    rows[:10, 1] -= 0.5 * time
    rows[0, 2] = 1.0
    return rows


def pose(time: float) -> np.ndarray:
    yaw = 0.8 * time
    return np.array((2.5 + math.sin(yaw), 2.0 - math.cos(yaw), 0.0, math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)))


def snapshot(tick: int) -> Snapshot:
    time = 0.02 * (tick + 1)
    fuel = np.zeros((PIECES, 7))
    fuel[:, :3], fuel[:, 3] = places(time), 1.0
    return Snapshot(
        time=time,
        tick=tick,
        poses={"Sim/Robot/Pose3d": pose(time)},
        pose_arrays={"Sim/GamePieces/Fuel": fuel},
        doubles={"Sim/Debug/BatteryVoltage": 12.0 - time, "Sim/Debug/BatteryCurrent": 40.0 * time},
        integers={"Sim/Score/Blue": tick // 10, "Sim/Score/Red": 0, "Sim/Intake/HeldCount": 3},
        booleans={"Sim/Robot/IsAirborne": tick > 20},
        integer_arrays={"Sim/PieceIds/Fuel": np.arange(PIECES) + 1000, "few": np.arange(tick % 3)},
        strings={"Sim/Match/Period": "auto" if tick < 4 else "teleop"},
    )


def recorded(ticks: int = 50, **options: float) -> Recording:
    recording = Recording(**options)
    for tick in range(ticks):
        if recording.due(0.02 * (tick + 1)):
            recording.write(snapshot(tick))
    return recording
