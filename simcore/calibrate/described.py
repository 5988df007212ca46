"""Description of the robot that recorded a log, from simcore.toml and the robot program, or of the kit chassis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from simcore.calibrate.drive_model import DriveConfig
from simcore.errors import ConfigError
from simcore.robot.dc_motor import motor
from simcore.robot.fixed_wheel_config import MecanumConfig, TankConfig
from simcore.robot.robot_config import RobotConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot_file.drivetrain_table import DrivetrainSettings
from simcore.robot_file.init_command import survey
from simcore.robot_file.reader import read_settings
from simcore.robot_file.robot_settings import FILE_NAME, RobotSettings
from simcore.robotcode.sim.check_command import surveyed_drivetrain

__all__ = ["Described", "described"]


@dataclass(frozen=True, slots=True, eq=False)
class Described:
    """Description of a project's robot before calibration.

    The field `about` names the source of the description. The field `devices` has the side of each drive motor by the
    motor's name in logs.
    """

    config: RobotConfig
    settings: RobotSettings
    about: str
    devices: Mapping[str, str]

    problem: str
    """Reason why the program does not give the drivetrain; empty if the drivetrain is known or no program exists."""

    @property
    def drivetrain(self) -> DriveConfig:
        """Config of the robot's drivetrain.

        Raises:
            ConfigError: If `problem` is not empty.
        """
        if self.problem:
            raise ConfigError(
                f"{self.problem}; to fit a log, simcore.toml needs only kind, drive_motor, drive_gearing and "
                "wheel_diameter under [drivetrain]"
            )
        return self.config.drivetrain


def described(folder: Path) -> Described:
    """Return the description of the robot of the project in a folder.

    The drivetrain is that of `[drivetrain]` in simcore.toml, or that of the robot program if `[drivetrain]` has no
    kind. If the folder has neither robot.py nor simcore.toml, the robot is the kit chassis.

    Raises:
        ConfigError: If the project's simcore.toml is invalid.
    """
    settings = read_settings(folder / FILE_NAME)
    said, drivetrain, problem = settings.drivetrain, _of_file(settings), ""
    about = (
        f"as {FILE_NAME} says"
        if (folder / FILE_NAME).is_file()
        else "the kit chassis, because there is no robot.py or simcore.toml"
    )
    if (folder / "robot.py").is_file() and not said.kind:
        found: dict[str, Any] = survey(folder / "robot.py", "described").get("drivetrain", {})
        if "model" in found:
            drivetrain, about = surveyed_drivetrain(found["model"]), "as the program builds it"
            rows = {row[0]: row[1] for row in found.get("rows", ())}
            sides = tuple(tuple(rows[side]) for side in ("left", "right")) if "left" in rows else ()
            said = replace(
                said, kind=rows.get("kind", ""), drive=sides or tuple((one,) for one in rows.get("drive", ()))
            )
        else:
            problem = found.get("problem", "robot.py could not be built")
    return Described(settings.robot_config(drivetrain), settings, about, _devices(said), problem)


def _of_file(settings: RobotSettings) -> DriveConfig:
    """Build the drivetrain config from the settings in simcore.toml only, by default a tank drive."""
    said = settings.drivetrain
    own = {key: value for key, value in said.measures.items() if key not in ("wheel_diameter", "reversed")}
    own |= {name: motor(own[name]) for name in ("drive_motor", "steer_motor") if name in own}
    if settings.drive_motor is not None:
        own["drive_motor"] = motor(settings.drive_motor)
    if "wheel_diameter" in said.measures:
        own["wheel_radius"] = 0.5 * said.measures["wheel_diameter"]
    body: dict[str, Any] = {"mass": settings.mass} if "mass" in settings.given else {}
    body |= {"yaw_inertia": own.pop("yaw_inertia")} if "yaw_inertia" in own else {}
    if said.kind == "swerve":
        own = {key: value for key, value in own.items() if hasattr(SwerveModuleConfig, key)}
        places = said.places or ((0.28, 0.28), (0.28, -0.28), (-0.28, 0.28), (-0.28, -0.28))
        return SwerveConfig(modules=tuple(SwerveModuleConfig(x=x, y=y, **own) for x, y in places), **body)
    names = {"drive_motor": "motor", "drive_gearing": "gearing", "drive_stator_limit": "stator_limit",
             "drive_supply_limit": "supply_limit"}  # fmt: skip
    kind = MecanumConfig if said.kind == "mecanum" else TankConfig
    fields = {names.get(key, key): value for key, value in own.items()}
    fields = {key: value for key, value in fields.items() if hasattr(kind, key)}
    if kind is TankConfig and said.drive:
        fields["motors_per_side"] = max(map(len, said.drive))
    return kind(**fields, **body)


def _devices(said: DrivetrainSettings) -> dict[str, str]:
    """Return the side of each drive motor by the motor's name in URCL logs; a side is empty if not of a tank drive."""
    sides = ("left", "right") if said.kind == "tank" and len(said.drive) == 2 else ("",) * len(said.drive)
    return {f"Spark-{address}": side for side, row in zip(sides, said.drive, strict=True) for address in row}
