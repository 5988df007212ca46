"""Connection of CTRE's unmodified `SwerveDrivetrain` to simcore's swerve model.

The drivetrain object keeps its own control loops, odometry thread and pose estimate. As on a real robot, the inputs are
rotor positions, CANcoders and the Pigeon 2, never a pose.
"""

from __future__ import annotations

import functools
import logging
import math
import time
from collections.abc import Sequence
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from phoenix6.hardware import CANcoder, CANdi, Pigeon2, TalonFXS
from phoenix6.sim import ChassisReference
from phoenix6.swerve import SwerveDrivetrain, SwerveModule, SwerveModuleConstants

from simcore import season
from simcore.errors import ConfigError
from simcore.quantities import DeviceKey
from simcore.robot.dc_motor import MotorModel, motor
from simcore.robot.swerve_config import USUAL_FRICTION, SwerveConfig, SwerveModuleConfig
from simcore.robot.swerve_drive import SwerveDrive
from simcore.robot.wheel_config import MOST_FRICTION, plate_inertia
from simcore.robotcode.makers.phoenix6.built_devices import MOTORS_OF_TALON_FXS, key_of
from simcore.robotcode.makers.phoenix6.sensor_ports import CANcoderSim, CANdiEncoderSim, Pigeon2Sim, is_emulated
from simcore.robotcode.makers.phoenix6.talon_motor import TalonPort
from simcore.robotcode.program.motor_ports import AnglePort, SwervePorts
from simcore.robotcode.program.program_odometry import PoseReset, PoseResets, watch_sets
from simcore.robotcode.program.recorder import after_call, record_class
from simcore.typing import FloatArray

__all__ = [
    "SwerveDrivetrainSim",
    "arranged_motor",
    "known_drivetrains",
    "module_constants",
    "only_drivetrain",
    "swerve_config",
]


_log = logging.getLogger(__name__)

_CLOCKWISE = ChassisReference.CLOCKWISE_POSITIVE
_COUNTER_CLOCKWISE = ChassisReference.COUNTER_CLOCKWISE_POSITIVE

_SHOWN = 0.25  # [s], longest wait for a reading, which takes an encoder frame and a motor frame: 20 ms
_LEVEL = 1e-3  # [rotations], largest angle that counts as zero; the CANcoder rounds to 1/4096

_seen: WeakKeyDictionary[Any, list[Any]] = WeakKeyDictionary()


def _note_constants(drivetrain: Any, args: tuple[Any, ...], settings: dict[str, Any]) -> None:
    """Record the module constants of a drivetrain, which the drivetrain object does not expose."""
    for value in (*args, *settings.values()):
        if isinstance(value, (list, tuple)) and value and isinstance(value[0], SwerveModuleConstants):
            _seen[drivetrain] = list(value)


def _note_module(module: Any, args: tuple[Any, ...], settings: dict[str, Any]) -> None:
    """Set a module's steer encoder to zero, straight ahead, before odometry starts.

    A simulated encoder starts at zero plus its offset. Odometry takes its first sample within 4 ms, and would
    interpret the jump to the true angle as coupled travel of the wheel, up to 6 cm.
    """
    _show_straight_ahead(module, settings.get("constants", args[3] if len(args) > 3 else None))


def _show_straight_ahead(module: Any, constants: Any) -> None:
    _match_wired_encoder(module, constants)
    port = _azimuth(module, constants)
    if port is not None:
        port.write(0.0, 0.0)
    if is_emulated():
        return  # the emulator sends no frame before the first step
    until = time.monotonic() + _SHOWN
    position = module.steer_motor.get_position
    while abs(position().value) > _LEVEL and time.monotonic() < until:
        time.sleep(0.005)


def _azimuth(module: Any, c: Any) -> AnglePort | None:
    """Return the port of a module's steer CANcoder or CANdi; None for an encoder wired to the motor controller.

    Raises:
        ConfigError: The constants give no CANdi pin.
    """
    encoder, turned, offset = module.encoder, c.encoder_inverted, c.encoder_offset
    if isinstance(encoder, CANdi):
        return CANdiEncoderSim(encoder, _pin(c), inverted=turned, offset=offset)
    return CANcoderSim(encoder, inverted=turned, magnet_offset=offset) if isinstance(encoder, CANcoder) else None


def _pin(c: Any) -> int:
    """Return the CANdi pin of the steer encoder, or 0 without a CANdi."""
    name = str(getattr(getattr(c, "feedback_source", None), "name", ""))
    return int(name[-1]) if "CANDI_PWM" in name else 0


