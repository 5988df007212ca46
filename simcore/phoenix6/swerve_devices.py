"""The devices of swerve modules, of CTRE's drivetrain or a team's own: volts to the model, motion to the sensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from phoenix6.hardware import CANcoder, CANdi, Pigeon2, TalonFX, TalonFXS

from simcore.errors import ConfigError
from simcore.phoenix6.built_devices import key_of
from simcore.phoenix6.sensor_ports import CANcoderSim, CANdiEncoderSim, Pigeon2Sim
from simcore.phoenix6.talon_port import Talon, TalonPort, is_configured_clockwise
from simcore.robot.motor_ports import AnglePort, SwervePorts
from simcore.robot.swerve_drive import SwerveDrive

__all__ = ["SwerveDevicesSim", "SwerveModuleDevices", "azimuth_port"]


@dataclass(frozen=True, slots=True, kw_only=True)
class SwerveModuleDevices:
    """One module of a team's own swerve code. What is None is read from the device once, in 50 ms.

    Positive is forward for the drive motor, and counter-clockwise seen from above for steer motor and encoder, as the
    team's own odometry needs it; inversions are as configured in the devices.
    """

    drive_motor: Talon
    steer_motor: Talon
    encoder: CANcoder | CANdi | None = None
    encoder_pin: int | None = None
    """Of a CANdi: 1 or 2."""
    drive_inverted: bool | None = None
    """Whether the drive motor is configured `CLOCKWISE_POSITIVE`."""
    steer_inverted: bool | None = None
    encoder_inverted: bool | None = None
    encoder_offset: float | None = None
    """Offset as configured [rotations]."""


class SwerveDevicesSim(SwervePorts):
    """Moves volts from TalonFX to the model of a swerve drive, and the model's motion to their sensors.

    For teams with modules of their own; CTRE's drivetrain has `SwerveDrivetrainSim`.

    Args:
        modules: In the order of the model's modules; an encoder wired to a TalonFXS is taken to sit on the azimuth.
        pigeon: The gyro; None if it is another maker's.
        drive: The model of the same robot; its owner steps it with the chassis.

    Raises:
        ConfigError: Another number of modules than the model has; a device of another kind; two of a kind with one id
            (the device simulation would make them one); a device that does not answer.
    """

    def __init__(self, modules: Sequence[SwerveModuleDevices], pigeon: Pigeon2 | None, drive: SwerveDrive) -> None:
        if len(modules) != len(drive.config.modules):
            raise ConfigError(
                f"swerve: devices of {len(modules)} modules for a model of {len(drive.config.modules)}; want as many"
            )
        _check_devices(modules)
        devices = [d for m in modules for d in (m.drive_motor, m.steer_motor, m.encoder)]
        self.devices = tuple(key_of(d) for d in (*devices, pigeon) if d is not None)
        """Of all its devices, (model, id)."""
        super().__init__(
            drive,
            [_port(m.drive_motor, m.drive_inverted) for m in modules],
            [
                _port(m.steer_motor, m.steer_inverted, c.steer_gearing)
                for m, c in zip(modules, drive.config.modules, strict=True)
            ],
            steer_encoders=[azimuth_port(m) for m in modules],
            gyro=None if pigeon is None else Pigeon2Sim(pigeon),
        )


def _port(talon: Talon, inverted: bool | None, sensor_gearing: float | None = None) -> TalonPort:
    clockwise = is_configured_clockwise(talon) if inverted is None else inverted
    return TalonPort(talon, clockwise=clockwise, sensor_gearing=sensor_gearing)


def azimuth_port(m: SwerveModuleDevices) -> AnglePort | None:
    """The encoder of a module, ready to show its azimuth; None: it has none of its own.

    Raises:
        ConfigError: It does not answer, or has no such pin.
    """
    if isinstance(m.encoder, CANdi):
        return CANdiEncoderSim(m.encoder, m.encoder_pin or 0, inverted=m.encoder_inverted, offset=m.encoder_offset)
    if m.encoder is None:
        return None
    return CANcoderSim(m.encoder, inverted=m.encoder_inverted, magnet_offset=m.encoder_offset)


def _check_devices(modules: Sequence[SwerveModuleDevices]) -> None:
    owners: dict[tuple[str, int, int | None], str] = {}
    for k, module in enumerate(modules):
        for role, kinds in (
            ("drive_motor", (TalonFX, TalonFXS)),
            ("steer_motor", (TalonFX, TalonFXS)),
            ("encoder", (CANcoder, CANdi)),
        ):
            device = getattr(module, role)
            if device is None:
                continue
            where = f"module {k} {role}"
            if not isinstance(device, kinds):
                wanted = " and ".join(kind.__name__ for kind in kinds)
                raise ConfigError(f"{where}: only {wanted} can be simulated, got {type(device).__name__}")
            model, number = key_of(device)
            key = (model, number, module.encoder_pin if model == "CANdi" else None)
            if key in owners:
                raise ConfigError(
                    f"{where}: {model} id {number} is already {owners[key]}; simulated ids must differ across CAN "
                    "buses too"
                )
            owners[key] = where
