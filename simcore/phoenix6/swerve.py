"""CTRE's `SwerveDrivetrain`, unmodified, on simcore's swerve model.

The drivetrain object keeps its own control loops, odometry thread and pose estimate. It is fed the way the robot feeds
it: rotor positions, CANcoders and the Pigeon 2. Nothing here ever hands it a pose.
"""

from __future__ import annotations

import functools
import logging
import math
from collections.abc import Sequence
from typing import Any
from weakref import WeakKeyDictionary

from phoenix6.hardware import CANcoder, TalonFX
from phoenix6.swerve import SwerveDrivetrain, SwerveModuleConstants

from simcore.drivetrain.config import SwerveConfig
from simcore.drivetrain.motor import MotorModel
from simcore.drivetrain.swerve import SwerveDrive
from simcore.errors import ConfigError
from simcore.phoenix6.cancoder import CANcoderSim
from simcore.phoenix6.pigeon import Pigeon2Sim
from simcore.phoenix6.talon import TalonPort

__all__ = ["SwerveDrivetrainSim", "module_constants", "remember_module_constants", "swerve_config"]

_log = logging.getLogger(__name__)

_seen: WeakKeyDictionary[Any, list[Any]] = WeakKeyDictionary()


def remember_module_constants() -> None:
    """Note the module constants of every drivetrain built from now on; the drivetrain itself does not show them.

    Runs once when this module is imported. `physics.py` is loaded before the robot object is built, so an import there
    is early enough; robot code stays as it is.
    """
    build = SwerveDrivetrain.__init__
    if getattr(build, "_notes_constants", False):
        return

    @functools.wraps(build)
    def init(self: Any, *args: Any, **kwargs: Any) -> None:
        build(self, *args, **kwargs)
        for value in (*args, *kwargs.values()):
            if isinstance(value, (list, tuple)) and value and isinstance(value[0], SwerveModuleConstants):
                _seen[self] = list(value)

    init._notes_constants = True  # type: ignore[attr-defined]
    SwerveDrivetrain.__init__ = init  # type: ignore[method-assign]


remember_module_constants()


def module_constants(drivetrain: Any) -> list[Any]:
    """The `SwerveModuleConstants` that a drivetrain was built with, in its order.

    Raises:
        ConfigError: It was built before this module was imported.
    """
    if drivetrain not in _seen:
        raise ConfigError(
            f"the constants of {type(drivetrain).__name__} are not known: import simcore.phoenix6.swerve at the top of "
            "physics.py, before the drivetrain is built, or pass modules=[TunerConstants.front_left, ...]"
        )
    return _seen[drivetrain]


def swerve_config(
    drivetrain: Any,
    *,
    modules: Sequence[Any] | None = None,
    mass: float = 55.0,
    bumper: tuple[float, float] = (0.8, 0.8),
    height: float = 0.2,
    tread: float = 1.2,
    drive_motor: MotorModel | None = None,
    steer_motor: MotorModel | None = None,
) -> SwerveConfig:
    """The plant that a drivetrain's constants describe; mass and bumpers are nowhere in them.

    Args:
        drivetrain: A `SwerveDrivetrain`, of whatever class.
        modules: Its constants, if it was built too early for `module_constants`.
        mass: With bumpers and battery [kg].
        bumper: Length and width [m].
        height: Of the center of mass [m].
        tread: Coefficient of friction [-].
        drive_motor: Where a TalonFX is not a Kraken X60.
        steer_motor: The same for the azimuths.

    Raises:
        ConfigError: A constant is missing or makes no sense.
    """
    return SwerveConfig.from_ctre(
        module_constants(drivetrain) if modules is None else modules,
        mass=mass,
        bumper=bumper,
        height=height,
        tread=tread,
        drive_motor=drive_motor,
        steer_motor=steer_motor,
    )


