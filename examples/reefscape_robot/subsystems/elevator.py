"""The elevator: two stages, two motors, MotionMagic in meters."""

import math

from commands2 import Subsystem
from constants import Ids
from phoenix6 import configs, controls, hardware, signals

LOWEST, HIGHEST = 0.0, 1.9  # m that the carriage rises
GEARING = 14.0
CARRIAGE_PER_TURN = 2 * math.pi * 0.064  # m a turn of the drum: twice its circumference, as the second stage doubles it


class Elevator(Subsystem):
    """Carries the arm up and down."""

    def __init__(self) -> None:
        super().__init__()
        self._motor = hardware.TalonFX(Ids.ELEVATOR)
        self._follower = hardware.TalonFX(Ids.ELEVATOR_FOLLOWER)
        config = configs.TalonFXConfiguration()
        config.motor_output.neutral_mode = signals.NeutralModeValue.BRAKE
        config.current_limits.stator_current_limit = 60.0
        config.feedback.sensor_to_mechanism_ratio = GEARING / CARRIAGE_PER_TURN  # so positions are meters
        config.slot0.k_g = 0.23
        config.slot0.gravity_type = signals.GravityTypeValue.ELEVATOR_STATIC
        config.slot0.k_s = 0.2
        config.slot0.k_v = 4.3
        config.slot0.k_a = 0.08
        config.slot0.k_p = 60.0
        config.motion_magic.motion_magic_cruise_velocity = 2.0
        config.motion_magic.motion_magic_acceleration = 8.0
        limits = config.software_limit_switch
        limits.forward_soft_limit_enable, limits.forward_soft_limit_threshold = True, HIGHEST - 0.01
        limits.reverse_soft_limit_enable, limits.reverse_soft_limit_threshold = True, LOWEST
        for motor in (self._motor, self._follower):
            motor.configurator.apply(config)
        self._follower.set_control(controls.Follower(Ids.ELEVATOR, signals.MotorAlignmentValue.OPPOSED))
        self._motor.set_position(LOWEST)  # it is switched on at the bottom
        self._go = controls.MotionMagicVoltage(LOWEST)
        self.goal = LOWEST

    def set_height(self, height: float) -> None:
        """Go to a height [m]."""
        self.goal = height
        self._motor.set_control(self._go.with_position(height))

    @property
    def height(self) -> float:
        """Where it is [m]."""
        return self._motor.get_position().value

    @property
    def is_at_goal(self) -> bool:
        return abs(self.height - self.goal) < 0.015
