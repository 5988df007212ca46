"""The model of a drivetrain that was found, and the ports between that model and the program's devices."""

from __future__ import annotations

import math
from typing import Any

from simcore.devices.found_drivetrain import FoundDrivetrain, FoundWheel
from simcore.devices.makers import maker_of
from simcore.errors import ConfigError
from simcore.robot.dc_motor import motor
from simcore.robot.fixed_wheel_config import MecanumConfig, TankConfig
from simcore.robot.fixed_wheel_drive import MecanumDrive, TankDrive
from simcore.robot.motor_controllers import BuiltDevice, CurrentMeter, OwnLoops
from simcore.robot.motor_ports import AnglePort, GyroPort, MotorPort, ShaftPorts, SwervePorts
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.swerve_drive import SwerveDrive
from simcore.robot.wheel_config import plate_inertia
from simcore.robot_file.robot_settings import RobotSettings

__all__ = ["ConnectedDrivetrain", "connect_drivetrain", "drivetrain_config"]

_MODULE_MEASURES = (
    *("drive_gearing", "steer_gearing", "wheel_radius", "wheel_cof", "coupling_ratio"),
    *("drive_stator_limit", "drive_supply_limit", "steer_stator_limit", "steer_supply_limit"),
)
_SIDE_MEASURES = {
    "drive_gearing": "gearing",
    "wheel_radius": "wheel_radius",
    "wheel_cof": "wheel_cof",
    "drive_stator_limit": "stator_limit",
    "drive_supply_limit": "supply_limit",
}


def drivetrain_config(found: FoundDrivetrain, settings: RobotSettings) -> SwerveConfig | TankConfig | MecanumConfig:
    """The model of a drivetrain whose measures are complete.

    Args:
        found: See `complete_measures`.
        settings: Of simcore.toml: mass, bumpers, height of the center of mass.

    Raises:
        ConfigError: A measure makes no sense.
    """
    measures = {name: m.value for name, m in found.measures.items()}
    mass = measures.get("mass", settings.mass)
    bumper = settings.with_bumper_around(found.places).bumper
    assert bumper is not None
    inertia = measures.get("yaw_inertia") or plate_inertia(mass, *bumper)
    center = (0.0, 0.0, settings.center_of_mass_height)
    cof = measures.get("wheel_cof", settings.wheel_cof)
    if found.kind == "swerve":
        given = {name: measures[name] for name in _MODULE_MEASURES if name in measures}
        modules = tuple(
            SwerveModuleConfig(
                **{
                    **given,
                    "name": wheel.name.split(".")[-1] if not wheel.name.split(".")[-1].isdigit() else f"module {k}",
                    "x": wheel.place[0],
                    "y": wheel.place[1],
                    "wheel_cof": cof,
                    "drive_motor": motor(measures["drive_motor"]),
                    "steer_motor": motor(measures["steer_motor"]),
                }
            )
            for k, wheel in enumerate(found.wheels)
        )
        return SwerveConfig(modules=modules, mass=mass, yaw_inertia=inertia, center_of_mass=center)
    shafts: dict[str, Any] = {own: measures[name] for name, own in _SIDE_MEASURES.items() if name in measures}
    if "wheel_cof" in measures or "tread" in settings.given:
        shafts["wheel_cof"] = cof
    shafts |= {"mass": mass, "yaw_inertia": inertia, "center_of_mass": center, "motor": motor(measures["drive_motor"])}
    motors = max(len(wheel.motors) for wheel in found.wheels)
    if found.kind == "mecanum":
        return MecanumConfig(**shafts, places=found.places, motors_per_wheel=motors)
    own = {name: measures[name] for name in ("trackwidth", "dropped_center") if name in measures}
    return TankConfig(**shafts, **own, motors_per_side=motors)


class ConnectedDrivetrain:
    """The devices of a drivetrain on its model, as `RobotPhysics` wants them.

    Args:
        found: What was found.
        ports: Between its devices and the model.
    """

    def __init__(self, found: FoundDrivetrain, ports: SwervePorts | ShaftPorts) -> None:
        self.found = found
        self.devices = found.keys
        """Of all its devices, (model, id)."""
        self.run = ports.run
        self.read = ports.read
        self.write = ports.write


