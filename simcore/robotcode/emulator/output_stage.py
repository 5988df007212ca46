"""Output stage of a motor controller: peak output, ramp, deadband, soft and hard limits, applied in this order.

A robot model applies the current limits and sets the motor voltage and current (`Bridge.show`). A test may instead
write the rotor state through `sim_state`. Without a robot model, the bridge computes voltage and current with the motor
law of the simulation loop, for a rotor held at its present speed.

Source: measurements of CTRE's simulation 26.3 with the rotor held at given speeds. Current limits act in all four
quadrants. The output stage subtracts the deadband and rescales the remainder. The stator limit applies to braking with
zero volts (`VoltageOut(0)`), but not to a static brake. The current of a bridge never exceeds 200 A.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

from phoenix6.spns.spn_value import SpnValue

from simcore.loop.motor import solve_limited
from simcore.robot.dc_motor import MotorModel, motor
from simcore.robotcode.emulator.emulated_device import LOOP, Setting, Unit

__all__ = [
    "ARRANGEMENTS", "KRAKEN_X44", "KRAKEN_X60", "OVER_VOLTAGE", "Bridge", "ConnectedMotor", "Stage", "duty",
    "supply_current",
]  # fmt: skip


@dataclass(frozen=True, slots=True)
class ConnectedMotor:
    """Motor connected to a controller, and the constants that the controller reports for the motor."""

    model: MotorModel
    """Motor model, with FOC if the motor supports FOC."""
    trapezoidal: MotorModel
    kt: float
    """Torque constant that `get_motor_kt` returns [N m/A]."""
    kv: float
    """Velocity constant that `get_motor_kv` returns [rpm/V]."""
    stall_current: float
    """Stall current that `get_motor_stall_current` returns [A]."""
    number: int
    """Motor number in `ConnectedMotorValue`."""


def _brushless(name: str, kt: float, kv: float, stall_current: float, number: int) -> ConnectedMotor:
    return ConnectedMotor(motor(name), motor(name), kt, kv, stall_current, number)


KRAKEN_X60 = ConnectedMotor(motor("Kraken X60 FOC"), motor("Kraken X60"), 0.0198, 490.0, 476.0, 2)
KRAKEN_X44 = ConnectedMotor(  # the simulated device reports the number 2 for both motors
    motor("Kraken X44 FOC"), motor("Kraken X44"), 0.0154, 625.0, 329.0, 2
)
ARRANGEMENTS: dict[int, ConnectedMotor] = {
    1: _brushless("Minion", 0.0152, 633.0, 212.0, 4),
    2: _brushless("CIM", 0.0, 444.0, 0.0, 5),
    5: _brushless("NEO", 0.0196, 490.0, 216.0, 8),
    6: _brushless("NEO 550", 0.0097, 975.0, 111.0, 9),
    7: _brushless("NEO Vortex", 0.0154, 565.0, 391.0, 10),
}
"""Motors of a TalonFXS, by `MotorArrangementValue`. A CIM represents all brushed motors."""

Stage = Callable[[float, int], None]
"""Output stage: a function that applies the control law's output to the bridge for a number of control loops."""

OVER_VOLTAGE = 16.5
"""Supply voltage above which the bridge turns off [V]. The measured threshold is between 16 and 18 V."""
_HARD_CAP = 200.0
"""Largest current of a bridge, even without configured limits [A]."""
_SUPPLY_SLACK = 0.4
"""Amount by which the bridge lowers the configured supply limit [A].

CTRE's simulated limiter oscillates within 1 A of the limit. The mean current is this amount below the limit.
"""
_LIMITED = 0.98
"""Fraction of a current limit above which the limit counts as reached [-].

The fraction is below 1 because the supply voltages of robot model and device differ slightly.
"""
_HELD = 1e12
"""Damping coefficient that holds the rotor at the given speed against any torque [N m s]."""
_TORQUE_RANGE = 327.67
"""Torque current that the deadband leaves unchanged: the full scale of a torque current request [A]."""
_MAX_REQUEST_DEADBAND = 15.0
"""Largest deadband that a request can set [A]."""
_FULL = {Unit.DUTY: 1.0, Unit.VOLTS: 12.0, Unit.AMPERES: 300.0}
"""Output change in one configured ramp period, by output unit [-, V or A]."""
_RAMPS = {
    (Unit.DUTY, False): SpnValue.CONFIG_DUTY_CYCLE_OPEN_LOOP_RAMP_PERIOD.value,
    (Unit.VOLTS, False): SpnValue.CONFIG_VOLTAGE_OPEN_LOOP_RAMP_PERIOD.value,
    (Unit.AMPERES, False): SpnValue.CONFIG_TORQUE_OPEN_LOOP_RAMP_PERIOD.value,
    (Unit.DUTY, True): SpnValue.CONFIG_DUTY_CYCLE_CLOSED_LOOP_RAMP_PERIOD.value,
    (Unit.VOLTS, True): SpnValue.CONFIG_VOLTAGE_CLOSED_LOOP_RAMP_PERIOD.value,
    (Unit.AMPERES, True): SpnValue.CONFIG_TORQUE_CLOSED_LOOP_RAMP_PERIOD.value,
}