def _device_keys(modules: Sequence[tuple[Any, Any]], pigeon: Pigeon2 | None) -> tuple[DeviceKey, ...]:
    """List the keys of all devices of a drivetrain.

    Raises:
        ConfigError: Two modules share a device, which the simulation would move twice.
    """
    owners: dict[tuple[DeviceKey, int], str] = {}
    for k, (module, c) in enumerate(modules):
        for role in ("drive_motor", "steer_motor", "encoder"):
            device = getattr(module, role)
            if role == "encoder" and not isinstance(device, (CANcoder, CANdi)):
                continue  # the encoder is wired to the steer motor's controller
            model, address = key_of(device)
            key = (model, address), _pin(c) if model == "CANdi" else 0
            if key in owners:
                raise ConfigError(f"module {k} {role}: {model} {address} is already {owners[key]}")
            owners[key] = f"module {k} {role}"
    return (*dict.fromkeys(key for key, _ in owners), *(() if pigeon is None else (key_of(pigeon),)))


def _match_wired_encoder(module: Any, c: Any) -> None:
    """Set the simulated orientation and offset of an encoder wired to the steer motor's TalonFXS."""
    if isinstance(module.steer_motor, TalonFXS):
        state = module.steer_motor.sim_state
        is_turned = c.steer_motor_inverted != c.encoder_inverted
        state.ext_sensor_orientation = _CLOCKWISE if is_turned else _COUNTER_CLOCKWISE
        state.pulse_width_sensor_offset = c.encoder_offset


# physics.py is loaded before the robot object is built, so importing this module there is early enough
record_class(SwerveDrivetrain, _note_constants)
record_class(SwerveModule, _note_module)


_RESETS = PoseResets()
"""Record of the pose resets that robot code makes on all drivetrains."""


def _heading(drivetrain: Any, rotation: Any = None) -> float:
    """Return the heading that `seed_field_centric` sets [rad]."""
    turn = 0.0 if rotation is None else float(rotation.radians())
    return turn + float(drivetrain.get_operator_forward_direction().radians())


_MEANINGS: dict[str, Any] = {
    "reset_pose": lambda drivetrain, pose: ((float(pose.x), float(pose.y)), float(pose.rotation().radians())),
    "reset_translation": lambda drivetrain, place: ((float(place.x), float(place.y)), None),
    "reset_rotation": lambda drivetrain, rotation: (None, float(rotation.radians())),
    "seed_field_centric": lambda drivetrain, rotation=None: (None, _heading(drivetrain, rotation)),
}
"""Position [m, m] and heading [rad] set by each method's arguments; None for an unchanged part."""


def _noting(meaning: Any) -> Any:
    def note(drivetrain: Any, _: Any, args: tuple[Any, ...], settings: dict[str, Any]) -> None:
        _RESETS.note(drivetrain, meaning(drivetrain, *args, **settings))

    return note


for _method, _meaning in _MEANINGS.items():
    after_call(SwerveDrivetrain, _method, _noting(_meaning))
    if _method.startswith("reset"):
        watch_sets(SwerveDrivetrain, _method, "pose")


def module_constants(drivetrain: Any) -> list[Any]:
    """Return the `SwerveModuleConstants` of a drivetrain, in module order.

    Raises:
        ConfigError: The drivetrain was built before this module was imported.
    """
    if drivetrain not in _seen:
        raise ConfigError(
            f"the constants of {type(drivetrain).__name__} are not known: write `from simcore import swerve_config` at "
            "the top of physics.py, before the drivetrain is built, or pass modules=[TunerConstants.front_left, ...]"
        )
    return _seen[drivetrain]


def known_drivetrains() -> list[Any]:
    """List all drivetrains that the program has built."""
    return list(_seen)


def only_drivetrain() -> Any:
    """Return the drivetrain that the program has built, or the last of several on the same devices.

    Raises:
        ConfigError: The program has built no drivetrain, or drivetrains on different devices.
    """
    found = known_drivetrains()
    if found and len(_of_same_devices(found[-1])) == len(found):
        return found[-1]
    if len(found) != 1:
        raise ConfigError(
            f"there must be one phoenix6.swerve.SwerveDrivetrain after robotInit, got {len(found)}"
            + (f": {[type(d).__name__ for d in found]}" if found else "; without one, write a physics.py")
        )
    return found[0]


def _of_same_devices(drivetrain: Any) -> list[Any]:
    """List the drivetrains with the same motors as `drivetrain`, including `drivetrain`, in build order."""
    own_keys = _motor_keys(drivetrain)
    return [other for other in known_drivetrains() if _motor_keys(other) == own_keys]


def _motor_keys(drivetrain: Any) -> set[DeviceKey]:
    return {key_of(motor) for module in drivetrain.modules for motor in (module.drive_motor, module.steer_motor)}


