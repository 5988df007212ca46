"""What `sim_state` and SimDevices write to a motor controller and read of it, by the names of CTRE's library."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simcore.phoenix6_emulator.electrical import KRAKEN_X44, KRAKEN_X60

if TYPE_CHECKING:
    from simcore.phoenix6_emulator.talon import Talon

__all__ = ["get", "put"]


def put(talon: Talon, name: str, value: float) -> bool:
    """Write a value; False where there is none of that name. Rotors turn counter-clockwise."""
    if name == "RawRotorPosition":
        talon.raw = value
    elif name == "RotorVelocity":
        talon.rotor_rps = value
    elif name == "RotorAcceleration":
        talon.rotor_acceleration = value
    elif name == "SupplyVoltage":
        talon.supply = talon.bridge.supply = max(value, 4.0)
    elif name == "AddRotorPosition":
        talon.raw += value
    elif name == "ForwardLimit":
        talon.forward.closed = value != 0.0
    elif name == "ReverseLimit":
        talon.reverse.closed = value != 0.0
    elif name == "MotorType":
        talon.bridge.motor = KRAKEN_X44 if value == 1.0 else KRAKEN_X60
        talon.configured()
    else:
        return False
    return True


def get(talon: Talon, name: str) -> float | None:
    """Read a value; None where there is none of that name. Shafts counter-clockwise, the torque current as in code."""
    bridge = talon.bridge
    if name == "MotorVoltage":
        return bridge.volts * talon.turn
    if name == "TorqueCurrent":
        return bridge.current
    if name == "SupplyCurrent":
        return bridge.supply_current
    if name == "DutyCycle":
        return bridge.duty
    if name == "SupplyVoltage":
        return talon.supply
    if name == "RotorPosition":
        return talon.turn * talon.rotor_position
    if name == "RawRotorPosition":
        return talon.raw
    if name == "RotorVelocity":
        return talon.rotor_rps
    if name == "RotorAcceleration":
        return talon.rotor_acceleration
    if name in ("ForwardLimit", "ReverseLimit"):
        return float((talon.forward if name == "ForwardLimit" else talon.reverse).closed)
    return None
