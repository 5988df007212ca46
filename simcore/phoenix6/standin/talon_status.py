"""What a motor controller reports: its status frame and its faults."""

from __future__ import annotations

from collections.abc import Set
from typing import TYPE_CHECKING

from simcore.phoenix6.standin.bridge import OVER_VOLTAGE
from simcore.phoenix6.standin.faults import FAULTS
from simcore.phoenix6.standin.talon_frame import REQ_BRAKE, REQ_COAST, TalonFrame

if TYPE_CHECKING:
    from simcore.phoenix6.standin.talon import Talon

__all__ = ["active_faults", "frame_of"]

_OFF, _BRAKING, _MOTORING, _DISCORDANT, _REGENERATING = 1, 2, 3, 4, 5  # MotorOutputStatusValue
_NO_FAULTS: frozenset[int] = frozenset()
_new = tuple.__new__


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
    b, plan, enabled, turn = talon.bridge, talon.plan, talon.enabled, talon.turn
    profile, current = plan.profile, b.current
    profiled = enabled and profile is not None
    if b.is_neutral:
        drives, status = (REQ_BRAKE, _BRAKING) if current else (REQ_COAST, _OFF)
    else:
        drives = plan.drives
        status = _DISCORDANT if current * b.rps < 0.0 else _MOTORING
        if b.supply_current < 0.0:
            status = _REGENERATING
    forward, reverse, world = talon.forward, talon.reverse, talon.world
    # 2.4 us by place and past TalonFrame.__new__, which is a Python function; 7 us by name and through it
    return _new(TalonFrame, (
        talon.pos, talon.vel, talon.acc, talon.rotor_position, talon.rotor_rps * turn,
        b.volts, current, b.supply_current, b.supply, b.duty,
        talon.ref, talon.slope, talon.err, talon.derr, talon.integral, talon.feed_forward,
        talon.pid_out, plan.gains, talon.slot, plan.mode if enabled else 0, drives, status, enabled,
        not forward.is_closed(world), not reverse.is_closed(world), turn,
        profiled, profile is not None and profiled and profile.done, plan.on_velocity, plan.unit_number, b.motor,
    ))  # fmt: skip
