"""The output stage of a motor controller: peaks, ramps, deadband, limit switches, current limits, neutral.

Order of the steps: peak output, ramp, deadband, soft and hard limits, supply voltage, stator limit, supply limit.

Source: measured on CTRE's simulation 26.3 with the rotor held at given speeds, and with its speed changed while volts
and amperes were polled. Its limits act in all four quadrants; a deadband is subtracted and the rest stretched; a brake
with volts (`VoltageOut(0)`) keeps the stator limit, a static brake does not; no bridge carries more than 200 A.

The limits of a voltage allow the back-EMF, plus what the limit makes in the winding; and the rotor speed that they use
follows the real one late. So a motor that spins up a light load gets less than its limit: 39 A of 60 A on average at
680 rotations/s^2, which is what the azimuth of a swerve module does, and 50 A at 340. A new request acts at once;
torque currents do not lag.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from phoenix6.spns.spn_value import SpnValue

from simcore.errors import ConfigError
from simcore.phoenix6_emulator.emulated_device import LOOP, Setting, Unit

__all__ = [
    "ARRANGEMENTS",
    "KRAKEN_X44",
    "KRAKEN_X60",
    "LIMITER_GAIN",
    "OVER_VOLTAGE",
    "Bridge",
    "MotorConstants",
    "Stage",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorConstants:
    """A motor without its mechanism, at 12 V.

    Source: stall current and free speed measured on CTRE's simulation 26.3, torque current at 1, 3 and 6 V with the
    rotor held at 0, 20 and 60 rotations/s; the Kraken X60 is WPILib's `DCMotor.krakenX60FOC`.
    """

    name: str
    """As robot code calls it."""
    stall_current: float
    """[A]"""
    free_rps: float
    """Rotor speed without load [rotations/s]."""
    trapezoidal_stall: float
    """Stall current without FOC [A]."""
    trapezoidal_rps: float
    """Free speed without FOC [rotations/s]."""
    kt: float
    """What `get_motor_kt` answers [N m/A]."""
    kv: float
    """What `get_motor_kv` answers [rpm/V]."""
    reported_stall: float
    """What `get_motor_stall_current` answers [A]."""
    connected: int
    """`ConnectedMotorValue`."""

    def __post_init__(self) -> None:
        for field in ("stall_current", "free_rps", "trapezoidal_stall", "trapezoidal_rps"):
            value = getattr(self, field)
            if not (math.isfinite(value) and value > 0.0):
                raise ConfigError(f"{self.name}: {field} must be finite and > 0, got {value}")


KRAKEN_X60 = MotorConstants(
    name="Kraken X60",
    stall_current=483.0,
    free_rps=5800.0 / 60.0,
    trapezoidal_stall=366.0,
    trapezoidal_rps=100.0,
    kt=0.0198,
    kv=490.0,
    reported_stall=476.0,
    connected=2,
)
KRAKEN_X44 = MotorConstants(
    name="Kraken X44",
    stall_current=329.0,
    free_rps=125.0,
    trapezoidal_stall=277.5,
    trapezoidal_rps=130.0,
    kt=0.0154,
    kv=625.0,
    reported_stall=329.0,
    connected=2,  # the simulated device reports this for both motors
)


def _jst(name: str, stall: float, rps: float, kt: float, kv: float, reported: float, connected: int) -> MotorConstants:
    return MotorConstants(
        name=name,
        stall_current=stall,
        free_rps=rps,
        trapezoidal_stall=stall,
        trapezoidal_rps=rps,
        kt=kt,
        kv=kv,
        reported_stall=reported,
        connected=connected,
    )


ARRANGEMENTS: dict[int, MotorConstants] = {
    1: _jst("Minion", 211.0, 126.9, 0.0152, 633.0, 212.0, 4),
    2: _jst("brushed motor", 129.1, 89.0, 0.0, 444.0, 0.0, 5),
    5: _jst("NEO", 103.5, 94.6, 0.0196, 490.0, 216.0, 8),
    6: _jst("NEO 550", 98.9, 185.0, 0.0097, 975.0, 111.0, 9),
    7: _jst("Vortex", 207.8, 113.6, 0.0154, 565.0, 391.0, 10),
}
"""Motors of a TalonFXS by `MotorArrangementValue`; a brushed motor is a CIM."""


Stage = Callable[[float, int], None]
"""Drives the motor with an output for a number of control loops."""

OVER_VOLTAGE = 16.5
"""Above this supply the bridge is off [V]; measured between 16 and 18."""
_HARD_CAP = 200.0
"""What the simulated bridge carries at most, also with its limits off [A]."""
_SUPPLY_SLACK = 0.4
"""The simulated limiters oscillate within 1 A of their limit; the supply current is this much below on average [A]."""
_LIMITER_LAG = 6.0
"""Time constant with which the limits of a voltage follow a new rotor speed, in control loops. The measured lag is not
quite one pole: a quarter of a jump in one loop, the last tenth in 30; this one gives the same mean current."""
LIMITER_GAIN = (*(-math.expm1(-loops / _LIMITER_LAG) for loops in range(64)), 1.0)
"""Share of a jump of the rotor speed that the limits of a voltage use after so many control loops; the last is for
more."""
_TORQUE_RANGE = 327.67
"""Full scale of a torque current request, to which a deadband stretches the rest [A]."""
_MAX_REQUEST_DEADBAND = 15.0
"""More than this a request's own deadband cannot be [A]."""
_FULL = {Unit.DUTY: 1.0, Unit.VOLTS: 12.0, Unit.AMPERES: 300.0}
"""What is reached from zero in the time of a ramp."""
_RAMPS = {
    (Unit.DUTY, False): SpnValue.CONFIG_DUTY_CYCLE_OPEN_LOOP_RAMP_PERIOD.value,
    (Unit.VOLTS, False): SpnValue.CONFIG_VOLTAGE_OPEN_LOOP_RAMP_PERIOD.value,
    (Unit.AMPERES, False): SpnValue.CONFIG_TORQUE_OPEN_LOOP_RAMP_PERIOD.value,
    (Unit.DUTY, True): SpnValue.CONFIG_DUTY_CYCLE_CLOSED_LOOP_RAMP_PERIOD.value,
    (Unit.VOLTS, True): SpnValue.CONFIG_VOLTAGE_CLOSED_LOOP_RAMP_PERIOD.value,
    (Unit.AMPERES, True): SpnValue.CONFIG_TORQUE_CLOSED_LOOP_RAMP_PERIOD.value,
}


