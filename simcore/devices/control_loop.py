"""What the 1 kHz loops of motor controllers share: P, I and D in units of their sensor, ramps, trapezoids.

I is summed and D differenced once a loop, as REV's and CTRE's controllers do.
"""

from __future__ import annotations

from dataclasses import dataclass

from simcore import season

TrapezoidProfile = season.wpimath.TrapezoidProfile

__all__ = ["ControlLoop", "PidGains", "ramped"]

_LOOP = 1e-3  # [s]


@dataclass(frozen=True, slots=True, kw_only=True)
class PidGains:
    """Of one closed-loop slot, in robot code's units."""

    p: float = 0.0
    i: float = 0.0
    d: float = 0.0
    d_filter: float = 0.0
    i_zone: float = 0.0
    """Error beyond which the sum is dropped; 0: none."""
    i_most: float = 0.0
    """Largest sum; 0: any."""
    allowed_error: float = 0.0


class ControlLoop:
    """State of one controller's loop: `SparkLoop`, `TalonLoop`."""

    def __init__(self) -> None:
        self.output = 0.0
        """Duty cycle that it asks for, before limits that depend on the motor [-]."""
        self.error = 0.0
        """Of the closed loop, sensor units."""
        self.error_slope = 0.0
        """Its change in one loop."""
        self.integral = 0.0
        """Sum of errors, one a loop."""
        self.profile_position = 0.0
        """Setpoint of the motion profile now, sensor units."""
        self.profile_velocity = 0.0
        self._last_error: float | None = None
        self._asked_for: tuple[int, int] | None = None

    def rest(self) -> None:
        """Disabled: no output, and nothing is remembered."""
        self.output = self.integral = self.error_slope = 0.0
        self._last_error = self._asked_for = None

    def begin(self, mode: int, slot: int, position: float, velocity: float) -> None:
        """Robot code asks for a mode and a slot: others than the last ones start anew from where the sensor is."""
        if (mode, slot) != self._asked_for:
            self._asked_for = mode, slot
            self.integral = 0.0
            self._last_error = None
            self.profile_position, self.profile_velocity = position, velocity

    def pid(self, loops: int, gains: PidGains, error: float) -> float:
        """P, I and D of an error that stands for some loops."""
        self.error = error
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
        self.error_slope = kept * self.error_slope + (1.0 - kept) * ((error - last) / loops)
        self._last_error = error
        return gains.p * error + gains.i * self.integral + gains.d * self.error_slope

    def advance_profile(self, loops: int, goal: float, cruise: float, acceleration: float, rate: float) -> None:
        """Move along a trapezoid.

        Args:
            loops: Of 1 ms.
            goal: Sensor units.
            cruise: Largest velocity, in the sensor's own unit; without one or an acceleration it does not move.
            acceleration: The same a second.
            rate: Position units per second for one velocity unit.
        """
        if not (cruise > 0.0 and acceleration > 0.0):
            self.profile_velocity = 0.0
            return
        profile = TrapezoidProfile(TrapezoidProfile.Constraints(cruise * abs(rate), acceleration * abs(rate)))
        start = TrapezoidProfile.State(self.profile_position, self.profile_velocity * rate)
        state = profile.calculate(loops * _LOOP, start, TrapezoidProfile.State(goal, 0.0))
        self.profile_position, self.profile_velocity = float(state.position), float(state.velocity) / rate


def ramped(asked: float, last: float, loops: int, ramp: float) -> float:
    """A duty cycle within -1 to 1, after some loops of a ramp of so long from 0 to full output [s]; 0: at once."""
    asked = min(max(asked, -1.0), 1.0)
    if ramp <= 0.0:
        return asked
    most = loops * _LOOP / ramp
    return min(max(asked, last - most), last + most)
