"""What the robot does with coral: put one on a branch, and fetch one from a station."""

from collections.abc import Callable, Sequence

from commands2 import Command, cmd
from constants import CARRY_HEIGHT, LEVELS, STANDOFF, STATION_GAP, TUCKED_DEG, branch_pose, station_pose
from subsystems.arm import Arm
from subsystems.claw import Claw, Funnel
from subsystems.command_swerve_drivetrain import CommandSwerveDrivetrain
from subsystems.elevator import Elevator

from commands.drive_to import DriveTo


class CoralCommands:
    """Makes commands out of the subsystems that coral needs."""

    def __init__(
        self, drivetrain: CommandSwerveDrivetrain, elevator: Elevator, arm: Arm, claw: Claw, funnel: Funnel
    ) -> None:
        self._drivetrain, self._elevator, self._arm, self._claw, self._funnel = drivetrain, elevator, arm, claw, funnel

    def tuck(self) -> Command:
        """Arm up, then elevator down, to drive."""
        arm = self._arm.runOnce(lambda: self._arm.set_angle(TUCKED_DEG))
        down = self._elevator.runOnce(lambda: self._elevator.set_height(CARRY_HEIGHT))
        return arm.andThen(cmd.waitUntil(lambda: self._arm.angle_deg > 45.0)).andThen(down)

    def score(
        self,
        branch: Callable[[], str],
        level: Callable[[], int],
        *,
        past: Sequence[tuple[float, float]] = (),
    ) -> Command:
        """Drive to a branch, put the coral on it and back off; both are asked for as the command begins.

        Args:
            branch: A to L.
            level: 2 to 4.
            past: Places on the way there, as a blue robot.
        """

        def before(gap: float):
            return lambda: branch_pose(branch(), LEVELS[level()].distance + gap)

        def lift() -> None:
            to = LEVELS[level()]
            self._elevator.set_height(to.height + to.rise * min(approach.left, STANDOFF))

        def reach() -> None:
            self._arm.set_angle(LEVELS[level()].arm_deg)

        approach = DriveTo(self._drivetrain, before(0.0), speed=1.0, tolerance=0.012)
        return cmd.sequence(
            self._elevator.runOnce(lift),
            DriveTo(self._drivetrain, before(STANDOFF), past=past, tolerance=0.12),
            cmd.waitUntil(lambda: self._elevator.height > self._elevator.goal - 0.3),
            self._arm.runOnce(reach),
            approach.alongWith(cmd.waitUntil(lambda: self._elevator.is_at_goal and self._arm.is_at_goal))
            .withTimeout(2.0)
            .raceWith(self._elevator.run(lift)),
            self.let_go(),
            DriveTo(self._drivetrain, before(STANDOFF), speed=2.0, tolerance=0.12).withTimeout(1.5),
            self.tuck(),
        )

    def let_go(self) -> Command:
        """Turn the coral out of the claw."""
        return (
            self._claw.runOnce(self._claw.release)
            .andThen(cmd.waitSeconds(0.2))
            .andThen(self._claw.runOnce(self._claw.stop))
        )

    def take(self) -> Command:
        """Rollers in until a coral is in the claw."""

        def start() -> None:
            self._funnel.set_turning(True)
            self._claw.take()

        def stop() -> None:
            self._funnel.set_turning(False)
            self._claw.stop()

        turn = cmd.startEnd(start, stop, self._funnel, self._claw)
        return self.tuck().alongWith(turn.until(lambda: self._claw.has_coral))

    def fetch(self, *, past: Sequence[tuple[float, float]] = ()) -> Command:
        """Back up to the left station and wait for a coral."""
        drive = DriveTo(self._drivetrain, station_pose(STATION_GAP), past=past, tolerance=0.06)
        return drive.alongWith(self.take())
