"""A slot of closed-loop gains, read from a device's configuration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6_emulator.wire import Setting

__all__ = ["Gains", "gains_of"]

_FIRST = (SpnValue.SLOT0_K_P.value, SpnValue.SLOT1_K_P.value, SpnValue.SLOT2_K_P.value)
_SIGN = (SpnValue.SLOT0_K_S_SIGN.value, SpnValue.SLOT1_K_S_SIGN.value, SpnValue.SLOT2_K_S_SIGN.value)
_OFFSET = (
    SpnValue.SLOT0_K_G_POS_OFFSET.value,
    SpnValue.SLOT1_K_G_POS_OFFSET.value,
    SpnValue.SLOT2_K_G_POS_OFFSET.value,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Gains:
    """Gains of one slot, in the unit of the request (volts, duty cycle or amperes) per rotation and its rates."""

    kp: float = 0.0
    ki: float = 0.0
    kd: float = 0.0
    ks: float = 0.0
    kv: float = 0.0
    ka: float = 0.0
    kg: float = 0.0
    arm: bool = False
    """Whether kG turns with the cosine of the position (an arm) and is not constant (an elevator)."""
    sign_of_error: bool = False
    """Whether kS has the sign of the closed-loop error and not that of the reference velocity."""
    kg_offset: float = 0.0
    """Added to the position before its cosine is taken [rotations]."""


def gains_of(config: Mapping[int, Setting], slot: int) -> Gains:
    """Gains of slot 0, 1 or 2."""
    first = _FIRST[slot]
    p, i, d, s, v, a, g, kind = (config[first + k] for k in range(8))
    return Gains(
        kp=p,
        ki=i,
        kd=d,
        ks=s,
        kv=v,
        ka=a,
        kg=g,
        arm=kind == 1,
        sign_of_error=config[_SIGN[slot]] == 1,
        kg_offset=config[_OFFSET[slot]],
    )
