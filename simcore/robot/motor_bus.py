"""All motors on one battery: the voltage that they agree on, and what they drew."""

from __future__ import annotations

from collections.abc import Sequence

from simcore.robot.limited_motor import LimitedMotor
from simcore.units import plain_sum

__all__ = ["MotorReadout", "bus_voltage"]


def bus_voltage(
    guess: float,
    open_voltage: float,
    resistance: float,
    other_current: float,
    motors: Sequence[LimitedMotor],
    requests: Sequence[float | None],
    limits: Sequence[float],
    emfs: Sequence[float],
) -> float:
    """Voltage at which battery and motors agree: V = V_open - R (I_other + I_motors(V)).

    Four stalled motors have less resistance together than the battery, so last step's current must not set this
    step's voltage: that would ring between 0 and 13 V. Newton from the last voltage; one round when nothing changes.

    Args:
        guess: Voltage of the last step [V].
        open_voltage: Behind the resistance [V].
        resistance: Of the battery [ohm].
        other_current: Drawn by everything else [A].
        motors: Constants per motor.
        requests: Voltage wanted per motor; None is an open circuit [V].
        limits: Stator limit per motor [A].
        emfs: Back-EMF per motor now [V].
    """
    bus = guess if guess > 1e-3 else open_voltage
    if bus < 1e-3:
        return 0.0
    turning = [
        (m, m.winding != m.resistance, m.conductance, m.winding, m.supply_limit, m.count, v, limit, emf)
        for m, v, limit, emf in zip(motors, requests, limits, emfs, strict=True)
        if v is not None
    ]
    for _ in range(8):
        total = other_current
        rise = 0.0  # d total / d bus
        per_bus = 1.0 / bus
        for m, has_supply, conductance, own_resistance, supply_limit, count, v, limit, emf in turning:
            if has_supply:
                v, line = m.line_in_force(v, bus, emf, limit)
                conductance = 1.0 / line
            if v >= bus:
                drawn = i = (bus - emf) * conductance
                slope = conductance
            elif v <= -bus:
                i = (-bus - emf) * conductance
                drawn = -i
                slope = conductance
            else:
                i = (v - emf) * conductance
                drawn = v * i * per_bus
                slope = -drawn * per_bus
            if i > limit or i < -limit:
                i = limit if i > 0.0 else -limit
                drawn = (emf + i * own_resistance) * i * per_bus
                slope = -drawn * per_bus
            if drawn > supply_limit or drawn < -supply_limit:
                drawn = supply_limit if drawn > 0.0 else -supply_limit
                slope = 0.0
            total += drawn * count
            rise += slope * count
        miss = open_voltage - resistance * total - bus
        if -0.01 < miss < 0.01:
            break
        steep = 1.0 + resistance * rise
        # Beyond the point of greatest power Newton would run uphill: halve until the requests saturate.
        new = bus + miss / steep if steep > 0.2 else (0.5 * bus if miss < 0.0 else open_voltage)
        bus = new if new > 0.0 else 0.5 * bus
        if bus < 1e-3:
            return 0.0
    return bus


class MotorReadout:
    """What the motors of one kind did in the last inner step, one entry per motor.

    Sums are kept as they come and turned into what people ask for only when they ask: this runs every inner step.
    """

    __slots__ = ("_bus", "_charge2", "_resistance", "current", "energy", "volts")

    def __init__(self, resistance: Sequence[float]) -> None:
        """All at rest, nothing taken.

        Args:
            resistance: Of each motor [ohm].
        """
        n = len(resistance)
        self._resistance = tuple(resistance)
        self._bus = 0.0
        self._charge2 = [0.0] * n
        self.volts = [0.0] * n
        """At the terminals [V]."""
        self.current = [0.0] * n
        """Stator current [A]."""
        self.energy = 0.0
        """Electrical energy that all of them took since the last reset: the integral of V I [J]."""

    @property
    def supply(self) -> list[float]:
        """Current from the battery; negative feeds back [A]."""
        if self._bus <= 0.0:
            return [0.0] * len(self.volts)
        return [v * i / self._bus for v, i in zip(self.volts, self.current, strict=True)]

    @property
    def heat(self) -> list[float]:
        """Copper loss since the last reset [J]."""
        return [r * q for r, q in zip(self._resistance, self._charge2, strict=True)]

    @property
    def supply_total(self) -> float:
        """Current from the battery of all of them [A]."""
        return plain_sum(self.supply)

    def accumulate(self, volts: list[float], current: list[float], bus: float, h: float) -> float:
        """Add one inner step of `h` [s]; the current from the battery [A]."""
        self.volts = volts
        self.current = current
        self._bus = bus
        charge2 = self._charge2
        power = 0.0
        for k, i in enumerate(current):
            power += volts[k] * i
            charge2[k] += i * i * h
        self.energy += power * h
        return power / bus if bus > 0.0 else 0.0