def swerve_config(
    drivetrain: Any,
    *,
    modules: Sequence[Any] | None = None,
    mass: float = 55.0,
    bumper: tuple[float, float] = (0.8, 0.8),
    height: float = 0.2,
    wheel_cof: float = 1.2,
    drive_motor: MotorModel | None = None,
    steer_motor: MotorModel | None = None,
) -> SwerveConfig:
    """Return the model configuration of a drivetrain from its `SwerveModuleConstants`.

    The constants give module positions, gear ratios, coupling, wheel radius, motors and current limits. The function
    ignores inertias and friction voltages on purpose: Tuner X fills these constants with placeholders (0.01 kg m^2,
    0.2 V) that describe no real robot. Mass and bumper size are not part of the constants.

    Args:
        drivetrain: `SwerveDrivetrain`, possibly of a derived class.
        modules: Module constants in module order; None for `module_constants`, which needs an early import.
        mass: Mass with bumpers and battery [kg].
        bumper: Length and width over the bumpers [m], for the yaw inertia.
        height: Height of the center of mass [m].
        wheel_cof: Coefficient of friction of the wheels on carpet [-].
        drive_motor: Drive motor; None for the motor in the constants, where `TALON_FX_INTEGRATED` is a Kraken X60 with
            FOC.
        steer_motor: Steer motor; None for the motor in the constants.

    Raises:
        ConfigError: A constant is missing or invalid; the message names the module.
    """
    constants = module_constants(drivetrain) if modules is None else modules
    return SwerveConfig(
        modules=tuple(_module(k, c, wheel_cof, drive_motor, steer_motor) for k, c in enumerate(constants)),
        mass=mass,
        yaw_inertia=plate_inertia(mass, *bumper),
        center_of_mass=(0.0, 0.0, height),
    )


def _module(
    k: int, constants: object, wheel_cof: float, drive_motor: MotorModel | None, steer_motor: MotorModel | None
) -> SwerveModuleConfig:
    owner = f"module {k}"

    def number(name: str) -> float:
        value = getattr(constants, name, None)
        if not isinstance(value, (int, float)) or not math.isfinite(value):
            raise ConfigError(f"{owner}: CTRE constants need a finite {name}, got {value!r}")
        return float(value)

    drive = getattr(constants, "drive_motor_initial_configs", None)
    steer = getattr(constants, "steer_motor_initial_configs", None)
    slip_current = getattr(constants, "slip_current", None)
    stator, supply = _limits(drive)
    # CTRE applies the slip current as the stator current limit of the drive motors.
    if isinstance(slip_current, (int, float)) and slip_current > 0.0:
        stator = float(slip_current) if stator is None else min(stator, float(slip_current))
    steer_stator, steer_supply = _limits(steer)
    model = drive_motor or arranged_motor(constants, "drive_motor_type")
    return SwerveModuleConfig(
        name=owner,
        x=number("location_x"),
        y=number("location_y"),
        drive_motor=model,
        drive_friction_volts=_friction(constants, model),
        steer_motor=steer_motor or arranged_motor(constants, "steer_motor_type"),
        drive_gearing=number("drive_motor_gear_ratio"),
        steer_gearing=number("steer_motor_gear_ratio"),
        coupling_ratio=number("coupling_gear_ratio"),
        wheel_radius=number("wheel_radius"),
        wheel_cof=wheel_cof,
        drive_stator_limit=stator,
        drive_supply_limit=supply,
        steer_stator_limit=steer_stator,
        steer_supply_limit=steer_supply,
    )


def _friction(constants: object, drive_motor: MotorModel) -> float:
    """Return a module's drive friction [V] from the kS drive gain (V or A); `USUAL_FRICTION` without a plausible kS."""
    ks = getattr(getattr(constants, "drive_motor_gains", None), "k_s", 0.0)
    if not isinstance(ks, (int, float)) or not math.isfinite(ks) or ks == 0.0:
        return USUAL_FRICTION
    output = str(getattr(getattr(constants, "drive_motor_closed_loop_output", None), "name", ""))
    volts = abs(float(ks)) * (drive_motor.winding_resistance if "TORQUE" in output else 1.0)
    return volts if volts < MOST_FRICTION else USUAL_FRICTION


def arranged_motor(constants: object, name: str) -> MotorModel:
    """Return the motor model for the motor arrangement in CTRE's module constants; the default is a Kraken X60 FOC.

    Args:
        constants: Constants of one module.
        name: Name of the constant: `drive_motor_type` or `steer_motor_type`.
    """
    kind = str(getattr(getattr(constants, name, None), "name", ""))
    # the constants do not distinguish a Falcon from the Krakens, or one brushed motor from another
    other = "CIM" if "BRUSHED" in kind else "Kraken X60 FOC"
    return motor(MOTORS_OF_TALON_FXS.get(kind.removeprefix("TALON_FXS_"), other))


