"""A TimedRobot of odd devices: Minions on TalonFXS turn the azimuths, CANdis read them; nobody steps anything."""

import measures
import wpilib


class Robot(wpilib.TimedRobot):
    def __init__(self) -> None:
        super().__init__()
        self.parts = {"drive": measures.build(inverted_steer=False, fxs=True)}

    def teleopPeriodic(self) -> None:
        self.parts["drive"].set_control(measures.driver_request())
