"""The climber: a hook on a winch."""

import math

from commands2 import Subsystem
from constants import Ids
from phoenix6 import configs, controls, hardware, signals

HIGHEST = 0.55  # m that the hook rises
GEARING = 50.0
HOOK_PER_TURN = 2 * math.pi * 0.012  # m a turn of the winch


class Climber(Subsystem):
    """Lifts the robot by a cage."""

    def __init__(self) -> None:
        super().__init__()
        self._motor = hardware.TalonFX(Ids.CLIMBER)
        self._follower = hardware.TalonFX(Ids.CLIMBER_FOLLOWER)
        config = configs.TalonFXConfiguration()
        config.motor_output.neutral_mode = signals.NeutralModeValue.BRAKE  # beside the friction of its gears
        config.current_limits.stator_current_limit = 60.0
        config.feedback.sensor_to_mechanism_ratio = GEARING / HOOK_PER_TURN
        limits = config.software_limit_switch
        limits.forward_soft_limit_enable, limits.forward_soft_limit_threshold = True, HIGHEST - 0.01
        limits.reverse_soft_limit_enable, limits.reverse_soft_limit_threshold = True, 0.01
        for motor in (self._motor, self._follower):
            motor.configurator.apply(config)
        self._follower.set_control(controls.Follower(Ids.CLIMBER, signals.MotorAlignmentValue.OPPOSED))
        self._motor.set_position(0.0)
        self._turn = controls.VoltageOut(0.0)
        self.setDefaultCommand(self.run(lambda: self.pull(0.0)))

    def pull(self, volts: float) -> None:
        """Positive lifts the hook, negative the robot."""
        self._motor.set_control(self._turn.with_output(volts))

    @property
    def height(self) -> float:
        """Of the hook over its lowest place [m]."""
        return self._motor.get_position().value
