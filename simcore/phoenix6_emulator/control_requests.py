"""The control requests of Phoenix 6 as native functions receive them: a name and plain numbers in a fixed order."""

from __future__ import annotations

import enum
import re
from dataclasses import dataclass
from functools import cached_property

__all__ = ["REQUESTS", "Axis", "RequestKind", "Unit"]


class Unit(enum.Enum):
    """What the number that a control law ends with means."""

    VOLTS = "V"
    DUTY = "DC"
    AMPERES = "A"

    __hash__ = object.__hash__  # members are one of a kind; hashing their names took 0.06 ms of a tick


class Axis(enum.Enum):
    """What a control law works on."""

    OPEN = "open loop"
    VELOCITY = "velocity"
    POSITION = "position"
    MOTION_MAGIC = "Motion Magic"
    MOTION_MAGIC_VELOCITY = "Motion Magic Velocity"
    MOTION_MAGIC_EXPO = "Motion Magic Expo"
    NEUTRAL = "neutral"
    BRAKE = "brake"
    COAST = "coast"
    FOLLOW = "follow"
    MUSIC = "music"

    __hash__ = object.__hash__


_MODES = {
    Axis.NEUTRAL: "NEUTRAL_OUT",
    Axis.BRAKE: "STATIC_BRAKE",
    Axis.COAST: "COAST_OUT",
    Axis.FOLLOW: "FOLLOWER",
    Axis.MUSIC: "MUSIC_TONE",
}
_VOLT_TAIL = (
    "override_brake_dur_neutral",
    "limit_forward_motion",
    "limit_reverse_motion",
    "ignore_hardware_limits",
    "ignore_software_limits",
    "use_timesync",
)
_AMPERE_TAIL = ("override_coast_dur_neutral", *_VOLT_TAIL[1:])


@dataclass(frozen=True, eq=False)
class RequestKind:
    """One kind of request."""

    name: str
    """As Phoenix 6 calls the class, `VoltageOut`."""
    axis: Axis
    """What it controls."""
    unit: Unit
    """What it drives with."""
    fields: tuple[str, ...]
    """The arguments of the native function after network and device, by their Python names."""

    def mode(self, foc: bool) -> str:
        """Name of the `ControlModeValue` that a device reports while it does this."""
        if self.axis in _MODES:
            return _MODES[self.axis]
        words = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", self.name.removeprefix("Dynamic")).upper()
        if self.unit is Unit.AMPERES or not foc:
            return words
        return words.removesuffix("_OUT") + "_FOC"

    @cached_property
    def slots(self) -> dict[str, int]:
        """Place of each field."""
        return {name: k for k, name in enumerate(self.fields)}


def _kinds() -> list[RequestKind]:
    kinds = [
        RequestKind("NeutralOut", Axis.NEUTRAL, Unit.VOLTS, ("update_freq_hz", "use_timesync")),
        RequestKind("StaticBrake", Axis.BRAKE, Unit.VOLTS, ("update_freq_hz", "use_timesync")),
        RequestKind("CoastOut", Axis.COAST, Unit.VOLTS, ("update_freq_hz", "use_timesync")),
        RequestKind("MusicTone", Axis.MUSIC, Unit.VOLTS, ("update_freq_hz", "audio_frequency")),
        RequestKind("Empty", Axis.NEUTRAL, Unit.VOLTS, ("update_freq_hz",)),
        RequestKind("Follower", Axis.FOLLOW, Unit.VOLTS, ("update_freq_hz", "leader_id", "motor_alignment")),
        RequestKind("StrictFollower", Axis.FOLLOW, Unit.VOLTS, ("update_freq_hz", "leader_id")),
    ]
    closed: list[tuple[str, Axis, tuple[str, ...]]] = [
        ("Position", Axis.POSITION, ("position", "velocity")),
        ("Velocity", Axis.VELOCITY, ("velocity", "acceleration")),
        ("MotionMagic", Axis.MOTION_MAGIC, ("position",)),
        ("MotionMagicVelocity", Axis.MOTION_MAGIC_VELOCITY, ("velocity", "acceleration")),
        ("MotionMagicExpo", Axis.MOTION_MAGIC_EXPO, ("position",)),
        ("DynamicMotionMagic", Axis.MOTION_MAGIC, ("position", "velocity", "acceleration", "jerk")),
        ("DynamicMotionMagicExpo", Axis.MOTION_MAGIC_EXPO, ("position", "k_v", "k_a", "velocity")),
    ]
    for suffix, unit in (("DutyCycle", Unit.DUTY), ("Voltage", Unit.VOLTS), ("TorqueCurrentFOC", Unit.AMPERES)):
        for prefix, axis, goals in closed:
            foc = () if unit is Unit.AMPERES else ("enable_foc",)
            tail = _AMPERE_TAIL if unit is Unit.AMPERES else _VOLT_TAIL
            fields = ("update_freq_hz", *goals, *foc, "feed_forward", "slot", *tail)
            kinds.append(RequestKind(prefix + suffix, axis, unit, fields))
    open_loop = ("update_freq_hz", "output")
    kinds.append(RequestKind("DutyCycleOut", Axis.OPEN, Unit.DUTY, (*open_loop, "enable_foc", *_VOLT_TAIL)))
    kinds.append(RequestKind("VoltageOut", Axis.OPEN, Unit.VOLTS, (*open_loop, "enable_foc", *_VOLT_TAIL)))
    torque = (*open_loop, "max_abs_duty_cycle", "deadband", *_AMPERE_TAIL)
    kinds.append(RequestKind("TorqueCurrentFOC", Axis.OPEN, Unit.AMPERES, torque))
    return kinds


REQUESTS: dict[str, RequestKind] = {kind.name: kind for kind in _kinds()}
"""Every request that is modelled, by name."""
