"""Drivetrain that was found: its wheels with their devices, each measure with where it comes from, and all in words."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from simcore.errors import ConfigError
from simcore.quantities import DeviceKey
from simcore.robotcode.program.motor_controllers import BuiltDevice

__all__ = [
    "DrivetrainNotFoundError", "FoundDrivetrain", "FoundWheel", "Measure", "drivetrain_lines", "drivetrain_rows",
    "guesses",
]  # fmt: skip


class DrivetrainNotFoundError(ConfigError):
    """The program has no drivetrain that simcore can find, and its file describes none."""


@dataclass(frozen=True, slots=True)
class Measure:
    """A value and where it comes from."""

    value: Any
    source: str
    is_guess: bool = False

    def __str__(self) -> str:
        text = f"{self.value:.4g}" if isinstance(self.value, float) else str(self.value)
        return f"{text} ({self.source})"


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundWheel:
    """One swerve module, one side of a tank, or one mecanum wheel."""

    name: str
    """For messages."""
    place: tuple[float, float]
    """From the robot's center, forward and left [m]; of a side of a tank its middle."""
    motors: tuple[BuiltDevice, ...]
    """That turn the wheel; the first one leads."""
    steer: BuiltDevice | None = None
    """That turns the azimuth."""
    encoder: BuiltDevice | None = None
    """On the azimuth; the steer motor itself where it is wired to that."""
    wheel_encoder: BuiltDevice | None = None
    """On the wheel, where the motor has no encoder."""
    drive_sign: float = 1.0
    """-1 where positive in robot code drives backward."""
    steer_sign: float = 1.0
    """-1 where positive in robot code turns the azimuth clockwise, seen from above."""
    is_steer_sign_known: bool = True
    """Whether something says so; else the program's own loop tells it, as the robot is driven first."""
    encoder_sign: float = 1.0
    """The same of the encoder on the azimuth."""
    encoder_turns: float = 1.0
    """Of that encoder per turn of the azimuth, which of one that counts pulses the program alone knows [-]."""
    zero: float = 0.0
    """Angle at which robot code takes the azimuth to be while its encoder reads zero [rad]."""
    meters_per_encoder_turn: float | None = None
    """What robot code takes for the way of one turn of `wheel_encoder` [m]."""

    @property
    def is_wired(self) -> bool:
        """Whether the azimuth's encoder is wired to the steer motor's controller."""
        return self.encoder is not None and self.steer is not None and self.encoder.key == self.steer.key

    @property
    def devices(self) -> list[BuiltDevice]:
        """All of them, each once."""
        more = (self.steer, self.encoder, self.wheel_encoder)
        return list({d.key: d for d in (*self.motors, *(d for d in more if d is not None))}.values())


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundDrivetrain:
    """A drivetrain of any kind and maker."""

    kind: str
    """`swerve`, `tank` or `mecanum`."""
    wheels: tuple[FoundWheel, ...]
    """In the order of the program's kinematics; of a tank left and right; of a mecanum drive front left, front right,
    rear left, rear right."""
    gyro: BuiltDevice | None = None
    measures: Mapping[str, Measure] = field(default_factory=dict)
    """`drive_motor`, `drive_gearing`, `wheel_radius` [m], `steer_motor` ... and where each is from."""
    free_speed_volts: tuple[Measure, ...] = ()
    """What feed-forwards of velocity give at the free speed of their motors [V]."""
    differences: tuple[str, ...] = ()
    """Where the program, its settings and its file contradict one another; a sentence each."""
    about: str = ""
    """How it was found."""
    kinematics: str = ""
    """Of which class of the program places are; empty: the program does not say them."""
    drives_itself: bool = False
    """Whether a library's own object drives it, which is found again without a table."""

    @property
    def keys(self) -> tuple[DeviceKey, ...]:
        """Of all its devices."""
        found = [d.key for wheel in self.wheels for d in wheel.devices]
        found += [] if self.gyro is None else [self.gyro.key]
        return tuple(dict.fromkeys(found))

    @property
    def hardware(self) -> list[Any]:
        """The program's own objects of these devices."""
        gyro = [] if self.gyro is None else [self.gyro]
        return [d.hardware for d in (*(d for wheel in self.wheels for d in wheel.devices), *gyro)]

    @property
    def places(self) -> tuple[tuple[float, float], ...]:
        """Of its wheels [m]."""
        return tuple(wheel.place for wheel in self.wheels)

    def measure(self, name: str) -> Any:
        """Return a value that must be there."""
        return self.measures[name].value


# --- in words -----------------------------------------------------------------------------------------------------

Row = tuple[str, Any, str]

_MEASURES = (
    *("drive_motor", "drive_gearing", "wheel_radius", "steer_motor", "steer_gearing", "trackwidth", "reversed"),
)
_LOOPS = ("drive_loop", "steer_loop")


