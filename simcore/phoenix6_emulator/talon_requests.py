"""Configuration and requests of an emulated motor controller: what is in force, and from when."""

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
from simcore.phoenix6_emulator.output_stage import Stage
from simcore.phoenix6_emulator.talon_feedback import feedback_of
from simcore.phoenix6_emulator.talon_follower import following, turning
from simcore.phoenix6_emulator.talon_state import IDLE, TalonState

__all__ = ["TalonRequests"]

_log = logging.getLogger(__name__)

_CONTROL_PHASE_NS = 4_000_000
"""When in their period control frames leave [ns]. Robot code at a multiple of the period waits this long; on the wall
clock the wait is anything between nothing and a period, 4.4 ms in the middle."""
_ONE_SHOT_NS = 100_000_000
"""How long a request that is sent once (`update_freq_hz=0`) is in force [ns]."""
_DEFAULTS = {"enable_foc": True, "max_abs_duty_cycle": 1.0, "update_freq_hz": 100.0}
"""Fields of requests whose default in the library is not 0."""


class TalonRequests(TalonState):
    """A motor controller as far as configuration and requests go; the control loop is in `EmulatedTalon`.

    Args:
        device_id: CAN id.
        clock: Simulated time.
        defaults: Factory configuration.
        devices: All devices by type and id.
    """

    __slots__ = (
        *("_autosets", "_expires", "_follow", "_has_warned", "_holds", "_is_blind", "_law", "_limit_flags"),
        *("_limits_are_plain", "_measure", "_no_forward", "_no_reverse", "_pending", "_plans", "_remote", "_seen_ns"),
        *("_senses", "_stage", "_unseen", "feedback"),
    )

    def __init__(
        self, device_id: int, clock: SimulatedClock, defaults: Mapping[int, Setting], devices: Devices
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
        self._holds = False
        """Whether the output follows from request, rotor and supply alone."""
        self._limit_flags: tuple[bool, ...] = (False, False, False, False)
        self._no_forward = self._no_reverse = False
        self._has_warned = False

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
        """Read feed-forward, neutral, deadband and limits of a request that drives."""
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

    def measure(self) -> None:
        """Read the sensors."""
        self._measure()

    def _stir(self) -> None:
        """Have the next loop of this motor and of its followers computed even if their rotors rest."""
        self.settled_rps = math.nan
        for follower in self.followers:
            follower.settled_rps = math.nan
