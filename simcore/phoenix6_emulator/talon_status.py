"""What a motor controller reports: its status frame and its faults."""

from __future__ import annotations

from collections.abc import Set
from typing import TYPE_CHECKING

from simcore.phoenix6_emulator.bridge import OVER_VOLTAGE
from simcore.phoenix6_emulator.faults import FAULTS
from simcore.phoenix6_emulator.talon_frame import TalonFrame

if TYPE_CHECKING:
    from simcore.phoenix6_emulator.talon import Talon

__all__ = ["active_faults", "frame_of"]

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
    b, plan, turn, world = talon.bridge, talon.plan, talon.turn, talon.world
    profile = plan.profile
    # 0.9 us past TalonFrame.__new__, which is a Python function, and with what few read computed when it is read; 7 us
    # by name and all at once. 17 motors make 34 frames a tick.
    return _new(TalonFrame, (
        talon.pos, talon.vel, talon.acc, turn * (talon.raw + talon.shift) + talon.rotor_offset, talon.rotor_rps * turn,
        b.volts, b.current, b.supply_current, b.supply, b.duty, b.is_neutral, b.rps,
        talon.ref, talon.slope, talon.err, talon.derr, talon.integral, talon.feed_forward, talon.pid_out,
        talon.slot, talon.enabled, talon.forward.is_closed(world), talon.reverse.is_closed(world), turn,
        profile is not None and profile.done, plan, b.motor,
    ))  # fmt: skip
