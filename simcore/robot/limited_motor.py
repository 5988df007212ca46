"""Constants of a geared DC motor behind its controller; `simcore.loop.motor` has what it does with them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from simcore.robot.dc_motor import MotorModel

__all__ = ["LimitedMotor"]


@dataclass(frozen=True, slots=True)
class LimitedMotor:
    """Constants of `count` equal motors on one shaft, seen from the shaft."""

    resistance: float
    """Of one motor at full duty [ohm]."""
    conductance: float
    """1 / resistance [1/ohm]."""
    winding: float
    """Of one motor behind its controller [ohm]; see `MotorModel.supply_resistance`."""
    emf: float
    """Back-EMF per shaft speed [V s/rad]."""
    torque_driving: float
    """Shaft torque per motor current while the motor drives the gears [N m/A]."""
    torque_driven: float
    """The same while the gears drive the motor; gear loss then helps to brake [N m/A]."""
    friction: float
    """Dry friction at the shaft [N m]."""
    stator_limit: float
    """Per motor [A]."""
    supply_limit: float
    """Per motor [A]."""
    count: int

    @staticmethod
    def of(
        model: MotorModel,
        *,
        gearing: float,
        efficiency: float = 1.0,
        friction_volts: float = 0.0,
        limits: tuple[float, float] = (math.inf, math.inf),
        count: int = 1,
    ) -> LimitedMotor:
        """Refer a motor behind a gear to the shaft; `limits` are of stator and supply, per motor [A]."""
        torque = model.kt * gearing * count
        stator_limit, supply_limit = limits
        return LimitedMotor(
            resistance=model.resistance,
            conductance=1.0 / model.resistance,
            winding=model.winding_resistance,
            emf=gearing / model.kv,
            torque_driving=torque * efficiency,
            torque_driven=torque / efficiency,
            # The voltage that just turns the shaft against friction is multiplied by the gears, as any torque is.
            friction=torque * efficiency * friction_volts / model.winding_resistance,
            stator_limit=stator_limit,
            supply_limit=supply_limit,
            count=count,
        )
