"""A motor-driven shaft: the base of every mechanism here.

It is a record in the arrays of the loop, which moves it with everything else of its robot; alone it is moved by `step`.
A step of the loop is exact for a motor on constant volts; limits, friction that turns round and hard stops act from
millisecond to millisecond.
"""

from __future__ import annotations

import math

from simcore.errors import ConfigError, NonFiniteError
from simcore.loop.robot_state import DUTY, MECHANISM, NEUTRAL, SHAFT, VOLTS, Records, records
from simcore.loop.shaft import turn_alone
from simcore.quantities import ANGLE, INERTIA, require
from simcore.robot.gearbox import GearboxConfig

__all__ = ["ShaftSim"]


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

    __slots__ = ("_record", "gearbox", "gearing", "inertia", "motors")

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
        self.gearing = gearbox.gearing
        """Rotor turns per turn of the mechanism [-]."""
        self.motors = gearbox.motors
        """Motors that share the current."""
        self._record = records(SHAFT)
        for name, value in {
            "kind": MECHANISM,
            "inertia": inertia,
            "emf": gearbox.volts_per_speed,
            "resistance": gearbox.resistance,
            "winding": gearbox.resistance,
            "driving": gearbox.torque_per_amp,
            "driven": gearbox.torque_per_amp,
            "friction": gearbox.friction_torque,
            "stator_limit": gearbox.stator_current_limit,
            "supply_limit": gearbox.supply_current_limit,
            "count": gearbox.motors,
            "lower": lower_stop,
            "upper": upper_stop,
            "partner": -1,
            "mode": VOLTS,
            "brakes": 1,
            "position": position,
        }.items():
            self._record[name] = value

    @property
    def record(self) -> Records:
        """Its record in the arrays of the loop, shape (1,); the loop of a world has those of all its robots."""
        return self._record

    @record.setter
    def record(self, record: Records) -> None:
        self._record = record

    @property
    def position(self) -> float:
        """Angle of the mechanism [rad]."""
        return float(self._record["position"][0])

    @position.setter
    def position(self, angle: float) -> None:
        self._record["position"] = angle

    @property
    def velocity(self) -> float:
        """Rate of the mechanism [rad/s]."""
        return float(self._record["speed"][0])

    @velocity.setter
    def velocity(self, rate: float) -> None:
        self._record["speed"] = rate

    @property
    def volts(self) -> float:
        """Voltage asked for, before the battery limits it [V]; `set_volts` sets it."""
        return float(self._record["request"][0])

    @property
    def current(self) -> float:
        """Stator current of all motors together, mean of the last step [A]."""
        return float(self._record["mean_current"][0])

    @property
    def supply_current(self) -> float:
        """Current that all motors took from the battery, mean of the last step; below zero they feed it [A]."""
        return float(self._record["mean_supply"][0])

    @property
    def stops(self) -> tuple[float, float]:
        """Lower and upper hard stop [rad]; infinite where there is none."""
        return float(self._record["lower"][0]), float(self._record["upper"][0])

    @property
    def time_constant(self) -> float:
        """Time in which the speed comes 63 % closer to its end value [s]."""
        box = self.gearbox
        return box.resistance * self.inertia / (box.torque_per_amp * box.volts_per_speed)

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
        record = self._record
        record["mode"], record["request"], record["brakes"] = VOLTS, volts, 1

    def set_duty_cycle(self, share: float) -> None:
        """Hold this share of the battery's voltage from the next step on, -1 to 1; zero brakes.

        Raises:
            NonFiniteError: If it is NaN or infinite.
        """
        if not math.isfinite(share):
            raise NonFiniteError(f"{type(self).__name__}: duty cycle must be a finite number, got {share}")
        record = self._record
        record["mode"], record["request"], record["brakes"] = DUTY, min(max(share, -1.0), 1.0), 1

    @property
    def load_torque(self) -> float:
        """Torque from outside on the mechanism, along positive motion [N m]."""
        return float(self._record["load"][0])

    def set_load(self, torque: float) -> None:
        """Let this torque [N m] act from outside, along positive motion, from the next step on."""
        if not math.isfinite(torque):
            raise NonFiniteError(f"{type(self).__name__}: load torque must be a finite number, got {torque}")
        self._record["load"] = torque

    def coast(self) -> None:
        """Open the circuit: no current flows until volts are set again."""
        record = self._record
        record["mode"], record["request"], record["brakes"] = NEUTRAL, 0.0, 0

    def reset(self, position: float = 0.0, velocity: float = 0.0) -> None:
        """Put the shaft somewhere, with zero volts asked for."""
        if not (math.isfinite(position) and math.isfinite(velocity)):
            raise NonFiniteError(f"{type(self).__name__}: state must be finite, got {position} rad, {velocity} rad/s")
        lower, upper = self.stops
        self.position, self.velocity = min(max(position, lower), upper), velocity
        record = self._record
        record["mode"], record["request"], record["brakes"] = VOLTS, 0.0, 1
        record["mean_current"] = record["mean_supply"] = 0.0

    def step(self, dt: float, battery_voltage: float = 12.0) -> None:
        """Move on by `dt`, with the volts held; for a mechanism that is in no robot.

        Args:
            dt: Any length; cut into steps of 1 ms or less [s].
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
        turn_alone(self._record, 0, dt, battery_voltage)
