"""A drivetrain found in the program: wheels with their devices, measures with their sources, and its description."""

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
    """A value and its source."""

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
    """Name in messages."""
    place: tuple[float, float]
    """Position relative to the robot's center, forward and left [m]; for a side of a tank drive its middle."""
    motors: tuple[BuiltDevice, ...]
    """Motors that turn the wheel; the first one leads."""
    steer: BuiltDevice | None = None
    """Motor that turns the azimuth."""
    encoder: BuiltDevice | None = None
    """Encoder on the azimuth; the steer motor itself where the encoder is wired to it."""
    wheel_encoder: BuiltDevice | None = None
    """Encoder on the wheel, where the motor has none."""
    drive_sign: float = 1.0
    """-1 where positive in robot code drives backward."""
    steer_sign: float = 1.0
    """-1 where positive in robot code turns the azimuth clockwise, seen from above."""
    is_steer_sign_known: bool = True
    """Whether a source gives the sign; else the program's own loop shows it in the first seconds of driving."""
    encoder_sign: float = 1.0
    """-1 where the azimuth's encoder counts clockwise as positive in robot code, seen from above."""
    encoder_turns: float = 1.0
    """Encoder turns per turn of the azimuth [-]; only the program knows it for an encoder that counts pulses."""
    zero: float = 0.0
    """Angle that robot code assigns to the azimuth while its encoder reads zero [rad]."""
    meters_per_encoder_turn: float | None = None
    """Distance that robot code counts per turn of `wheel_encoder` [m]."""

    @property
    def is_wired(self) -> bool:
        """Whether the azimuth's encoder is wired to the steer motor's controller."""
        return self.encoder is not None and self.steer is not None and self.encoder.key == self.steer.key

    @property
    def devices(self) -> list[BuiltDevice]:
        """Devices of the wheel, each once."""
        more = (self.steer, self.encoder, self.wheel_encoder)
        return list({d.key: d for d in (*self.motors, *(d for d in more if d is not None))}.values())


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundDrivetrain:
    """A drivetrain of any kind and maker."""

    kind: str
    """Kind: `swerve`, `tank` or `mecanum`."""
    wheels: tuple[FoundWheel, ...]
    """Wheels in the order of the kinematics.

    Tank: left, right. Mecanum: front left, front right, rear left, rear right.
    """
    gyro: BuiltDevice | None = None
    measures: Mapping[str, Measure] = field(default_factory=dict)
    """Measures by name (`drive_motor`, `drive_gearing`, `wheel_radius` [m], `steer_motor` ...), with their sources."""
    free_speed_volts: tuple[Measure, ...] = ()
    """Velocity feed-forward voltages at the free speed of their motors [V]."""
    differences: tuple[str, ...] = ()
    """Contradictions between the program, its settings and its file; a sentence each."""
    about: str = ""
    """How simcore found it."""
    kinematics: str = ""
    """Class of the program's kinematics that gives the positions; empty: the program gives none."""
    drives_itself: bool = False
    """Whether a library's own object drives it, which simcore finds without a table."""

    @property
    def keys(self) -> tuple[DeviceKey, ...]:
        """Keys of all its devices."""
        found = [d.key for wheel in self.wheels for d in wheel.devices]
        found += [] if self.gyro is None else [self.gyro.key]
        return tuple(dict.fromkeys(found))

    @property
    def hardware(self) -> list[Any]:
        """Objects of these devices in robot code."""
        gyro = [] if self.gyro is None else [self.gyro]
        return [d.hardware for d in (*(d for wheel in self.wheels for d in wheel.devices), *gyro)]

    @property
    def places(self) -> tuple[tuple[float, float], ...]:
        """Positions of its wheels [m]."""
        return tuple(wheel.place for wheel in self.wheels)

    def measure(self, name: str) -> Any:
        """Return the value of a measure that must exist."""
        return self.measures[name].value


# --- description --------------------------------------------------------------------------------------------------

Row = tuple[str, Any, str]

_MEASURES = (
    *("drive_motor", "drive_gearing", "wheel_radius", "steer_motor", "steer_gearing", "trackwidth", "reversed"),
)
_LOOPS = ("drive_loop", "steer_loop")


def drivetrain_rows(found: FoundDrivetrain) -> list[Row]:
    """List keys of `[drivetrain]`, their values and a remark on each, as `simcore init` writes them.

    Args:
        found: Drivetrain with complete measures.
    """
    wheels, first = found.wheels, found.wheels[0]
    leaders = [wheel.motors[0] for wheel in wheels]
    head: Row = ("kind", found.kind, found.about)
    measures = [_measure(name, found.measures[name]) for name in _MEASURES if name in found.measures]
    if len({d.model for d in leaders}) > 1:  # a key of the table alone; a found drivetrain does not need it
        return [head, *(_places(found) if "x and y" in found.measures else ()), *measures]
    model = leaders[0].model
    rows: list[Row] = [head, ("controller", model, "")]
    if found.kind == "tank":  # the program itself configures followers, whatever their model
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
            rows.append(("wheel_distances", ways, "m per 2048 pulses in robot code"))
    if found.gyro is not None:
        rows += [("gyro", str(found.gyro), ""), ("gyro_upside_down", False, "guess: it is mounted upright")]
    return rows + measures


def drivetrain_lines(found: FoundDrivetrain) -> list[str]:
    """List lines for a person: its kind, its guesses and its contradictions."""
    loops = {str(found.measures[name].value) for name in _LOOPS if name in found.measures}
    closed = f", loops on the {' and on the '.join(sorted(loops))}" if loops else ""
    lines = [f"{found.kind} drive: {found.about}, {found.gyro or 'no gyro'}{closed}"]
    lines += [f"guess: {guess}" for guess in guesses(found)]
    return lines + [f"differs: {sentence}" for sentence in found.differences]


def guesses(found: FoundDrivetrain) -> list[str]:
    """List measures that are guesses, by keys of `[drivetrain]`."""
    measures = {name: measure for name, measure in found.measures.items() if measure.is_guess}
    if (radius := measures.pop("wheel_radius", None)) is not None:
        measures["wheel_diameter"] = replace(radius, value=2.0 * radius.value)
    return [f"{name} {measure}" for name, measure in measures.items()]


def _numbers(devices: Iterable[BuiltDevice | None]) -> list[Any]:
    """List addresses as the file writes them."""
    return [d.address.in_file for d in devices if d is not None]


def _names(wheels: tuple[FoundWheel, ...]) -> str:
    """Join the last attribute of each wheel's name."""
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
    given = found.measures.get("x and y")
    remark = "forward of the center" if given is None else f"guess: {given.source}" if given.is_guess else given.source
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
