"""An emulated TalonFX or TalonFXS: configuration, requests, control loop, status."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping
from typing import Any

from phoenix6.spns.spn_value import SpnValue

from simcore.errors import NonFiniteError
from simcore.phoenix6_emulator.config_text import Setting
from simcore.phoenix6_emulator.control_laws import PROFILE_LOOPS, Law
from simcore.phoenix6_emulator.control_plan import ControlPlan, build_plan, limits_of
from simcore.phoenix6_emulator.control_requests import REQUESTS, Axis, RequestKind, Unit
from simcore.phoenix6_emulator.device_clock import LOOP_NS, SimulatedClock
from simcore.phoenix6_emulator.emulated_device import Devices, period_of
from simcore.phoenix6_emulator.motor_constants import ARRANGEMENTS, KRAKEN_X60
from simcore.phoenix6_emulator.output_stage import LIMITER_GAIN, Stage
from simcore.phoenix6_emulator.talon_feedback import feedback_of
from simcore.phoenix6_emulator.talon_follower import following, turning
from simcore.phoenix6_emulator.talon_frame import SIGNALS, TalonFrame, active_faults, frame_of, units_number
from simcore.phoenix6_emulator.talon_state import IDLE, TalonState

__all__ = ["EmulatedTalon", "EmulatedTalonFXS"]

_log = logging.getLogger(__name__)

_CONTROL_PHASE_NS = 4_000_000
"""When in their period control frames leave [ns]. Robot code at a multiple of the period waits this long; on the wall
clock the wait is anything between nothing and a period, 4.4 ms in the middle."""
_ONE_SHOT_NS = 100_000_000
"""How long a request that is sent once (`update_freq_hz=0`) is in force [ns]."""
_DEFAULTS = {"enable_foc": True, "max_abs_duty_cycle": 1.0, "update_freq_hz": 100.0}
"""Fields of requests whose default in the library is not 0."""


class EmulatedTalon(TalonState):
    """One TalonFX.

    Args:
        device_id: CAN id.
        clock: Simulated time.
        defaults: Factory configuration.
        devices: All devices by type and id.
    """

    __slots__ = (
        *("_autosets", "_expires", "_follow", "_holds", "_is_blind", "_law", "_limit_flags", "_limits_are_plain"),
        *("_measure", "_no_forward", "_no_reverse", "_pending", "_plans", "_remote", "_rests", "_seen_ns", "_seen_raw"),
        *("_senses", "_stage", "_unseen", "_has_warned", "feedback"),
    )
    model = "talon fx"
    type_number = 4
    signals = SIGNALS

    def __init__(
        self,
        device_id: int,
        clock: SimulatedClock,
        defaults: Mapping[int, Setting],
        devices: Devices,
    ) -> None:
        super().__init__(device_id, clock, defaults, devices)
        self._pending: tuple[int, RequestKind, tuple[Any, ...]] | None = None
        """The request of the next control frame, and when that frame arrives [ns]."""
        self._expires: int | None = None
        """When the request ends that was sent once [ns]."""
        self._plans: dict[tuple[str, int, bool], ControlPlan] = {}
        self._law: Law | None = None
        self._stage: Stage | None = None
        self._follow: Callable[[int], None] | None = None
        self._seen_ns = -1
        """Time of the remote sensor's frame that the law has used last [ns]."""
        self._unseen = 0
        """Control loops since then."""
        self._seen_raw = 0.0
        """Rotor position at the last loop."""
        self._rests = False
        """Whether the output does not depend on the position either: in neutral, or of a follower."""
        self._holds = False
        """Whether the output follows from request, rotor and supply alone."""
        self._limit_flags: tuple[bool, ...] = (False, False, False, False)
        self._no_forward = self._no_reverse = False
        self._has_warned = False
        self.configured()
        self.send_frame()

    # ---- configuration

    def configured(self) -> None:
        """Apply the configuration."""
        self.sign = self.turn = -1.0 if self.config[SpnValue.CONFIG_INVERTED.value] else 1.0
        self.rotor_offset = self.config.get(SpnValue.CONFIG_FEEDBACK_ROTOR_OFFSET.value, 0.0)
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
        self._limits_are_plain = self.forward.is_plain and self.reverse.is_plain
        self._plans.clear()
        self.resolve()
        self._accept(self.kind, self.args)

    def resolve(self) -> None:
        """Find the configured sensor and the leader, which robot code may build after this controller."""
        self._stir()
        self.feedback = feedback_of(self, self.config)
        self._measure = self.feedback.measure
        self._is_blind = self.feedback.is_missing and self.kind.axis is not Axis.OPEN
        self._follow = following(self)
        self._remote = self.feedback.remote

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
            if not self._has_warned:
                _log.warning("%r: set_position() does nothing with a remote sensor, as in CTRE's simulation", self)
            self._has_warned = True
            return
        ratio = self.config[SpnValue.CONFIG_SENSOR_TO_MECHANISM_RATIO.value] or 1.0
        self._stir()
        self.shift += self.turn * (position * ratio - self.rotor_position)
        self.measure()

    def set_input(self, name: str, value: float) -> None:
        """Rotor, supply, limit switches, kind of motor."""
        self._stir()
        super().set_input(name, value)

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
        phase = min(_CONTROL_PHASE_NS, period - LOOP_NS)
        self._pending = ((now - phase + period - 1) // period * period + phase, kind, args)

    def apply(self, kind: str, **values: float) -> None:
        """Carry out a request at once, without the latency of a control frame.

        Args:
            kind: Name of the request, "VelocityVoltage".
            **values: Its fields; those that are not named have the library's defaults.
        """
        request = REQUESTS[kind]
        self._pending = None
        self._accept(request, tuple(values.get(f, _DEFAULTS.get(f, 0.0)) for f in request.fields))

    def renew(self, kind: RequestKind, foc: bool) -> bool:
        """Whether this kind of request, sent once, is in force; then it lasts anew, and its set points may change.

        Args:
            kind: Kind of request.
            foc: Field-oriented commutation.
        """
        if self.kind is not kind or self._pending is not None or self._expires is None:
            return False
        place = kind.slots.get("enable_foc")
        if place is not None and bool(self.args[place]) != foc:
            return False
        self._expires = self.clock.ns + _ONE_SHOT_NS
        return True

    def _accept(self, kind: RequestKind, args: tuple[Any, ...]) -> None:
        """Carry out a request from now on."""
        changed = kind is not self.kind
        self.kind, self.args = kind, args
        self.turn = turning(self)
        field = kind.slots
        axis = kind.axis
        self._expires = self.clock.ns + _ONE_SHOT_NS if args[0] == 0.0 and kind is not IDLE else None
        self.slot = slot = int(args[field["slot"]]) if "slot" in field else 0
        foc = bool(args[field["enable_foc"]]) if "enable_foc" in field else True
        plan = self._plans.get((kind.name, slot, foc))
        if plan is None:
            plan = self._plans[kind.name, slot, foc] = build_plan(self, kind, slot, foc)
        self.plan = plan
        self._law, self._stage = plan.law, plan.stage
        self._follow = following(self)
        self._stir()
        self._holds = (
            (axis is Axis.OPEN or axis is Axis.POSITION or axis is Axis.VELOCITY or axis is Axis.FOLLOW)
            and (self.feedback.is_rotor or not plan.reads_sensor)
            and self._limits_are_plain
            and not plan.has_memory
            and self._expires is None
            and not self._autosets
        )
        self._senses = axis is not Axis.OPEN or not self._limits_are_plain
        self._is_blind = self.feedback.is_missing and axis is not Axis.OPEN
        self._take_goals(plan)
        if plan.law is not None:
            self._take_options()
        if changed:
            self.bridge.carry(kind.unit)
            self._begin()

    def _take_goals(self, plan: ControlPlan) -> None:
        """Read the set points of the request."""
        axis, args = self.kind.axis, self.args
        if axis is Axis.OPEN:
            self.output = float(args[1])
        elif axis in (Axis.VELOCITY, Axis.MOTION_MAGIC_VELOCITY):
            self.goal_v, self.goal_a = float(args[1]), float(args[2])
        elif axis is Axis.POSITION:
            self.goal_p, self.goal_v = float(args[1]), float(args[2])
        elif plan.profile is not None:
            self.goal_p = float(args[1])
        if plan.profile is not None:
            self.limits = limits_of(self.config, self.kind, args)

    def _take_options(self) -> None:
        """Read what a request that drives says of feed-forward, neutral, deadband and limits."""
        bridge, args, field = self.bridge, self.args, self.kind.slots
        self.feed_forward = float(args[field["feed_forward"]]) if "feed_forward" in field else 0.0
        torque = self.kind.unit is Unit.AMPERES
        bridge.override = bool(args[field["override_coast_dur_neutral" if torque else "override_brake_dur_neutral"]])
        bridge.deadband = float(args[field["deadband"]]) if "deadband" in field else 0.0
        bridge.max_duty = float(args[field["max_abs_duty_cycle"]]) if "max_abs_duty_cycle" in field else 1.0
        # the last six fields of every request that drives
        self._limit_flags = tuple(bool(flag) for flag in args[-5:-1])
        self._no_forward, self._no_reverse = self._limit_flags[:2]

    def _begin(self) -> None:
        """Reset integral and profiles: a new request starts from the present state."""
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
        self._measure()

    def run(self, loops: int, enabled: bool) -> None:
        """Advance by this many control loops."""
        pending = self._pending
        if pending is None:
            # Odometry cuts a step in two, and motors rest: half of all loops would change nothing. 0.06 ms a tick.
            if (
                self.rotor_rps == self.settled_rps
                and (self._rests or self.raw == self._seen_raw)
                and enabled is self.enabled
            ):
                return
        else:
            before = (pending[0] - self.clock.loop_ns + LOOP_NS - 1) // LOOP_NS
            if before < loops:
                self._pending = None
                if before > 0:
                    self._loop(before, enabled)
                    loops -= before
                self._accept(pending[1], pending[2])
        self._loop(loops, enabled)

    def _loop(self, loops: int, enabled: bool) -> None:
        bridge = self.bridge
        rps, late = self.rotor_rps, self.late_rps
        if late != rps:
            late += LIMITER_GAIN[loops if loops < 64 else 64] * (rps - late)
            self.late_rps = late = late if abs(rps - late) > 1e-3 else rps
        turn = self.turn
        bridge.rps = rps * turn
        bridge.late_rps = late * turn
        if self._expires is not None and self.clock.loop_ns >= self._expires:
            self._accept(IDLE, (0.0,))
        if self._autosets:
            for limit in (self.forward, self.reverse):
                value = limit.autoset(self.devices)
                if value is not None:
                    self.set_position(value)
        if enabled is not self.enabled:
            self.enabled = enabled
            self.settled_rps = math.nan
            if not enabled:
                bridge.rest()
            self._begin()
        law, stage = self._law, self._stage
        if law is None or stage is None or not enabled:
            self._neutral_or_follow(loops)
            return
        remote = self._remote
        is_stale = remote is not None and remote.frame_ns == self._seen_ns
        if self._senses and not is_stale:
            self._measure()
        if self._limits_are_plain and not self.forward.closed and not self.reverse.closed:
            bridge.blocked_forward = self._no_forward
            bridge.blocked_reverse = self._no_reverse
        else:
            self._check_limits()
        if self._is_blind:
            self.pid_out = 0.0
        elif self.kind.axis is Axis.OPEN:
            self.pid_out = law(loops)
        elif is_stale:
            self._unseen += loops
        else:
            if remote is not None:
                self._seen_ns = remote.frame_ns
            self.pid_out = law(loops + self._unseen)
            self._unseen = 0
        stage(self.pid_out, loops)
        self.settled_rps = late if self._holds and not bridge.is_supply_limited and late == rps else math.nan
        self._seen_raw = self.raw
        self._rests = False

    def _stir(self) -> None:
        """Have the next loop of this motor and of its followers computed even if their rotors rest."""
        self.settled_rps = math.nan
        for follower in self.followers:
            follower.settled_rps = math.nan

    def _neutral_or_follow(self, loops: int) -> None:
        """Neutral, or the output of the leader."""
        bridge, axis = self.bridge, self.kind.axis
        if not self.enabled:
            coasts = axis is Axis.COAST or (self.kind.unit is Unit.AMPERES and bridge.override)
            bridge.neutral(bridge.brake and not coasts)
        elif self._follow is not None:
            self._follow(loops)
            is_settled = self._holds and not bridge.is_supply_limited and self.late_rps == self.rotor_rps
            self.settled_rps = self.rotor_rps if is_settled else math.nan
            self._rests = True
            return
        else:
            bridge.rest()
            bridge.neutral(axis is Axis.BRAKE or (bridge.brake and axis is not Axis.COAST))
        is_settled = self._expires is None and not self._autosets and self.late_rps == self.rotor_rps
        self.settled_rps = self.rotor_rps if is_settled else math.nan
        self._rests = is_settled

    def _check_limits(self) -> None:
        forward, reverse, bridge = self.forward, self.reverse, self.bridge
        no_forward, no_reverse, ignore_hard, ignore_soft = self._limit_flags
        soft_f, hard_f = forward.stops(self.devices, self.pos, ignore_soft, ignore_hard)
        soft_r, hard_r = reverse.stops(self.devices, self.pos, ignore_soft, ignore_hard)
        bridge.blocked_forward = no_forward or soft_f or hard_f
        bridge.blocked_reverse = no_reverse or soft_r or hard_r
        self.limits_hit = (soft_f, soft_r, hard_f, hard_r)

    # ---- status

    def sample(self) -> TalonFrame:
        """A frame of this moment."""
        self._measure()
        return frame_of(self)

    def send_frame(self) -> None:
        """Make the present state, and its faults, what robot code sees."""
        self.fault_flags.show(active_faults(self, self.feedback.is_missing))
        super().send_frame()
        for follower in self.followers:
            follower.settled_rps = math.nan

    def units_of(self, spn: int) -> int:
        """Number whose units a signal has in the last frame."""
        return units_number(spn, self.frame)


class EmulatedTalonFXS(EmulatedTalon):
    """One TalonFXS; without a motor arrangement its bridge stays off."""

    model = "talon fxs"
    type_number = 7

    def configured(self) -> None:
        """Take over a configuration, and with it the motor.

        Raises:
            NotImplementedError: The arrangement is not modelled (a custom brushless motor).
        """
        arrangement = int(self.config[SpnValue.CONFIG_MOTOR_TYPE.value])
        if arrangement and arrangement not in ARRANGEMENTS:
            raise NotImplementedError(f"{self!r}: motor arrangement {arrangement} is not modelled in simulated time")
        self.bridge.motor = ARRANGEMENTS.get(arrangement, KRAKEN_X60)
        self._has_motor = arrangement != 0
        super().configured()

    def set_input(self, name: str, value: float) -> None:
        """As a TalonFX, which motor being a matter of its configuration."""
        if name == "MotorType":
            raise NotImplementedError(f"{self!r}: sim_state input {name!r} is not modelled in simulated time")
        super().set_input(name, value)

    def _loop(self, loops: int, enabled: bool) -> None:
        super()._loop(loops, enabled and self._has_motor)
