"""The control law of a Talon SRX or Victor SPX: 1 kHz loops from a demand and a sensor to a duty cycle.

Source: CTRE's Phoenix 5 documentation ("Motor Controller Closed Loop": outputs of 1023 are full, errors in sensor
units, velocities in units per 100 ms, currents in mA, I summed and D differenced once a loop), and the simulation in
Phoenix 5.36, whose outputs for a sensor at rest it meets within two thousandths.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

from simcore.devices.control_loop import ControlLoop, PidGains, ramped

__all__ = ["ControlMode", "Demand", "SlotGains", "TalonConfiguration", "TalonLoop"]

_FULL = 1023.0  # output units of full output
_TENTHS = 10.0  # of a second in one


class ControlMode(enum.IntEnum):
    """As `phoenix5.ControlMode` numbers them."""

    PERCENT_OUTPUT = 0
    POSITION = 1
    VELOCITY = 2
    CURRENT = 3
    FOLLOWER = 5
    MOTION_MAGIC = 7
    DISABLED = 15


@dataclass(frozen=True, slots=True, kw_only=True)
class SlotGains(PidGains):
    """One closed-loop slot, in CTRE's units."""

    f: float = 0.0
    peak: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class TalonConfiguration:
    """What a controller is configured with, as far as it shows in simulation."""

    brakes: bool = False
    """In neutral; else it coasts. A controller that is never told keeps what is set by its button; that it coasts
    then is a guess."""
    compensation: float | None = None
    """Voltage compensation [V]."""
    open_ramp: float = 0.0
    """Time from 0 to full output [s]; 0: at once."""
    closed_ramp: float = 0.0
    peak_forward: float = 1.0
    peak_reverse: float = -1.0
    nominal_forward: float = 0.0
    nominal_reverse: float = 0.0
    deadband: float = 0.04
    """Output below which it is neutral [-]."""
    supply_limit: float | None = None
    """Supply current to which it falls [A]..."""
    supply_trigger: float = 0.0
    """...once more than this [A]..."""
    supply_delay: float = 0.0
    """...has flowed for so long [s]."""
    soft_forward: float | None = None
    """Sensor units."""
    soft_reverse: float | None = None
    cruise: float = 0.0
    """Of Motion Magic [units/100 ms]."""
    acceleration: float = 0.0
    """[units/100 ms/s]"""
    slots: tuple[SlotGains, ...] = (SlotGains(),) * 4


@dataclass(frozen=True, slots=True)
class Demand:
    """What robot code asks for."""

    mode: int = ControlMode.DISABLED
    value: float = 0.0
    slot: int = 0
    feed_forward: float = 0.0
    """Arbitrary feed-forward, a share of full output [-]."""


class TalonLoop(ControlLoop):
    """State of one controller's loop; its profile is Motion Magic's [units, units/100 ms].

    Args:
        config: What it is configured with; it may be replaced at any time.
    """

    def __init__(self, config: TalonConfiguration | None = None) -> None:
        super().__init__()
        self.config = config or TalonConfiguration()
        self._ramped = 0.0

    def rest(self) -> None:
        """Disabled: no output, and nothing is remembered."""
        super().rest()
        self._ramped = 0.0

    def run(self, loops: int, demand: Demand, position: float, velocity: float, amps: float, bus: float) -> float:
        """Advance by some loops of 1 ms in which nothing that is measured changes.

        Args:
            loops: At least one.
            demand: Held meanwhile.
            position: Of the selected sensor [units].
            velocity: Its [units/100 ms].
            amps: Of the motor [A].
            bus: Supply [V].

        Returns:
            The duty cycle.
        """
        self.begin(demand.mode, demand.slot, position, velocity)
        c = self.config
        is_open = demand.mode in (ControlMode.PERCENT_OUTPUT, ControlMode.DISABLED)
        if demand.mode == ControlMode.DISABLED:
            self.output = self._ramped = 0.0
            return 0.0
        asked = demand.value if is_open else self._closed(loops, demand, position, velocity, amps)
        asked += demand.feed_forward
        ramp = c.open_ramp if is_open else c.closed_ramp
        self._ramped = asked = ramped(asked, self._ramped, loops, ramp)
        if abs(asked) < c.deadband:
            asked = 0.0
        elif asked > 0.0:
            asked = min(max(asked, c.nominal_forward), c.peak_forward)
        else:
            asked = max(min(asked, c.nominal_reverse), c.peak_reverse)
        if (asked > 0.0 and c.soft_forward is not None and position >= c.soft_forward) or (
            asked < 0.0 and c.soft_reverse is not None and position <= c.soft_reverse
        ):
            asked = 0.0
        if c.compensation is not None:
            asked = min(max(asked * c.compensation / bus, -1.0), 1.0)
        self.output = asked
        return asked

    def _closed(self, loops: int, demand: Demand, position: float, velocity: float, amps: float) -> float:
        gains = self.config.slots[demand.slot if 0 <= demand.slot < len(self.config.slots) else 0]
        if demand.mode == ControlMode.POSITION:
            return self._pid(loops, gains, demand.value - position, demand.value)
        if demand.mode == ControlMode.VELOCITY:
            return self._pid(loops, gains, demand.value - velocity, demand.value)
        if demand.mode == ControlMode.CURRENT:
            return self._pid(loops, gains, (demand.value - amps) * 1000.0, demand.value * 1000.0)
        if demand.mode == ControlMode.MOTION_MAGIC:
            c = self.config
            self.advance_profile(loops, demand.value, c.cruise, c.acceleration, _TENTHS)
            return self._pid(loops, gains, self.profile_position - position, self.profile_velocity)
        return 0.0  # follower: of its leader; motion profiles and music are not simulated

    def _pid(self, loops: int, gains: SlotGains, error: float, feed: float) -> float:
        units = self.pid(loops, gains, error) + gains.f * feed
        return math.copysign(min(abs(units) / _FULL, gains.peak), units)
