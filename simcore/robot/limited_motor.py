"""A geared DC motor behind its controller: bus voltage, brake and coast, stator and supply limit, in four quadrants.

A request is a voltage, or None for an open circuit (coast); zero volts brake. `limited_volts` is the law at a given
speed: what the controller puts on the motor so that the voltage stays within the bus, the current within the stator
limit, and the power, drawn or fed back, within the supply limit times the bus voltage.

The rest solves the same law together with the shaft that the motor turns, one scalar equation per shaft and step.
Backward Euler for the shaft speed w is

    k w = a + T(w)          k = J/h + (tire stiffness),   a = J/h w_old + (tire force)

and the torque T of motor, limits, gear loss and dry friction never rises with w. So there is exactly one solution
for any inertia and any step, it is found by a few comparisons, and it cannot diverge.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

from simcore.robot.dc_motor import MotorModel

__all__ = [
    "LOCKED",
    "LimitedMotor",
    "MotorConstants",
    "end_weight",
    "limited_volts",
    "solve_limited",
    "solve_shaft",
    "solve_supply",
    "supply_line",
    "torque_line",
    "within",
    "within_supply",
]

MotorConstants: TypeAlias = tuple[float, float, float, float, float]
"""Back-EMF per shaft speed, resistance, torque per current driving and driven, dry friction; see `LimitedMotor`."""

LOCKED = 1e12
"""Slope of a torque line that stands for a shaft held by friction [N m s]."""


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

    def line_in_force(self, volts: float, bus: float, emf: float, limit: float) -> tuple[float, float]:
        """What holds now of a motor whose controller makes up for the resistance before it.

        It does so as long as its duty lets it: of (V - e) / R_winding, (V_bus - e) / R and the stator limit the
        smallest flows.

        Args:
            volts: Wanted [V].
            bus: Battery voltage [V].
            emf: Back-EMF now [V].
            limit: Stator limit in force [A].

        Returns:
            Voltage [V] and resistance [ohm] of the line I = (V - e) / R.
        """
        volts = within(volts, bus)
        full = bus if volts > 0.0 else -bus
        at_full = abs(full - emf) * self.conductance
        is_driving = (volts - emf) * volts > 0.0
        if is_driving and at_full < limit and at_full * self.winding < abs(volts - emf):
            return full, self.resistance
        return volts, self.winding


def end_weight(h: float, rate: float) -> float:
    """Share of the end of a step in the mean that makes the step of w' = -rate w exact (exponential fitting).

    A slow shaft (rate h << 1) gets 1/2, the trapezoidal rule of second order; a fast one tends to 1, backward Euler,
    which does not ring.

    Args:
        h: Time step [s].
        rate: At which back-EMF slows the free shaft down [1/s].
    """
    z = h * rate
    if z < 1e-3:
        return 0.5 + z / 12.0
    return -1.0 / math.expm1(-z) - 1.0 / z


def within(value: float, limit: float) -> float:
    """The number nearest to `value` in -limit..limit: a voltage within the bus, a current within the stator limit."""
    if value > limit:
        return limit
    if value < -limit:
        return -limit
    return value


def within_supply(volts: float, emf: float, resistance: float, power: float) -> float:
    """The voltage nearest to `volts` with |V I| within `power` at a given back-EMF [V].

    The power (V - e) V / R that is drawn grows with |V| beyond e, so its limit is a root of a quadratic. Between 0 and
    e the motor feeds back, at most e^2 / 4R; the limit then is the root on the side of e, with less braking torque.

    Args:
        volts: Wanted [V].
        emf: Back-EMF e [V].
        resistance: Of the motor [ohm].
        power: Supply limit times bus voltage [W].
    """
    drawn = (volts - emf) * volts / resistance
    if drawn > power:
        root = math.sqrt(emf * emf + 4.0 * resistance * power)
        return 0.5 * (emf + root) if volts > 0.0 else 0.5 * (emf - root)
    if drawn < -power:
        return 0.5 * (emf + math.copysign(math.sqrt(max(0.0, emf * emf - 4.0 * resistance * power)), emf))
    return volts


def limited_volts(
    volts: float, emf: float, resistance: float, *, bus: float, stator_limit: float, supply_limit: float
) -> float:
    """What a controller puts on its motor at a given speed [V]; the current is (V - e) / R.

    Args:
        volts: Wanted [V].
        emf: Back-EMF e at this speed [V].
        resistance: Of the motor [ohm].
        bus: Battery voltage [V].
        stator_limit: Of the motor current [A].
        supply_limit: Of the battery current, drawing and feeding back [A].
    """
    most = stator_limit * resistance
    return within_supply(emf + within(within(volts, bus) - emf, most), emf, resistance, supply_limit * bus)


def solve_shaft(
    k: float, a: float, i0: float, i1: float, limit: float, drive: float, driven: float, friction: float
) -> tuple[float, float, float, float]:
    """Solve `k w = a + T(w)` exactly for a limited motor behind lossy gears with dry friction.

    Args:
        k: Stiffness, > 0 [N m s].
        a: Torque that is there without the motor [N m].
        i0: Motor current at standstill, before the limit [A].
        i1: How much the current falls per shaft speed, >= 0 [A s/rad].
        limit: Of the current, in both directions [A].
        drive: Torque per current while the motor drives [N m/A].
        driven: Torque per current while it is driven, >= drive [N m/A].
        friction: Dry friction [N m].

    Returns:
        Shaft speed [rad/s], current [A], and the line T = t0 - t1 w that holds there: t0 [N m], t1 [N m s].
    """
    current = i0
    if current > limit:
        current = limit
    elif current < -limit:
        current = -limit
    # Torque just above and just below standstill: between them gear loss and friction hold the shaft.
    if current > 0.0:
        up = a + drive * current - friction
        down = a + driven * current + friction
    else:
        up = a + driven * current - friction
        down = a + drive * current + friction
    if up > 0.0:
        a -= friction
        # The motor drives below its free speed i0 / i1; the torque balance at that speed tells on which side we are.
        f = drive if i0 > 0.0 and a * i1 < k * i0 else driven
        sign = -friction
    elif down < 0.0:
        a += friction
        f = drive if i0 < 0.0 and a * i1 > k * i0 else driven
        sign = friction
    else:
        return 0.0, current, 0.0, LOCKED
    w = (a + f * i0) / (k + f * i1)
    current = i0 - i1 * w
    if current > limit:
        torque = f * limit
        return (a + torque) / k, limit, torque + sign, 0.0
    if current < -limit:
        torque = f * limit
        return (a - torque) / k, -limit, sign - torque, 0.0
    return w, current, f * i0 + sign, f * i1


def solve_limited(
    k: float,
    a: float,
    i0: float,
    i1: float,
    stator_limit: float,
    constants: MotorConstants,
    emf_offset: float,
    w: float,
    power: float,
) -> tuple[float, float, float, float, float]:
    """`solve_shaft` within both limits, stator and supply.

    Args:
        k: See `solve_shaft`.
        a: See `solve_shaft`.
        i0: See `solve_shaft`.
        i1: See `solve_shaft`.
        stator_limit: In force now [A].
        constants: Of the motor.
        emf_offset: Back-EMF at standstill [V].
        w: Shaft speed before the step [rad/s].
        power: Supply limit times bus voltage [W].

    Returns:
        Shaft speed [rad/s], current [A], volts at the motor [V], and the line of torque: t0 [N m], t1 [N m s].
    """
    emf, resistance, driving, driven, friction = constants
    end, i, t0, t1 = solve_shaft(k, a, i0, i1, stator_limit, driving, driven, friction)
    volts = emf_offset + emf * end + i * resistance
    drawn = volts * i
    if drawn > power or drawn < -power:
        end, i, t0, t1 = solve_supply(k, a, i, drawn, stator_limit, constants, emf_offset, w, power)
        volts = emf_offset + emf * end + i * resistance
    return end, i, volts, t0, t1


def torque_line(
    volts: float | None,
    bus: float,
    emf_offset: float,
    w: float,
    limit: float,
    power: float,
    conductance: float,
    constants: MotorConstants,
) -> tuple[float, float, float, float]:
    """The lines of current and torque over shaft speed that hold near `w`.

    Args:
        volts: Wanted [V]; None is an open circuit.
        bus: Battery voltage, which the motor cannot exceed [V].
        emf_offset: Back-EMF at standstill (azimuth coupling) [V].
        w: Shaft speed [rad/s].
        limit: Stator limit in force [A].
        power: Supply limit times bus voltage [W].
        conductance: 1 / resistance [1/ohm].
        constants: Of the motor.

    Returns:
        `i0, i1` of the current I = i0 - i1 w without limits, and `t0, t1` of the torque T = t0 - t1 w within them.
    """
    emf, resistance, driving, driven, friction = constants
    i0 = i1 = t0 = t1 = 0.0
    if volts is not None:
        if volts > bus:
            volts = bus
        elif volts < -bus:
            volts = -bus
        i0 = (volts - emf_offset) * conductance
        i1 = emf * conductance
        i = i0 - i1 * w
        f = driving if i * w >= 0.0 else driven
        p = volts * i
        if p > power or p < -power:
            t0, t1 = supply_line(emf_offset + emf * w, emf, w, resistance, power, i, p)
            i = t0 - t1 * w
            t0 *= f
            t1 *= f
        else:
            t0 = f * i0
            t1 = f * i1
        if i > limit:
            t0 = f * limit
            t1 = 0.0
        elif i < -limit:
            t0 = -f * limit
            t1 = 0.0
    if w > 0.0:
        return i0, i1, t0 - friction, t1
    if w < 0.0:
        return i0, i1, t0 + friction, t1
    if t0 > friction:
        return i0, i1, t0 - friction, t1
    if t0 < -friction:
        return i0, i1, t0 + friction, t1
    return i0, i1, 0.0, LOCKED


def supply_line(
    emf: float, slope: float, w: float, resistance: float, power: float, current: float, drawn: float
) -> tuple[float, float]:
    """The current line that keeps |V I| within `power`, near a shaft speed.

    While drawing, the limit is the curve (e + I R) I = P, which is convex in e: its tangent at the present e stays
    below it, so the limit also holds at the end of the step. While regenerating, the controller reduces torque until
    the power fed back is within the limit; that current falls with e, so it is safe up to the e that is given.

    Args:
        emf: Back-EMF e [V].
        slope: Back-EMF per shaft speed [V s/rad].
        w: Shaft speed at which e was taken [rad/s].
        resistance: R [ohm].
        power: Limit P [W].
        current: The current that broke the limit; only its sign matters [A].
        drawn: The power that broke it; below zero it was fed back [W].

    Returns:
        `i0, i1` of the line I = i0 - i1 w, for `solve_shaft`.
    """
    if drawn < 0.0:
        e = abs(emf)
        return -math.copysign(0.5 * (e - math.sqrt(max(0.0, e * e - 4.0 * resistance * power))) / resistance, emf), 0.0
    sign = 1.0 if current > 0.0 else -1.0
    e = emf * sign
    size = 0.5 * (math.sqrt(e * e + 4.0 * resistance * power) - e) / resistance
    drop = size / (e + 2.0 * size * resistance) if size > 0.0 else 0.0
    return sign * size + drop * slope * w, drop * slope


def solve_supply(
    k: float,
    a: float,
    current: float,
    end_power: float,
    stator_limit: float,
    constants: MotorConstants,
    emf_offset: float,
    w: float,
    power: float,
) -> tuple[float, float, float, float]:
    """`solve_shaft` again, after its solution turned out to break the supply limit.

    Args:
        k: See `solve_shaft`.
        a: See `solve_shaft`.
        current: Of that solution [A].
        end_power: V I of that solution [W].
        stator_limit: In force now [A].
        constants: Back-EMF per speed, resistance, torque driving, torque driven, dry friction, as in `LimitedMotor`.
        emf_offset: Back-EMF at standstill (azimuth coupling) [V].
        w: Shaft speed before the step [rad/s].
        power: Supply limit times bus voltage [W].

    Returns:
        As `solve_shaft`.
    """
    emf, resistance, driving, driven, friction = constants
    if end_power > 0.0:
        i0, i1 = supply_line(emf_offset + emf * w, emf, w, resistance, power, current, end_power)
        result = solve_shaft(k, a, i0, i1, stator_limit, driving, driven, friction)
        # A shaft that is thrown backwards within the step can turn the drawing motor into a generator.
        if (emf_offset + emf * result[0] + result[1] * resistance) * result[1] >= -power:
            return result
    # With no current at all the shaft ends at the greatest |e| that it can have: limited there, limited always.
    w = solve_shaft(k, a, 0.0, 0.0, stator_limit, driving, driven, friction)[0]
    i0, i1 = supply_line(emf_offset + emf * w, emf, w, resistance, power, current, -1.0)
    return solve_shaft(k, a, i0, i1, stator_limit, driving, driven, friction)
