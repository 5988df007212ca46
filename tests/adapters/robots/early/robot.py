"""Robot that builds its devices during import: here, in a class body, and in another module."""

import os
import threading

import measures
import wpilib
from hardware_map import Shooter, beam, drivetrain, feeder
from phoenix6 import controls, hardware

INTAKE = hardware.TalonFX(50)


class Robot(wpilib.TimedRobot):
    shooter = Shooter()

    def robotInit(self) -> None:
        if "THREAD" in os.environ:  # never ends
            threading.Thread(target=threading.Event().wait, name="team-loop").start()

    def teleopPeriodic(self) -> None:
        drivetrain.set_control(measures.driver_request())
        for motor in (INTAKE, feeder, Shooter.wheels):
            motor.set_control(controls.VoltageOut(6.0))

    def facts(self) -> dict:
        speeds = [motor.get_velocity().value for motor in (INTAKE, feeder, Shooter.wheels)]
        return {"speeds": speeds, "beam": beam.get()}
