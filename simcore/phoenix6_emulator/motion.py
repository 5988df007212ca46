"""Turns a control request into a law, an output stage and a status for one controller."""

from __future__ import annotations

from typing import TYPE_CHECKING

from phoenix6.signals import ControlModeValue
from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6_emulator import laws
from simcore.phoenix6_emulator.bridge import Stage
from simcore.phoenix6_emulator.gains import Gains, gains_of
from simcore.phoenix6_emulator.plan import REQ_FOC, REQ_TORQUE, REQ_TRAPEZOIDAL, Plan
from simcore.phoenix6_emulator.profile import Profile
from simcore.phoenix6_emulator.requests import REQUESTS, Axis, RequestKind, Unit

if TYPE_CHECKING:
    from simcore.phoenix6_emulator.talon import Talon

__all__ = ["build", "limits_of"]

_OUTPUTLESS = frozenset((Axis.NEUTRAL, Axis.BRAKE, Axis.COAST, Axis.MUSIC, Axis.FOLLOW))


def build(talon: Talon, kind: RequestKind, slot: int, foc: bool) -> Plan:
    """Law, output stage and status of a request.

    Raises:
        NotImplementedError: The slot schedules its gains.
    """
    law, stage, gains = _law(talon, kind, slot, foc)
    torque = kind.unit is Unit.AMPERES
    profiles: dict[Axis, Profile] = {
        Axis.MOTION_MAGIC: talon.scurve,
        Axis.MOTION_MAGIC_EXPO: talon.expo,
        Axis.MOTION_MAGIC_VELOCITY: talon.velocity_ramp,
    }
    return Plan(
        law,
        stage,
        gains,
        profile=profiles.get(kind.axis),
        mode=0 if kind is REQUESTS["Empty"] else int(ControlModeValue[kind.mode(foc)].value),
        drives=REQ_TORQUE if torque else (REQ_FOC if foc else REQ_TRAPEZOIDAL),
        unit_number=(Unit.DUTY, Unit.VOLTS, Unit.AMPERES).index(kind.unit),
        on_velocity=kind.axis in (Axis.VELOCITY, Axis.MOTION_MAGIC_VELOCITY),
        looks=law is not None and kind.axis is not Axis.OPEN,
        remembers=gains.ki != 0.0 or talon.bridge.has_ramp,
    )


def _law(talon: Talon, kind: RequestKind, slot: int, foc: bool) -> tuple[laws.Law | None, Stage | None, Gains]:
    axis = kind.axis
    if axis in _OUTPUTLESS:
        return None, None, Gains()
    c = talon.config
    stage = talon.bridge.stage(kind.unit, closed=axis is not Axis.OPEN, foc=foc)
    if axis is Axis.OPEN:
        return (lambda loops: talon.output), stage, Gains()
    if c[SpnValue.SLOT0_GAIN_SCHED_BEHAVIOR.value + slot]:
        raise NotImplementedError(f"{talon!r}: gain scheduling (slot{slot}) is not modelled in simulated time")
    gains = gains_of(c, slot)
    peaks = talon.bridge.peaks[kind.unit]
    wrap = bool(c[SpnValue.CONFIG_CONTINUOUS_WRAP.value])
    if axis is Axis.POSITION:
        return laws.position(talon, gains, peaks, wrap), stage, gains
    if axis is Axis.VELOCITY:
        return laws.velocity(talon, gains, peaks), stage, gains
    if axis is Axis.MOTION_MAGIC:
        return laws.motion_magic(talon, gains, peaks, wrap, talon.scurve), stage, gains
    if axis is Axis.MOTION_MAGIC_EXPO:
        return laws.motion_magic_expo(talon, gains, peaks, wrap, talon.expo), stage, gains
    return laws.motion_magic_velocity(talon, gains, peaks, talon.velocity_ramp), stage, gains


def limits_of(talon: Talon, kind: RequestKind, args: tuple[float, ...]) -> tuple[float, float, float]:
    """Limits of the profile of a request, from the request itself (Dynamic) or from the configuration."""
    c = talon.config
    field = kind.slots
    dynamic = kind.name.startswith("Dynamic")
    cruise = c[SpnValue.CONFIG_MOTION_MAGIC_CRUISE_VELOCITY.value]
    if kind.axis is Axis.MOTION_MAGIC_EXPO:
        if dynamic:
            return args[field["velocity"]], args[field["k_v"]], args[field["k_a"]]
        kv = c[SpnValue.CONFIG_MOTION_MAGIC_EXPO_K_V.value]
        return cruise, kv, c[SpnValue.CONFIG_MOTION_MAGIC_EXPO_K_A.value]
    acceleration = c[SpnValue.CONFIG_MOTION_MAGIC_ACCELERATION.value]
    jerk = c[SpnValue.CONFIG_MOTION_MAGIC_JERK.value]
    if dynamic:
        return args[field["velocity"]], args[field["acceleration"]], args[field["jerk"]]
    if kind.axis is Axis.MOTION_MAGIC_VELOCITY:
        return cruise, args[field["acceleration"]] or acceleration, jerk
    return cruise, acceleration, jerk
