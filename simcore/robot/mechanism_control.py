"""Small controllers that turn a goal into volts, for scripted robots that have no robot code."""

from __future__ import annotations

from dataclasses import dataclass

from simcore.quantities import GAIN, VOLTAGE, VOLTAGE_OR_NONE, require_fields
from simcore.robot.gearbox import GearboxConfig

__all__ = ["PositionController", "VelocityController"]


@dataclass(frozen=True, slots=True, kw_only=True)
class VelocityController:
    """Feed-forward of the back-EMF plus a proportional term; holds no state, so it cannot wind up."""

    kv: float
    """Volts per speed of the goal [V s/rad]."""
    kp: float = 0.0
    """Volts per speed that is missing [V s/rad]."""
    ks: float = 0.0
    """Volts against friction, in the direction of the goal [V]."""
    max_volts: float = 12.0
    """Either way [V]."""

    def __post_init__(self) -> None:
        require_fields(self, kv=GAIN, kp=GAIN, ks=VOLTAGE_OR_NONE, max_volts=VOLTAGE)

    @classmethod
    def for_gearbox(cls, gearbox: GearboxConfig, *, kp: float = 0.0, max_volts: float = 12.0) -> VelocityController:
        """Feed-forward terms as the motor and its friction ask for them."""
        return cls(
            kv=gearbox.volts_per_speed,
            kp=kp,
            ks=gearbox.holding_volts(gearbox.friction_torque),
            max_volts=max_volts,
        )

    def volts(self, goal: float, velocity: float) -> float:
        """Volts that bring `velocity` to `goal` [rad/s]; a goal of zero brakes only as far as `kp` asks."""
        friction = self.ks if goal > 0.0 else -self.ks if goal < 0.0 else 0.0
        return _clamp(friction + self.kv * goal + self.kp * (goal - velocity), self.max_volts)


@dataclass(frozen=True, slots=True, kw_only=True)
class PositionController:
    """Proportional-derivative control of an angle or a length, with room for the weight as feed-forward."""

    kp: float
    """Volts per error of position [V/rad]."""
    kd: float = 0.0
    """Volts per speed, against it [V s/rad]."""
    max_volts: float = 12.0
    """Either way [V]."""

    def __post_init__(self) -> None:
        require_fields(self, kp=GAIN, kd=GAIN, max_volts=VOLTAGE)

    def volts(self, goal: float, position: float, velocity: float, feedforward: float = 0.0) -> float:
        """Volts that bring `position` to `goal` and stop there.

        Args:
            goal: Where to be [rad].
            position: Where it is [rad].
            velocity: How fast it goes [rad/s].
            feedforward: Added before the limit, as `ArmSim.holding_volts` [V].
        """
        return _clamp(feedforward + self.kp * (goal - position) - self.kd * velocity, self.max_volts)


def _clamp(volts: float, limit: float) -> float:
    return min(max(volts, -limit), limit)
