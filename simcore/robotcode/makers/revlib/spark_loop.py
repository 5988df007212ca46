"""Control law of a SPARK: 1 kHz loops that compute a duty cycle from a set-point and a sensor reading.

Source: REV's closed-loop documentation (docs.revrobotics.com/revlib/spark/closed-loop: P on the error, I summed and D
differenced once per 1 ms loop, feedforward in volts, MAXMotion profiles) and REVLib 2026.0's `SparkSim.iterate`, whose
proportional, feedforward, wrapping and limiting terms are matched to the last printed digit.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, field

from simcore import season

TrapezoidProfile = season.wpimath.TrapezoidProfile

__all__ = ["LOOP", "Command", "ControlMode", "Feedback", "MotionLimits", "SlotGains", "SparkConfiguration", "SparkLoop"]

LOOP = 1e-3
"""Period of a controller's control loop [s]."""


class ControlMode(enum.IntEnum):
    """Control mode of a set-point, with the values of `SparkLowLevel.ControlType`."""

    DUTY_CYCLE = 0
    VELOCITY = 1
    VOLTAGE = 2
    POSITION = 3
    CURRENT = 4
    MAXMOTION_POSITION = 5
    MAXMOTION_VELOCITY = 6


class Feedback(enum.Enum):
    """Sensor that closes the control loop."""

    PRIMARY = "primary encoder"
    ABSOLUTE = "absolute encoder"
    EXTERNAL = "alternate or external encoder"
    ANALOG = "analog sensor"
    NONE = "a sensor that is not simulated"


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionLimits:
    """MAXMotion limits in robot code's units; acceleration in velocity units per second."""

    cruise: float = 0.0
    acceleration: float = 0.0
    allowed_error: float = 0.0
    """Profile error above which the profile restarts at the mechanism's position; 0 for no limit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SlotGains:
    """Gains of one closed-loop slot in robot code's units.

    The output of PID is a duty cycle, and the output of feedforward is a voltage [V].
    """

    p: float = 0.0
    i: float = 0.0
    d: float = 0.0
    d_filter: float = 0.0
    i_zone: float = 0.0
    """Error above which the integral is reset; 0 for no limit."""
    i_most: float = 0.0
    """Largest absolute value of the integral; 0 for no limit."""
    allowed_error: float = 0.0
    least: float = -1.0
    most: float = 1.0
    ks: float = 0.0
    kv: float = 0.0
    ka: float = 0.0
    kg: float = 0.0
    kcos: float = 0.0
    kcos_ratio: float = 0.0
    motion: MotionLimits = field(default_factory=MotionLimits)


@dataclass(frozen=True, slots=True, kw_only=True)
class SparkConfiguration:
    """SPARK settings that affect the simulation."""

    brakes: bool = False
    """Whether the idle mode is brake instead of coast."""
    current_limit: float = 80.0
    """Smart current limit of the motor current [A]; 0 for no limit."""
    compensation: float | None = None
    """Nominal voltage of the voltage compensation [V]; None if disabled."""
    open_ramp: float = 0.0
    """Open-loop ramp: time from 0 to full output [s]; 0 for no ramp."""
    closed_ramp: float = 0.0
    feedback: Feedback = Feedback.PRIMARY
    primary: tuple[float, float] = (1.0, 1.0)
    """Position and velocity conversion factors of the primary encoder, from turns and rpm."""
    absolute: tuple[float, float] = (1.0, 1.0)
    external: tuple[float, float] = (1.0, 1.0)
    analog: tuple[float, float] = (1.0, 1.0)
    """Position and velocity conversion factors of the analog sensor, from volts and volts per second."""
    is_centered: bool = False
    """Whether the absolute encoder reads -1/2 to 1/2 turn instead of 0 to 1."""
    is_brushed: bool = False
    """Whether the motor is brushed, with the primary encoder wired to the data port instead of a rotor sensor."""
    wrap: tuple[float, float] | None = None
    """Lower and upper limit for position wrapping, in robot code's units; None if disabled."""
    soft_forward: float | None = None
    soft_reverse: float | None = None
    stops_forward: bool = False
    """Whether the forward limit switch stops the motor."""
    stops_reverse: bool = False
    slots: tuple[SlotGains, ...] = (SlotGains(),)

    @property
    def factors(self) -> tuple[float, float]:
        """Position and velocity conversion factors of the loop's sensor, from turns and rpm (analog: V and V/min)."""
        others = {
            Feedback.ABSOLUTE: self.absolute,
            Feedback.EXTERNAL: self.external,
            Feedback.ANALOG: (self.analog[0], self.analog[1] / 60.0),
        }
        return others.get(self.feedback, self.primary)


