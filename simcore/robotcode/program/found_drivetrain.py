"""Drivetrain found in a robot program: wheels and their devices, measures and their sources, and printed summaries."""

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
    """Error for a program in which simcore finds no drivetrain, and a simcore.toml that describes no drivetrain."""


@dataclass(frozen=True, slots=True)
class Measure:
    """Value and source of one drivetrain parameter."""

    value: Any
    source: str
    is_guess: bool = False

    def __str__(self) -> str:
        text = f"{self.value:.4g}" if isinstance(self.value, float) else str(self.value)
        return f"{text} ({self.source})"


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundWheel:
    """Swerve module, side of a tank drive, or mecanum wheel."""

    name: str
    """Name of the wheel for messages: attribute path or number of a module, else side or corner."""
    place: tuple[float, float]
    """Position relative to the robot's center: x forward, y left [m]; the midpoint of a tank drive's side."""
    motors: tuple[BuiltDevice, ...]
    """Motors that turn the wheel, leader first."""
    steer: BuiltDevice | None = None
    """Steer motor; None for a wheel that does not steer."""
    encoder: BuiltDevice | None = None
    """Encoder on the steering axis: a device, or the steer motor's controller if wired; None without an encoder."""
    wheel_encoder: BuiltDevice | None = None
    """Encoder on the wheel, read instead of the motor's encoder; None without a wheel encoder."""
    drive_sign: float = 1.0
    """-1 if positive output in robot code drives backward, else 1."""
    steer_sign: float = 1.0
    """-1 if positive output in robot code steers clockwise seen from above, else 1."""
    is_steer_sign_known: bool = True
    """Whether a source gives `steer_sign`; if not, the steer loop reveals the sign in the first seconds of driving."""
    encoder_sign: float = 1.0
    """-1 if the steer encoder counts clockwise as positive in robot code, seen from above, else 1."""
    encoder_turns: float = 1.0
    """Turns of the steer encoder per turn of the steering axis [-]; for a pulse encoder, inferred from robot code."""
    zero: float = 0.0
    """Module angle in robot code while the steer encoder reads zero [rad]."""
    meters_per_encoder_turn: float | None = None
    """Distance that robot code adds per turn of `wheel_encoder` [m]; None if unknown."""

    @property
    def is_wired(self) -> bool:
        """Whether the steer encoder is wired to the steer motor's controller."""
        return self.encoder is not None and self.steer is not None and self.encoder.key == self.steer.key

    @property
    def devices(self) -> list[BuiltDevice]:
        """All devices of the wheel, each device once."""
        more = (self.steer, self.encoder, self.wheel_encoder)
        return list({d.key: d for d in (*self.motors, *(d for d in more if d is not None))}.values())


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundDrivetrain:
    """Drivetrain found in a robot program, of any kind and maker."""

    kind: str
    """Kind of drive: `swerve`, `tank` or `mecanum`."""
    wheels: tuple[FoundWheel, ...]
    """Wheels in the order of the program's kinematics.

    Tank: left, right. Mecanum: front left, front right, rear left, rear right.
    """
    gyro: BuiltDevice | None = None
    measures: Mapping[str, Measure] = field(default_factory=dict)
    """Measures by name, such as `drive_motor`, `drive_gearing` and `wheel_radius` [m]."""
    free_speed_volts: tuple[Measure, ...] = ()
    """Velocity feedforward voltages at the motors' free speed [V]."""
    differences: tuple[str, ...] = ()
    """Contradictions between robot code, path-planner settings and simcore.toml, one sentence each."""
    about: str = ""
    """Short description of the drivetrain for messages: `sides of DifferentialDrive`."""
    kinematics: str = ""
    """Class name of the kinematics that gives the wheel positions; empty if the program has no kinematics."""
    drives_itself: bool = False
    """Whether an object of a vendor library controls the drivetrain, so that no `[drivetrain]` table is needed."""

    @property
    def keys(self) -> tuple[DeviceKey, ...]:
        """Model and address of each device of the drivetrain, without duplicates."""
        found = [d.key for wheel in self.wheels for d in wheel.devices]
        found += [] if self.gyro is None else [self.gyro.key]
        return tuple(dict.fromkeys(found))

    @property
    def hardware(self) -> list[Any]:
        """Robot code's objects for all devices, with the gyro last."""
        gyro = [] if self.gyro is None else [self.gyro]
        return [d.hardware for d in (*(d for wheel in self.wheels for d in wheel.devices), *gyro)]

    @property
    def places(self) -> tuple[tuple[float, float], ...]:
        """Positions of the wheels relative to the robot's center: x forward, y left [m]."""
        return tuple(wheel.place for wheel in self.wheels)

    def measure(self, name: str) -> Any:
        """Return the value of the measure `name`, which must be in `measures`."""
        return self.measures[name].value


