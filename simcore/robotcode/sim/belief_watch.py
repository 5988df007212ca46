"""Check of a program's odometry while driving, with one warning that states the likely cause of an error.

The check compares three paths since the last pose reset: the program's estimate, the path from wheels and gyro
(including slip), and the true path. Slip causes a difference between the last two paths. Only an error in the program
or in the robot description causes a difference between the estimate and both other paths. The comparison also restarts
if the robot is carried or the program zeroes the gyro. For a robot with cameras, only the growth of the error counts.
"""

from __future__ import annotations

import cmath
import logging
import math
from collections.abc import Callable
from dataclasses import dataclass

from simcore.robot.robot import Robot
from simcore.world.symmetry import Pose

__all__ = ["BeliefError", "BeliefWatch"]

_log = logging.getLogger(__name__)

_APART = 0.4  # smallest position error that is reported [m]
_SHARE = 0.15  # smallest position error as a fraction of the travel, because real calibrations are this inaccurate [-]
_TURNED = 0.5 * math.pi  # smallest heading error that is reported [rad]
_TURNED_WRONG = 0.5  # smallest heading error if the estimate consistently turns by a wrong ratio [rad]
_SETTLES = 5  # number of ticks until the estimate shows a reset
_CARRIED = 0.25, 0.3  # motion in one tick that only a carried robot can make [m, rad]
_RESTS = 0.002  # largest true rotation in one tick at which a jump of the estimated heading is a reset [rad]
_LEAST_TURN = 0.2  # smallest sum of rotations from which the sign can be judged [rad]
_TRIVIAL = 0.1  # smallest travel from which directions can be judged [m]


@dataclass(frozen=True, slots=True)
class BeliefError:
    """Error of a program's estimated pose relative to the true pose."""

    position: float
    """Distance between estimated and true position [m]."""
    heading: float
    """Estimated minus true heading, wrapped to -pi..pi [rad]."""


