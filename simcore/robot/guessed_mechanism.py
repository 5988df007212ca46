"""What a motor controller's configuration tells of a mechanism that nobody has described."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanism_friction import default_friction, friction_from_volts
from simcore.robot.mechanisms import ArmSim
from simcore.robot.shaft import ShaftSim

__all__ = ["GuessedMechanism", "guessed_inertia", "guessed_weight", "with_guessed_friction"]

_SPIN_UP = 0.05  # [s]; time constant without a kA. Estimate: rollers are .02-.1, shooters .1-.5


@dataclass(frozen=True, slots=True, kw_only=True)
class GuessedMechanism:
    """What a group of motor controllers probably turns."""

    mechanism: ShaftSim
    motor: str

    ARM_GAIN: ClassVar[str] = "kG"
    """Gain whose volts hold an arm."""

    @property
    def has_weight(self) -> bool:
        """Whether gravity acts on it."""
        return isinstance(self.mechanism, ArmSim) or self.mechanism.load_torque != 0.0

    def __str__(self) -> str:
        m = self.mechanism
        text = f"{m.motors} x {self.motor}, {m.gearing:.3g}:1, {m.inertia:.2g} kg m^2"
        if isinstance(m, ArmSim):
            return f"{text}, weight of its {self.ARM_GAIN} as an arm"
        return text + (", weight of its kG" if self.has_weight else "")


def with_guessed_friction(gearbox: GearboxConfig, static_volts: float) -> GearboxConfig:
    """The same with the friction of a kS [V]; 0: it is not tuned, and the friction is the default of its motors."""
    friction = friction_from_volts(gearbox, static_volts) if static_volts else default_friction(gearbox)
    return replace(gearbox, friction_torque=friction)


def guessed_inertia(gearbox: GearboxConfig, kv: float, ka: float) -> float:
    """Inertia at the mechanism [kg m^2] with a time constant of kA / kV [s], 50 ms where these are not tuned."""
    spin_up = ka / kv if ka > 0.0 and kv > 0.0 else _SPIN_UP
    return spin_up * (gearbox.torque_per_amp / gearbox.resistance) * gearbox.volts_per_speed


def guessed_weight(gearbox: GearboxConfig, inertia: float, torque: float) -> ShaftSim:
    """A shaft with a load [N m] that does not depend on its angle, at rest on a stop; a free shaft without one.

    A weight that pulls up (a negative kG: a spring, or counting down) rests on the upper stop.
    """
    if torque == 0.0:
        return ShaftSim(gearbox, inertia)
    shaft = ShaftSim(gearbox, inertia, **{"lower_stop" if torque > 0.0 else "upper_stop": 0.0})
    shaft.set_load(-torque)
    return shaft
