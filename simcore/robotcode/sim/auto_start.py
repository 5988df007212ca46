"""Where the robot truly stands as autonomous begins: where the test or the file says, else where the auto says.

A drive team carries the robot to where its auto begins. Robot code itself says where that is: before the robot is
enabled, or with the auto's first loop, it sets the drivetrain's pose anew. That moves belief, never a robot; here the
robot is put there too, while it stands.
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
"""Position [m] and heading [rad] that robot code has set; None is what stays."""

_WINDOW = 0.5  # [s] of autonomous in which a reset says where it begins; its commands are scheduled in its first loop
_AT_REST = 0.05  # [m/s]
_MOVED = 0.05  # [m]; so far from where autonomous has found it the robot is on its way
_SAME = 0.02, math.radians(1.0)  # a robot that stands so near stands there
_SEEN = 0.3, math.radians(15.0)  # the same where cameras tell it: such a reset is a correction
_CHOOSER = 25  # ticks between two looks at the dashboard's choosers


class AutoStart:
    """Puts one robot where its autonomous begins, each time that it is enabled.

    Args:
        match: With the robot on its field.
        number: Of the robot.
        starts: Of autos by name, as a blue robot [m, m, rad].
        believed: Where robot code believes to be now, field frame [m, m, rad]; None: nobody knows.
    """

    def __init__(
        self, match: Match, number: int, starts: Mapping[str, Pose], *, believed: Callable[[], Pose | None]
    ) -> None:
        self._match = match
        self._number = number
        self._robot = match.robots[number]
        self.starts = starts
        """Of autos by name; see the arguments."""
        self._believed = believed
        self._given: Pose | None = None
        self._chosen: str | None = None
        self._wanted: Reset | None = None  # by the auto, in its first loops
        self._seeded: Reset | None = None  # while disabled
        self._since: float | None = None
        self._found: Pose = self._robot.chassis.pose
        self._is_open = False
        self._was_enabled = False
        self._ticks = 0

    def place(self, pose: Pose) -> None:
        """Put the robot there, and leave it there whatever resets say [m, m, rad].

        Raises:
            StartError: It is not on the field, or not free.
        """
        self._match.carry_to(self._number, pose)
        self.note_place(pose)

    def note_place(self, pose: Pose | None) -> None:
        """Somebody has put the robot there [m, m, rad], where it stays; None: at its start, as if nobody had."""
        self._given = pose
        self._is_open = False

    def keep_place(self) -> None:
        """The alliance has changed, and with it the start: a place that was given stays."""
        if self._given is not None:
            self._match.carry_to(self._number, self._given)
        self._chosen = None

    def see_reset(self, position: tuple[float, float] | None, heading: float | None) -> None:
        """Robot code has set its drivetrain's pose anew; see `simcore.robotcode.program.program_odometry.PoseReset`."""
        self._note_mode()
        if RobotState.is_disabled():
            before, turned = self._seeded or (None, None)
            self._seeded = (position or before, turned if heading is None else heading)
        elif self._is_open and not RobotState.is_fms_attached():
            before, turned = self._wanted or (None, None)
            if before is None:  # the first one; the heading may have been set before the position
                self._wanted = (position, turned if heading is None else heading)

    def before_tick(self) -> None:
        """Put the robot where a reset of the last robot loop, or the file's start of the chosen auto, says."""
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
        _log.info("the auto begins at %s, as robot code has set its pose: the robot is carried there", pose_text(goal))

    # --- inside ---------------------------------------------------------------------------------------------------

    def _note_mode(self) -> None:
        """Open the window with autonomous, and close it when it is over or the robot moves."""
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
        """What was set while disabled, as autonomous begins, unless cameras have led belief away from it since."""
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
        """Before the first enable: the drive team carries the robot to the start of the auto that it chooses."""
        self._ticks += 1
        if self._was_enabled or self._given is not None or not self.starts or self._ticks % _CHOOSER:
            return
        if RobotState.is_disabled():
            self._place_chosen(again=False)

    def _place_chosen(self, *, again: bool = True) -> bool:
        """Put the robot where the file lets the chosen auto start; returns whether it says so."""
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
