"""What a motor controller tells robot code: the status frame, and what each signal reads from it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6_emulator.electrical import MotorConstants
from simcore.phoenix6_emulator.feedback import within_range
from simcore.phoenix6_emulator.plan import REQ_BRAKE, REQ_COAST, Plan

__all__ = ["SIGNALS", "TalonFrame", "units_number"]

_OFF, _BRAKING, _MOTORING, _DISCORDANT, _REGENERATING = 1, 2, 3, 4, 5  # MotorOutputStatusValue


class TalonFrame(NamedTuple):
    """State of a motor controller at one moment, in robot code's signs."""

    position: float
    velocity: float
    acceleration: float
    turns: float
    """Of the rotor, any number."""
    rotor_velocity: float
    volts: float
    current: float
    supply_current: float
    supply: float
    duty: float
    is_neutral: bool
    bridge_rps: float
    """Rotor velocity that the output stage last saw."""
    ref: float
    slope: float
    err: float
    err_rate: float
    i_out: float
    ff_out: float
    pid_out: float
    slot: int
    enabled: bool
    forward_closed: bool
    reverse_closed: bool
    turn: float
    """-1 where positive is clockwise."""
    has_arrived: bool
    """Whether the reference has reached its goal."""
    plan: Plan
    motor: MotorConstants

    @property
    def rotor_position(self) -> float:
        """As it is told, within +-16384 [rotations]."""
        return within_range(self.turns)

    @property
    def bridge(self) -> int:
        """`BridgeOutputValue`."""
        if not self.is_neutral:
            return self.plan.drives
        return REQ_BRAKE if self.current else REQ_COAST

    @property
    def status(self) -> int:
        """`MotorOutputStatusValue`."""
        if self.is_neutral:
            return _BRAKING if self.current else _OFF
        if self.supply_current < 0.0:
            return _REGENERATING
        return _DISCORDANT if self.current * self.bridge_rps < 0.0 else _MOTORING

    @property
    def profiled(self) -> bool:
        """Whether Motion Magic runs."""
        return self.enabled and self.plan.profile is not None


def _constant(value: float) -> Callable[[Any], float]:
    return lambda frame: value