# --- description --------------------------------------------------------------------------------------------------

Row = tuple[str, Any, str]

_MEASURES = (
    *("drive_motor", "drive_gearing", "wheel_radius", "steer_motor", "steer_gearing", "trackwidth", "reversed"),
)
_LOOPS = ("drive_loop", "steer_loop")


def drivetrain_rows(found: FoundDrivetrain) -> list[Row]:
    """List the `[drivetrain]` entries that `simcore init` writes: key, value and remark.

    Args:
        found: Drivetrain with complete measures.
    """
    wheels, first = found.wheels, found.wheels[0]
    leaders = [wheel.motors[0] for wheel in wheels]
    head: Row = ("kind", found.kind, found.about)
    measures = [_measure(name, found.measures[name]) for name in _MEASURES if name in found.measures]
    if len({d.model for d in leaders}) > 1:  # the table has one `controller` key, not needed for a found drivetrain
        return [head, *(_places(found) if "x and y" in found.measures else ()), *measures]
    model = leaders[0].model
    rows: list[Row] = [head, ("controller", model, "")]
    if found.kind == "tank":  # the program configures followers of other models itself
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
    """List the lines printed at startup: kind of drive, gyro and loops, guesses, contradictions."""
    loops = {str(found.measures[name].value) for name in _LOOPS if name in found.measures}
    closed = f", loops on the {' and on the '.join(sorted(loops))}" if loops else ""
    lines = [f"{found.kind} drive: {found.about}, {found.gyro or 'no gyro'}{closed}"]
    lines += [f"guess: {guess}" for guess in guesses(found)]
    return lines + [f"differs: {sentence}" for sentence in found.differences]


def guesses(found: FoundDrivetrain) -> list[str]:
    """List each guessed measure as text: key in `[drivetrain]`, value and source."""
    measures = {name: measure for name, measure in found.measures.items() if measure.is_guess}
    if (radius := measures.pop("wheel_radius", None)) is not None:
        measures["wheel_diameter"] = replace(radius, value=2.0 * radius.value)
    return [f"{name} {measure}" for name, measure in measures.items()]


def _numbers(devices: Iterable[BuiltDevice | None]) -> list[Any]:
    """List the addresses of devices as written in simcore.toml."""
    return [d.address.in_file for d in devices if d is not None]


def _names(wheels: tuple[FoundWheel, ...]) -> str:
    """Join the last parts of the wheels' names with commas; return an empty text for long or numbered names."""
    names = [w.name.split(".")[-1] for w in wheels]
    return ", ".join(names) if len("".join(names)) < 60 and not names[0].isdigit() else ""


def _encoders(wheels: tuple[FoundWheel, ...]) -> list[Row]:
    encoder = wheels[0].encoder
    if encoder is None:
        return [("encoder", "none", "")]
    if wheels[0].is_wired:
        return [("encoder", "wired", "absolute encoders wired to the steer motors' controllers")]
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
            "angle of each module in your code at an encoder reading of 0"
            if guess is None
            else f"guess: {guess.source}"
        )
        rows.append(("zeros_deg", zeros, remark))
    for key, signs in (
        ("reversed_drive", [w.drive_sign for w in wheels]),
        ("reversed_steer", [w.steer_sign for w in wheels]),
        ("reversed_encoders", [w.encoder_sign for w in wheels]),
    ):
        if turned := [k for k, sign in enumerate(signs) if sign < 0.0]:
            rows.append((key, turned, "indices in the lists above, from 0"))
    return rows


def _measure(name: str, measure: Measure) -> Row:
    remark = f"{'guess: ' if measure.is_guess else ''}{measure.source}"
    if name == "wheel_radius":
        return "wheel_diameter", _rounded(2.0 * float(measure.value)), remark
    return name, _rounded(measure.value), remark


def _rounded(value: Any) -> Any:
    return float(f"{value:.7g}") if isinstance(value, float) else value