@dataclass(frozen=True, slots=True)
class Command:
    """Request of robot code to a controller: control mode, set-point, slot and arbitrary feedforward."""

    mode: int = 0
    setpoint: float = 0.0
    slot: int = 0
    feed_forward: float = 0.0
    """Arbitrary feedforward: duty cycle [-] if `feed_forward_is_duty`, else voltage [V]."""
    feed_forward_is_duty: bool = False


class SparkLoop:
    """Control loop of one controller, with the state of the PID controller and the MAXMotion profile.

    Args:
        config: Configuration, replaceable at any time; None for the defaults.
    """

    def __init__(self, config: SparkConfiguration | None = None) -> None:
        self.config = config or SparkConfiguration()
        self.output = 0.0
        """Requested duty cycle before soft limits, limit switches and current limit [-]."""
        self.integral = 0.0
        """Sum of the error over all loops since the last reset, in robot code's units."""
        self.profile_position = 0.0
        """Current position set-point of the motion profile, in robot code's units."""
        self.profile_velocity = 0.0
        self._error_slope = 0.0  # filtered change of the error per loop
        self._last_error: float | None = None
        self._asked_for: tuple[int, int] | None = None
        self.is_at_setpoint = False
        """Whether the error is within the slot's allowed error."""

    def rest(self) -> None:
        """Reset the loop while the robot is disabled: zero the output and clear the state."""
        self.output = self.integral = self._error_slope = 0.0
        self._last_error = self._asked_for = None

    def run(self, loops: int, command: Command, position: float, velocity: float, current: float, bus: float) -> float:
        """Advance by a number of 1 ms loops with constant measurements.

        Args:
            loops: Number of loops, at least 1.
            command: Request during these loops.
            position: Position of the sensor that closes the loop, in robot code's units.
            velocity: Velocity of the sensor that closes the loop, in robot code's units.
            current: Motor current [A].
            bus: Supply voltage [V].

        Returns:
            Requested duty cycle [-].
        """
        if (command.mode, command.slot) != self._asked_for:  # a change of mode or slot resets the loop
            self._asked_for = command.mode, command.slot
            self.integral = 0.0
            self._last_error = None
            self.profile_position, self.profile_velocity = position, velocity
        config = self.config
        extra = command.feed_forward if command.feed_forward_is_duty else command.feed_forward / bus
        scale = 1.0 if config.compensation is None else config.compensation / bus
        mode = command.mode
        if mode == ControlMode.DUTY_CYCLE:
            asked, ramp = command.setpoint * scale + extra, config.open_ramp
        elif mode == ControlMode.VOLTAGE:
            asked, ramp = command.setpoint / bus + extra, config.open_ramp
        else:
            gains = config.slots[command.slot if 0 <= command.slot < len(config.slots) else 0]
            feedback, volts = self._closed(loops, command, gains, position, velocity, current)
            asked = min(max(feedback * scale + volts / bus + extra, gains.least), gains.most)
            ramp = config.closed_ramp
        self.output = _ramped(asked, self.output, loops, ramp)
        return self.output

    def _closed(
        self, loops: int, command: Command, gains: SlotGains, position: float, velocity: float, current: float
    ) -> tuple[float, float]:
        """Return PID duty cycle [-] and feedforward voltage [V]; advance the profile in MAXMotion modes."""
        mode = command.mode
        if mode == ControlMode.POSITION:
            error = self.wrapped(command.setpoint - position)
            volts = math.copysign(gains.ks, error) if error else 0.0
            return self._pid(loops, gains, error, error), volts + self._gravity(gains, position)
        if mode == ControlMode.VELOCITY:
            goal = command.setpoint
            error = goal - velocity
            return self._pid(loops, gains, error, error), _sign(goal) * gains.ks + gains.kv * goal
        if mode == ControlMode.CURRENT:
            error = command.setpoint - current
            return self._pid(loops, gains, error, error), 0.0
        before = self.profile_velocity
        if mode == ControlMode.MAXMOTION_VELOCITY:
            self._ramp_velocity(loops, gains.motion, command.setpoint)
            error, rest, volts = self.profile_velocity - velocity, command.setpoint - velocity, 0.0
        else:
            self._advance_profile(loops, gains.motion, command.setpoint, position, velocity)
            error = self.wrapped(self.profile_position - position)
            rest = self.wrapped(command.setpoint - position)
            volts = self._gravity(gains, position)
        speed = self.profile_velocity
        volts += _sign(speed) * gains.ks + gains.kv * speed + gains.ka * (speed - before) / (loops * LOOP)
        return self._pid(loops, gains, error, rest), volts

    def _pid(self, loops: int, gains: SlotGains, error: float, rest: float) -> float:
        """Return the PID output after a number of 1 ms loops with a constant error.

        Args:
            loops: Number of loops.
            gains: Gains of the slot.
            error: Error from the set-point, or from the motion profile.
            rest: Error from the set-point itself, compared with the allowed error.
        """
        self.is_at_setpoint = abs(rest) <= gains.allowed_error
        if abs(error) < gains.allowed_error:
            error = 0.0
        if gains.i_zone == 0.0 or abs(error) <= gains.i_zone:
            self.integral += error * loops
            if gains.i_most > 0.0:
                self.integral = min(max(self.integral, -gains.i_most), gains.i_most)
        else:
            self.integral = 0.0
        last = error if self._last_error is None else self._last_error
        kept = gains.d_filter
        self._error_slope = kept * self._error_slope + (1.0 - kept) * ((error - last) / loops)
        self._last_error = error
        return gains.p * error + gains.i * self.integral + gains.d * self._error_slope

    def _gravity(self, gains: SlotGains, position: float) -> float:
        return gains.kg + gains.kcos * math.cos(math.tau * gains.kcos_ratio * position)

    def wrapped(self, error: float) -> float:
        """Return a position error, reduced to at most half the range if position wrapping is enabled."""
        if self.config.wrap is None:
            return error
        span = self.config.wrap[1] - self.config.wrap[0]
        return math.remainder(error, span) if span > 0.0 else error

    def _ramp_velocity(self, loops: int, motion: MotionLimits, goal: float) -> None:
        if motion.cruise > 0.0:
            goal = min(max(goal, -motion.cruise), motion.cruise)
        most = motion.acceleration * loops * LOOP
        speed = self.profile_velocity
        self.profile_velocity = min(max(goal, speed - most), speed + most)

    def _advance_profile(self, loops: int, motion: MotionLimits, goal: float, position: float, velocity: float) -> None:
        """Advance the MAXMotion position profile, a trapezoid even if robot code selects an S-curve."""
        if motion.cruise > 0.0 and 0.0 < motion.allowed_error < abs(self.wrapped(self.profile_position - position)):
            self.profile_position, self.profile_velocity = position, velocity
        of_position, of_velocity = self.config.factors
        # Position units per second for one velocity unit, from turns and rpm with their conversion factors.
        rate = of_position / (60.0 * of_velocity) if of_velocity else 1.0
        if self.config.wrap is not None:
            goal = self.profile_position + self.wrapped(goal - self.profile_position)
        if not (motion.cruise > 0.0 and motion.acceleration > 0.0):
            self.profile_velocity = 0.0
            return
        profile = TrapezoidProfile(
            TrapezoidProfile.Constraints(motion.cruise * abs(rate), motion.acceleration * abs(rate))
        )
        start = TrapezoidProfile.State(self.profile_position, self.profile_velocity * rate)
        state = profile.calculate(loops * LOOP, start, TrapezoidProfile.State(goal, 0.0))
        self.profile_position, self.profile_velocity = float(state.position), float(state.velocity) / rate


def _sign(value: float) -> float:
    return math.copysign(1.0, value) if value else 0.0


def _ramped(asked: float, last: float, loops: int, ramp: float) -> float:
    """Return the clamped duty cycle after a number of loops; `ramp` is the time from 0 to 1 [s], 0 for no ramp."""
    asked = min(max(asked, -1.0), 1.0)
    if ramp <= 0.0:
        return asked
    most = loops * LOOP / ramp
    return min(max(asked, last - most), last + most)
