"""Status frame of a motor controller: its content, its fault flags, and what each signal reads from it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Set
from typing import Any, NamedTuple

from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6_emulator.control_plan import REQ_BRAKE, REQ_COAST, ControlPlan
from simcore.phoenix6_emulator.emulated_device import FAULTS
from simcore.phoenix6_emulator.motor_constants import MotorConstants
from simcore.phoenix6_emulator.output_stage import OVER_VOLTAGE
from simcore.phoenix6_emulator.talon_state import TalonState, within_range

__all__ = ["SIGNALS", "TalonFrame", "active_faults", "frame_of", "units_number"]

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
    """Rotor velocity at the last run of the output stage."""
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
    """Whether the setpoint has reached its goal."""
    plan: ControlPlan
    motor: MotorConstants

    @property
    def rotor_position(self) -> float:
        """As robot code reads it, within +-16384 [rotations]."""
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


_DIFFERENTIAL = tuple(
    spn
    for spn in SpnValue
    if spn.name.startswith(("PRO_DIFF_", "PRO_AVG_", "PRO_MOTOR_OUTPUT_PID_STATE_DIFF_"))
    or spn.name == "TALON_FX_DIFFERENTIAL_CONTROL_MODE"
)
_RAW_INPUTS = (  # of a TalonFXS, before its offset: CTRE's simulation does not send them
    SpnValue.TALON_FXS_GADGETEER_G3,
    SpnValue.PRO_GADGETEER_PWM_RAW_PWM_POSITION,
    SpnValue.PRO_GADGETEER_PWM_RAW_PWM_VELOCITY,
    SpnValue.PRO_GADGETEER_QUAD_RAW_QUADRATURE_POSITION,
    SpnValue.PRO_GADGETEER_QUAD_RAW_QUADRATURE_VELOCITY,
)

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
    # Differential requests are refused, so that these say what they say without one.
    **{spn.value: _constant(0.0) for spn in _DIFFERENTIAL},
    **{spn.value: _constant(0.0) for spn in _RAW_INPUTS},
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


_NO_FAULTS: frozenset[int] = frozenset()
_new = tuple.__new__


def active_faults(talon: TalonState, is_sensor_missing: bool) -> Set[int]:
    """Numbers of the faults that are active now; robot code may not have built the configured remote sensor."""
    bridge = talon.bridge
    limited = bridge.is_stator_limited or bridge.is_supply_limited or bridge.is_blocked
    if not limited and bridge.supply <= OVER_VOLTAGE and not is_sensor_missing:
        return _NO_FAULTS
    found = set()
    if bridge.is_stator_limited:
        found.add(FAULTS["TALONFX_STATOR_CURR_LIMIT"])
    if bridge.is_supply_limited:
        found.add(FAULTS["TALONFX_SUPPLY_CURR_LIMIT"])
    if bridge.supply > OVER_VOLTAGE:
        found.add(FAULTS["TALONFX_OVER_SUPPLY_V"])
    if is_sensor_missing:
        found.add(FAULTS["TALONFX_MISSING_REMOTE_SENSOR"])
    if bridge.is_blocked:
        names = ("FORWARD_SOFT_LIMIT", "REVERSE_SOFT_LIMIT", "FORWARD_HARD_LIMIT", "REVERSE_HARD_LIMIT")
        found |= {FAULTS[f"TALONFX_{name}"] for name, hit in zip(names, talon.limits_hit, strict=True) if hit}
    return found


def frame_of(talon: TalonState) -> TalonFrame:
    """The status frame of this moment."""
    b, plan, turn, devices = talon.bridge, talon.plan, talon.turn, talon.devices
    profile = plan.profile
    # 0.9 us, because it bypasses TalonFrame.__new__, a Python function, and rarely read values are computed when they
    # are read; 7 us by name and all at once. 17 motors make 34 frames a tick.
    return _new(TalonFrame, (
        talon.pos, talon.vel, talon.acc, turn * (talon.raw + talon.shift) + talon.rotor_offset, talon.rotor_rps * turn,
        b.volts, b.current, b.supply_current, b.supply, b.duty, b.is_neutral, b.rps,
        talon.ref, talon.slope, talon.err, talon.derr, talon.integral, talon.feed_forward, talon.pid_out,
        talon.slot, talon.enabled, talon.forward.is_closed(devices), talon.reverse.is_closed(devices), turn,
        profile is not None and profile.done, plan, b.motor,
    ))  # fmt: skip
