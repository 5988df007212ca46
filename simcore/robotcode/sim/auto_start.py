"""Placement of the robot at the start pose of autonomous.

The start pose comes from the test, the robot description file or a pose reset in robot code. A drive team carries the
real robot to the start pose of the auto. Robot code resets the drivetrain's pose to this start pose, either while
disabled or in the first loop of the auto. On a real robot, the reset changes only the estimated pose. In simulation,
this module also moves the robot to the reset pose if the robot is at rest.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping

from simcore import season
from simcore.match.match import Match
from simcore.match.starts import StartError, pose_text
from simcore.robotcode.sim.driver_controls import chosen_autos

RobotState = season.wpilib.RobotState
Timer = season.wpilib.Timer

__all__ = ["AutoStart"]

_log = logging.getLogger(__name__)

Pose = tuple[float, float, float]
Reset = tuple[tuple[float, float] | None, float | None]
"""Position [m] and heading [rad] that robot code has set; None for a value that robot code has not set."""

_WINDOW = 0.5  # time in autonomous during which a reset sets the start; commands run from the first loop [s]
_AT_REST = 0.05  # largest speed of a robot at rest [m/s]
_MOVED = 0.05  # largest distance from the pose at the start of autonomous for a robot at rest [m]
_SAME = 0.02, math.radians(1.0)  # tolerance within which a robot is already at a pose [m, rad]
_SEEN = 0.3, math.radians(15.0)  # tolerance with cameras, whose corrections also reset the pose [m, rad]
_CHOOSER = 25  # number of ticks between two checks of the dashboard's choosers


class AutoStart:
    """Placement of one robot at the start pose of each autonomous period.

    Args:
        match: Match that contains the robot.
        number: Index of the robot in the match.
        starts: Start poses by auto name, for the blue alliance, field frame [m, m, rad].
        believed: Function that returns robot code's estimated pose, field frame [m, m, rad]; None if unknown.
    """

    def __init__(
        self, match: Match, number: int, starts: Mapping[str, Pose], *, believed: Callable[[], Pose | None]
    ) -> None:
        self._match = match
        self._number = number
        self._robot = match.robots[number]
        self.starts = starts
        """Start poses by auto name, for the blue alliance, field frame [m, m, rad]."""
        self._believed = believed
        self._given: Pose | None = None
        self._chosen: str | None = None
        self._wanted: Reset | None = None  # reset in the first loops of the auto
        self._seeded: Reset | None = None  # reset while disabled
        self._since: float | None = None
        self._found: Pose = self._robot.chassis.pose
        self._is_open = False
        self._was_enabled = False
        self._ticks = 0

    def place(self, pose: Pose) -> None:
        """Place the robot at a pose, field frame [m, m, rad], and ignore later pose resets in robot code.

        Raises:
            StartError: The pose is off the field or obstructed.
        """
        self._match.carry_to(self._number, pose)
        self.note_place(pose)

    def note_place(self, pose: Pose | None) -> None:
        """Record the pose at which a test has placed the robot, field frame [m, m, rad].

        Later pose resets in robot code do not move the robot. None allows these resets again.
        """
        self._given = pose
        self._is_open = False

    def keep_place(self) -> None:
        """Move the robot back to the pose from the test after a change of alliance has moved the robot.

        Without such a pose, the next check of the auto chooser places the robot at the new alliance's start.
        """
        if self._given is not None:
            self._match.carry_to(self._number, self._given)
        self._chosen = None

    def see_reset(self, position: tuple[float, float] | None, heading: float | None) -> None:
        """Record a pose reset in robot code while disabled or at the start of autonomous.

        Args:
            position: New estimated position, field frame [m]; None for an unchanged position.
            heading: New estimated heading [rad]; None for an unchanged heading.
        """
        self._note_mode()
        if RobotState.is_disabled():
            before, turned = self._seeded or (None, None)
            self._seeded = (position or before, turned if heading is None else heading)
        elif self._is_open and not RobotState.is_fms_attached():
            before, turned = self._wanted or (None, None)
            if before is None:  # only the first position counts; a heading may be set before the position
                self._wanted = (position, turned if heading is None else heading)

    def before_tick(self) -> None:
        """Place the robot at the file's start pose for the chosen auto, or at robot code's reset pose for autonomous.

        If the robot cannot stand at the reset pose, the robot does not move, and the match records the reason.
        """
        self._note_mode()
        self._follow_chooser()
        position, heading = self._wanted or (None, None)
        self._wanted, is_of_auto = None, position is not None
        if not is_of_auto:
            position, seeded = self._kept_seed()
            heading = seeded if heading is None else heading
        if RobotState.is_enabled():
            self._seeded = None
        if (position is None and heading is None) or not self._is_open:
            return
        self._is_open = not is_of_auto
        x, y, yaw = self._robot.chassis.pose
        goal = (*(position or (x, y)), yaw if heading is None else math.remainder(heading, math.tau))
        has_cameras = any(camera.robot == self._number for camera in self._match.cameras.cameras.values())
        near, turned = _SEEN if has_cameras else _SAME
        if math.dist(goal[:2], (x, y)) < near and abs(math.remainder(goal[2] - yaw, math.tau)) < turned:
            return
        try:
            self._match.carry_to(self._number, goal, by_people=True)
        except StartError as error:
            self._match.beliefs.reasons[self._number] = (
                f"robot code has set {pose_text(goal)}; there it {error.problem}"
            )
            return
        self._found = self._robot.chassis.pose
        _log.info(
            "the auto begins at %s, because robot code has set that pose: the robot is placed there", pose_text(goal)
        )

    # --- internals ----------------------------------------------------------------------------------------------------

    def _note_mode(self) -> None:
        """Place the robot, or open the time window for pose resets, when autonomous begins.

        A pose from the test keeps the robot in place and the window closed. Otherwise, if the file has a start pose for
        the chosen auto, the method places the robot at this pose and keeps the window closed. An open window closes
        after 0.5 s, when the robot moves, or when autonomous ends.
        """
        is_auto = RobotState.is_autonomous_enabled()
        if not is_auto:
            self._since = None
            self._is_open = False
            self._was_enabled |= RobotState.is_enabled()
            return
        now = float(Timer.get_monotonic_timestamp())
        if self._since is None:
            self._since = now
            self._found = self._robot.chassis.pose
            self._is_open = self._given is None and not self._place_chosen() and self._is_at_rest()
        elif now - self._since > _WINDOW or not self._is_at_rest():
            self._is_open = False

    def _kept_seed(self) -> Reset:
        """Return the pose reset that robot code made while disabled, if the estimated pose is still near the reset.

        The method returns (None, None) if the reset has no position or the window is closed.
        """
        position, heading = self._seeded or (None, None)
        if position is None or not self._is_open or RobotState.is_fms_attached():
            return None, None
        believed = self._believed()
        is_kept = believed is None or math.dist(believed[:2], position) < _SEEN[0]
        return (position, heading) if is_kept else (None, None)

    def _is_at_rest(self) -> bool:
        chassis = self._robot.chassis
        return chassis.speed < _AT_REST and math.dist(chassis.pose[:2], self._found[:2]) < _MOVED

    def _follow_chooser(self) -> None:
        """Move the robot to the file's start pose for the chosen auto, every 25 ticks before the first enable."""
        self._ticks += 1
        if self._was_enabled or self._given is not None or not self.starts or self._ticks % _CHOOSER:
            return
        if RobotState.is_disabled():
            self._place_chosen(again=False)

    def _place_chosen(self, *, again: bool = True) -> bool:
        """Place the robot at the file's start pose for the chosen auto; return whether the file has this start pose.

        Args:
            again: Whether to place the robot even if the chosen auto is unchanged.
        """
        if self._since is not None:
            self._was_enabled = True
        name = next((auto for auto in chosen_autos() if auto in self.starts), None) if self.starts else None
        if name is None:
            return False
        if again or name != self._chosen:
            self._chosen = name
            pose = self.starts[name]
            if self._match.alliances[self._number] == "red":
                pose = self._match.game.field.symmetry.flip_pose(*pose)
            if math.dist(pose[:2], self._robot.chassis.pose[:2]) > _SAME[0] or again:
                self._match.carry_to(self._number, pose, by_people=True)
                self._found = self._robot.chassis.pose
                _log.info("auto %r starts at %s, as the file says", name, pose_text(pose))
        return True
