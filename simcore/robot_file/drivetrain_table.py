"""Table `[drivetrain]` of `simcore.toml`: description of the drivetrain, or corrections to the found drivetrain.

The table is optional. A table without motors corrects the drivetrain found in the program. A table with motors
describes the whole drivetrain, and simcore does not search the program for a drivetrain.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from simcore.errors import ConfigError
from simcore.quantities import (
    CURRENT_LIMIT,
    DEGREES,
    GEARING,
    INERTIA,
    RATIO,
    ROBOT_LENGTH,
    ROBOT_PLACE,
    DeviceAddress,
    Quantity,
)
from simcore.robot.dc_motor import MOTOR_NAMES
from simcore.robot_file.key_tables import Key, KeyTable, Several, Table

__all__ = ["DRIVETRAIN", "MEASURES", "NO_PHOENIX_5", "OLD_CONTROLLERS", "DrivetrainSettings", "read_drivetrain"]

_OF_DEVICES = ("controller", "steer_controller", "steer", "encoder", "encoders", "wheel_encoders")
"""Keys for devices other than the drive motors; a table with these keys needs the drive motors, too."""
KINDS = ("swerve", "tank", "mecanum")
ON_PORTS = ("DutyCycleEncoder", "AnalogEncoder", "DutyCycle", "AnalogInput", "AnalogPotentiometer")
"""WPILib classes that read absolute encoders on ports of the roboRIO."""
ENCODERS = ("CANcoder", *ON_PORTS, "wired", "none")
"""Valid values of the key `encoder`: a class in robot code, `wired` (to the steer motors' controllers) or `none`."""
NO_PHOENIX_5 = (
    "Phoenix 5 (Talon SRX, Victor SPX, Pigeon IMU) is not simulated: it ends with the roboRIO, and its Python package "
    "does not install with Phoenix 6 26.3. TalonFX, SPARK MAX, SPARK Flex and PWM controllers work, and so do Pigeon2 "
    "and navX"
)
OLD_CONTROLLERS = dict.fromkeys(("Talon SRX", "Victor SPX"), NO_PHOENIX_5)
"""Reason why a file may not name a Phoenix 5 motor controller, by model of the controller."""
_IDS = Several(DeviceAddress, or_one=False)
_ROWS = Several(Quantity("", 0, 62, is_whole=True), or_one=False)
_PLACES = Several(ROBOT_PLACE)

MEASURES = (
    Key("drive_motor", MOTOR_NAMES, None, "model of the drive motors; left out: the motor in the program, else the "
        "usual motor of the controller", "NEO"),
    Key("steer_motor", MOTOR_NAMES, None, "model of the steer motors; left out: the motor in the program, else the "
        "usual motor of the controller", "NEO 550"),
    Key("drive_gearing", GEARING, None, "rotor turns per turn of the wheel; left out: from the program, PathPlanner or "
        "Choreo, else a guess", 6.75),
    Key("steer_gearing", GEARING, None, "rotor turns per turn of the steering axis; left out: from the program, else a "
        "guess", 21.43),
    Key("coupling_ratio", RATIO, None, "turns of the drive rotor per turn of the steering axis with the wheel at rest",
        0.0),
    Key("wheel_diameter", ROBOT_LENGTH, None, "diameter of the wheels [m]; left out: from the program, PathPlanner or "
        "Choreo, else a guess", 0.1016),
    Key("trackwidth", ROBOT_LENGTH, None, "distance between the left and right wheels of a tank drive [m]; left out: "
        "from the program, PathPlanner or Choreo, else a guess", 0.56),
    Key("dropped_center", bool, None, "whether the middle wheels of a tank drive are lower, as in kit chassis; left "
        "out: true", False),
    Key("reversed", bool, None, "whether positive output drives a tank or mecanum drive backward; left out: false",
        True),
    Key("yaw_inertia", INERTIA, None, "yaw moment of inertia [kg m^2]; left out: that in PathPlanner or Choreo, else "
        "that of a uniform plate", 5.0),
    Key("drive_stator_limit", CURRENT_LIMIT, None, "stator current limit of each drive motor [A]; left out: as "
        "configured in the program", 60.0),
    Key("drive_supply_limit", CURRENT_LIMIT, None, "supply current limit of each drive motor [A]; left out: as "
        "configured in the program", 60.0),
    Key("steer_stator_limit", CURRENT_LIMIT, None, "stator current limit of each steer motor [A]; left out: as "
        "configured in the program", 20.0),
    Key("steer_supply_limit", CURRENT_LIMIT, None, "supply current limit of each steer motor [A]; left out: as "
        "configured in the program", 20.0),
)  # fmt: skip
"""Keys of drivetrain parameters; each key overrides the value found in the program."""
DRIVETRAIN = KeyTable(
    "[drivetrain]",
    "corrections to the drivetrain found in the program; a table with motors describes the whole drivetrain instead",
    (
        Key("kind", KINDS, "", "kind of drive; left out: that of the program", "swerve"),
        Key("controller", str, "", "model of the drive motors' controllers: TalonFX, SPARK MAX, PWM, ...", "SPARK MAX",
            refused=OLD_CONTROLLERS),
        Key("drive", _IDS, (), "CAN ids or channels of the drive motors, in the order of your kinematics; mecanum: "
            "front left, front right, rear left, rear right", [1, 3, 5, 7]),
        Key("left", _IDS, (), "CAN ids or channels of the motors on the left side of a tank drive, leader first",
            [1, 2]),
        Key("right", _IDS, (), "CAN ids or channels of the motors on the right side of a tank drive, leader first",
            [3, 4]),
        Key("steer_controller", str, "", "model of the steer motors' controllers; left out: the same as controller",
            "SPARK MAX", refused=OLD_CONTROLLERS),
        Key("steer", _IDS, (), "CAN ids or channels of the steer motors, in the order of drive", [2, 4, 6, 8]),
        Key("encoder", ENCODERS, "", "kind of absolute encoder on the steering axes; wired: connected to the steer "
            "motors' controllers; left out: CANcoder if encoders is set, else none", "CANcoder"),
        Key("encoders", _IDS, (), "CAN ids or channels of the absolute encoders, in the order of drive",
            [11, 12, 13, 14]),
        Key("x", _PLACES, (), "x coordinates of the modules or mecanum wheels, forward of the robot's center [m]",
            [0.27, 0.27, -0.27, -0.27]),
        Key("y", _PLACES, (), "y coordinates of the modules or mecanum wheels, left of the robot's center [m]",
            [0.27, -0.27, 0.27, -0.27]),
        Key("zeros_deg", Several(DEGREES), (), "angle of each module in your code at an encoder reading of 0 [deg]",
            [0.0, 0.0, 0.0, 0.0]),
        Key("reversed_drive", _ROWS, (), "indices, from 0, of wheels or sides whose motors drive backward with "
            "positive output", []),
        Key("reversed_steer", _ROWS, (), "indices, from 0, of modules whose steer motors turn clockwise with positive "
            "output", []),
        Key("reversed_encoders", _ROWS, (), "indices, from 0, of modules whose absolute encoders count up clockwise",
            []),
        Key("wheel_encoders", _ROWS, (), "first DIO channel of each encoder on a wheel or side", []),
        Key("wheel_distances", Several(Quantity("m", -100.0, 100.0)), (), "distance that your code counts per 2048 "
            "pulses of each wheel encoder [m]", []),
        Key("gyro", str, "", "model of the gyro, with the id if there are several; left out: the first in the program",
            "Pigeon2 9"),
        Key("gyro_upside_down", bool, False, "whether the gyro is mounted upside down; the program must account for "
            "the mounting", True),
        Key("gyro_reversed", bool, False, "whether only the yaw of the gyro is reversed", True),
        *MEASURES,
    ),
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class DrivetrainSettings:
    """Contents of the `[drivetrain]` table; fields without a value in the table keep their defaults."""

    kind: str = ""
    """Kind of the drivetrain, one of `KINDS`; empty if the table gives no kind."""
    controller: str = ""
    """Model of the drive motors' controllers, e.g. `TalonFX`, `SPARK MAX` or `PWM`; empty if not in the table."""
    steer_controller: str = ""
    """Model of the steer motors' controllers; empty if equal to `controller`."""
    drive: tuple[tuple[DeviceAddress, ...], ...] = ()
    """CAN IDs or channels of the motors on each wheel, or on each side of a tank drive (left first), leader first."""
    steer: tuple[DeviceAddress, ...] = ()
    """CAN ID or channel of each module's steer motor."""
    encoder: str = ""
    """Kind of the absolute steer encoders, one of `ENCODERS`; empty if the table gives no kind."""
    encoders: tuple[DeviceAddress, ...] = ()
    """CAN IDs or channels of separate absolute steer encoders, in the order of `drive`; may be empty."""
    wheel_encoders: tuple[int, ...] = ()
    """First DIO channel of each encoder on a wheel or side; may be empty."""
    wheel_distances: tuple[float, ...] = ()
    """Distance that robot code counts for one turn (2048 pulses) of each wheel encoder [m]."""
    places: tuple[tuple[float, float], ...] = ()
    """Position of each wheel: x forward and y left of the robot's center [m]."""
    zeros: tuple[float, ...] = ()
    """Steer angle that robot code computes for each module at an encoder reading of zero [rad]."""
    reversed_drive: tuple[int, ...] = ()
    """Indices in `drive`, from 0, of the wheels or sides whose motors drive backward with positive output."""
    reversed_steer: tuple[int, ...] = ()
    """Indices of modules whose steer motors turn the wheel clockwise, seen from above, with positive output."""
    reversed_encoders: tuple[int, ...] = ()
    """Indices of modules whose absolute encoders count up clockwise, seen from above."""
    gyro: str = ""
    """Model of the gyro, with the id if there are several gyros, e.g. `Pigeon2 9`; empty for the first gyro."""
    gyro_upside_down: bool = False
    """Whether the gyro is rotated by half a turn about the robot's x axis."""
    gyro_reversed: bool = False
    """Whether only the yaw of the gyro is reversed."""
    measures: Mapping[str, Any] = field(default_factory=dict)
    """Values of the keys of `MEASURES` that the table gives, by key."""

    @property
    def has_devices(self) -> bool:
        """Whether the table names drive motors and therefore describes the whole drivetrain."""
        return bool(self.drive)

    @property
    def corrections(self) -> tuple[str, ...]:
        """Keys in the table that correct directions, positions, zero angles or encoder distances of wheels."""
        own = ("reversed_drive", "reversed_steer", "reversed_encoders", "zeros", "places", "wheel_distances")
        return self._present_keys(*own)

    @property
    def of_swerve(self) -> tuple[str, ...]:
        """Keys in the table that apply only to a swerve drive."""
        return self._present_keys("reversed_steer", "reversed_encoders", "zeros")

    def _present_keys(self, *names: str) -> tuple[str, ...]:
        keys = {"zeros": "zeros_deg", "places": "x"}
        return tuple(keys.get(name, name) for name in names if getattr(self, name))


def read_drivetrain(t: Table | None) -> DrivetrainSettings:
    """Read and check the `[drivetrain]` table; return default settings if the file has no such table.

    Raises:
        ConfigError: A key is unknown, invalid or missing, or conflicts with another key.
    """
    if t is None:
        return DrivetrainSettings()
    said = DRIVETRAIN.read(t)
    t.finish()
    measures = {key.name: said.pop(key.name) for key in MEASURES}
    left, right, xs, ys = (said.pop(name) for name in ("left", "right", "x", "y"))
    drive = tuple((address,) for address in said.pop("drive"))
    if not (left or right or drive):
        for name in _OF_DEVICES:
            if name in t:
                raise t.error(name, "needs the motors as well: drive, or left and right")
    if bool(left) != bool(right):
        raise t.error("left", "and right must both name motors")
    if len(xs) != len(ys):
        raise t.error("x", f"and y must name as many places, got {len(xs)} and {len(ys)}")
    settings = DrivetrainSettings(
        **{name: value for name, value in said.items() if name != "zeros_deg"},
        drive=(left, right) if left else drive,
        zeros=tuple(math.radians(v) for v in said["zeros_deg"]),
        places=tuple(zip(xs, ys, strict=True)),
        measures={name: value for name, value in measures.items() if value is not None},
    )
    _require_whole(t, settings)
    return settings


def _require_whole(t: Table, s: DrivetrainSettings) -> None:
    """Check that a table with motors gives kind and controller, and one entry per wheel in the lists.

    The lists of a tank drive are not checked.

    Raises:
        ConfigError: The table fails the check.
    """
    if not s.has_devices:
        return
    if not s.kind or not s.controller:
        raise ConfigError(f"{t.where}: kind and controller (of the drive motors, e.g. SPARK MAX) belong to its motors")
    n = len(s.drive)
    for key, row in (("steer", s.steer), ("encoders", s.encoders), ("zeros_deg", s.zeros), ("x and y", s.places)):
        is_needed = s.kind == "swerve" and key in ("steer", "x and y")
        if (row or is_needed) and len(row) != n and s.kind != "tank":
            raise t.error(key, f"must have {n} entries, one for each of drive; got {len(row)}")
    if s.kind == "mecanum" and n != 4:
        raise t.error("drive", f"must name 4 motors: front left, front right, rear left, rear right; got {n}")
