"""The arm on the elevator: one motor, an absolute encoder on its joint, MotionMagic in rotations."""

from commands2 import Subsystem
from constants import TUCKED_DEG, Ids
from phoenix6 import configs, controls, hardware, signals

LOWEST, HIGHEST = -60.0, 90.0  # degrees above the horizontal


class Arm(Subsystem):
    """Swings the claw forward and up."""

    def __init__(self) -> None:
        super().__init__()
        self._motor = hardware.TalonFX(Ids.ARM)
        self._encoder = hardware.CANcoder(Ids.ARM)
        config = configs.TalonFXConfiguration()
        config.motor_output.neutral_mode = signals.NeutralModeValue.BRAKE
        config.current_limits.stator_current_limit = 60.0
        config.feedback.feedback_sensor_source = signals.FeedbackSensorSourceValue.FUSED_CANCODER
        config.feedback.feedback_remote_sensor_id = Ids.ARM
        config.feedback.rotor_to_sensor_ratio = 60.0
        config.slot0.k_g = 0.19
        config.slot0.gravity_type = signals.GravityTypeValue.ARM_COSINE
        config.slot0.k_s = 0.2
        config.slot0.k_v = 7.4
        config.slot0.k_a = 0.1
        config.slot0.k_p = 120.0
        config.slot0.k_d = 1.0
        config.motion_magic.motion_magic_cruise_velocity = 1.2
        config.motion_magic.motion_magic_acceleration = 5.0
        limits = config.software_limit_switch
        limits.forward_soft_limit_enable, limits.forward_soft_limit_threshold = True, (HIGHEST - 1.0) / 360
        limits.reverse_soft_limit_enable, limits.reverse_soft_limit_threshold = True, (LOWEST + 1.0) / 360
        self._motor.configurator.apply(config)
        self._go = controls.MotionMagicVoltage(TUCKED_DEG / 360)
        self.goal_deg = TUCKED_DEG

    def set_angle(self, degrees: float) -> None:
        """Go to an angle above the horizontal."""
        self.goal_deg = degrees
        self._motor.set_control(self._go.with_position(degrees / 360))

    @property
    def angle_deg(self) -> float:
        """Where it is."""
        return 360 * self._motor.get_position().value

    @property
    def is_at_goal(self) -> bool:
        return abs(self.angle_deg - self.goal_deg) < 1.5