class Bridge:
    """Drives one motor; all numbers have robot code's signs.

    Args:
        motor: The motor that it drives.
    """

    __slots__ = (
        "_ampere_cap",
        "_deadband",
        "_last",
        "_lower",
        "_lower_time",
        "_lowered",
        "_over",
        "_ramps",
        "_supply_limit",
        "_torque_deadband",
        "_volt_cap",
        "blocked_forward",
        "blocked_reverse",
        "brake",
        "current",
        "deadband",
        "duty",
        "has_ramp",
        "holds_duty",
        "is_blocked",
        "is_neutral",
        "is_stator_limited",
        "is_supply_limited",
        "late_rps",
        "max_duty",
        "motor",
        "override",
        "peaks",
        "rps",
        "supply",
        "supply_current",
        "volts",
    )

    def __init__(self, motor: MotorConstants) -> None:
        self.motor = motor
        self.volts = self.current = self.supply_current = self.duty = 0.0
        self.holds_duty = False
        """Whether it holds `duty` until its next loop, and not `volts`: no limit lowers an output in duty cycles."""
        self.supply = 12.0
        """At its terminals [V]."""
        self.rps = 0.0
        """Of the rotor, robot code's sign [rotations/s]."""
        self.late_rps = 0.0
        """The same, late, as the limits of a voltage use it."""
        self.brake = False
        """Configured neutral mode."""
        self.override = False
        """Whether the request neutralises the other way than configured."""
        self.deadband = 0.0
        """Of the torque request [A]."""
        self.max_duty = 1.0
        """Of the torque request."""
        self.blocked_forward = self.blocked_reverse = False
        """Whether a limit forbids this direction."""
        self.is_neutral = True
        self.is_blocked = self.is_stator_limited = self.is_supply_limited = False
        self._last = self._over = 0.0
        self._lowered = False

    def configure(self, config: Mapping[int, Setting]) -> None:
        """Apply limits, peaks, deadbands and ramps."""

        def get(name: str, default: float = 0.0) -> float:
            return config.get(SpnValue[name].value, default)

        self._volt_cap, self._ampere_cap = math.inf, _HARD_CAP
        if get("CONFIG_STATOR_CURR_LIMIT_EN"):
            limit = get("CONFIG_STATOR_CURRENT_LIMIT")
            self._ampere_cap = min(limit, _HARD_CAP)
            self._volt_cap = max(limit, 0.0)
        self._supply_limit = math.inf
        if get("CONFIG_SUPPLY_CURR_LIMIT_EN"):
            self._supply_limit = max(get("CONFIG_SUPPLY_CURRENT_LIMIT") - _SUPPLY_SLACK, 0.0)
        self._lower = max(get("CONFIG_SUPPLY_CURRENT_LOWER_LIMIT") - _SUPPLY_SLACK, 0.0)
        self._lower_time = get("CONFIG_SUPPLY_CURRENT_LOWER_TIME")
        self.brake = get("CONFIG_NEUTRAL_MODE") == 1
        self._deadband = get("CONFIG_DUTY_CYCLE_NEUTRAL_DB")
        self._torque_deadband = get("CONFIG_TORQUE_NEUTRAL_DB")
        self.peaks = {
            Unit.DUTY: (get("CONFIG_PEAK_FORWARD_DC", 1.0), get("CONFIG_PEAK_REVERSE_DC", -1.0)),
            Unit.VOLTS: (get("CONFIG_PEAK_FORWARD_V", 16.0), get("CONFIG_PEAK_REVERSE_V", -16.0)),
            Unit.AMPERES: (get("CONFIG_PEAK_FOR_TORQ_CURR", 800.0), get("CONFIG_PEAK_REV_TORQ_CURR", -800.0)),
        }
        self._ramps = {key: _FULL[key[0]] / period if (period := config.get(spn, 0.0)) > 0.0 else 0.0
                       for key, spn in _RAMPS.items()}  # fmt: skip
        self.has_ramp = any(self._ramps.values())

    def stage(self, unit: Unit, *, closed: bool, foc: bool) -> Stage:
        """The output stage for one kind of request."""
        high, low = self.peaks[unit]
        rate = self._ramps[unit, closed] * LOOP
        motor = self.motor
        foc = foc or unit is Unit.AMPERES
        resistance = 12.0 / (motor.stall_current if foc else motor.trapezoidal_stall)
        emf_per_rps = 12.0 / (motor.free_rps if foc else motor.trapezoidal_rps)
        is_duty, is_torque = unit is Unit.DUTY, unit is Unit.AMPERES
        cap = (self._ampere_cap if is_torque else self._volt_cap) * resistance
        hard_cap = _HARD_CAP * resistance
        limit, deadband = self._supply_limit * resistance, self._deadband

        def drive(out: float, loops: int) -> None:
            out = high if out > high else (low if out < low else out)
            if rate:
                step = rate * loops
                last = self._last
                out = last + step if out > last + step else (last - step if out < last - step else out)
                self._last = out
            supply = self.supply
            emf = self.rps * emf_per_rps
            if is_torque:
                out = self._past_deadband(out)
                v = emf + out * resistance
            else:
                v = out * supply if is_duty else out
                if deadband:
                    size = abs(v) / supply
                    v = math.copysign((size - deadband) / (1.0 - deadband) * supply, v) if size > deadband else 0.0
            self.is_blocked = blocked = (self.blocked_forward and out > 0.0) or (self.blocked_reverse and out < 0.0)
            if supply > OVER_VOLTAGE:
                self.neutral(False)
                return
            if blocked or out == 0.0 or (v == 0.0 and not is_torque):
                if is_torque:  # zero torque is neutral as configured; its override coasts
                    self.neutral(self.brake and not self.override)
                    return
                if not (self.brake or self.override):
                    self.neutral(False)
                    return
                v = 0.0  # a bridge that drives zero volts brakes, within the current limits
            top = self.max_duty * supply if is_torque else supply
            v = asked = top if v > top else (-top if v < -top else v)
            known = emf if is_torque else self.late_rps * emf_per_rps
            self.is_stator_limited = False
            if v > known + cap:
                v = known + cap
                self.is_stator_limited = True
            elif v < known - cap:
                v = known - cap
                self.is_stator_limited = True
            if self._over or (v - known) * v > limit * supply:
                v = self._limit_supply(v, known, resistance, loops)
            if v > emf + hard_cap:
                v = emf + hard_cap
                self.is_stator_limited = True
            elif v < emf - hard_cap:
                v = emf - hard_cap
                self.is_stator_limited = True
            current = (v - emf) / resistance
            self.is_neutral = False
            self.volts = v
            self.current = current
            self.supply_current = current * v / supply
            self.duty = v / supply
            self.holds_duty = is_duty and v == asked

        return drive

    def neutral(self, brake: bool) -> None:
        """Open the circuit (coast), or short it (brake)."""
        self.is_neutral = True
        self.holds_duty = False
        self.volts = self.duty = self.supply_current = 0.0
        self.is_stator_limited = self.is_supply_limited = False
        motor = self.motor
        self.current = -self.rps * motor.trapezoidal_stall / motor.trapezoidal_rps if brake else 0.0

    def carry(self, unit: Unit) -> None:
        """Start the ramp of another kind of request at the present output."""
        self._last = {Unit.DUTY: self.duty, Unit.VOLTS: self.volts, Unit.AMPERES: self.current}[unit]
        if self.is_neutral:
            self._last = 0.0

    def rest(self) -> None:
        """Reset the ramp and the time over the limit."""
        self._last = self._over = 0.0
        self._lowered = self.is_blocked = False

    def _past_deadband(self, amperes: float) -> float:
        """What is left of a torque current after the deadbands of request and configuration."""
        band = max(min(self.deadband, _MAX_REQUEST_DEADBAND), self._torque_deadband)
        if band == 0.0:
            return amperes
        rest = abs(amperes) - band
        return math.copysign(rest * _TORQUE_RANGE / (_TORQUE_RANGE - band), amperes) if rest > 0.0 else 0.0

    def _limit_supply(self, v: float, emf: float, resistance: float, loops: int) -> float:
        """Volts with which the supply limit is kept, at the back-EMF that the limit uses [V]."""
        if (v - emf) * v <= (self._lower if self._lowered else self._supply_limit) * resistance * self.supply:
            self._over = 0.0
            self._lowered = self.is_supply_limited = False
            return v
        self._over += loops * LOOP
        self._lowered = self._lowered or self._over > self._lower_time > 0.0
        limit = self._lower if self._lowered and self._lower < self._supply_limit else self._supply_limit
        self.is_supply_limited = True
        # v (v - emf) / R = limit * supply, solved for the v with the sign that was asked for
        root = math.sqrt(emf * emf + 4.0 * resistance * limit * self.supply)
        return 0.5 * (emf + root) if v > 0.0 else 0.5 * (emf - root)
