"""An emulated TalonFX or TalonFXS: its control loop and its status."""

from __future__ import annotations

import math
from collections.abc import Mapping

from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6_emulator.config_text import Setting
from simcore.phoenix6_emulator.control_requests import Axis, Unit
from simcore.phoenix6_emulator.device_clock import LOOP_NS, SimulatedClock
from simcore.phoenix6_emulator.emulated_device import Devices
from simcore.phoenix6_emulator.motor_constants import ARRANGEMENTS, KRAKEN_X60
from simcore.phoenix6_emulator.output_stage import LIMITER_GAIN
from simcore.phoenix6_emulator.talon_frame import SIGNALS, TalonFrame, active_faults, frame_of, units_number
from simcore.phoenix6_emulator.talon_requests import TalonRequests
from simcore.phoenix6_emulator.talon_state import IDLE

__all__ = ["EmulatedTalon", "EmulatedTalonFXS"]


class EmulatedTalon(TalonRequests):
    """One TalonFX.

    Args:
        device_id: CAN id.
        clock: Simulated time.
        defaults: Factory configuration.
        devices: All devices by type and id.
    """

    __slots__ = ("_rests", "_seen_raw")
    model = "talon fx"
    type_number = 4
    signals = SIGNALS

    def __init__(
        self, device_id: int, clock: SimulatedClock, defaults: Mapping[int, Setting], devices: Devices
    ) -> None:
        super().__init__(device_id, clock, defaults, devices)
        self._seen_raw = 0.0
        """Rotor position at the last loop."""
        self._rests = False
        """Whether the output does not depend on the position either: in neutral, or of a follower."""
        self.configured()
        self.send_frame()

    # ---- control loop

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
        """Send a status frame with the present faults."""
        self.fault_flags.show(active_faults(self, self.feedback.is_missing))
        super().send_frame()
        for follower in self.followers:
            follower.settled_rps = math.nan

    def units_of(self, spn: int) -> int:
        """Number of the signal whose units this one has in the last frame."""
        return units_number(spn, self.frame)


class EmulatedTalonFXS(EmulatedTalon):
    """One TalonFXS; without a motor arrangement its bridge stays off."""

    model = "talon fxs"
    type_number = 7

    def configured(self) -> None:
        """Apply the configuration, and with it the motor.

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
        """As a TalonFX, except the motor, which is configured."""
        if name == "MotorType":
            raise NotImplementedError(f"{self!r}: sim_state input {name!r} is not modelled in simulated time")
        super().set_input(name, value)

    def _loop(self, loops: int, enabled: bool) -> None:
        super()._loop(loops, enabled and self._has_motor)