def _limits(configs: object) -> tuple[float | None, float | None]:
    """Return the stator and supply current limits [A]: infinite if disabled, None without a configuration."""
    limits = getattr(configs, "current_limits", None)
    if limits is None:
        return None, None

    def one(kind: str) -> float:
        value = getattr(limits, f"{kind}_current_limit", None)
        enabled = getattr(limits, f"{kind}_current_limit_enable", False)
        return float(value) if enabled and isinstance(value, (int, float)) and value > 0.0 else math.inf

    return one("stator"), one("supply")


class SwerveDrivetrainSim(SwervePorts):
    """Devices of a CTRE swerve drivetrain: the motors' volts drive the model, whose motion sets the sensors.

    The constructor replaces `update_sim_state` of the drivetrain with an empty function. Tuner X's class calls this
    method from a 250 Hz Notifier, but physics alone must step the model.

    Args:
        drivetrain: `SwerveDrivetrain`, possibly of a derived class.
        drive: Model of the drivetrain, which the caller steps with the chassis.
        modules: Module constants in module order; None for `module_constants`, which needs an early import.

    Raises:
        ConfigError: The number of modules differs from the number in the model, or two modules share a device.
    """

    def __init__(self, drivetrain: Any, drive: SwerveDrive, *, modules: Sequence[Any] | None = None) -> None:
        constants = module_constants(drivetrain) if modules is None else list(modules)
        if not len(constants) == len(drivetrain.modules) == len(drive.config.modules):
            raise ConfigError(
                f"swerve: {len(drivetrain.modules)} modules in the drivetrain, {len(constants)} constants and "
                f"{len(drive.config.modules)} in the model; the numbers must be equal"
            )
        pairs = list(zip(drivetrain.modules, constants, strict=True))
        devices = _device_keys(pairs, drivetrain.pigeon2)
        gearings = [module.steer_gearing for module in drive.config.modules]
        super().__init__(
            drive,
            [TalonPort(m.drive_motor, clockwise=c.drive_motor_inverted) for m, c in pairs],
            [
                TalonPort(m.steer_motor, clockwise=c.steer_motor_inverted, sensor_gearing=gearing)
                for (m, c), gearing in zip(pairs, gearings, strict=True)
            ],
            steer_encoders=[_azimuth(m, c) for m, c in pairs],
            gyro=None if drivetrain.pigeon2 is None else Pigeon2Sim(drivetrain.pigeon2),
        )
        self.devices = devices
        for module, c in pairs:
            _match_wired_encoder(module, c)
        self._drivetrain = drivetrain
        self._twins = _of_same_devices(drivetrain) or [drivetrain]
        for twin in self._twins:
            twin.update_sim_state = _do_nothing
            _stop_stepping(twin)
        if len(self._twins) > 1:
            _log.warning(
                "the program builds %d drivetrains on the same devices (%s): on the real robot, too, each would "
                "command the motors against the others; build one, and pass it on",
                *(len(self._twins), ", ".join(type(twin).__name__ for twin in self._twins)),
            )
        _log.info("swerve: %d modules; physics owns their simulation", len(constants))

    def on_pose_reset(self, tell: PoseReset) -> None:
        """Call `tell` for the latest pose resets by robot code at once, and for each later reset."""
        for twin in self._twins:
            _RESETS.listen(twin, functools.partial(self._note_reset, twin, tell))

    def _note_reset(self, twin: Any, tell: PoseReset, *pose: Any) -> None:
        self._drivetrain = twin  # the drivetrain that was reset holds the pose estimate in use
        tell(*pose)

    def module_setpoints(self) -> FloatArray:
        """Return the latest module targets: speed [m/s] and angle [rad], shape (n, 2)."""
        targets: Any = self._drivetrain.get_state().module_targets
        return np.array([(season.module_speed(one), one.angle.radians()) for one in targets])

    def estimated_pose(self) -> tuple[float, float, float]:
        """Return the drivetrain's estimated pose in the field frame [m, m, rad]."""
        pose = self._drivetrain.get_state().pose
        return pose.x, pose.y, pose.rotation().radians()


def _stop_stepping(drivetrain: Any) -> None:
    """With the emulator, stop the simulation Notifier of Tuner X's class, since `update_sim_state` is empty."""
    notifier: Any = getattr(drivetrain, "_sim_notifier", None)
    if is_emulated() and hasattr(notifier, "stop"):
        notifier.stop()


def _do_nothing(dt: float, supply_voltage: float) -> None:
    """Ignore a call of `update_sim_state`, because physics steps the model."""
