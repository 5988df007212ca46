"""How a controller carries out one kind of request: built once, used each step."""

from __future__ import annotations

from dataclasses import dataclass

from phoenix6.signals import BridgeOutputValue

from simcore.phoenix6_emulator.bridge import Stage
from simcore.phoenix6_emulator.gains import Gains
from simcore.phoenix6_emulator.laws import Law
from simcore.phoenix6_emulator.profile import Profile

__all__ = ["REQ_BRAKE", "REQ_COAST", "REQ_FOC", "REQ_TORQUE", "REQ_TRAPEZOIDAL", "Plan"]

REQ_COAST, REQ_BRAKE, REQ_TRAPEZOIDAL, REQ_TORQUE, REQ_FOC = (
    int(BridgeOutputValue[f"BRIDGE_REQ_{name}"].value)
    for name in ("COAST", "BRAKE", "TRAPEZ", "FOC_TORQUE", "FOC_EASY")
)
"""What a bridge does, as `get_bridge_output` tells."""


@dataclass(frozen=True, slots=True)
class Plan:
    """Law and output stage, and what status frames say of them."""

    law: Law | None
    """None: the bridge lets go, brakes or follows."""
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
    """0 to 2: number of the unit in which the loop's output is told, after that of the duty cycle."""
    on_velocity: bool
    """Whether a velocity is controlled."""
    looks: bool
    """Whether the law reads a sensor."""
    remembers: bool
    """Whether the output depends on what was before: an integral, a ramp."""
