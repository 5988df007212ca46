from components.shooters import ShotControl
from components.swerve import Drivetrain
from magicbot import AutonomousStateMachine, state, timed_state


class Across(AutonomousStateMachine):
    MODE_NAME = "across"
    DEFAULT = True
    drivetrain: Drivetrain
    shots: ShotControl

    @timed_state(first=True, duration=1.5, next_state="shoot")
    def drive(self) -> None:
        self.drivetrain.go(0.0, 1.0, 0.0)

    @state
    def shoot(self) -> None:
        self.shots.engage()
