"""What a motor controller reports: its status frame and its faults."""

from __future__ import annotations

from collections.abc import Set
from functools import cache
from typing import TYPE_CHECKING

from phoenix6.signals import ControlModeValue

from simcore.phoenix6.standin.bridge import OVER_VOLTAGE
from simcore.phoenix6.standin.faults import FAULTS
from simcore.phoenix6.standin.motion import PROFILED, VELOCITY
from simcore.phoenix6.standin.requests import REQUESTS, Axis, RequestKind, Unit
from simcore.phoenix6.standin.talon_frame import (
    REQ_BRAKE,
    REQ_COAST,
    REQ_FOC,
    REQ_TORQUE,
    REQ_TRAPEZOIDAL,
    TalonFrame,
)

if TYPE_CHECKING:
    from simcore.phoenix6.standin.talon import Talon

__all__ = ["active_faults", "frame_of"]

_OFF, _BRAKING, _MOTORING, _DISCORDANT, _REGENERATING = 1, 2, 3, 4, 5  # MotorOutputStatusValue
_UNIT_NUMBER = {Unit.DUTY: 0, Unit.VOLTS: 1, Unit.AMPERES: 2}
_NO_FAULTS: frozenset[int] = frozenset()


@cache
def _mode_number(kind: RequestKind, foc: bool) -> int:
    return int(ControlModeValue[kind.mode(foc)].value)


def _mode(talon: Talon) -> int:
    return 0 if not talon.enabled or talon.kind is REQUESTS["Empty"] else _mode_number(talon.kind, talon.foc)


def _bridge_output(talon: Talon) -> int:
    bridge = talon.bridge
    if bridge.is_neutral:
        return REQ_BRAKE if bridge.current else REQ_COAST
    if talon.kind.unit is Unit.AMPERES:
        return REQ_TORQUE
    return REQ_FOC if talon.foc else REQ_TRAPEZOIDAL


def _status(talon: Talon) -> int:
    bridge = talon.bridge
    if bridge.is_neutral:
        return _BRAKING if bridge.current else _OFF
    if bridge.supply_current < 0.0:
        return _REGENERATING
    return _DISCORDANT if bridge.current * bridge.rps < 0.0 else _MOTORING


def active_faults(talon: Talon) -> Set[int]:
    """Numbers of the faults that are active now."""
    bridge = talon.bridge
    limited = bridge.is_stator_limited or bridge.is_supply_limited or bridge.is_blocked
    if not limited and bridge.supply <= OVER_VOLTAGE and not talon.feedback.is_missing:
        return _NO_FAULTS
    found = set()
    if bridge.is_stator_limited:
        found.add(FAULTS["TALONFX_STATOR_CURR_LIMIT"])
    if bridge.is_supply_limited:
        found.add(FAULTS["TALONFX_SUPPLY_CURR_LIMIT"])
    if bridge.supply > OVER_VOLTAGE:
        found.add(FAULTS["TALONFX_OVER_SUPPLY_V"])
    if talon.feedback.is_missing:
        found.add(FAULTS["TALONFX_MISSING_REMOTE_SENSOR"])
    if bridge.is_blocked:
        names = ("FORWARD_SOFT_LIMIT", "REVERSE_SOFT_LIMIT", "FORWARD_HARD_LIMIT", "REVERSE_HARD_LIMIT")
        found |= {FAULTS[f"TALONFX_{name}"] for name, hit in zip(names, talon.limits_hit, strict=True) if hit}
    return found


def frame_of(talon: Talon) -> TalonFrame:
    """The status frame of this moment."""
    b, g = talon.bridge, talon.gains
    axis = talon.kind.axis
    profiled = talon.enabled and axis in PROFILED
    profile = {Axis.MOTION_MAGIC: talon.scurve, Axis.MOTION_MAGIC_EXPO: talon.expo}.get(axis, talon.velocity_ramp)
    motor, rotor = b.motor, talon.rotor_rps * talon.turn
    return TalonFrame(  # by place: by name it takes twice the time
        talon.pos, talon.vel, talon.acc, talon.rotor_position, rotor,
        b.volts, b.current, b.supply_current, b.supply, b.duty,
        talon.ref, talon.slope, talon.err, g.kp * talon.err, talon.integral, g.kd * talon.derr,
        talon.feed_forward, talon.pid_out,
        talon.slot, _mode(talon), _bridge_output(talon), _status(talon), talon.enabled,
        not talon.forward.is_closed(talon.world), not talon.reverse.is_closed(talon.world), int(talon.turn < 0.0),
        profiled, profiled and profile.done, axis in VELOCITY, _UNIT_NUMBER[talon.kind.unit],
        motor.kt, motor.kv, motor.reported_stall, motor.connected,
    )  # fmt: skip