def connect_drivetrain(found: FoundDrivetrain, drive: SwerveDrive | TankDrive | MecanumDrive) -> ConnectedDrivetrain:
    """Put the program's devices on the model.

    Args:
        found: What was found.
        drive: Its model.

    Raises:
        ConfigError: A device does not answer.
    """
    _require_own(found)
    gyro: GyroPort | None = None if found.gyro is None else maker_of(found.gyro).gyro_port(found.gyro)
    drives = [[_motor_port(d) for d in wheel.motors] for wheel in found.wheels]
    radius = float(found.measure("wheel_radius"))
    wheels = [_wheel_encoder(wheel, radius, row[0]) for wheel, row in zip(found.wheels, drives, strict=True)]
    ports: SwervePorts | ShaftPorts
    if not isinstance(drive, SwerveDrive):
        mounted = [[_Mounted(port, w.drive_sign) for port in row] for w, row in zip(found.wheels, drives, strict=True)]
        ports = ShaftPorts(drive, mounted, encoders=wheels, gyro=gyro)
    else:
        steers = [_motor_port(wheel.steer) for wheel in found.wheels]
        gearings = [m.steer_gearing for m in drive.config.modules]
        ports = SwervePorts(
            drive,
            [_Mounted(row[0], w.drive_sign) for row, w in zip(drives, found.wheels, strict=True)],
            [
                _Mounted(port, w.steer_sign, -w.zero * g / math.tau)
                for port, w, g in zip(steers, found.wheels, gearings, strict=True)
            ],
            steer_encoders=[_azimuth(w, port) for w, port in zip(found.wheels, steers, strict=True)],
            wheel_encoders=wheels,
            gyro=gyro,
        )
    return ConnectedDrivetrain(found, ports)


def _require_own(found: FoundDrivetrain) -> None:
    owners: dict[tuple[str, int], str] = {}
    for wheel in found.wheels:
        for device in wheel.devices:
            if device.key in owners:
                raise ConfigError(
                    f"drivetrain: {device} is in {owners[device.key]} and in {wheel.name}; simulated ids must differ "
                    "across CAN buses too"
                )
            owners[device.key] = wheel.name


def _motor_port(device: BuiltDevice | None) -> MotorPort:
    assert device is not None, "a swerve module has two motors"
    return maker_of(device).motor_port(device)


def _azimuth(wheel: FoundWheel, steer: MotorPort) -> AnglePort | None:
    if wheel.encoder is None:
        return None
    return _Shaft(maker_of(wheel.encoder).encoder_port(wheel.encoder, steer), wheel.encoder_sign, wheel.zero)


def _wheel_encoder(wheel: FoundWheel, radius: float, drive: MotorPort) -> AnglePort | None:
    if wheel.wheel_encoder is None:
        return None
    way = wheel.meters_per_encoder_turn
    port = maker_of(wheel.wheel_encoder).encoder_port(wheel.wheel_encoder, drive)
    return _Shaft(port, 1.0 if way is None else math.tau * radius / way, 0.0)


class _Mounted:
    """A motor that turns the other way round than the model's, or counts from another zero.

    Args:
        port: Of the motor.
        sign: -1 where positive in robot code is negative for the model.
        ahead: How far its rotor is ahead of the model's, seen the model's way [rotations].
    """

    def __init__(self, port: MotorPort, sign: float, ahead: float = 0.0) -> None:
        self._port = port
        self._sign = sign
        self._ahead = ahead
        self.set_supply = port.set_supply
        self.is_open = port.is_open
        if isinstance(port, CurrentMeter):
            self.show_current = port.show_current
        if isinstance(port, OwnLoops):
            self.run = port.run

    def volts(self) -> float:
        """On the motor, as the model has it [V]."""
        return self._sign * self._port.volts()

    def write(self, rotations: float, rps: float) -> None:
        """The rotor, as the model has it."""
        self._port.write(self._sign * (rotations + self._ahead), self._sign * rps)


class _Shaft:
    """An encoder that counts `scale` times the shaft's angle from where the shaft is at `zero` [rad]."""

    def __init__(self, port: AnglePort, scale: float, zero: float) -> None:
        self._port = port
        self._scale = scale
        self._zero = zero

    def write(self, angle: float, rate: float) -> None:
        """The shaft, as the model has it [rad, rad/s]."""
        self._port.write(self._scale * (angle - self._zero), self._scale * rate)
