"""Followers: a motor controller repeats the output of its leader, late by the leader's status frames."""

from __future__ import annotations

from collections.abc import Callable

from simcore.phoenix6_emulator.control_requests import Axis, Unit
from simcore.phoenix6_emulator.output_stage import Stage
from simcore.phoenix6_emulator.talon_frame import TalonFrame
from simcore.phoenix6_emulator.talon_state import TalonState

__all__ = ["following", "turning"]

_OPPOSED = 1


def _leader(talon: TalonState) -> TalonState | None:
    leader = talon.devices.get((talon.type_number, int(talon.args[1])))
    return leader if isinstance(leader, TalonState) and leader is not talon else None


def _opposes(talon: TalonState) -> bool:
    return bool(talon.args[2] == _OPPOSED)


def turning(talon: TalonState) -> float:
    """Direction in which a positive output turns the motor: its own, or for a follower the leader's.

    Source: measured. A `Follower` takes over the leader's inversion, a `StrictFollower` keeps its own.
    """
    if talon.kind.axis is not Axis.FOLLOW or talon.kind.name == "StrictFollower":
        return talon.sign
    leader = _leader(talon)
    if leader is None:
        return talon.sign
    return -leader.turn if _opposes(talon) else leader.turn


def following(talon: TalonState) -> Callable[[int], None] | None:
    """The step of a follower; None for a motor whose request is another one.

    Its output is that of the leader's last frame, in the unit that the leader drives with; neutral without a leader.
    Built when request, configuration or devices change: a search for the leader each step would double its cost.
    """
    if talon.kind.axis is not Axis.FOLLOW:
        return None
    bridge, leader = talon.bridge, _leader(talon)
    if leader is None:
        return lambda loops: _alone(talon)
    found = leader
    if talon not in found.followers:
        found.followers.append(talon)
    is_strict = talon.kind.name == "StrictFollower"
    sign = -1.0 if not is_strict and _opposes(talon) else 1.0
    unit: Unit | None = None
    stage: Stage | None = None

    def drive(loops: int) -> None:
        nonlocal unit, stage
        talon.turn = turn = talon.sign if is_strict else sign * found.turn
        bridge.rps, bridge.late_rps = talon.rotor_rps * turn, talon.late_rps * turn
        frame: TalonFrame = found.frame
        if frame.is_neutral:
            bridge.neutral(frame.current != 0.0)  # a leader that brakes, not one that coasts
            return
        if stage is None or unit is not found.kind.unit:
            unit = found.kind.unit
            stage = bridge.stage(unit, closed=True, foc=True)
            bridge.override, bridge.deadband, bridge.max_duty = False, 0.0, 1.0
            bridge.blocked_forward = bridge.blocked_reverse = False
        stage(frame.volts if unit is Unit.VOLTS else (frame.duty if unit is Unit.DUTY else frame.current), loops)

    return drive


def _alone(talon: TalonState) -> None:
    talon.bridge.rest()
    talon.bridge.neutral(talon.bridge.brake)
