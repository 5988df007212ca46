"""What was found of a drivetrain: its wheels with their devices, and each measure with where it comes from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from simcore.devices.motor_controllers import BuiltDevice
from simcore.errors import ConfigError
from simcore.quantities import DeviceKey

__all__ = ["DrivetrainNotFoundError", "FoundDrivetrain", "FoundWheel", "Measure"]


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
        """A value that must be there."""
        return self.measures[name].value
