"""Snapshots in which every value follows from the tick."""

import numpy as np
import pytest

from simcore.telemetry.snapshot import Snapshot


def make_snapshot(tick: int, *, pieces: int = 504, dt: float = 0.02) -> Snapshot:
    """Return a snapshot whose every value follows from its tick."""
    rows = np.zeros((pieces, 7))
    rows[:, 0] = np.arange(pieces) + 0.001 * tick
    rows[:, 1] = -tick
    rows[:, 3] = 1.0
    return Snapshot(
        time=(tick + 1) * dt,
        tick=tick,
        poses={"Sim/Robot/Pose3d": np.array([1.0 + tick, 2.0, 0.0, np.cos(0.5), 0.0, 0.0, np.sin(0.5)])},
        pose_arrays={"Sim/GamePieces/Fuel": rows, "Sim/Robot/ComponentPoses": np.empty((0, 7))},
        doubles={"Sim/Robot/GroundClearance": 0.01 * tick, "Sim/Debug/HoodAngleDeg": 25.0},
        integers={"Sim/Score/Total": tick // 5},
        booleans={"Sim/Robot/IsAirborne": tick % 10 == 9},
        integer_arrays={
            "Sim/PieceIds/Fuel": np.arange(pieces) + tick // 8,
            "Sim/PieceIds/Held": np.empty(0, dtype=np.int64),
        },
        strings={"Sim/Match/Period": ("auto", "Übergang")[tick // 15]},
    )


@pytest.fixture
def snapshots() -> list[Snapshot]:
    return [make_snapshot(tick) for tick in range(20)]
