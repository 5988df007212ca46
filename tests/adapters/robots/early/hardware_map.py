"""All devices of the robot, made when this module is imported."""

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
    """Shooter with motors in its class body."""

    wheels = hardware.TalonFX(52)
