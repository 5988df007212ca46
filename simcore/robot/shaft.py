"""A motor-driven shaft, solved exactly: the base of every mechanism here.

With constant volts the shaft follows J dw/dt = kt I - friction + load with I = (V - ke w) / R, which is a straight
line in w. Its solution is an exponential, so one step of any length costs one `exp` and has no error. Whatever bends
the line (a current limit, friction that turns round, a hard stop) happens at an instant that can be computed; the
step is cut there and goes on with the next exact piece. One step costs about 1 us (a wpilib sim: 13-17 us).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

from simcore.errors import ConfigError, NonFiniteError
from simcore.quantities import ANGLE, INERTIA, require
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.limited_motor import within, within_supply

__all__ = ["ShaftSim"]

_Travel: TypeAlias = Callable[[float], float]
_MAX_PIECES = 16  # a step needs at most: limited, free, turn round, free, limited, stop
_EDGE = 1e-12  # relative width of "exactly at the current limit"
_REST = 1e-9  # [rad/s], a turn in 200 years: a shaft that nothing drives stands still from here on, and does not
# approach zero for ever, so that a robot at rest changes nothing in its log


class ShaftSim:
    """Motors, a gear and an inertia, with optional load, friction, current limit and hard stops.

    Args:
        gearbox: Motors and gear.
        inertia: Of everything that turns, seen at the mechanism [kg m^2].
        lower_stop: Hard stop [rad]; reaching it takes all the speed away.
        upper_stop: Hard stop [rad].
        position: At the start [rad].

    Raises:
        ConfigError: If the inertia is not positive, or the start is not between the stops.
    """

    __slots__ = (
        "_coasting",
        "_friction",
        "_ke",
        "_kt",
        "_limit",
        "_limit_below",
        "_limit_volts",
        "_load",
        "_lower",
        "_rate",
        "_resistance",
        "_resting",
        "_simple",
        "_supply_limit",
        "_upper",
        "current",
        "gearbox",
        "gearing",
        "inertia",
        "motors",
        "position",
        "supply_current",
        "velocity",
        "volts",
    )

    def __init__(
        self,
        gearbox: GearboxConfig,
        inertia: float,
        *,
        lower_stop: float = -math.inf,
        upper_stop: float = math.inf,
        position: float = 0.0,
    ) -> None:
        require(type(self).__name__, "inertia", inertia, INERTIA)
        require(type(self).__name__, "position", position, ANGLE)
        if not lower_stop <= position <= upper_stop or not lower_stop < upper_stop:
            raise ConfigError(
                f"{type(self).__name__}: want lower stop <= start <= upper stop,"
                f" got {lower_stop}, {position}, {upper_stop}"
            )
        self.gearbox = gearbox
        self.inertia = inertia
        self.position = position
        """Angle of the mechanism [rad]."""
        self.velocity = 0.0
        """Rate of the mechanism [rad/s]."""
        self.volts = 0.0
        """Voltage asked for, before the battery limits it [V]; `set_volts` sets it."""
        self.current = 0.0
        """Stator current of all motors together, mean of the last step [A]."""
        self.supply_current = 0.0
        """Current that all motors took from the battery, mean of the last step; below zero they feed it [A]."""
        self.gearing = gearbox.gearing
        """Rotor turns per turn of the mechanism [-]."""
        self.motors = gearbox.motors
        """Motors that share the current."""
        self._load = 0.0
        self._coasting = False
        self._resting: tuple[float, float, bool] | None = None  # place and load that friction or a stop holds
        self._kt = gearbox.torque_per_amp
        self._ke = gearbox.volts_per_speed
        self._resistance = gearbox.resistance
        self._limit = gearbox.stator_current_limit
        self._supply_limit = gearbox.supply_current_limit
        self._limit_below = self._limit * (1.0 - _EDGE)
        self._limit_volts = self._limit * self._resistance
        self._friction = gearbox.friction_torque
        self._lower = lower_stop
        self._upper = upper_stop
        self._rate = self._kt * self._ke / (self._resistance * inertia)
        has_stops = math.isfinite(lower_stop) or math.isfinite(upper_stop)
        self._simple = math.isinf(self._limit) and self._friction == 0.0 and not has_stops

    @property
    def stops(self) -> tuple[float, float]:
        """Lower and upper hard stop [rad]; infinite where there is none."""
        return self._lower, self._upper

    @property
    def time_constant(self) -> float:
        """Time in which the speed comes 63 % closer to its end value [s]."""
        return 1.0 / self._rate

    @property
    def kinetic_energy(self) -> float:
        """Energy in the turning parts [J]."""
        return 0.5 * self.inertia * self.velocity * self.velocity

    def set_volts(self, volts: float) -> None:
        """Hold this voltage from the next step on; zero volts brake.

        Raises:
            NonFiniteError: If `volts` is NaN or infinite.
        """
        if not math.isfinite(volts):
            raise NonFiniteError(f"{type(self).__name__}: volts must be a finite number, got {volts}")
        self.volts = float(volts)  # one of numpy's would make all that follows from it numpy's: ten times slower
        self._coasting = False

    @property
    def load_torque(self) -> float:
        """Torque from outside on the mechanism, along positive motion [N m]."""
        return self._load

    def set_load(self, torque: float) -> None:
        """Let this torque [N m] act from outside, along positive motion, from the next step on."""
        if not math.isfinite(torque):
            raise NonFiniteError(f"{type(self).__name__}: load torque must be a finite number, got {torque}")
        self._load = torque

    def coast(self) -> None:
        """Open the circuit: no current flows until volts are set again."""
        self.volts = 0.0
        self._coasting = True

    def reset(self, position: float = 0.0, velocity: float = 0.0) -> None:
        """Put the shaft somewhere, with zero volts asked for."""
        if not (math.isfinite(position) and math.isfinite(velocity)):
            raise NonFiniteError(f"{type(self).__name__}: state must be finite, got {position} rad, {velocity} rad/s")
        self.position = min(max(position, self._lower), self._upper)
        self.velocity = velocity
        self.volts = self.current = self.supply_current = 0.0
        self._coasting = False

    def step(self, dt: float, battery_voltage: float = 12.0) -> None:
        """Move on by `dt`, with the volts held.

        Args:
            dt: Any length; the solution is exact [s].
            battery_voltage: The motors get no more than this, either way [V].

        Raises:
            ConfigError: If `dt` is not positive or a number is NaN.
        """
        if not 0.0 < dt < math.inf:
            raise ConfigError(f"{type(self).__name__}: dt must be finite and > 0 s, got {dt}")
        if not 0.0 <= battery_voltage < math.inf:
            raise ConfigError(
                f"{type(self).__name__}: battery_voltage must be finite and >= 0 V, got {battery_voltage}"
            )
        if self.volts == 0.0 and self.velocity == 0.0:  # nothing to do, as for most of a match
            if self._load == 0.0 or self._resting == (self.position, self._load, self._coasting):
                self.current = self.supply_current = 0.0
                return
        volts = within(self.volts, battery_voltage)
        if self._supply_limit != math.inf and not self._coasting:
            emf = self._ke * self.velocity
            # The stator limit first: where it keeps the supply limit as well, the pieces of the step keep it exactly.
            asked = emf + within(volts - emf, self._limit_volts)
            kept = within_supply(asked, emf, self._resistance, self._supply_limit * battery_voltage)
            if kept != asked:
                volts = kept
        if self._simple and not self._coasting:
            charge, energy = self._run_free(volts, dt)
        else:
            charge, energy = self._run_in_pieces(volts, dt)
        if -_REST < self.velocity < _REST:
            self.velocity = 0.0
        motors = self.motors
        self.current = motors * charge / dt
        self.supply_current = motors * energy / (battery_voltage * dt) if battery_voltage > 0.0 else 0.0

    def _run_free(self, volts: float, dt: float) -> tuple[float, float]:
        """The whole step as one exponential; charge [A s] and electrical energy [J] of one motor."""
        target = (volts + self._load * self._resistance / self._kt) / self._ke
        gap = self.velocity - target
        decay = math.expm1(-self._rate * dt)
        angle = target * dt - gap * decay / self._rate
        self.velocity += gap * decay
        self.position += angle
        charge = (volts * dt - self._ke * angle) / self._resistance
        return charge, volts * charge

    def _run_in_pieces(self, volts: float, dt: float) -> tuple[float, float]:
        """The step cut where the law changes; charge [A s] and electrical energy [J] of one motor."""
        left = dt
        charge = energy = 0.0
        for _ in range(_MAX_PIECES):
            friction = self._friction_now(volts)
            if friction is None:  # held by friction or by a stop
                if volts == 0.0 and left == dt:
                    self._resting = (self.position, self._load, self._coasting)
                amps = self._stall_amps(volts)
                charge += amps * left
                energy += amps * amps * self._resistance * left
                break
            used, piece_charge, piece_energy = self._piece(volts, self._load - friction, left)
            charge += piece_charge
            energy += piece_energy
            left -= used
            if left <= 0.0:
                break
        return charge, energy

    def _stall_amps(self, volts: float) -> float:
        if self._coasting:
            return 0.0
        return within(volts / self._resistance, self._limit)

    def _friction_now(self, volts: float) -> float | None:
        """Friction torque against the motion that is or is about to start; None if the shaft stays where it is."""
        direction = self.velocity
        if self.position >= self._upper if direction > 0.0 else direction < 0.0 and self.position <= self._lower:
            direction = self.velocity = 0.0
        if direction == 0.0:
            direction = self._kt * self._stall_amps(volts) + self._load
            if abs(direction) <= self._friction:
                return None
            if self.position >= self._upper if direction > 0.0 else self.position <= self._lower:
                return None
        return math.copysign(self._friction, direction)

    def _piece(self, volts: float, torque: float, left: float) -> tuple[float, float, float]:
        """One exact piece under constant outside `torque`; time used, charge and energy of one motor."""
        start = self.velocity
        stopped = None
        position = self.position
        amps: float | None = None
        edge: float | None = None
        if self._coasting:
            amps = 0.0
        else:
            asked = (volts - self._ke * start) / self._resistance
            if not abs(asked) < self._limit_below:
                amps, edge = self._limited_amps(volts, torque, asked)
        if amps is not None:
            slope = (self._kt * amps + torque) / self.inertia
            used = left
            end = start + slope * used
            if edge is not None and (start < edge < end or end < edge < start):
                used, end = (edge - start) / slope, edge
            # compared, not multiplied: a product would underflow to "does not pass"
            if start < 0.0 < end or end < 0.0 < start:
                used, end = -start / slope, 0.0
            angle = 0.5 * (start + end) * used
            if position + angle > self._upper or position + angle < self._lower:
                stopped = self._time_to_stop(angle, _even(start, slope), used)
                used, end = stopped, start + slope * stopped
                angle = 0.5 * (start + end) * used
            charge = amps * used
            energy = 0.0 if self._coasting else amps * (amps * self._resistance * used + self._ke * angle)
        else:
            rate = self._rate
            target = (volts + torque * self._resistance / self._kt) / self._ke
            gap = start - target
            used = left
            end = target + gap * math.exp(-rate * used)
            if start < 0.0 < end or end < 0.0 < start:
                # min: a subnormal target divides to infinity
                used, end = min(used, math.log(gap / -target) / rate), 0.0
            if abs(volts - self._ke * end) > self._limit_volts * (1.0 + _EDGE):
                edge = (volts - math.copysign(self._limit_volts, volts - self._ke * end)) / self._ke
                used, end = min(used, math.log(gap / (edge - target)) / rate), edge
            angle = target * used + (start - end) / rate
            if position + angle > self._upper or position + angle < self._lower:
                stopped = self._time_to_stop(angle, _settling(target, gap, rate), used)
                used = stopped
                end = target + gap * math.exp(-rate * used)
                angle = target * used + (start - end) / rate
            charge = (volts * used - self._ke * angle) / self._resistance
            energy = volts * charge
        if stopped is None:
            self.position = position + angle
            self.velocity = end
        else:
            self.position = self._upper if angle > 0.0 else self._lower
            self.velocity = 0.0
        return used, charge, energy

    def _limited_amps(self, volts: float, torque: float, asked: float) -> tuple[float | None, float | None]:
        """Amps per motor that the limit holds, and the speed at which it lets go; None where it does not act.

        Args:
            volts: At the motors [V].
            torque: From outside [N m].
            asked: Current without the limit, at its edge or past it [A].
        """
        amps = math.copysign(self._limit, asked)
        if abs(asked) <= self._limit * (1.0 + _EDGE) and (self._kt * amps + torque) * amps > 0.0:
            return None, None  # at the edge and on the way out of the limit
        return amps, (volts - amps * self._resistance) / self._ke

    def _time_to_stop(self, angle: float, travel: _Travel, used: float) -> float:
        """When, within `used` seconds of one-way motion over `angle`, which leads past it, a hard stop is met."""
        room = (self._upper if self.position + angle > self._upper else self._lower) - self.position
        low, high = 0.0, used
        for _ in range(50):  # rare: once per hit, 50 halvings reach the last bit
            middle = 0.5 * (low + high)
            if abs(travel(middle)) < abs(room):
                low = middle
            else:
                high = middle
        return high


def _even(start: float, slope: float) -> _Travel:
    """Angle over time at a constant acceleration [rad]."""
    return lambda t: t * (start + 0.5 * slope * t)


def _settling(target: float, gap: float, rate: float) -> _Travel:
    """Angle over time at a speed that settles at `target` [rad]."""
    return lambda t: target * t - gap * math.expm1(-rate * t) / rate
