"""What the physics hook needs from a game, a robot's plant and its devices, and nothing more."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from simcore.match.scoring import Alliance
from simcore.robot.battery import Battery
from simcore.robot.gyro import Gyro
from simcore.robot.shaft import ShaftSim
from simcore.typing import FloatArray

__all__ = [
    "AttachedPlant",
    "Body",
    "DrivetrainDevices",
    "Game",
    "MotorDevices",
    "Plant",
]


class Game(Protocol):
    """A field with robots and pieces, moved in ticks of 20 ms that can be cut: `RebuiltSim`."""

    last_tick_ms: float | None
    """Wall time of the last tick [ms], told to it for its telemetry."""

    def begin_tick(self) -> None:
        """What comes before motion."""
        ...

    def move(self, dt: float) -> None:
        """A part of the tick [s]: robots, pieces and mechanisms move."""
        ...

    def end_tick(self) -> None:
        """Scoring, shots, telemetry."""
        ...

    def set_clock(self, now: float) -> None:
        """What NetworkTables' clock, on a robot the FPGA's, shows at the end of the present tick [s]."""
        ...

    def set_alliance(self, number: int, alliance: Alliance) -> None:
        """Put a robot where it starts as one of the alliance."""
        ...

    def start_period(self, period: str) -> None:
        """`auto` or `teleop` has just been enabled."""
        ...

    @property
    def game_message(self) -> str:
        """The game data that the field sends now; empty for none."""
        ...

    def piece_places(self) -> Mapping[str, FloatArray]:
        """Pieces to show, by type; field frame [m], shape (n, 3)."""
        ...

    def close(self) -> None:
        """Free the engine."""
        ...


class Body(Protocol):
    """Where a robot is."""

    @property
    def pose(self) -> tuple[float, float, float]:
        """Field frame [m, m, rad]."""
        ...


class Plant(Protocol):
    """One robot of the game, as its roboRIO and gyro see it."""

    @property
    def number(self) -> int:
        """Its place among the robots of the game."""
        ...

    @property
    def battery(self) -> Battery:
        """Stepped by the game."""
        ...

    @property
    def gyro(self) -> Gyro:
        """Stepped by the game."""
        ...

    @property
    def chassis(self) -> Body:
        """Stepped by the game."""
        ...


class AttachedPlant(Plant, Protocol):
    """A robot built from `simcore.toml`, to which guessed mechanisms are added."""

    @property
    def named(self) -> Mapping[str, ShaftSim]:
        """The mechanisms of the file."""
        ...

    def add_mechanism(self, mechanism: ShaftSim) -> None:
        """Step one more; being a guess, it draws nothing from the battery."""
        ...

    def remove_mechanism(self, mechanism: ShaftSim) -> None:
        """Leave one to somebody else."""
        ...


class DrivetrainDevices(Protocol):
    """The devices of a drivetrain: `SwerveDrivetrainSim`."""

    def read(self, battery_voltage: float) -> None:
        """Supply in, volts out to the model [V]."""
        ...

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """The model's motion and the gyro's reading to the sensors [rad, rad/s]."""
        ...


class MotorDevices(Protocol):
    """The devices of a mechanism: `TalonFXMotorSim`."""

    def read(self, battery_voltage: float, *, powered: bool = True) -> None:
        """Supply in, volts out to the mechanism [V]."""
        ...

    def write(self) -> None:
        """The mechanism's motion to the sensors."""
        ...
