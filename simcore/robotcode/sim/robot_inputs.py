"""Exchange of driver station data between a match and robot code, and a field map for the simulation GUI."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping
from typing import Any

from simcore import season
from simcore.match.clock import Mode
from simcore.match.match import Match
from simcore.typing import FloatArray
from simcore.units import plain_sum

MatchState = season.wpilib.MatchState
RobotState = season.wpilib.RobotState
DriverStationSim = season.wpilib_simulation.DriverStationSim
Pose2d = season.wpimath.Pose2d
Rotation2d = season.wpimath.Rotation2d

__all__ = ["DriverStationLink", "FieldView"]

_log = logging.getLogger(__name__)


class DriverStationLink:
    """Link between a match and WPILib's driver station, in place of the field management system (FMS).

    The match receives the enabled mode and the alliance. Robot code receives the match time and game data, unless an
    FMS is attached.

    The link resets the field for a new match when autonomous starts, if the robot has been enabled since the last field
    reset and no FMS is attached.

    Args:
        match: Match whose clock follows the driver station.
        number: Index of the driver station's robot in the match.
        placed: Function to call after the robot has moved to the start of a new alliance.
    """

    def __init__(self, match: Match, number: int, *, placed: Callable[[], object] = lambda: None) -> None:
        self._match = match
        self._placed = placed
        self._number = number
        self._mode: Mode = "disabled"
        self._shown = -1.0
        self._message = ""
        self._color: Any = None
        self._was_enabled = False
        self._played_after = -1  # number of field resets when the robot was last enabled
        match.timer.follow_driver_station()

    def update(self) -> None:
        """Copy mode and alliance to the match, and match time and game data to robot code, at the end of a tick.

        With an FMS attached, the method does not write match time and game data.
        """
        self._follow_alliance()
        is_enabled = RobotState.is_enabled()
        self._match.timer.set_enabled(is_enabled)
        mode: Mode = "disabled"
        if is_enabled:
            mode = "auto" if RobotState.is_autonomous() else "teleop"
        if mode != self._mode:
            self._mode = mode
            if mode == "auto":
                self._begin_match()
            if mode != "disabled":
                self._match.start_mode(mode)
        if is_enabled:
            self._played_after = self._match.field_resets
        if not RobotState.is_fms_attached():
            self._show_time()
            self._send(self._match.rules.game_data())

    def _begin_match(self) -> None:
        """Reset the field if the robot has been enabled since the last field reset and no FMS is attached."""
        if self._played_after == self._match.field_resets and not RobotState.is_fms_attached():
            self._match.reset_field()
            _log.info("autonomous begins again: pieces and preloads are back where they are at the start of a match")

    def _follow_alliance(self) -> None:
        """Apply a change of alliance before the first enable. The change moves the robot to the alliance's start."""
        if self._was_enabled:
            return
        self._was_enabled = RobotState.is_enabled()  # the first packet with the alliance may also enable the robot
        color = MatchState.get_alliance()
        if color is not None and color != self._color:
            self._color = color
            self._match.set_alliance(self._number, "red" if color == season.wpilib.Alliance.RED else "blue")
            self._placed()

    def _show_time(self) -> None:
        """Send robot code the remaining time of the mode in whole seconds, as on a real field; -1 while disabled."""
        left = -1.0
        if self._mode != "disabled":
            timer = self._match.timer
            length = plain_sum(phase.duration for phase in timer.clock.phases if phase.mode == self._mode)
            elapsed = timer.time - timer.clock.start_of_mode(self._mode)
            left = max(0.0, length - math.floor(elapsed + 1e-9))
        if left != self._shown:
            self._shown = left
            DriverStationSim.set_match_time(left)
            DriverStationSim.notify_new_data()  # otherwise robot code continues to read the old time

    def _send(self, message: str) -> None:
        """Send new game data to robot code, unless a user or test has set other game data in the driver station."""
        if message == self._message:
            return
        if MatchState.get_game_data() == self._message:
            DriverStationSim.set_game_data(message)
            DriverStationSim.notify_new_data()
        self._message = message


class FieldView:
    """Field map in the simulation GUI, with the robot's true pose and all game pieces.

    By default, the map updates the pieces five times per second, which is enough for a dashboard.

    Args:
        field: `Field2d` to draw on.
        every: Number of ticks between two updates of the pieces.
    """

    def __init__(self, field: Any, *, every: int = 10) -> None:
        self._field = field
        self._every = every
        self._ticks = 0
        self._level = Rotation2d()

    def update(self, pose: tuple[float, float, float], pieces: Mapping[str, FloatArray]) -> None:
        """Draw the robot's true pose each tick, and the pieces every `every` ticks.

        Args:
            pose: True pose of the robot, field frame [m, m, rad].
            pieces: Positions of the pieces, field frame [m], shape (n, 3), by name of the kind.
        """
        x, y, yaw = pose
        self._field.set_robot_pose(Pose2d(x, y, Rotation2d(yaw)))
        if self._ticks % self._every == 0:
            for name, positions in pieces.items():
                poses = [Pose2d(px, py, self._level) for px, py, _ in positions.tolist()]
                self._field.get_object(name).set_poses(poses)
        self._ticks += 1
