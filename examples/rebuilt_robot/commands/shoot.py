"""Aim at the own hub, spin up, feed when everything is ready."""

import math

from commands2 import Command
from constants import FIELD_LENGTH, FIELD_WIDTH, HUB_BLUE, MAX_TURN, shooter_rps
from phoenix6.swerve import requests
from subsystems.command_swerve_drivetrain import CommandSwerveDrivetrain
from subsystems.indexer import Feeder, Spindexer
from subsystems.shooter import Hood, Shooter
from wpilib import DriverStation
from wpimath.geometry import Translation2d


class Shoot(Command):
    """Shoots for as long as it runs."""

    def __init__(
        self,
        drivetrain: CommandSwerveDrivetrain,
        shooter: Shooter,
        hood: Hood,
        feeder: Feeder,
        spindexer: Spindexer,
    ) -> None:
        super().__init__()
        self._drivetrain, self._shooter, self._hood = drivetrain, shooter, hood
        self._feeder, self._spindexer = feeder, spindexer
        self._turn = requests.RobotCentric().with_deadband(0.0).with_rotational_deadband(0.0)
        self.addRequirements(drivetrain, shooter, feeder, spindexer)

    def execute(self) -> None:
        state = self._drivetrain.get_state()
        is_red = DriverStation.getAlliance() == DriverStation.Alliance.kRed
        hub = Translation2d(FIELD_LENGTH - HUB_BLUE.X(), FIELD_WIDTH - HUB_BLUE.Y()) if is_red else HUB_BLUE
        ahead = hub - state.pose.translation()
        error = (ahead.angle() - state.pose.rotation()).radians()
        error = math.remainder(error, math.tau)
        rate = min(max(10.0 * error, -MAX_TURN), MAX_TURN)
        self._drivetrain.set_control(self._turn.with_rotational_rate(rate if abs(error) > 0.008 else 0.0))
        self._shooter.set_speed(shooter_rps(ahead.norm()))
        is_still = math.hypot(state.speeds.vx, state.speeds.vy) < 0.15
        is_ready = self._shooter.is_at_speed and self._hood.is_at_goal and is_still and abs(error) < math.radians(2.5)
        self._feeder.set_turning(is_ready)
        self._spindexer.set_turning(is_ready)

    def end(self, interrupted: bool) -> None:
        self._feeder.set_turning(False)
        self._spindexer.set_turning(False)
        self._shooter.stop()
        self._drivetrain.set_control(requests.RobotCentric())