def drivetrain_rows(found: FoundDrivetrain) -> list[Row]:
    """List keys of `[drivetrain]`, their values, and what is to be said of each, as `simcore init` writes them.

    Args:
        found: With complete measures.
    """
    wheels, first = found.wheels, found.wheels[0]
    leaders = [wheel.motors[0] for wheel in wheels]
    head: Row = ("kind", found.kind, found.about)
    measures = [_measure(name, found.measures[name]) for name in _MEASURES if name in found.measures]
    if len({d.model for d in leaders}) > 1:  # the table has one; what is found has no need of it
        return [head, *(_places(found) if "x and y" in found.measures else ()), *measures]
    model = leaders[0].model
    rows: list[Row] = [head, ("controller", model, "")]
    if found.kind == "tank":  # the program says itself who follows, of whatever model
        rows += [(w.name, _numbers(d for d in w.motors if d.model == model), "the leader first") for w in wheels]
    else:
        rows.append(("drive", _numbers(leaders), _names(wheels)))
    if first.steer is not None:
        if first.steer.model != model:
            rows.append(("steer_controller", first.steer.model, ""))
        rows += [("steer", _numbers(w.steer for w in wheels), ""), *_encoders(wheels)]
    if found.kind != "tank":
        rows += _places(found)
    rows += _signs(found)
    if first.wheel_encoder is not None and first.wheel_encoder.model == "Encoder":
        rows.append(("wheel_encoders", _numbers(w.wheel_encoder for w in wheels), "DIO"))
        if all(w.meters_per_encoder_turn for w in wheels):
            ways = [_rounded(w.meters_per_encoder_turn) for w in wheels]
            rows.append(("wheel_distances", ways, "m that 2048 pulses are to the code"))
    if found.gyro is not None:
        rows += [("gyro", str(found.gyro), ""), ("gyro_upside_down", False, "guess: it is mounted upright")]
    return rows + measures


def drivetrain_lines(found: FoundDrivetrain) -> list[str]:
    """List lines for a person: what it is, what is guessed, and what contradicts what."""
    loops = {str(found.measures[name].value) for name in _LOOPS if name in found.measures}
    closed = f", loops on the {' and on the '.join(sorted(loops))}" if loops else ""
    lines = [f"{found.kind} drive: {found.about}, {found.gyro or 'no gyro'}{closed}"]
    lines += [f"guess: {guess}" for guess in guesses(found)]
    return lines + [f"differs: {sentence}" for sentence in found.differences]


def guesses(found: FoundDrivetrain) -> list[str]:
    """List measures that are guesses, by the keys of `[drivetrain]`."""
    measures = {name: measure for name, measure in found.measures.items() if measure.is_guess}
    if (radius := measures.pop("wheel_radius", None)) is not None:
        measures["wheel_diameter"] = replace(radius, value=2.0 * radius.value)
    return [f"{name} {measure}" for name, measure in measures.items()]


def _numbers(devices: Iterable[BuiltDevice | None]) -> list[Any]:
    """List addresses as the file writes them."""
    return [d.address.in_file for d in devices if d is not None]


def _names(wheels: tuple[FoundWheel, ...]) -> str:
    """Join last attributes that tell the wheels apart."""
    names = [w.name.split(".")[-1] for w in wheels]
    return ", ".join(names) if len("".join(names)) < 60 and not names[0].isdigit() else ""


def _encoders(wheels: tuple[FoundWheel, ...]) -> list[Row]:
    encoder = wheels[0].encoder
    if encoder is None:
        return [("encoder", "none", "")]
    if wheels[0].is_wired:
        return [("encoder", "wired", "absolute encoders at the steer motors' controllers")]
    return [("encoder", encoder.model, ""), ("encoders", _numbers(w.encoder for w in wheels), "")]


def _places(found: FoundDrivetrain) -> list[Row]:
    told = found.measures.get("x and y")
    remark = "forward of the center" if told is None else f"guess: {told.source}" if told.is_guess else told.source
    xs, ys = ([_rounded(w.place[axis]) for w in found.wheels] for axis in (0, 1))
    return [("x", xs, remark), ("y", ys, "")]


def _signs(found: FoundDrivetrain) -> list[Row]:
    rows: list[Row] = []
    wheels, guess = found.wheels, found.measures.get("zeros_deg")
    if guess is not None or any(w.zero for w in wheels):
        zeros = [round(math.degrees(w.zero), 4) for w in wheels]
        remark = (
            "what your code reads as angle while the encoder reads 0" if guess is None else f"guess: {guess.source}"
        )
        rows.append(("zeros_deg", zeros, remark))
    for key, signs in (
        ("reversed_drive", [w.drive_sign for w in wheels]),
        ("reversed_steer", [w.steer_sign for w in wheels]),
        ("reversed_encoders", [w.encoder_sign for w in wheels]),
    ):
        if turned := [k for k, sign in enumerate(signs) if sign < 0.0]:
            rows.append((key, turned, "by their place in the lists above, from 0"))
    return rows


def _measure(name: str, measure: Measure) -> Row:
    remark = f"{'guess: ' if measure.is_guess else ''}{measure.source}"
    if name == "wheel_radius":
        return "wheel_diameter", _rounded(2.0 * float(measure.value)), remark
    return name, _rounded(measure.value), remark


def _rounded(value: Any) -> Any:
    return float(f"{value:.7g}") if isinstance(value, float) else value