class BeliefWatch:
    """Check that compares one robot's estimated motion with the wheel odometry and the true motion each tick.

    Args:
        robot: Robot whose `estimated_pose` the program updates.
        sees: Function that returns whether cameras may correct the program's pose.
        why_still: Function that returns a sentence with the reason why the program's pose does not move; empty if
            unknown.
    """

    def __init__(
        self, robot: Robot, *, sees: Callable[[], bool] = lambda: False, why_still: Callable[[], str] = lambda: ""
    ) -> None:
        self._robot = robot
        self._has_cameras = sees
        self._why_still = why_still
        self._is_reported = False
        self._settles = _SETTLES
        self._last: tuple[Pose, Pose, Pose] | None = None  # estimated, by sensors, true

    @property
    def error(self) -> BeliefError:
        """Error of the program's estimate, or of the simulated odometry if the program has no estimate."""
        believed, true = self._robot.believed_pose, self._robot.chassis.pose
        return BeliefError(math.dist(believed[:2], true[:2]), math.remainder(believed[2] - true[2], math.tau))

    def note_reset(self) -> None:
        """Restart the comparison after a pose reset by the program."""
        self._settles = _SETTLES

    def after_tick(self, *, is_driving: bool) -> None:
        """Compare the paths at the end of a tick, and log a warning for the first error.

        Args:
            is_driving: Whether the robot is enabled. The check ignores errors while disabled.
        """
        believed = self._robot.estimated_pose
        if self._is_reported or believed is None:
            return
        poses = believed, self._robot.odometry.pose, self._robot.chassis.pose
        last = self._last
        if last is None or self._settles or not is_driving or _was_set(last, poses):
            self._settles = max(0, self._settles - 1)
            self._begin(poses)
            return
        self._add(last, poses)
        self._last = poses
        self._judge(poses)

    def _begin(self, poses: tuple[Pose, Pose, Pose]) -> None:
        self._start = self._last = poses
        self._least = self.error
        self._way = 0.0
        # Sums over ticks: rotations, and steps in the robot frame by the program's estimate and by the wheels.
        self._turned = self._turned_alike = self._turning = 0.0
        self._squares = self._program_squares = 0.0
        self._alike = self._mirrored = 0j

    def _add(self, last: tuple[Pose, Pose, Pose], now: tuple[Pose, Pose, Pose]) -> None:
        turn, true_turn = (math.remainder(now[k][2] - last[k][2], math.tau) for k in (0, 2))
        self._turning += abs(true_turn)
        self._turned += true_turn * true_turn
        self._turned_alike += turn * true_turn
        step, wheels = (_step(last[k], now[k]) for k in (0, 1))
        self._way += abs(wheels)
        if abs(step) > _CARRIED[0]:
            return  # a camera's correction
        self._squares += abs(wheels) ** 2
        self._program_squares += abs(step) ** 2
        self._alike += step * wheels.conjugate()
        self._mirrored += step * wheels

    def _judge(self, poses: tuple[Pose, Pose, Pose]) -> None:
        gone, by_wheels, truly = (_step(start, pose) for start, pose in zip(self._start, poses, strict=True))
        turns = [pose[2] - start[2] for start, pose in zip(self._start, poses, strict=True)]
        error, least = self.error, self._least
        self._least = BeliefError(min(error.position, least.position), min(abs(error.heading), abs(least.heading)))
        grown = error.position, abs(error.heading)
        if self._has_cameras():
            grown = grown[0] - least.position, grown[1] - abs(least.heading)
        apart = min(abs(gone - by_wheels), abs(gone - truly), grown[0])
        turned = min(*(abs(math.remainder(turns[0] - turn, math.tau)) for turn in turns[1:]), grown[1])
        most = _TURNED if 0.8 < self._share_of_turning() < 1.25 else _TURNED_WRONG
        if turned < most and apart < max(_APART, _SHARE * self._way):
            return
        self._is_reported = True
        _log.warning(
            "the program's odometry is off: it says that robot %d moved %.2f m and turned %.0f deg, but the robot "
            "moved %.2f m and turned %.0f deg; slip explains %.2f m of the difference. %s (docs/troubleshooting.md)",
            *(self._robot.number, abs(gone), math.degrees(turns[0]), abs(truly), math.degrees(turns[2])),
            *(abs(by_wheels - truly), self._cause()),
        )

    def _share_of_turning(self) -> float:
        """Return the fitted ratio of estimated to true rotation [-]; 1 until the robot has turned 0.2 rad in total."""
        return self._turned_alike / self._turned if self._turning > _LEAST_TURN else 1.0

    def _cause(self) -> str:
        """Return the most likely cause of the error as a sentence."""
        if self._turning > _LEAST_TURN:
            share = self._share_of_turning()
            if share < -0.5:
                return (
                    "Its heading turns the wrong way: if its gyro is mounted upside down, set gyro_upside_down = true "
                    "under [drivetrain] in simcore.toml (gyro_reversed = true if only its yaw is reversed) and leave "
                    "the program as it is; otherwise the gyro is not negated (navX, ADXRS450, AnalogGyro count "
                    "clockwise), or the frame is mirrored"
                )
            if abs(share) < 0.2:
                return "Its heading stays the same while the robot turns: the odometry does not read the gyro"
            if not 0.8 < share < 1.25:
                return (
                    f"Its heading turns {share:.3g} times as far as the robot: are degrees taken as radians, or turns "
                    "as degrees?"
                )
        if self._squares < _TRIVIAL * _TRIVIAL * 0.01:
            return "Its pose moves while the wheels stand still: something other than the encoders moves it"
        size = self._alike / self._squares
        if self._program_squares < 0.01 * self._squares:
            return (
                self._why_still()
                or "Its pose hardly moves: its encoders read nothing, or something else writes to them"
            )
        mirrored = abs(self._mirrored) / self._squares
        if mirrored > abs(size) + 0.1:
            return "It has left and right swapped: y is positive to the left in WPILib's kinematics"
        angle = math.degrees(cmath.phase(size))
        fit = abs(self._alike) ** 2 / (self._squares * self._program_squares)
        if fit < 0.5:
            return (
                "Its pose moves in other directions than the wheels: something other than the encoders moves it, or "
                "the modules' zeros do not match"
            )
        if abs(angle) < 20.0:
            return (
                f"It counts {abs(size):.3g} m for each meter driven: wheel size, gearing or a conversion factor "
                "differs between program and robot ([drivetrain] in simcore.toml)"
            )
        if abs(angle) > 160.0:
            return (
                "Its pose moves the opposite way: its encoders count down when driving forward, or positive output "
                "drives this robot backward ([drivetrain] reversed = true, or reversed_drive for a swerve drive)"
            )
        return (
            f"Its pose moves {angle:.0f} deg away from the direction of the wheels: the zeros or directions of the "
            "azimuth encoders are wrong ([drivetrain] zeros_deg, reversed_encoders, reversed_steer)"
        )


def _was_set(last: tuple[Pose, Pose, Pose], now: tuple[Pose, Pose, Pose]) -> bool:
    """Return whether the robot was carried in this tick, or the estimated heading jumped without true rotation."""
    turned, true_turned = (abs(math.remainder(now[k][2] - last[k][2], math.tau)) for k in (0, 2))
    was_carried = math.dist(last[2][:2], now[2][:2]) > _CARRIED[0] or true_turned > _CARRIED[1]
    return was_carried or (turned > _CARRIED[1] and true_turned < _RESTS)


def _step(last: Pose, now: Pose) -> complex:
    """Return the displacement in the frame of the `last` pose [m]: forward (real part) and left (imaginary part)."""
    return complex(now[0] - last[0], now[1] - last[1]) * cmath.exp(-1j * last[2])
