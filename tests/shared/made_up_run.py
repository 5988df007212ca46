"""Made-up run: one robot on a circle with a wrong pose estimate, and pieces that lie, roll, fly or are held."""

import math

import numpy as np

from simcore.show.scene import Goal, PieceLook, RobotLook, Scene
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
    goals=(Goal(alliance="", center=(4.0, 3.0, 0.9)), Goal(alliance="blue", center=(3.0, 1.0, 0.9))),
)


def places(time: float) -> np.ndarray:
    """Return a grid of ten by ten pieces 0.2 m apart; the first row rolls, and the first piece is in the air."""
    x, y = np.meshgrid(np.arange(10) * 0.2 + 5.5, np.arange(10) * 0.2 + 1.0)
    rows = np.column_stack((x.ravel(), y.ravel(), np.full(PIECES, 0.075)))
    rows[:10, 1] -= 0.5 * time
    rows[0, 2] = 1.0
    return rows


SHOTS = {2000: (0.4, 0.2, True), 2001: (0.6, 0.1, False)}
"""Start and duration of each flight [s], and whether it scored, by piece."""
HELD = (0.1, -0.2)
"""Position of a held piece, forward and left of the robot's center [m]."""


def flight(time: float, start: float) -> np.ndarray:
    """Return the pose on a flight along x at 5 m/s, starting upward at 3 m/s."""
    t = time - start
    return np.array((3.0 + 5.0 * t, 3.0, 0.5 + 3.0 * t - 0.5 * 9.80665 * t * t, 1.0, 0.0, 0.0, 0.0))


def held(time: float) -> np.ndarray:
    (x, y, *_), yaw = pose(time), 0.8 * time
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.array((x + cos * HELD[0] - sin * HELD[1], y + sin * HELD[0] + cos * HELD[1], 0.3, *pose(time)[3:]))


def pose(time: float) -> np.ndarray:
    yaw = 0.8 * time
    return np.array((2.5 + math.sin(yaw), 2.0 - math.cos(yaw), 0.0, math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)))


def snapshot(tick: int) -> Snapshot:
    time = 0.02 * (tick + 1)
    fuel = np.zeros((PIECES, 7))
    fuel[:, :3], fuel[:, 3] = places(time), 1.0
    flying = [
        (piece, start) for piece, (start, lasts, _) in SHOTS.items() if start - 1e-9 < time < start + lasts + 1e-9
    ]
    shot = [(piece, start, lasts, hit) for piece, (start, lasts, hit) in SHOTS.items() if start < time + 1e-9]
    return Snapshot(
        time=time,
        tick=tick,
        poses={
            "Sim/Robot/Pose3d": pose(time),
            "Sim/Robot/EstimatedPose": pose(time) + np.array([0.3, 0.4, 0, 0, 0, 0, 0]),
        },
        pose_arrays={
            "Sim/GamePieces/Fuel": fuel,
            "Sim/InFlight/Fuel": np.array([fuel[0], *(flight(time, start) for _, start in flying)]),
            "Sim/Held/Fuel": held(time)[None],
        },
        doubles={"Sim/Debug/BatteryVoltage": 12.0 - time, "Sim/Debug/BatteryCurrent": 40.0 * time},
        integers={"Sim/Score/Blue": tick // 10, "Sim/Score/Red": 0, "Sim/Intake/HeldCount": 1},
        booleans={"Sim/Robot/IsAirborne": tick > 20},
        integer_arrays={
            "Sim/PieceIds/Fuel": np.arange(PIECES) + 1000,
            "Sim/InFlightIds/Fuel": np.array([1000, *(piece for piece, _ in flying)], dtype=np.int64),
            "Sim/HeldIds/Fuel": np.array([3000]),
            "Sim/NewestShots": np.array(
                [(k, piece, 0, round(start / 0.02)) for k, (piece, start, *_) in enumerate(shot, 1)], dtype=np.int64
            ).ravel(),
            "Sim/NewestHits": np.array(
                [(1, k) for k, (_, start, lasts, hit) in enumerate(shot, 1) if hit and time > start + lasts],
                dtype=np.int64,
            ).ravel(),
            "few": np.arange(tick % 3),
        },
        strings={"Sim/Match/Period": "auto" if tick < 4 else "teleop"},
    )


def recorded(ticks: int = 50, **options: float) -> Recording:
    recording = Recording(**options)
    for tick in range(ticks):
        if recording.due(0.02 * (tick + 1)):
            recording.write(snapshot(tick))
    return recording