class SwerveDrivetrainSim:
    """Moves volts from the drivetrain's TalonFX to the model, and the model's motion to their sensors.

    Takes the place of `update_sim_state`: whoever calls that (the generated class does so from a Notifier, 250 times a
    second) now calls nothing, so the model is stepped exactly once.

    Args:
        drivetrain: A `SwerveDrivetrain`, of whatever class.
        drive: The model of the same robot; its owner steps it with the chassis.
        modules: Constants, if the drivetrain was built too early for `module_constants`.

    Raises:
        ConfigError: Another number of modules than the model has; a module that is not TalonFX, TalonFX and CANcoder;
            two devices of a kind with one id (the device simulation would make them one).
    """

    def __init__(self, drivetrain: Any, drive: SwerveDrive, *, modules: Sequence[Any] | None = None) -> None:
        constants = module_constants(drivetrain) if modules is None else list(modules)
        if not len(constants) == len(drivetrain.modules) == len(drive.config.modules):
            raise ConfigError(
                f"swerve: {len(drivetrain.modules)} modules in the drivetrain, {len(constants)} constants and "
                f"{len(drive.config.modules)} in the model; want the same number"
            )
        _check_devices(drivetrain.modules)
        self._drive = drive
        self._drive_ports: list[TalonPort] = []
        self._steer_ports: list[TalonPort] = []
        self._encoders: list[CANcoderSim] = []
        for module, c in zip(drivetrain.modules, constants, strict=True):
            self._drive_ports.append(TalonPort(module.drive_motor, clockwise=c.drive_motor_inverted))
            self._steer_ports.append(TalonPort(module.steer_motor, clockwise=c.steer_motor_inverted))
            self._encoders.append(
                CANcoderSim(module.encoder, inverted=c.encoder_inverted, magnet_offset=c.encoder_offset)
            )
        self._pigeon = Pigeon2Sim(drivetrain.pigeon2)
        self._per_volt = [(1.0 / m.drive_motor.kv, 1.0 / m.steer_motor.kv) for m in drive.config.modules]
        self._yaw_at_start: float | None = None
        drivetrain.update_sim_state = _owned_by_physics
        _log.info("swerve: %d modules; physics owns their simulation", len(constants))

    def read(self, battery_voltage: float) -> None:
        """Give the devices their supply [V] and the model their volts."""
        for port in (*self._drive_ports, *self._steer_ports):
            port.set_supply(battery_voltage)
        state = self._drive.state
        drive, steer = [], []
        for k, m in enumerate(self._drive.config.modules):
            per_drive, per_steer = self._per_volt[k]
            rotor = m.drive_gearing * state.wheel_speed[k] + m.coupling_ratio * state.steer_speed[k]
            drive.append(_terminal_volts(self._drive_ports[k], rotor * per_drive))
            steer.append(_terminal_volts(self._steer_ports[k], m.steer_gearing * state.steer_speed[k] * per_steer))
        self._drive.set_volts(drive, steer)

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """Give the sensors what the model did.

        Args:
            yaw: Of the gyro, continuous over turns; where it starts is where the Pigeon reads zero [rad].
            pitch: [rad]
            roll: [rad]
            rates: About the robot's axes [rad/s], shape (3,).
        """
        state = self._drive.state
        turn = math.tau
        for k, m in enumerate(self._drive.config.modules):
            wheel, azimuth = state.wheel_angle[k], state.steer_angle[k]
            wheel_rate, azimuth_rate = state.wheel_speed[k], state.steer_speed[k]
            self._drive_ports[k].write(
                (wheel * m.drive_gearing + azimuth * m.coupling_ratio) / turn,
                (wheel_rate * m.drive_gearing + azimuth_rate * m.coupling_ratio) / turn,
            )
            self._steer_ports[k].write(azimuth * m.steer_gearing / turn, azimuth_rate * m.steer_gearing / turn)
            self._encoders[k].write(azimuth, azimuth_rate)
        if self._yaw_at_start is None:
            self._yaw_at_start = yaw
        self._pigeon.write(yaw - self._yaw_at_start, pitch, roll, rates)


def _terminal_volts(port: TalonPort, back_emf: float) -> float:
    """Volts at the motor [V]; an open circuit carries no current, as at exactly its back-EMF."""
    volts = port.volts()
    return back_emf if port.is_open(volts) else volts


def _owned_by_physics(dt: float, supply_voltage: float) -> None:
    """Stands in for `update_sim_state`."""


def _check_devices(modules: Sequence[Any]) -> None:
    talons: dict[int, str] = {}
    encoders: dict[int, str] = {}
    for k, module in enumerate(modules):
        for role, kind, ids in (
            ("drive_motor", TalonFX, talons),
            ("steer_motor", TalonFX, talons),
            ("encoder", CANcoder, encoders),
        ):
            device = getattr(module, role)
            where = f"module {k} {role}"
            if not isinstance(device, kind):
                raise ConfigError(f"{where}: only {kind.__name__} can be simulated so far, got {type(device).__name__}")
            if device.device_id in ids:
                raise ConfigError(
                    f"{where}: {kind.__name__} id {device.device_id} is already {ids[device.device_id]}; simulated ids "
                    "must differ across CAN buses too"
                )
            ids[device.device_id] = where
