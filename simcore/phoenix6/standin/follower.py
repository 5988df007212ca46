"""Following: a motor that does what another one does, with its frames' latency."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simcore.phoenix6.standin.gains import Gains
from simcore.phoenix6.standin.requests import Axis, Unit
from simcore.phoenix6.standin.talon_frame import REQ_BRAKE, REQ_COAST, TalonFrame

if TYPE_CHECKING:
    from simcore.phoenix6.standin.talon import Talon

__all__ = ["follow", "turning"]

_OPPOSED = 1


def _leader(talon: Talon) -> Talon | None:
    leader = talon.world.devices.get((talon.type_number, int(talon.args[1])))
    return leader if leader is not talon else None  # type: ignore[return-value]


def turning(talon: Talon) -> float:
    """Direction in which a positive output turns the motor: its own, or for a follower the leader's.

    Source: measured. A `Follower` takes over the leader's inversion, a `StrictFollower` keeps its own.
    """
    if talon.kind.axis is not Axis.FOLLOW or talon.kind.name == "StrictFollower":
        return talon.sign
    leader = _leader(talon)
    if leader is None:
        return talon.sign
    return -leader.turn if talon.args[2] == _OPPOSED else leader.turn


def follow(talon: Talon, loops: int) -> None:
    """Put out what the leader's last frame says, in the unit that the leader drives with; nothing without a leader."""
    bridge = talon.bridge
    leader = _leader(talon)
    if leader is None:
        bridge.rest()
        bridge.neutral(bridge.brake)
        return
    talon.turn = turning(talon)
    bridge.rps, bridge.late_rps = talon.rotor_rps * talon.turn, talon.late_rps * talon.turn
    leader.watch()
    frame: TalonFrame = leader.frame
    if frame.bridge in (REQ_COAST, REQ_BRAKE):
        bridge.neutral(frame.bridge == REQ_BRAKE)
        return
    unit = leader.kind.unit
    key = (f"follow {unit.value}", 0, True)
    plan = talon.plans.get(key)
    if plan is None:
        plan = talon.plans[key] = (None, bridge.stage(unit, closed=True, foc=True), Gains())
    bridge.override, bridge.deadband, bridge.max_duty = False, 0.0, 1.0
    bridge.blocked_forward = bridge.blocked_reverse = False
    assert plan[1] is not None
    plan[1]({Unit.DUTY: frame.duty, Unit.VOLTS: frame.volts, Unit.AMPERES: frame.current}[unit], loops)
