"""The output stage of a motor controller: peaks, ramps, deadband, limit switches, current limits, neutral.

Order of the steps: peak output, ramp, deadband, soft and hard limits, supply voltage, current limits.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6.standin.clock import LOOP
from simcore.phoenix6.standin.electrical import MotorConstants
from simcore.phoenix6.standin.requests import Unit
from simcore.phoenix6.standin.wire import Setting

__all__ = ["Bridge"]

_STATOR = SpnValue.CONFIG_STATOR_CURRENT_LIMIT.value
_STATOR_ON = SpnValue.CONFIG_STATOR_CURR_LIMIT_EN.value
_SUPPLY = SpnValue.CONFIG_SUPPLY_CURRENT_LIMIT.value
_SUPPLY_ON = SpnValue.CONFIG_SUPPLY_CURR_LIMIT_EN.value
_LOWER = SpnValue.CONFIG_SUPPLY_CURRENT_LOWER_LIMIT.value
_LOWER_TIME = SpnValue.CONFIG_SUPPLY_CURRENT_LOWER_TIME.value
_HARD_CAP = 200.0
"""What the simulated bridge carries at most, also with its limits off [A]."""
_RAMPS = {
    (Unit.DUTY, False): (SpnValue.CONFIG_DUTY_CYCLE_OPEN_LOOP_RAMP_PERIOD.value, 1.0),
    (Unit.VOLTS, False): (SpnValue.CONFIG_VOLTAGE_OPEN_LOOP_RAMP_PERIOD.value, 12.0),
    (Unit.AMPERES, False): (SpnValue.CONFIG_TORQUE_OPEN_LOOP_RAMP_PERIOD.value, 300.0),
    (Unit.DUTY, True): (SpnValue.CONFIG_DUTY_CYCLE_CLOSED_LOOP_RAMP_PERIOD.value, 1.0),
    (Unit.VOLTS, True): (SpnValue.CONFIG_VOLTAGE_CLOSED_LOOP_RAMP_PERIOD.value, 12.0),
    (Unit.AMPERES, True): (SpnValue.CONFIG_TORQUE_CLOSED_LOOP_RAMP_PERIOD.value, 300.0),
}
"""Setting, and what is reached from zero in that time."""


class Bridge:
    """Drives one motor; all numbers have robot code's signs.

    Args:
        motor: What it turns.
    """

    __slots__ = (
        "_cap",
        "_emf",
        "_last",
        "_lower",
        "_lower_time",
        "_over",
        "_peaks",
        "_ramps",
        "_resistance",
        "_supply_limit",
        "_trap_emf",
        "_trap_resistance",
        "blocked_forward",
        "blocked_reverse",
        "brake",
        "current",
        "deadband",
        "duty",
        "is_neutral",
        "is_stator_limited",
        "is_supply_limited",
        "motor",
        "rps",
        "supply",
        "supply_current",
        "torque_deadband",
        "volts",
    )

    def __init__(self, motor: MotorConstants) -> None:
        self.volts = self.current = self.supply_current = self.duty = 0.0
        self.supply = 12.0
        self.rps = 0.0
        self.brake = False
        self.is_neutral = True
        self.is_stator_limited = self.is_supply_limited = False
        self.blocked_forward = self.blocked_reverse = False
        self._last = 0.0
        self._over = 0.0
        self.set_motor(motor)

    def set_motor(self, motor: MotorConstants) -> None:
        """Turn another motor."""
        self.motor = motor
        self._resistance = 12.0 / motor.stall_current
        self._emf = 12.0 / motor.free_rps
        self._trap_resistance = 12.0 / motor.trapezoidal_stall
        self._trap_emf = 12.0 / motor.trapezoidal_rps

    def configure(self, config: Mapping[int, Setting]) -> None:
        """Take over limits, peaks and ramps."""
        stator = config[_STATOR] if config[_STATOR_ON] else _HARD_CAP
        self._cap = min(stator, _HARD_CAP)
        self._supply_limit = config[_SUPPLY] if config[_SUPPLY_ON] else math.inf
        self._lower = config[_LOWER]
        self._lower_time = config[_LOWER_TIME]
        self.brake = config[SpnValue.CONFIG_NEUTRAL_MODE.value] == 1
        self.deadband = config[SpnValue.CONFIG_DUTY_CYCLE_NEUTRAL_DB.value]
        self.torque_deadband = config[SpnValue.CONFIG_TORQUE_NEUTRAL_DB.value]
        self._peaks = {
            Unit.DUTY: (config[SpnValue.CONFIG_PEAK_FORWARD_DC.value], config[SpnValue.CONFIG_PEAK_REVERSE_DC.value]),
            Unit.VOLTS: (config[SpnValue.CONFIG_PEAK_FORWARD_V.value], config[SpnValue.CONFIG_PEAK_REVERSE_V.value]),
            Unit.AMPERES: (
                config[SpnValue.CONFIG_PEAK_FOR_TORQ_CURR.value],
                config[SpnValue.CONFIG_PEAK_REV_TORQ_CURR.value],
            ),
        }
        self._ramps = {key: (full / config[spn] if config[spn] > 0.0 else 0.0) for key, (spn, full) in _RAMPS.items()}

    def stage(self, unit: Unit, *, closed: bool, foc: bool) -> Callable[[float, int], None]:
        """The output stage for one kind of request, as a closure (output, loops)."""
        high, low = self._peaks[unit]
        rate = self._ramps[unit, closed]
        duty_high, duty_low = self._peaks[Unit.DUTY]
        if unit is Unit.AMPERES:

            def amperes(out: float, loops: int) -> None:
                out = high if out > high else (low if out < low else out)
                if rate:
                    step = rate * loops * LOOP
                    last = self._last
                    out = last + step if out > last + step else (last - step if out < last - step else out)
                self._last = out
                if (
                    abs(out) <= self.torque_deadband
                    or (self.blocked_forward and out > 0.0)
                    or (self.blocked_reverse and out < 0.0)
                ):
                    self.neutral(self.brake)
                    return
                self._torque(out, loops)

            return amperes

        resistance = self._resistance if foc else self._trap_resistance
        emf_per_rps = self._emf if foc else self._trap_emf
        is_duty = unit is Unit.DUTY
        cap, limit = self._cap, self._supply_limit

        def volts(out: float, loops: int) -> None:
            out = high if out > high else (low if out < low else out)
            if rate:
                step = rate * loops * LOOP
                last = self._last
                out = last + step if out > last + step else (last - step if out < last - step else out)
            self._last = out
            supply = self.supply
            v = out * supply if is_duty else out
            top, bottom = duty_high * supply, duty_low * supply
            v = top if v > top else (bottom if v < bottom else v)
            if (
                abs(v) <= self.deadband * supply
                or (self.blocked_forward and v > 0.0)
                or (self.blocked_reverse and v < 0.0)
            ):
                self.neutral(self.brake, foc=foc)
                return
            emf = self.rps * emf_per_rps
            current = (v - emf) / resistance
            if current > cap:
                if v > 0.0:
                    current = cap
                    v = emf + cap * resistance
                self.is_stator_limited = True
            elif current < -cap:
                if v < 0.0:
                    current = -cap
                    v = emf - cap * resistance
                self.is_stator_limited = True
            else:
                self.is_stator_limited = False
            drawn = current * v / supply
            if drawn > limit:
                v, current, drawn = self._limit_supply(v, emf, resistance, loops)
            elif self._over:
                self._over = 0.0
                self.is_supply_limited = False
            self.is_neutral = False
            self.volts = v
            self.current = current
            self.supply_current = drawn
            self.duty = v / supply

        return volts

    def neutral(self, brake: bool, *, foc: bool = False) -> None:
        """Let go of the motor, or short it."""
        self.is_neutral = True
        self.volts = self.duty = self.supply_current = 0.0
        self.is_stator_limited = self.is_supply_limited = False
        if not brake:
            self.current = 0.0
        elif foc:
            self.current = -self.rps * self._emf / self._resistance
        else:
            self.current = -self.rps * self._trap_emf / self._trap_resistance

    def rest(self) -> None:
        """Forget the ramp: the next output starts from zero."""
        self._last = 0.0

    def _torque(self, amperes: float, loops: int) -> None:
        emf = self.rps * self._emf
        v = emf + amperes * self._resistance
        if abs(v) > self.supply:
            v = math.copysign(self.supply, v)
            amperes = (v - emf) / self._resistance
        self.is_neutral = False
        self.volts = v
        self.current = amperes
        self.supply_current = amperes * v / self.supply
        self.duty = v / self.supply

    def _limit_supply(self, v: float, emf: float, resistance: float, loops: int) -> tuple[float, float, float]:
        """Volts, torque current and supply current with which the supply limit is kept."""
        self._over += loops * LOOP
        limit = self._lower if self._over > self._lower_time > 0.0 else self._supply_limit
        self.is_supply_limited = True
        # v (v - emf) / R = limit * supply, solved for the v with the sign that was asked for
        root = math.sqrt(emf * emf + 4.0 * resistance * limit * self.supply)
        v = 0.5 * (emf + root) if v > 0.0 else 0.5 * (emf - root)
        current = (v - emf) / resistance
        return v, current, current * v / self.supply
