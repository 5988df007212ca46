"""A robot that drives again what the log of an earlier run has of it: its commands go to its plant, it is no ghost.

A log keeps where the robot was and the volts of its mechanisms. The drivetrain is told the logged velocity, corrected
by how far the robot is off its logged path; motors, tires and contacts do the rest, so who is in the way holds it up.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from simcore.errors import ConfigError, LogError, UnknownNameError
from simcore.geometry.rotation import wrap_angle, yaw_of
from simcore.geometry.symmetry import FieldSymmetry, Pose
from simcore.match.match import Match
from simcore.match.scoring import Alliance
from simcore.robot.robot import Robot
from simcore.robot.robot_config import telemetry_name
from simcore.robot.swerve_drive import SwerveDrive
from simcore.telemetry.snapshot import robot_prefix
from simcore.telemetry.wpilog import TelemetryLog, read_log
from simcore.typing import FloatArray
from simcore.units import TICK

__all__ = ["Recorded", "RecordedRobot"]

# Tried on two autos of 6 s: 8/s leaves the path by 8 cm where it brakes, 15/s by 6 cm, 20/s by 4 cm.
_PULL = 20.0  # [1/s]: an error of 5 cm is answered with 1 m/s
_MOST_PULL = 2.0  # [m/s, rad/s]; who was held up goes on no faster than this
_LEAD = 0.06  # [s] by which a velocity is told ahead: about what a drivetrain's loop lags behind
_CARRIED = 0.3  # [m] in a tick, 15 m/s: people put it elsewhere


class Recorded:
    """What a log has of one robot, from where it was first enabled.

    Args:
        path: Of the log.
        number: Of the robot in it.

    Raises:
        ConfigError: The file cannot be read, or has no such robot.
    """

    def __init__(self, path: Path, number: int = 0) -> None:
        prefix = robot_prefix(number)
        try:
            log = read_log(path)
            column = log.column(f"{prefix}/Robot/Pose3d")
            rows = column.poses()
        except (LogError, UnknownNameError) as error:
            raise ConfigError(f"log {str(path)!r}, robot {number}: {error}") from error
        if not len(rows):
            raise ConfigError(f"log {str(path)!r}, robot {number}: it has no pose")
        self._prefix = prefix
        self.times: FloatArray = column.times
        self.poses: FloatArray = np.column_stack(
            (rows[:, :2], np.unwrap([yaw_of(row[[4, 5, 6, 3]].tolist()) for row in rows]))
        )
        """Field frame [m, m, rad], shape (n, 3)."""
        self.begins = self._first_enabled(log)
        """When it was first enabled [s]."""
        self.is_red = self._is_red(log)
        self._log = log

    def start(self, symmetry: FieldSymmetry) -> Pose:
        """Where it was as it was first enabled, as a blue robot [m, m, rad]."""
        x, y, yaw = self.pose_at(self.begins).tolist()
        return symmetry.flip_pose(x, y, yaw) if self.is_red else (x, y, yaw)

    def pose_at(self, time: float) -> FloatArray:
        """Where it was at a time of its log [m, m, rad]."""
        return np.array([np.interp(time, self.times, self.poses[:, axis]) for axis in range(3)])

    def volts(self, mechanism: str) -> tuple[FloatArray, FloatArray] | None:
        """Times [s] and volts of a mechanism [V]; None: the log has none of that name."""
        key = f"{self._prefix}/Debug/{telemetry_name(mechanism)}VoltageIn"
        return self._log.series(key) if key in self._log.columns else None

    def _first_enabled(self, log: TelemetryLog) -> float:
        if "Sim/Match/Enabled" not in log.columns:
            return float(self.times[0])
        times, on = log.series("Sim/Match/Enabled")
        return float(times[int(np.argmax(on > 0.5))]) if (on > 0.5).any() else float(self.times[0])

    def _is_red(self, log: TelemetryLog) -> bool:
        key = f"{self._prefix}/Robot/IsRed"
        return key in log.columns and bool(len(log.columns[key]) and log.series(key)[1][-1])


class RecordedRobot:
    """The controller that drives a recorded robot again, once it is enabled.

    Args:
        recorded: What it does.
        match: In which it drives.
        alliance: On whose side; the other than the recorded one has it flipped.
    """

    def __init__(self, recorded: Recorded, match: Match, alliance: Alliance) -> None:
        self._recorded, self._symmetry = recorded, match.game.field.symmetry
        self._flips = (alliance == "red") != recorded.is_red
        self._since: float | None = None
        self._volts: dict[str, tuple[FloatArray, FloatArray]] | None = None

    def __call__(self, robot: Robot, time: float) -> None:
        """One tick of robot code."""
        if self._since is None:
            self._since = time
        at = self._recorded.begins + time - self._since
        if self._volts is None:
            found = {name: self._recorded.volts(name) for name in robot.mechanisms}
            self._volts = {name: columns for name, columns in found.items() if columns is not None}
        for name, (times, volts) in self._volts.items():
            row = int(np.searchsorted(times, at + 1e-9)) - 1
            robot.mechanisms[name].set_volts(float(volts[row]) if row >= 0 else 0.0)
        x, y, yaw = robot.chassis.pose
        goal, here, then = self._pose(at - TICK), self._pose(at + _LEAD - TICK), self._pose(at + _LEAD)
        move = (then[0] - here[0], then[1] - here[1])
        if math.hypot(*move) > _CARRIED:
            move = (0.0, 0.0)
        pull = [_pulled(want - have) for want, have in zip(goal[:2], (x, y), strict=True)]
        vx, vy = move[0] / TICK + pull[0], move[1] / TICK + pull[1]
        turn = wrap_angle(then[2] - here[2]) / TICK + _pulled(wrap_angle(goal[2] - yaw))
        c, s = math.cos(yaw), math.sin(yaw)
        drive = robot.drive
        assert isinstance(drive, SwerveDrive)
        drive.set_chassis_speeds(c * vx + s * vy, c * vy - s * vx, turn)

    def _pose(self, time: float) -> Pose:
        x, y, yaw = self._recorded.pose_at(time).tolist()
        return self._symmetry.flip_pose(x, y, yaw) if self._flips else (x, y, yaw)


def _pulled(error: float) -> float:
    return max(-_MOST_PULL, min(_MOST_PULL, _PULL * error))
