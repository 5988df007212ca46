"""Drive to the nearest fuel that the camera at the intake sees."""

import math

from commands2 import Command
from phoenix6.swerve import requests
from subsystems.command_swerve_drivetrain import CommandSwerveDrivetrain
from subsystems.intake import Intake
from subsystems.vision import Vision

SPEED = 1.2  # m/s
TURN = 4.0  # rad/s of turning per rad of error
PATIENCE = 25  # loops: a fuel that passes under the camera is out of the picture before it is taken in


class Collect(Command):
    """Takes in fuel after fuel, backwards, for as long as it runs; stands still where it sees none."""

    def __init__(self, drivetrain: CommandSwerveDrivetrain, intake: Intake, vision: Vision) -> None:
        super().__init__()
        self._drivetrain, self._intake, self._vision = drivetrain, intake, vision
        self._drive = requests.RobotCentric().with_deadband(0.0).with_rotational_deadband(0.0)
        self._blind = PATIENCE
        self.addRequirements(drivetrain, intake)

    def initialize(self) -> None:
        self._blind = PATIENCE
        self._intake.set_out(True)

    def execute(self) -> None:
        fuel = self._vision.nearest_fuel()
        self._blind = 0 if fuel is not None else self._blind + 1
        error = -math.radians(fuel.tx_deg) if fuel is not None else 0.0
        ahead = SPEED * max(0.0, math.cos(2.0 * error)) if self._blind < PATIENCE else 0.0
        self._drivetrain.set_control(
            self._drive.with_velocity_x(-ahead).with_velocity_y(0.0).with_rotational_rate(TURN * error)
        )

    def end(self, interrupted: bool) -> None:
        self._drivetrain.set_control(requests.RobotCentric())
