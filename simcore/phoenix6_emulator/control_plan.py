"""How a controller carries out one kind of request: law, output stage and status, built once and used each step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from phoenix6.signals import BridgeOutputValue, ControlModeValue
from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6_emulator import control_laws as laws
from simcore.phoenix6_emulator.config_text import Setting
from simcore.phoenix6_emulator.control_laws import ControlState, Gains, Law, gains_of
from simcore.phoenix6_emulator.control_requests import REQUESTS, Axis, RequestKind, Unit
from simcore.phoenix6_emulator.motion_profile import Expo, Profile, SCurve, VelocityRamp
from simcore.phoenix6_emulator.output_stage import Bridge, Stage

__all__ = [
    "REQ_BRAKE",
    "REQ_COAST",
    "REQ_FOC",
    "REQ_TORQUE",
    "REQ_TRAPEZOIDAL",
    "ControlPlan",
    "PlannedState",
    "build_plan",
    "limits_of",
]

REQ_COAST, REQ_BRAKE, REQ_TRAPEZOIDAL, REQ_TORQUE, REQ_FOC = (
    int(BridgeOutputValue[f"BRIDGE_REQ_{name}"].value)
    for name in ("COAST", "BRAKE", "TRAPEZ", "FOC_TORQUE", "FOC_EASY")
)
"""What a bridge does, as `get_bridge_output` reads."""


@dataclass(frozen=True, slots=True)
class ControlPlan:
    """Law and output stage, and what status frames say of them."""

    law: Law | None
    """None: the bridge coasts, brakes or follows."""
    stage: Stage | None
    """Output stage of the law."""
    gains: Gains
    profile: Profile | None
    """What Motion Magic moves along."""
    mode: int
    """`ControlModeValue`."""
    drives: int
    """`BridgeOutputValue` of a bridge that is not neutral."""
    unit_number: int
    """0 to 2: number of the unit of the loop's output, after that of the duty cycle."""
    on_velocity: bool
    """Whether a velocity is controlled."""
    reads_sensor: bool
    """Whether the law reads a sensor."""
    has_memory: bool
    """Whether the output depends on what was before: an integral, a ramp."""


class PlannedState(ControlState, Protocol):
    """What a plan is built from, beside what its law works on."""

    config: dict[int, Setting]
    bridge: Bridge
    output: float
    """Of an open loop."""
    scurve: SCurve
    expo: Expo
    velocity_ramp: VelocityRamp


_OUTPUTLESS = frozenset((Axis.NEUTRAL, Axis.BRAKE, Axis.COAST, Axis.MUSIC, Axis.FOLLOW))


def build_plan(talon: PlannedState, kind: RequestKind, slot: int, foc: bool) -> ControlPlan:
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
    return ControlPlan(
        law,
        stage,
        gains,
        profile=profiles.get(kind.axis),
        mode=0 if kind is REQUESTS["Empty"] else int(ControlModeValue[kind.mode(foc)].value),
        drives=REQ_TORQUE if torque else (REQ_FOC if foc else REQ_TRAPEZOIDAL),
        unit_number=(Unit.DUTY, Unit.VOLTS, Unit.AMPERES).index(kind.unit),
        on_velocity=kind.axis in (Axis.VELOCITY, Axis.MOTION_MAGIC_VELOCITY),
        reads_sensor=law is not None and kind.axis is not Axis.OPEN,
        has_memory=gains.ki != 0.0 or talon.bridge.has_ramp,
    )


def _law(talon: PlannedState, kind: RequestKind, slot: int, foc: bool) -> tuple[laws.Law | None, Stage | None, Gains]:
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


def limits_of(config: Mapping[int, Setting], kind: RequestKind, args: tuple[float, ...]) -> tuple[float, float, float]:
    """Limits of the profile of a request, from the request itself (Dynamic) or from the configuration."""
    c = config
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
