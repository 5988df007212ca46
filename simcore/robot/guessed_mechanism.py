"""What a motor controller's configuration tells of a mechanism that nobody has described.

It keeps at-setpoint logic alive: velocity loops spin up, position loops arrive, gravity gains find the weight that they
hold. It is no model of anything in particular; `simcore.toml` describes the real mechanism.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from simcore.robot.gearbox import GearboxConfig, default_friction, friction_from_volts
from simcore.robot.mechanisms import ArmConfig, ArmSim
from simcore.robot.shaft import ShaftSim

__all__ = ["GuessedMechanism", "guessed_inertia", "guessed_shaft"]

_SPIN_UP = 0.05  # [s]; time constant without a kA. Estimate: rollers are .02-.1, shooters .1-.5


@dataclass(frozen=True, slots=True, kw_only=True)
class GuessedMechanism:
    """What a group of motor controllers probably turns."""

    mechanism: ShaftSim
    motor: str
    arm_gain: str = "kG"
    """Gain whose volts hold an arm."""
    sensors: tuple[tuple[str, int], ...] = ()
    """Further devices that show where it is, as (model, id)."""

    has_wired_sensor: bool = False
    """Whether an encoder that is wired to the controller shows where it is."""

    @property
    def has_weight(self) -> bool:
        """Whether gravity acts on it."""
        return isinstance(self.mechanism, ArmSim) or self.mechanism.load_torque != 0.0

    def __str__(self) -> str:
        m = self.mechanism
        text = f"{m.motors} x {self.motor}, {m.gearing:.3g}:1, {m.inertia:.2g} kg m^2"
        if isinstance(m, ArmSim):
            return f"{text}, weight of its {self.arm_gain} as an arm"
        return text + (", weight of its kG" if self.has_weight else "")


def guessed_inertia(gearbox: GearboxConfig, spin_up: float = _SPIN_UP) -> float:
    """Inertia at the mechanism with which motors reach 63 % of their speed in so many seconds [kg m^2]."""
    return spin_up * gearbox.torque_per_amp / gearbox.resistance * gearbox.volts_per_speed


def guessed_shaft(
    gearbox: GearboxConfig,
    *,
    static: float = 0.0,
    kv: float = 0.0,
    ka: float = 0.0,
    weight: float = 0.0,
    arm: tuple[float, float] | None = None,
) -> ShaftSim:
    """A free shaft; with a weight, one that rests on a stop where it is at first.

    A weight that pulls up (a negative kG: a spring, or counting down) rests on the upper stop.

    Args:
        gearbox: Motors and gears.
        static: kS [V]; 0: it is not tuned, and the friction is the default of its motors.
        kv: In any unit that `ka` is in as well; their quotient is the time constant, 50 ms where they are not tuned.
        ka: See `kv`.
        weight: Volts that hold it: kG, of an arm that is level.
        arm: Lower stop and start of an arm [rad]; None: the load does not depend on the angle.
    """
    friction = friction_from_volts(gearbox, static) if static else default_friction(gearbox)
    gearbox = replace(gearbox, friction_torque=friction)
    inertia = guessed_inertia(gearbox, ka / kv if ka > 0.0 and kv > 0.0 else _SPIN_UP)
    torque = weight * gearbox.torque_per_amp / gearbox.resistance
    if torque == 0.0:
        return ShaftSim(gearbox, inertia)
    if arm is None:
        shaft = ShaftSim(gearbox, inertia, **{"lower_stop" if torque > 0.0 else "upper_stop": 0.0})
        shaft.set_load(-torque)
        return shaft
    low, start = arm
    return ArmSim(
        ArmConfig(
            gearbox=gearbox,
            inertia=inertia,
            mass=torque,
            center_of_mass=1.0,
            gravity=1.0,  # mass and lever are not known apart, and need not be
            min_angle=low,
            max_angle=start + math.pi,
            start_angle=start,
        )
    )