SIGNALS: Mapping[int, Callable[[Any], float]] = {
    SpnValue.PRO_POS_AND_VEL_POSITION.value: lambda f: f.position,
    SpnValue.PRO_POS_AND_VEL_VELOCITY.value: lambda f: f.velocity,
    SpnValue.PRO_POS_AND_VEL_ACCELERATION.value: lambda f: f.acceleration,
    SpnValue.PRO_ROTOR_POS_AND_VEL_POSITION.value: lambda f: f.rotor_position,
    SpnValue.PRO_ROTOR_POS_AND_VEL_VELOCITY.value: lambda f: f.rotor_velocity,
    SpnValue.PRO_MOTOR_OUTPUT_MOTOR_VOLTAGE.value: lambda f: f.volts,
    SpnValue.PRO_MOTOR_OUTPUT_DUTY_CYCLE.value: lambda f: f.duty,
    SpnValue.PRO_MOTOR_OUTPUT_TORQUE_CURRENT.value: lambda f: f.current,
    SpnValue.PRO_MOTOR_OUTPUT_ROTOR_POLARITY.value: lambda f: int(f.turn < 0.0),
    SpnValue.PRO_MOTOR_OUTPUT_BRIDGE_TYPE_PUBLIC.value: lambda f: f.bridge,
    SpnValue.TALON_FX_MOTOR_OUTPUT_STATUS.value: lambda f: f.status,
    SpnValue.TALON_FX_CONTROL_MODE.value: lambda f: f.plan.mode if f.enabled else 0,
    SpnValue.PRO_SUPPLY_AND_TEMP_STATOR_CURRENT.value: lambda f: f.current,
    SpnValue.PRO_SUPPLY_AND_TEMP_SUPPLY_CURRENT.value: lambda f: f.supply_current,
    SpnValue.PRO_SUPPLY_AND_TEMP_SUPPLY_VOLTAGE.value: lambda f: f.supply,
    # The simulated device stays at these temperatures.
    SpnValue.PRO_SUPPLY_AND_TEMP_DEVICE_TEMP.value: _constant(24.0),
    SpnValue.PRO_SUPPLY_AND_TEMP_DEVICE_TEMP2.value: _constant(0.0),
    SpnValue.PRO_SUPPLY_AND_TEMP_PROCESSOR_TEMP.value: _constant(20.0),
    SpnValue.EXTERNAL_MOTOR_TEMP.value: _constant(20.0),
    SpnValue.EXTERNAL_MOTOR_TEMP_STATUS.value: _constant(3.0),
    SpnValue.TALON_FXS_5_V_RAIL_VOLTAGE.value: _constant(5.0),
    SpnValue.FORWARD_LIMIT.value: lambda f: not f.forward_closed,
    SpnValue.REVERSE_LIMIT.value: lambda f: not f.reverse_closed,
    SpnValue.PRO_PID_STATE_ENABLES_ROBOT_ENABLE.value: lambda f: f.enabled,
    SpnValue.PRO_PID_STATE_ENABLES_DEVICE_ENABLE.value: lambda f: f.enabled,
    SpnValue.PRO_PID_STATE_ENABLES_IS_MOTION_MAGIC_RUNNING.value: lambda f: f.profiled,
    SpnValue.PRO_PID_STATE_ENABLES_MOTION_MAGIC_AT_TARGET.value: lambda f: f.profiled and f.has_arrived,
    SpnValue.PRO_PID_REF_PID_ERR_PID_REF_POSITION.value: lambda f: f.ref,
    SpnValue.PRO_PID_REF_PID_ERR_PID_ERR_POSITION.value: lambda f: f.err,
    SpnValue.PRO_PID_REF_SLOPE_ECU_TIME_REFERENCE_SLOPE_POSITION.value: lambda f: f.slope,
    SpnValue.PRO_PID_OUTPUT_OUTPUT_DC.value: lambda f: f.pid_out,
    SpnValue.PRO_PID_OUTPUT_PROPORTIONAL_OUTPUT_DC.value: lambda f: f.plan.gains.kp * f.err,
    SpnValue.PRO_PID_OUTPUT_DERIVATIVE_OUTPUT_DC.value: lambda f: f.plan.gains.kd * f.err_rate,
    SpnValue.PRO_PID_STATE_ENABLES_INTEGRATED_ACCUM_DC.value: lambda f: f.i_out,
    SpnValue.PRO_PID_STATE_ENABLES_FEED_FORWARD_DC.value: lambda f: f.ff_out,
    SpnValue.PRO_PID_OUTPUT_SLOT.value: lambda f: f.slot,
    SpnValue.TALON_FX_MOTOR_CONSTANTS_K_T.value: lambda f: f.motor.kt,
    SpnValue.TALON_FX_MOTOR_CONSTANTS_K_V.value: lambda f: f.motor.kv,
    SpnValue.TALON_FX_MOTOR_CONSTANTS_STALL_CURRENT.value: lambda f: f.motor.reported_stall,
    SpnValue.TALON_FX_CONNECTED_MOTOR.value: lambda f: f.motor.connected,
}
"""What each signal reads, by its number."""

_BY_AXIS = {
    SpnValue.PRO_PID_REF_PID_ERR_PID_REF_POSITION.value,
    SpnValue.PRO_PID_REF_PID_ERR_PID_ERR_POSITION.value,
    SpnValue.PRO_PID_REF_SLOPE_ECU_TIME_REFERENCE_SLOPE_POSITION.value,
}
_BY_UNIT = {
    SpnValue.PRO_PID_OUTPUT_OUTPUT_DC.value,
    SpnValue.PRO_PID_OUTPUT_PROPORTIONAL_OUTPUT_DC.value,
    SpnValue.PRO_PID_OUTPUT_DERIVATIVE_OUTPUT_DC.value,
    SpnValue.PRO_PID_STATE_ENABLES_INTEGRATED_ACCUM_DC.value,
    SpnValue.PRO_PID_STATE_ENABLES_FEED_FORWARD_DC.value,
}


def units_number(spn: int, frame: TalonFrame) -> int:
    """Number whose units a signal has in this frame: a reference is a velocity in a velocity loop, and so on."""
    if spn in _BY_AXIS:
        return spn + frame.plan.on_velocity
    return spn + frame.plan.unit_number if spn in _BY_UNIT else spn
