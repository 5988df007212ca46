"""What a motor controller tells robot code: the status frame, and what each signal reads from it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from phoenix6.signals import BridgeOutputValue
from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6.standin.electrical import MotorConstants
from simcore.phoenix6.standin.gains import Gains

__all__ = [
    "REQ_BRAKE",
    "REQ_COAST",
    "REQ_FOC",
    "REQ_TORQUE",
    "REQ_TRAPEZOIDAL",
    "SIGNALS",
    "TalonFrame",
    "units_number",
]

REQ_COAST, REQ_BRAKE, REQ_TRAPEZOIDAL, REQ_TORQUE, REQ_FOC = (
    int(BridgeOutputValue[f"BRIDGE_REQ_{name}"].value)
    for name in ("COAST", "BRAKE", "TRAPEZ", "FOC_TORQUE", "FOC_EASY")
)
"""What a bridge does, as `get_bridge_output` tells."""


class TalonFrame(NamedTuple):
    """State of a motor controller at one moment, in robot code's signs."""

    position: float
    velocity: float
    acceleration: float
    rotor_position: float
    rotor_velocity: float
    volts: float
    current: float
    supply_current: float
    supply: float
    duty: float
    ref: float
    slope: float
    err: float
    err_rate: float
    i_out: float
    ff_out: float
    pid_out: float
    gains: Gains
    slot: int
    mode: int
    bridge: int
    status: int
    enabled: bool
    forward_open: bool
    reverse_open: bool
    turn: float
    """-1 where positive is clockwise."""
    profiled: bool
    at_target: bool
    on_velocity: bool
    unit: int
    motor: MotorConstants


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
    SpnValue.TALON_FX_CONTROL_MODE.value: lambda f: f.mode,
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
    SpnValue.FORWARD_LIMIT.value: lambda f: f.forward_open,
    SpnValue.REVERSE_LIMIT.value: lambda f: f.reverse_open,
    SpnValue.PRO_PID_STATE_ENABLES_ROBOT_ENABLE.value: lambda f: f.enabled,
    SpnValue.PRO_PID_STATE_ENABLES_DEVICE_ENABLE.value: lambda f: f.enabled,
    SpnValue.PRO_PID_STATE_ENABLES_IS_MOTION_MAGIC_RUNNING.value: lambda f: f.profiled,
    SpnValue.PRO_PID_STATE_ENABLES_MOTION_MAGIC_AT_TARGET.value: lambda f: f.at_target,
    SpnValue.PRO_PID_REF_PID_ERR_PID_REF_POSITION.value: lambda f: f.ref,
    SpnValue.PRO_PID_REF_PID_ERR_PID_ERR_POSITION.value: lambda f: f.err,
    SpnValue.PRO_PID_REF_SLOPE_ECU_TIME_REFERENCE_SLOPE_POSITION.value: lambda f: f.slope,
    SpnValue.PRO_PID_OUTPUT_OUTPUT_DC.value: lambda f: f.pid_out,
    SpnValue.PRO_PID_OUTPUT_PROPORTIONAL_OUTPUT_DC.value: lambda f: f.gains.kp * f.err,
    SpnValue.PRO_PID_OUTPUT_DERIVATIVE_OUTPUT_DC.value: lambda f: f.gains.kd * f.err_rate,
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
        return spn + frame.on_velocity
    return spn + frame.unit if spn in _BY_UNIT else spn
