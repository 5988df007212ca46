"""Where the robot truly stands as autonomous begins: where the test or the file says, else where the auto says.

A drive team carries the robot to where its auto begins. The auto itself says where that is: with its first loop it
sets the drivetrain's pose anew. That moves belief, never a robot; here the robot is put there too, while it stands.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping

from wpilib import DriverStation, Timer

from simcore.match.match import Match
from simcore.match.starts import StartError, require_free_place
from simcore.robotpy.driver_controls import chosen_autos

__all__ = ["AutoStart"]

_log = logging.getLogger(__name__)

Pose = tuple[float, float, float]

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
    """

    def __init__(self, match: Match, number: int, starts: Mapping[str, Pose]) -> None:
        self._match = match
        self._number = number
        self._robot = match.robots[number]
        self.starts = starts
        """Of autos by name; see the arguments."""
        self._given: Pose | None = None
        self._chosen: str | None = None
        self._wanted: tuple[tuple[float, float] | None, float | None] | None = None
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
        self._require_free(pose)
        self.note_place(pose)
        self._match.carry_to(self._number, pose)

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
        """Robot code has set its drivetrain's pose anew; see `simcore.phoenix6.pose_resets.PoseReset`."""
        self._note_mode()
        if not self._is_open or DriverStation.isFMSAttached():
            return
        before, _ = self._wanted or (None, None)
        if before is None:  # the first one; the heading may have been set before the position
            self._wanted = (position, heading if heading is not None else self._wanted and self._wanted[1])

    def before_tick(self) -> None:
        """Put the robot where a reset of the last robot loop, or the file's start of the chosen auto, says."""
        self._note_mode()
        self._follow_chooser()
        wanted, self._wanted = self._wanted, None
        if wanted is None or not self._is_open:
            return
        position, heading = wanted
        x, y, yaw = self._robot.chassis.pose
        goal = (*(position or (x, y)), yaw if heading is None else math.remainder(heading, math.tau))
        if position is not None:
            self._is_open = False
        near, turned = _SEEN if self._robot.config.cameras else _SAME
        if math.dist(goal[:2], (x, y)) < near and abs(math.remainder(goal[2] - yaw, math.tau)) < turned:
            return
        try:
            self._require_free(goal)
        except StartError as error:
            _log.warning(
                "the auto begins at %s, but there the robot %s: it stays where it is", _text(goal), error.problem
            )
            return
        self._match.carry_to(self._number, goal, by_people=True)
        self._found = self._robot.chassis.pose
        _log.info("the auto begins at %s, as it has reset its odometry: the robot is carried there", _text(goal))

    # --- inside ---------------------------------------------------------------------------------------------------

    def _note_mode(self) -> None:
        """Open the window with autonomous, and close it when it is over or the robot moves."""
        is_auto = DriverStation.isAutonomousEnabled()
        if not is_auto:
            self._since = None
            self._is_open = False
            self._was_enabled |= DriverStation.isEnabled()
            return
        now = float(Timer.getFPGATimestamp())
        if self._since is None:
            self._since = now
            self._found = self._robot.chassis.pose
            self._is_open = self._given is None and not self._place_chosen() and self._is_at_rest()
        elif now - self._since > _WINDOW or not self._is_at_rest():
            self._is_open = False

    def _is_at_rest(self) -> bool:
        chassis = self._robot.chassis
        return chassis.speed < _AT_REST and math.dist(chassis.pose[:2], self._found[:2]) < _MOVED

    def _follow_chooser(self) -> None:
        """Before the first enable: the drive team carries the robot to the start of the auto that it chooses."""
        self._ticks += 1
        if self._was_enabled or self._given is not None or not self.starts or self._ticks % _CHOOSER:
            return
        if DriverStation.isDisabled():
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
                _log.info("auto %r starts at %s, as the file says", name, _text(pose))
        return True

    def _require_free(self, pose: Pose) -> None:
        size = self._match.game.field.size
        require_free_place(self._match.world, self._robot, pose, size)


def _text(pose: Pose) -> str:
    return f"({pose[0]:.2f}, {pose[1]:.2f}) m, {math.degrees(pose[2]):.0f} deg"
