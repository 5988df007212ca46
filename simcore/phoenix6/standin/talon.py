"""A TalonFX with its motor: sensors, requests, control loop, output."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from phoenix6.spns.spn_value import SpnValue

from simcore.errors import NonFiniteError
from simcore.phoenix6.standin.bridge import LIMITER_GAIN, Bridge
from simcore.phoenix6.standin.clock import LOOP_NS, SimulatedClock
from simcore.phoenix6.standin.device import Device, period_of
from simcore.phoenix6.standin.electrical import KRAKEN_X44, KRAKEN_X60
from simcore.phoenix6.standin.feedback import feedback_of
from simcore.phoenix6.standin.follower import follow, turning
from simcore.phoenix6.standin.laws import PROFILE_LOOPS
from simcore.phoenix6.standin.limits import Limit
from simcore.phoenix6.standin.motion import PROFILED, Plan, build, limits_of
from simcore.phoenix6.standin.profile import Expo, SCurve, VelocityRamp
from simcore.phoenix6.standin.requests import REQUESTS, Axis, RequestKind, Unit
from simcore.phoenix6.standin.talon_frame import SIGNALS, TalonFrame, units_number
from simcore.phoenix6.standin.talon_status import active_faults, frame_of
from simcore.phoenix6.standin.wire import Setting

if TYPE_CHECKING:
    from simcore.phoenix6.standin.world import StandIn

__all__ = ["CONTROL_PHASE_NS", "ONE_SHOT_NS", "Talon"]

_log = logging.getLogger(__name__)

CONTROL_PHASE_NS = 4_000_000
"""When in their period control frames go out [ns]. Robot code at a multiple of the period waits this long; on the wall
clock the wait is anything between nothing and a period, 4.4 ms in the middle."""
ONE_SHOT_NS = 100_000_000
"""How long a device obeys a request that is sent once (`update_freq_hz=0`) [ns]."""
_HALF_RANGE = 16384.0
_TRUE_BY_DEFAULT = {"enable_foc": True, "max_abs_duty_cycle": 1.0, "update_freq_hz": 100.0}
_IDLE = REQUESTS["Empty"]


class Talon(Device):
    """One motor controller; numbers have robot code's signs unless said otherwise.

    Args:
        device_id: CAN id.
        clock: Simulated time.
        defaults: Factory configuration.
        world: Where remote sensors and leaders are found.
    """

    model = "talon fx"
    type_number = 4
    signals = SIGNALS

    def __init__(self, device_id: int, clock: SimulatedClock, defaults: Mapping[int, Setting], world: StandIn) -> None:
        super().__init__(device_id, clock, defaults)
        self.world = world
        self.bridge = Bridge(KRAKEN_X60)
        self.forward = Limit(repr(self), forward=True)
        self.reverse = Limit(repr(self), forward=False)
        self.raw = 0.0
        """Rotor position as physics writes it, counter-clockwise [rotations]."""
        self.rotor_rps = 0.0
        """Rotor velocity as physics writes it, counter-clockwise [rotations/s]."""
        self.rotor_acceleration = 0.0
        """As physics writes it [rotations/s^2]."""
        self.late_rps = 0.0
        """Rotor velocity as the limits of a voltage know it, counter-clockwise [rotations/s]."""
        self.sign = 1.0
        """-1 with a clockwise configuration."""
        self.turn = 1.0
        """-1 where positive in robot code is clockwise: as configured, and for a follower as its leader says."""
        self.pos = self.vel = self.acc = 0.0
        self.output = self.goal_p = self.goal_v = self.goal_a = self.feed_forward = 0.0
        self.limits = (0.0, 0.0, 0.0)
        self.integral = self.err = self.derr = self.ref = self.slope = self.pid_out = 0.0
        self.scurve, self.expo, self.velocity_ramp = SCurve(), Expo(), VelocityRamp()
        self.kind: RequestKind = _IDLE
        """What it does, by the last request that has arrived."""
        self.args: tuple[Any, ...] = (0.0,)
        self.enabled = False
        self._shift = 0.0
        self._pending: tuple[int, RequestKind, tuple[Any, ...]] | None = None
        self._expires: int | None = None
        self._seen_ns = -1
        self.profile_loops = 0
        self._unseen = 0
        self.plans: dict[tuple[str, int, bool], Plan] = {}
        self._told = False
        self._limit_flags: tuple[bool, ...] = (False, False, False, False)
        self.limits_hit = (False, False, False, False)
        self.slot = 0
        self.is_watched = False
        """Whether anybody has ever looked at its frames."""
        self.configured()
        self.send_frame()

    # ---- configuration

    def configured(self) -> None:
        """Take over a configuration."""
        self.sign = self.turn = -1.0 if self.config[SpnValue.CONFIG_INVERTED.value] else 1.0
        self._rotor_offset = self.config.get(SpnValue.CONFIG_FEEDBACK_ROTOR_OFFSET.value, 0.0)
        self._autosets = any(
            self.config[spn.value]
            for spn in (
                SpnValue.CONFIG_FORWARD_LIMIT_AUTOSET_POS_ENABLE,
                SpnValue.CONFIG_REVERSE_LIMIT_AUTOSET_POS_ENABLE,
            )
        )
        self.bridge.configure(self.config)
        self.forward.configure(self.config)
        self.reverse.configure(self.config)
        self.plans.clear()
        self.resolve()
        self._accept(self.kind, self.args)

    def resolve(self) -> None:
        """Look for the configured sensor, which robot code may build later than the controller."""
        self.feedback = feedback_of(self, self.config)
        self._read, self._remote = self.feedback.read, self.feedback.remote

    def command(self, spn: int, value: float) -> None:
        """A new position."""
        if spn == SpnValue.TALON_FX_SET_SENSOR_POSITION.value:
            self.set_position(value)
        else:
            super().command(spn, value)

    def set_position(self, position: float) -> None:
        """Call the present position this [mechanism rotations].

        With a remote or fused sensor it has no effect, as in CTRE's simulation.
        """
        if not self.feedback.is_rotor:
            if not self._told:
                _log.warning("%r: set_position() does nothing with a remote sensor, as in CTRE's simulation", self)
            self._told = True
            return
        ratio = self.config[SpnValue.CONFIG_SENSOR_TO_MECHANISM_RATIO.value] or 1.0
        self._shift += self.turn * (position * ratio - self.rotor_position)
        self.measure()

    # ---- physics

    @property
    def rotor_position(self) -> float:
        """Rotor position as robot code knows it, within +-16384 [rotations]."""
        turns = self.turn * (self.raw + self._shift) + self._rotor_offset
        if -_HALF_RANGE <= turns < _HALF_RANGE:
            return turns
        return math.remainder(turns, 2.0 * _HALF_RANGE)

    def set_input(self, name: str, value: float) -> None:
        """Rotor, supply, limit switches, kind of motor."""
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
        """What `sim_state` and SimDevices read: shafts counter-clockwise, torque current with robot code's sign."""
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

    # ---- requests

    def receive(self, kind: RequestKind, args: tuple[Any, ...]) -> None:
        """A control request of robot code; it takes effect with the next control frame.

        Raises:
            NonFiniteError: A field is not a number.
        """
        total = sum(args)
        if total != total:
            raise NonFiniteError(f"{self!r}: {kind.name} with a field that is not a number: {args}")
        pending = self._pending
        hz = args[0]
        if pending is None:
            if kind is self.kind and args == self.args and hz != 0.0:
                return
        elif pending[1] is kind and pending[2] == args:
            return
        now = self.clock.ns
        if hz == 0.0:
            self._pending = (now, kind, args)
            return
        if pending is not None and pending[1].name == kind.name:
            self._pending = (pending[0], kind, args)  # the frame that is due carries the newest numbers
            return
        period = period_of(hz) * LOOP_NS
        phase = min(CONTROL_PHASE_NS, period - LOOP_NS)
        self._pending = ((now - phase + period - 1) // period * period + phase, kind, args)

    def apply(self, kind: str, **values: float) -> None:
        """Obey a request at once, without the latency of a control frame.

        Args:
            kind: Name of the request, "VelocityVoltage".
            **values: Its fields; those that are not named have the library's defaults.
        """
        request = REQUESTS[kind]
        self._pending = None
        self._accept(request, tuple(values.get(f, _TRUE_BY_DEFAULT.get(f, 0.0)) for f in request.fields))

    def _accept(self, kind: RequestKind, args: tuple[Any, ...]) -> None:
        changed = kind is not self.kind
        self.kind, self.args = kind, args
        self.turn = turning(self)
        field = kind.slots
        axis = kind.axis
        self._expires = self.clock.ns + ONE_SHOT_NS if args[0] == 0.0 and kind is not _IDLE else None
        self.slot = slot = int(args[field["slot"]]) if "slot" in field else 0
        self.foc = foc = bool(args[field["enable_foc"]]) if "enable_foc" in field else True
        plan = self.plans.get((kind.name, slot, foc))
        if plan is None:
            plan = self.plans[kind.name, slot, foc] = build(self, kind, slot, foc)
        self._law, self._stage, self.gains = plan
        if axis is Axis.OPEN:
            self.output = float(args[1])
        elif axis in (Axis.VELOCITY, Axis.MOTION_MAGIC_VELOCITY):
            self.goal_v, self.goal_a = float(args[1]), float(args[2])
        elif axis is Axis.POSITION:
            self.goal_p, self.goal_v = float(args[1]), float(args[2])
        elif axis in PROFILED:
            self.goal_p = float(args[1])
        if axis in PROFILED:
            self.limits = limits_of(self, kind, args)
        bridge = self.bridge
        if self._law is not None:
            self.feed_forward = float(args[field["feed_forward"]]) if "feed_forward" in field else 0.0
            torque = kind.unit is Unit.AMPERES
            bridge.override = bool(
                args[field["override_coast_dur_neutral" if torque else "override_brake_dur_neutral"]]
            )
            bridge.deadband = float(args[field["deadband"]]) if "deadband" in field else 0.0
            bridge.max_duty = float(args[field["max_abs_duty_cycle"]]) if "max_abs_duty_cycle" in field else 1.0
            # the last six fields of every request that drives
            self._limit_flags = tuple(bool(flag) for flag in args[-5:-1])
        if changed:
            bridge.carry(kind.unit)
            self._begin()

    def _begin(self) -> None:
        """Start a request anew, with neither integral nor profile of the one before."""
        self.integral = self.pid_out = 0.0
        self._unseen = 0
        self.profile_loops = PROFILE_LOOPS // 2
        if self._remote is not None:
            self._seen_ns = self._remote.frame_ns
        self.measure()
        self.scurve.start(self.pos, self.vel)
        self.expo.start(self.pos, self.vel)
        self.velocity_ramp.start(0.0, self.vel)
        self.velocity_ramp.v = self.vel

    # ---- control loop

    def measure(self) -> None:
        """Read the sensors."""
        self.pos, self.vel, self.acc = self._read()

    def run(self, loops: int, enabled: bool) -> None:
        """Advance by this many control loops."""
        pending = self._pending
        if pending is not None:
            before = (pending[0] - self.world.loop_ns + LOOP_NS - 1) // LOOP_NS
            if before < loops:
                self._pending = None
                if before > 0:
                    self._loop(before, enabled)
                    loops -= before
                self._accept(pending[1], pending[2])
        self._loop(loops, enabled)

    def _loop(self, loops: int, enabled: bool) -> None:
        remote = self._remote
        is_stale = remote is not None and remote.frame_ns == self._seen_ns
        if not is_stale:
            self.pos, self.vel, self.acc = self._read()
        bridge = self.bridge
        rps, late = self.rotor_rps, self.late_rps
        if late != rps:
            self.late_rps = late = late + LIMITER_GAIN[loops if loops < 64 else 64] * (rps - late)
        turn = self.turn
        bridge.rps = rps * turn
        bridge.late_rps = late * turn
        if self._expires is not None and self.world.loop_ns >= self._expires:
            self._accept(_IDLE, (0.0,))
        if self._autosets:
            for limit in (self.forward, self.reverse):
                value = limit.autoset(self.world)
                if value is not None:
                    self.set_position(value)
        law = self._law
        if not enabled:
            if self.enabled:
                self.enabled = False
                bridge.rest()
                self._begin()
            coasts = self.kind.axis is Axis.COAST or (self.kind.unit is Unit.AMPERES and bridge.override)
            bridge.neutral(bridge.brake and not coasts)
            return
        if not self.enabled:
            self.enabled = True
            self._begin()
        if law is None:
            if self.kind.axis is Axis.FOLLOW:
                follow(self, loops)
                return
            bridge.rest()
            axis = self.kind.axis
            bridge.neutral(axis is Axis.BRAKE or (bridge.brake and axis is not Axis.COAST))
            return
        self._check_limits()
        if self.kind.axis is Axis.OPEN:
            self.pid_out = law(loops)
        elif self.feedback.is_missing:
            self.pid_out = 0.0
        elif is_stale:
            self._unseen += loops
        else:
            if remote is not None:
                self._seen_ns = remote.frame_ns
            self.pid_out = law(loops + self._unseen)
            self._unseen = 0
        assert self._stage is not None
        self._stage(self.pid_out, loops)

    def _check_limits(self) -> None:
        forward, reverse, bridge = self.forward, self.reverse, self.bridge
        no_forward, no_reverse, ignore_hard, ignore_soft = self._limit_flags
        if forward.is_plain and reverse.is_plain and not forward.closed and not reverse.closed:
            bridge.blocked_forward = no_forward
            bridge.blocked_reverse = no_reverse
            return
        soft_f, hard_f = forward.stops(self.world, self.pos, ignore_soft, ignore_hard)
        soft_r, hard_r = reverse.stops(self.world, self.pos, ignore_soft, ignore_hard)
        bridge.blocked_forward = no_forward or soft_f or hard_f
        bridge.blocked_reverse = no_reverse or soft_r or hard_r
        self.limits_hit = (soft_f, soft_r, hard_f, hard_r)

    # ---- status

    def sample(self) -> TalonFrame:
        """A frame of this moment."""
        self.measure()
        self.fault_flags.show(active_faults(self))
        return frame_of(self)

    def send_frame(self) -> None:
        """Make the present state the one that robot code sees; what nobody looks at is not made.

        The motors of a swerve drivetrain are read by nobody but the drivetrain itself: 0.2 ms of a tick.
        """
        if self.frame is None or self.is_watched:
            super().send_frame()
            return
        self.fault_flags.show(active_faults(self))
        self.frame_ns = self.clock.ns

    def watch(self) -> None:
        """Somebody looks: from here on every frame is made."""
        if not self.is_watched:
            self.is_watched = True
            self.frame = self.sample()

    def read(self, spn: int) -> tuple[float, float, int] | None:
        """Value of a signal, the time it is from [s] and whose units it has; None for a signal that is not modelled."""
        self.watch()
        return super().read(spn)

    def units_of(self, spn: int) -> int:
        """Number whose units a signal has in the last frame."""
        self.watch()
        return units_number(spn, self.frame)