def _emf(model: MotorModel) -> float:
    """Return the back-EMF constant [V s/rotation] for zero free current, as in CTRE's simulation."""
    return model.nominal_voltage * math.tau / model.free_speed


class _Flow(Protocol):
    """Voltage and current of a motor, and the supply voltage of the controller."""

    @property
    def volts(self) -> float:
        """Motor voltage [V]."""

    @property
    def current(self) -> float:
        """Motor current [A]."""

    @property
    def supply(self) -> float:
        """Supply voltage of the controller [V]."""


def duty(flow: _Flow) -> float:
    """Return the duty cycle: motor voltage over supply voltage [-]."""
    return flow.volts / flow.supply


def supply_current(flow: _Flow) -> float:
    """Return the supply current: motor power over supply voltage [A]."""
    return flow.current * flow.volts / flow.supply


class Bridge:
    """Bridge that applies a voltage, duty cycle or torque current to one motor, with robot code's sign.

    Args:
        motor: Motor whose voltage and current the bridge computes until the first call of `show`.
    """

    def __init__(self, motor: ConnectedMotor) -> None:
        self.motor = motor
        self.unit = Unit.VOLTS
        """Unit of `asked`."""
        self.asked = 0.0
        """Output requested from the motor, in the unit `unit`."""
        self.is_neutral = True
        """Whether the bridge is neutral, with the motor shorted (brake) or disconnected (coast)."""
        self.is_braking = False
        """Whether a neutral bridge brakes by shorting the motor instead of coasting."""
        self._volts = self._current = 0.0
        self._is_due = False
        """Whether the next read must compute voltage and current.

        The bridge computes these values only on demand, because the computation takes longer than a control loop.
        """
        self.has_model = False
        """Whether a robot model sets voltage and current."""
        self.supply = 12.0
        """Supply voltage of the controller [V]."""
        self.rps = 0.0
        """Rotor speed, with robot code's sign [rotations/s]."""
        self.brake = False
        """Whether the configured neutral mode is brake."""
        self.override = False
        """Whether the request overrides the neutral mode: brake for voltage or duty cycle, coast for torque current."""
        self.deadband = 0.0
        """Deadband of the torque current request [A]."""
        self.max_duty = 1.0
        """Largest duty cycle of the torque current request [-]."""
        self.blocked_forward = self.blocked_reverse = False
        """Whether a limit or the request blocks forward output or reverse output."""
        self.is_blocked = False
        self._foc = True
        self._last = self._over = 0.0
        self._is_lowered = False

    def configure(self, config: Mapping[int, Setting]) -> None:
        """Apply the configured current limits, neutral mode, deadbands, peak outputs and ramps."""

        def get(name: str, default: float = 0.0) -> float:
            return config.get(SpnValue[name].value, default)

        self._stator_limit, self._supply_limit = _HARD_CAP, math.inf
        if get("CONFIG_STATOR_CURR_LIMIT_EN"):
            self._stator_limit = min(max(get("CONFIG_STATOR_CURRENT_LIMIT"), 0.0), _HARD_CAP)
        if get("CONFIG_SUPPLY_CURR_LIMIT_EN"):
            self._supply_limit = max(get("CONFIG_SUPPLY_CURRENT_LIMIT") - _SUPPLY_SLACK, 0.0)
        lower = max(get("CONFIG_SUPPLY_CURRENT_LOWER_LIMIT") - _SUPPLY_SLACK, 0.0)
        self._lower = min(lower, self._supply_limit)
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

    # ---- requests

    def stage(self, unit: Unit, *, closed: bool, foc: bool) -> Stage:
        """Return the output stage for one output unit, with the open-loop or closed-loop ramp. `foc` selects FOC."""
        high, low = self.peaks[unit]
        rate = self._ramps[unit, closed] * LOOP
        is_torque, is_duty = unit is Unit.AMPERES, unit is Unit.DUTY

        def drive(out: float, loops: int) -> None:
            self._time_limit(loops)
            out = high if out > high else (low if out < low else out)
            if rate:
                step = rate * loops
                out = self._last = min(max(out, self._last - step), self._last + step)
            asked = (
                self._past_deadband(out)
                if is_torque
                else self._past_duty_deadband(out, 1.0 if is_duty else self.supply)
            )
            self.is_blocked = (self.blocked_forward and out > 0.0) or (self.blocked_reverse and out < 0.0)
            if self.supply > OVER_VOLTAGE:
                self.neutral(False)
            elif asked != 0.0 and not self.is_blocked:
                self._ask(unit, asked, foc or is_torque)
            elif is_torque:  # zero torque applies the neutral mode; the request's override coasts
                self.neutral(self.brake and not self.override)
            elif self.brake or self.override:
                self._ask(Unit.VOLTS, 0.0, foc)  # a bridge at zero volts brakes, within the current limits
            else:
                self.neutral(False)

        return drive

    def neutral(self, brake: bool) -> None:
        """Make the bridge neutral: short the motor (brake) or open the circuit (coast)."""
        self.is_neutral, self.is_braking = True, brake
        self.unit, self.asked = Unit.VOLTS, 0.0
        self._is_due = not self.has_model

    def _ask(self, unit: Unit, asked: float, foc: bool) -> None:
        self.is_neutral = False
        self.unit, self.asked, self._foc = unit, asked, foc
        self._is_due = not self.has_model

    def carry(self, unit: Unit) -> None:
        """Start the ramp of a new request at the present output in `unit`, or at 0 if the bridge is neutral."""
        present = {Unit.DUTY: duty(self), Unit.VOLTS: self.volts, Unit.AMPERES: self.current}[unit]
        self._last = 0.0 if self.is_neutral else present

    def rest(self) -> None:
        """Reset the ramp, the time at the supply limit, the lowered supply limit and the blocked state."""
        self._last = self._over = 0.0
        self._is_lowered = self.is_blocked = False

    def _past_duty_deadband(self, out: float, full: float) -> float:
        """Return the output [duty cycle or V] beyond the duty cycle deadband, rescaled to the full output."""
        if not self._deadband:
            return out
        rest = abs(out) / full - self._deadband
        return math.copysign(rest / (1.0 - self._deadband) * full, out) if rest > 0.0 else 0.0

    def _past_deadband(self, amperes: float) -> float:
        """Return the torque current [A] beyond the deadband, rescaled to the full range.

        The deadband is the larger of the request's deadband and the configured deadband.
        """
        band = max(min(self.deadband, _MAX_REQUEST_DEADBAND), self._torque_deadband)
        rest = abs(amperes) - band
        return math.copysign(rest * _TORQUE_RANGE / (_TORQUE_RANGE - band), amperes) if rest > 0.0 else 0.0

    # ---- flow

    @property
    def asked_volts(self) -> float:
        """Requested motor voltage [V]; for a torque current request, the actual motor voltage."""
        if self.unit is Unit.AMPERES:
            return self.volts
        return self.asked * self.supply if self.unit is Unit.DUTY else self.asked

    @property
    def share(self) -> float | None:
        """Requested duty cycle before the current limits [-]; None for a voltage request.

        For a torque current request, the value is the largest allowed duty cycle, and `limits` includes the requested
        current.
        """
        if self.unit is Unit.AMPERES:
            return math.copysign(self.max_duty, self.asked)
        return self.asked if self.unit is Unit.DUTY else None

    @property
    def limits(self) -> tuple[float, float]:
        """Active limits of the stator current and of the supply current [A]."""
        stator = min(abs(self.asked), self._stator_limit) if self.unit is Unit.AMPERES else self._stator_limit
        return stator, self._lower if self._is_lowered else self._supply_limit

    @property
    def volts(self) -> float:
        """Motor voltage [V]."""
        if self._is_due:
            self._hold_rotor()
        return self._volts

    @property
    def current(self) -> float:
        """Motor current [A]."""
        if self._is_due:
            self._hold_rotor()
        return self._current

    @property
    def is_stator_limited(self) -> bool:
        """Whether the stator current limit is active."""
        return not self.is_neutral and abs(self.current) > _LIMITED * self._stator_limit

    @property
    def is_supply_limited(self) -> bool:
        """Whether the supply current limit was active when the motor current was last computed."""
        return not self.is_neutral and self._current * self._volts > _LIMITED * self.limits[1] * self.supply

    def show(self, volts: float, current: float) -> None:
        """Set motor voltage [V] and current [A] from a robot model. The bridge no longer computes these values."""
        self.has_model = True
        self._is_due = False
        self._volts, self._current = volts, current

    def _hold_rotor(self) -> None:
        """Compute the motor's voltage and current at the present rotor speed."""
        self._is_due = False
        model = self.motor.model if self._foc and not self.is_neutral else self.motor.trapezoidal
        ohm, emf, w = model.resistance, _emf(model), self.rps
        if self.is_neutral:
            self._volts, self._current = 0.0, -emf * w / ohm if self.is_braking else 0.0
            return
        top = self.supply
        if self.unit is Unit.AMPERES:
            volts, top = emf * w + self.asked * ohm, self.max_duty * self.supply
        else:
            volts = self.asked_volts
        volts = min(max(volts, -top), top)
        stator, power = self._stator_limit, self.limits[1] * self.supply
        held = _HELD * w, volts / ohm, emf / ohm, stator, emf, ohm, 1.0, 1.0, 0.0, 0.0, w, power
        _, self._current, self._volts, _, _ = solve_limited(_HELD, *held)  # type: ignore[no-untyped-call]

    def _time_limit(self, loops: int) -> None:
        """Lower the supply limit after the configured time at the limit.

        The method restores the configured limit as soon as the supply current is below the active limit.
        """
        limit = self._lower if self._is_lowered else self._supply_limit
        if self._current * self._volts <= _LIMITED * limit * self.supply:
            self._over, self._is_lowered = 0.0, False
            return
        self._over += loops * LOOP
        self._is_lowered = self._over > self._lower_time > 0.0
