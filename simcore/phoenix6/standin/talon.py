"""A TalonFX with its motor: sensors, requests, control loop, output."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from phoenix6.signals import BridgeOutputValue, ControlModeValue
from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6.standin.bridge import OVER_VOLTAGE, Bridge
from simcore.phoenix6.standin.clock import LOOP_NS, SimulatedClock
from simcore.phoenix6.standin.device import Device, period_of
from simcore.phoenix6.standin.electrical import KRAKEN_X44, KRAKEN_X60
from simcore.phoenix6.standin.faults import FAULTS
from simcore.phoenix6.standin.feedback import feedback_of
from simcore.phoenix6.standin.limits import Limit
from simcore.phoenix6.standin.motion import PROFILED, VELOCITY, Plan, build, limits_of
from simcore.phoenix6.standin.profile import Expo, SCurve, VelocityRamp
from simcore.phoenix6.standin.requests import REQUESTS, Axis, RequestKind, Unit
from simcore.phoenix6.standin.talon_frame import SIGNALS, TalonFrame, units_number
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
_UNIT_NUMBER = {Unit.DUTY: 0, Unit.VOLTS: 1, Unit.AMPERES: 2}
_OFF, _BRAKING, _MOTORING, _DISCORDANT, _REGENERATING = 1, 2, 3, 4, 5  # MotorOutputStatusValue
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
        self._plans: dict[tuple[str, int, bool], Plan] = {}
        self._told = False
        self._limit_flags: tuple[bool, ...] = (False, False, False, False)
        self._limits_hit = (False, False, False, False)
        self._slot = 0
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
        self._plans.clear()
        self.resolve()
        self._accept(self.kind, self.args)

    def resolve(self) -> None:
        """Look for the configured sensor, which robot code may build later than the controller."""
        self.feedback = feedback_of(self, self.config)
        self._read = self.feedback.read

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
        """What `sim_state` reads: volts counter-clockwise, torque current with robot code's sign, as CTRE has it."""
        bridge = self.bridge
        if name == "MotorVoltage":
            return bridge.volts * self.turn
        if name == "TorqueCurrent":
            return bridge.current
        if name == "SupplyCurrent":
            return bridge.supply_current
        if name == "DutyCycle":
            return bridge.duty
        return None

    # ---- requests

    def receive(self, kind: RequestKind, args: tuple[Any, ...]) -> None:
        """A control request of robot code; it takes effect with the next control frame."""
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
        self.turn = self._turning()
        field = kind.slots
        axis = kind.axis
        self._expires = self.clock.ns + ONE_SHOT_NS if args[0] == 0.0 and kind is not _IDLE else None
        self._slot = slot = int(args[field["slot"]]) if "slot" in field else 0
        foc = bool(args[field["enable_foc"]]) if "enable_foc" in field else True
        plan = self._plans.get((kind.name, slot, foc))
        if plan is None:
            plan = self._plans[kind.name, slot, foc] = build(self, kind, slot, foc)
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
            self._begin()

    def _begin(self) -> None:
        """Start a request anew, with neither integral nor profile of the one before."""
        self.integral = 0.0
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
        self.pos, self.vel, self.acc = self._read()
        bridge = self.bridge
        bridge.rps = self.rotor_rps * self.turn
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
            bridge.neutral(bridge.brake and self.kind.axis is not Axis.COAST)
            return
        if not self.enabled:
            self.enabled = True
            self._begin()
        if law is None:
            if self.kind.axis is Axis.FOLLOW:
                self._follow(loops)
                return
            bridge.rest()
            axis = self.kind.axis
            bridge.neutral(axis is Axis.BRAKE or (bridge.brake and axis is not Axis.COAST))
            return
        self._check_limits()
        if self.feedback.is_missing and self.kind.axis is not Axis.OPEN:
            self.pid_out = 0.0
        else:
            self.pid_out = law(loops)
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
        self._limits_hit = (soft_f, soft_r, hard_f, hard_r)

    # ---- following

    def _leader(self) -> Talon | None:
        leader = self.world.devices.get((self.type_number, int(self.args[1])))
        return leader if isinstance(leader, Talon) and leader is not self else None

    def _turning(self) -> float:
        """Direction in which a positive output turns the motor: its own, or for a follower the leader's."""
        if self.kind.axis is not Axis.FOLLOW or self.kind.name == "StrictFollower":
            return self.sign
        leader = self._leader()
        if leader is None:
            return self.sign
        return leader.turn * (-1.0 if self.args[2] == 1 else 1.0)

    def _follow(self, loops: int) -> None:
        """Put out what the leader's last frame says, in the unit that the leader drives with."""
        bridge = self.bridge
        leader = self._leader()
        if leader is None:
            bridge.rest()
            bridge.neutral(bridge.brake)
            return
        self.turn = self._turning()
        bridge.rps = self.rotor_rps * self.turn
        frame: TalonFrame = leader.frame
        if frame.bridge in (BridgeOutputValue.BRIDGE_REQ_COAST.value, BridgeOutputValue.BRIDGE_REQ_BRAKE.value):
            bridge.neutral(frame.bridge == BridgeOutputValue.BRIDGE_REQ_BRAKE.value)
            return
        unit = leader.kind.unit
        key = (f"follow {unit.value}", 0, True)
        plan = self._plans.get(key)
        if plan is None:
            plan = self._plans[key] = (None, bridge.stage(unit, closed=True, foc=True), self.gains)
        bridge.override, bridge.deadband, bridge.max_duty = False, 0.0, 1.0
        bridge.blocked_forward = bridge.blocked_reverse = False
        assert plan[1] is not None
        plan[1]({Unit.DUTY: frame.duty, Unit.VOLTS: frame.volts, Unit.AMPERES: frame.current}[unit], loops)

    # ---- status

    def _bridge_output(self) -> BridgeOutputValue:
        bridge = self.bridge
        if bridge.is_neutral:
            return BridgeOutputValue.BRIDGE_REQ_BRAKE if bridge.current else BridgeOutputValue.BRIDGE_REQ_COAST
        if self.kind.unit is Unit.AMPERES:
            return BridgeOutputValue.BRIDGE_REQ_FOC_TORQUE
        foc = "enable_foc" not in self.kind.slots or self.args[self.kind.slots["enable_foc"]]
        return BridgeOutputValue.BRIDGE_REQ_FOC_EASY if foc else BridgeOutputValue.BRIDGE_REQ_TRAPEZ

    def _status(self) -> int:
        bridge = self.bridge
        if bridge.is_neutral:
            return _BRAKING if bridge.current else _OFF
        if bridge.supply_current < 0.0:
            return _REGENERATING
        return _DISCORDANT if bridge.current * bridge.rps < 0.0 else _MOTORING

    def _mode(self) -> int:
        if not self.enabled or self.kind is _IDLE:
            return ControlModeValue.DISABLED_OUTPUT.value
        field = self.kind.slots
        foc = bool(self.args[field["enable_foc"]]) if "enable_foc" in field else True
        return int(ControlModeValue[self.kind.mode(foc)].value)

    def active_faults(self) -> set[int]:
        """Numbers of the faults that are active now."""
        bridge = self.bridge
        found = set()
        if bridge.is_stator_limited:
            found.add(FAULTS["TALONFX_STATOR_CURR_LIMIT"])
        if bridge.is_supply_limited:
            found.add(FAULTS["TALONFX_SUPPLY_CURR_LIMIT"])
        if bridge.supply > OVER_VOLTAGE:
            found.add(FAULTS["TALONFX_OVER_SUPPLY_V"])
        if self.feedback.is_missing:
            found.add(FAULTS["TALONFX_MISSING_REMOTE_SENSOR"])
        if bridge.is_blocked:
            names = ("FORWARD_SOFT_LIMIT", "REVERSE_SOFT_LIMIT", "FORWARD_HARD_LIMIT", "REVERSE_HARD_LIMIT")
            found |= {FAULTS[f"TALONFX_{name}"] for name, hit in zip(names, self._limits_hit, strict=True) if hit}
        return found

    def sample(self) -> TalonFrame:
        """A frame of this moment."""
        self.measure()
        self.fault_flags.show(self.active_faults())
        b, g = self.bridge, self.gains
        axis = self.kind.axis
        profile = {Axis.MOTION_MAGIC: self.scurve, Axis.MOTION_MAGIC_EXPO: self.expo}.get(axis, self.velocity_ramp)
        profiled = axis in PROFILED and self.enabled
        on_velocity = axis in VELOCITY
        ff = self.feed_forward + g.kv * (self.ref if on_velocity else self.slope)
        return TalonFrame(
            position=self.pos,
            velocity=self.vel,
            acceleration=self.acc,
            rotor_position=self.rotor_position,
            rotor_velocity=self.rotor_rps * self.turn,
            volts=b.volts,
            current=b.current,
            supply_current=b.supply_current,
            supply=b.supply,
            duty=b.duty,
            ref=self.ref,
            slope=self.slope,
            err=self.err,
            p_out=g.kp * self.err,
            i_out=self.integral,
            d_out=g.kd * self.derr,
            ff_out=ff,
            pid_out=self.pid_out,
            slot=self._slot,
            mode=self._mode(),
            bridge=self._bridge_output().value,
            status=self._status(),
            enabled=self.enabled,
            forward_open=not self.forward.is_closed(self.world),
            reverse_open=not self.reverse.is_closed(self.world),
            polarity=int(self.turn < 0.0),
            profiled=profiled,
            at_target=profiled and profile.done,
            on_velocity=on_velocity,
            unit=_UNIT_NUMBER[self.kind.unit],
            kt=b.motor.kt,
            kv=b.motor.kv,
            stall=b.motor.reported_stall,
            connected=b.motor.connected,
        )

    def units_of(self, spn: int) -> int:
        """Number whose units a signal has in the last frame."""
        return units_number(spn, self.frame)
