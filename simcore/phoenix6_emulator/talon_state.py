"""State of an emulated motor controller: inputs from physics, requests of robot code, results of control.

Feedback, followers, status frames and the control loop of `EmulatedTalon` work on this state; it imports none of them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from simcore.phoenix6_emulator.config_text import Setting
from simcore.phoenix6_emulator.control_plan import ControlPlan
from simcore.phoenix6_emulator.control_requests import REQUESTS, RequestKind
from simcore.phoenix6_emulator.device_clock import SimulatedClock
from simcore.phoenix6_emulator.emulated_device import Devices, EmulatedDevice
from simcore.phoenix6_emulator.motion_profile import Expo, SCurve, VelocityRamp
from simcore.phoenix6_emulator.motor_constants import KRAKEN_X44, KRAKEN_X60
from simcore.phoenix6_emulator.output_stage import Bridge
from simcore.phoenix6_emulator.talon_limits import TalonLimit

__all__ = ["HALF_RANGE", "IDLE", "TalonState", "within_range"]

HALF_RANGE = 16384.0
"""A device reports rotor positions within plus and minus this [rotations]."""
IDLE = REQUESTS["Empty"]
"""The request of a controller that has received none, or whose last one has expired."""


def within_range(turns: float) -> float:
    """A rotor position as a device reports it, within +-16384 [rotations]."""
    if -HALF_RANGE <= turns < HALF_RANGE:
        return turns
    return math.remainder(turns, 2.0 * HALF_RANGE)


class TalonState(EmulatedDevice):
    """State of one motor controller; numbers have robot code's signs unless said otherwise.

    Args:
        device_id: CAN id.
        clock: Simulated time.
        defaults: Factory configuration.
        devices: All devices by type and id: remote sensors and leaders are found among them.
    """

    # With an attribute dictionary, which Python 3.11 shares up to 30 names only, a step takes a tenth more.
    __slots__ = (
        *("acc", "args", "bridge", "derr", "devices", "enabled", "err", "expo", "feed_forward", "followers", "forward"),
        *("goal_a", "goal_p", "goal_v", "integral", "kind", "late_rps", "limits", "limits_hit", "output", "pid_out"),
        *("plan", "pos", "profile_loops", "raw", "ref", "reverse", "rotor_acceleration", "rotor_offset", "rotor_rps"),
        *("scurve", "settled_rps", "shift", "sign", "slope", "slot", "turn", "vel", "velocity_ramp"),
    )

    def __init__(
        self,
        device_id: int,
        clock: SimulatedClock,
        defaults: Mapping[int, Setting],
        devices: Devices,
    ) -> None:
        super().__init__(device_id, clock, defaults)
        self.devices = devices
        self.bridge = Bridge(KRAKEN_X60)
        self.forward = TalonLimit(repr(self), forward=True)
        self.reverse = TalonLimit(repr(self), forward=False)
        # rotor
        self.raw = 0.0
        """Rotor position as physics writes it, counter-clockwise [rotations]."""
        self.rotor_rps = 0.0
        """Rotor velocity as physics writes it, counter-clockwise [rotations/s]."""
        self.rotor_acceleration = 0.0
        """As physics writes it [rotations/s^2]."""
        self.late_rps = 0.0
        """Rotor velocity at which the limits of a voltage work, counter-clockwise [rotations/s]."""
        self.shift = 0.0
        """Of the rotor's zero, by `set_position`, counter-clockwise [rotations]."""
        self.rotor_offset = 0.0
        """As configured [rotations]."""
        self.sign = 1.0
        """-1 with a clockwise configuration."""
        self.turn = 1.0
        """-1 where positive in robot code is clockwise: as configured, or for a follower as its leader turns."""
        # measured position, velocity and acceleration of the configured sensor [mechanism rotations, 1/s, 1/s^2]
        self.pos = self.vel = self.acc = 0.0
        # request
        self.kind: RequestKind = IDLE
        """The last request that has arrived."""
        self.args: tuple[Any, ...] = (0.0,)
        """Its fields."""
        self.plan: ControlPlan
        """How it is carried out."""
        self.slot = 0
        self.enabled = False
        self.output = self.goal_p = self.goal_v = self.goal_a = self.feed_forward = 0.0
        self.limits = (0.0, 0.0, 0.0)
        """Limits of the profile, see `ControlState`."""
        # control
        self.integral = self.err = self.derr = self.ref = self.slope = self.pid_out = 0.0
        self.scurve, self.expo, self.velocity_ramp = SCurve(), Expo(), VelocityRamp()
        self.profile_loops = 0
        self.limits_hit = (False, False, False, False)
        """Soft limits forward and reverse, switches forward and reverse."""
        self.settled_rps = math.nan
        """Rotor velocity at the last loop if the output stays while the rotor does; else not a number."""
        self.followers: list[TalonState] = []
        """Controllers whose leader this one is."""

    @property
    def rotor_position(self) -> float:
        """Rotor position as robot code reads it, within +-16384 [rotations]."""
        return within_range(self.turn * (self.raw + self.shift) + self.rotor_offset)

    def set_input(self, name: str, value: float) -> None:
        """Write what `sim_state` and SimDevices set, by the names of CTRE's library; rotors turn counter-clockwise."""
        if name == "RawRotorPosition":
            self.raw = value
        elif name == "RotorVelocity":
            self.rotor_rps = value
        elif name == "RotorAcceleration":
            self.rotor_acceleration = value
        elif name == "SupplyVoltage":
            self.supply = self.bridge.supply = max(value, 4.0)
        elif name == "AddRotorPosition":
            self.raw += value
        elif name == "ForwardLimit":
            self.forward.closed = value != 0.0
        elif name == "ReverseLimit":
            self.reverse.closed = value != 0.0
        elif name == "MotorType":
            self.bridge.motor = KRAKEN_X44 if value == 1.0 else KRAKEN_X60
            self.configured()
        else:
            super().set_input(name, value)

    def get_value(self, name: str) -> float | None:
        """What `sim_state` and SimDevices read: shafts counter-clockwise, the torque current with robot code's sign."""
        bridge = self.bridge
        if name == "MotorVoltage":
            return bridge.volts * self.turn
        if name == "TorqueCurrent":
            return bridge.current
        if name == "SupplyCurrent":
            return bridge.supply_current
        if name == "DutyCycle":
            return bridge.duty
        if name == "SupplyVoltage":
            return self.supply
        if name == "RotorPosition":
            return self.turn * self.rotor_position
        if name == "RawRotorPosition":
            return self.raw
        if name == "RotorVelocity":
            return self.rotor_rps
        if name == "RotorAcceleration":
            return self.rotor_acceleration
        if name in ("ForwardLimit", "ReverseLimit"):
            return float((self.forward if name == "ForwardLimit" else self.reverse).closed)
        return None
