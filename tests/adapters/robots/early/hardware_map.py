"""Devices of the whole robot, made as this module is imported."""

import measures
import wpilib
from phoenix6 import configs, hardware

drivetrain = measures.build()
feeder = hardware.TalonFX(51)
CONFIG = configs.TalonFXConfiguration()
CONFIG.feedback.sensor_to_mechanism_ratio = 4.0
feeder.configurator.apply(CONFIG)
beam = wpilib.DigitalInput(3)


class Shooter:
    """Its motors are those of the class."""

    wheels = hardware.TalonFX(52)
