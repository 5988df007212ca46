"""CTRE's `Maker`: the Phoenix 6 devices TalonFX, TalonFXS, CANcoder and Pigeon 2, and CTRE's swerve drivetrain."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from phoenix6 import hardware
from phoenix6.phoenix_native import Native
from phoenix6.status_code import StatusCode

from simcore.errors import ConfigError
from simcore.quantities import DeviceAddress, DeviceKey
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import GuessedMechanism, ShaftSim, guessed_shaft
from simcore.robot_file.robot_settings import FILE_NAME, RobotSettings
from simcore.robotcode.makers.phoenix6 import swerve  # records drivetrains from this import on, before the robot
from simcore.robotcode.makers.phoenix6.built_devices import (
    DEVICES,
    MOTORS_OF_TALON_FXS,
    Feedback,
    feedback_of,
    key_of,
    require_distinct,
    talon_configuration,
    watch_simulations,
)
from simcore.robotcode.makers.phoenix6.candle_lights import candle_lights
from simcore.robotcode.makers.phoenix6.sensor_ports import CANcoderSim, CANdiEncoderSim, Pigeon2Sim, is_emulated
from simcore.robotcode.makers.phoenix6.talon_motor import MotorType, TalonFXMotorSim, TalonPort
from simcore.robotcode.program.drivetrain_measures import MODULE_MEASURES, complete_measures
from simcore.robotcode.program.found_drivetrain import FoundDrivetrain, FoundWheel, Measure
from simcore.robotcode.program.makers import LightsShown, Maker, MotorFacts, Mounting
from simcore.robotcode.program.motor_controllers import BuiltDevice, FollowerGroup, group_by_leader
from simcore.robotcode.program.motor_ports import AnglePort, GyroPort, MotorPort
from simcore.robotcode.program.program_odometry import watch_sets

__all__ = ["MAKER", "CtreDrivetrain"]

_SHOWN = 0.1  # [s], wait until all status frames are sent, which have 50 Hz or more
_MOST_VOLTS = 1.0  # [V], largest plausible kS or kG; larger gains are in amperes, for a torque-current loop


class CtreDrivetrain:
    """Drivetrain that CTRE's `SwerveDrivetrain` controls with its own loops; implements `MakersDrivetrain`.

    Args:
        drivetrain: `SwerveDrivetrain`, possibly of a derived class.
        settings: Settings of simcore.toml.
        folder: Folder of robot.py.

    Raises:
        ConfigError: The drivetrain's module constants are invalid.
    """

    def __init__(self, drivetrain: Any, settings: RobotSettings, folder: Path) -> None:
        self._drivetrain = drivetrain
        constants = swerve.module_constants(drivetrain)
        if len(constants) < 3:
            raise ConfigError(f"a swerve drivetrain has 3 modules or more (most have 4), got {len(constants)}")
        wheels = tuple(_wheel(k, m, c) for k, (m, c) in enumerate(zip(drivetrain.modules, constants, strict=True)))
        found = FoundDrivetrain(
            kind="swerve",
            wheels=wheels,
            gyro=None if drivetrain.pigeon2 is None else _ctre_device(drivetrain.pigeon2),
            measures=_measures(constants[0]),
            about=f"{type(drivetrain).__name__} with {len(wheels)} modules",
            drives_itself=True,
        )
        self.found = found = complete_measures(found, settings, folder)
        bumper = settings.with_bumper_around(found.places).bumper
        assert bumper is not None
        measures = {name: m.value for name, m in found.measures.items()}
        config = swerve.swerve_config(
            drivetrain,
            mass=measures.get("mass", settings.mass),
            bumper=bumper,
            height=settings.center_of_mass_height,
            wheel_cof=measures.get("wheel_cof", settings.wheel_cof),
            drive_motor=motor(measures["drive_motor"]),
            steer_motor=motor(measures["steer_motor"]),
        )
        file_values = {
            name: m.value for name, m in found.measures.items() if m.source == FILE_NAME and name in MODULE_MEASURES
        }
        self.config = replace(
            config,
            modules=tuple(replace(module, **file_values) for module in config.modules),
            yaw_inertia=measures.get("yaw_inertia", config.yaw_inertia),
        )

    def connect(self, drive: Any) -> swerve.SwerveDrivetrainSim:
        """Connect the drivetrain's devices to the swerve model `drive`, and return the ports."""
        return swerve.SwerveDrivetrainSim(self._drivetrain, drive)


def _ctre_device(made: Any) -> BuiltDevice:
    return BuiltDevice(*key_of(made), made)


def _wheel(k: int, module: Any, constants: Any) -> FoundWheel:
    encoder = module.encoder
    return FoundWheel(
        name=f"module {k}",
        place=(float(constants.location_x), float(constants.location_y)),
        motors=(_ctre_device(module.drive_motor),),
        steer=_ctre_device(module.steer_motor),
        encoder=_ctre_device(encoder) if isinstance(encoder, (hardware.CANcoder, hardware.CANdi)) else None,
    )


def _measures(constants: Any) -> dict[str, Measure]:
    source = "SwerveModuleConstants"
    found = {
        name: Measure(float(getattr(constants, key)), source)
        for name, key in (
            ("drive_gearing", "drive_motor_gear_ratio"),
            ("steer_gearing", "steer_motor_gear_ratio"),
            ("wheel_radius", "wheel_radius"),
        )
    }
    for role in ("drive", "steer"):
        found[f"{role}_motor"] = Measure(swerve.arranged_motor(constants, f"{role}_motor_type").name, source)
        found[f"{role}_loop"] = Measure("controller", source)
    return found


_WIRED = ("QUADRATURE", "PULSE_WIDTH")


@dataclass(frozen=True, slots=True, kw_only=True)
class Guess(GuessedMechanism):
    """Guessed mechanism of a group of Talons, with the settings that the connection needs."""

    inverted: bool
    """Whether the leader is configured as `CLOCKWISE_POSITIVE`."""
    feedback: Feedback


class _Ctre(Maker):
    name = "CTRE Phoenix 6"
    motors = ("TalonFX", "TalonFXS")
    encoders = ("CANcoder",)
    gyros = ("Pigeon2",)
    others = ("CANdi", "CANdle", "CANrange")
    sim_devices = ("(v6)",)

    def watch(self) -> None:
        watch_sets(hardware.Pigeon2, "set_yaw", "gyro's heading", StatusCode.OK)

    def watch_simulations(self, may_write: Callable[[DeviceKey], bool]) -> None:
        watch_simulations(may_write)

    def require_distinct(self) -> None:
        if not is_emulated():
            require_distinct()

    def lights(self) -> Mapping[str, LightsShown]:
        return {f"CANdle{at.number}{f'_{at.bus}' * bool(at.bus)}": lights for at, lights in candle_lights().items()}

    def groups(self, motors: Sequence[BuiltDevice]) -> list[FollowerGroup]:
        return group_by_leader(motors, _leader)

    def facts(self, motor: BuiltDevice) -> MotorFacts:
        config = talon_configuration(motor.hardware, motor.model)
        feedback, limits = feedback_of(config), config.current_limits
        sensor = (
            ("CANcoder", DeviceAddress(feedback.remote_id, motor.address.bus))
            if "CANCODER" in feedback.source
            else None
        )
        return MotorFacts(
            motor=_usual_motor(config),
            is_guess=_arrangement(config) not in MOTORS_OF_TALON_FXS,
            stator_limit=float(limits.stator_current_limit) if limits.stator_current_limit_enable else None,
            supply_limit=float(limits.supply_current_limit) if limits.supply_current_limit_enable else None,
            brakes=config.motor_output.neutral_mode.name == "BRAKE",
            units_per_rotor_turn=1.0 / feedback.ratio,
            sensor=sensor,
            rotor_per_sensor=None if sensor is None or feedback.rotor_per_sensor == 1.0 else feedback.rotor_per_sensor,
            has_gains=bool(config.slot0.k_p or config.slot0.k_v),
        )

    def motor_port(self, motor: BuiltDevice) -> MotorPort:
        return TalonPort(motor.hardware)

    def encoder_port(self, encoder: BuiltDevice, port: MotorPort | None = None) -> AnglePort:
        return CANcoderSim(encoder.hardware)

    def guess(self, group: FollowerGroup) -> Guess:
        """Guess the mechanism from the leader's configuration; the read takes 50 ms."""
        device = group.leader
        config = talon_configuration(device.hardware, device.model)
        feedback, gains, name = feedback_of(config), config.slot0, _usual_motor(config)
        gearbox = GearboxConfig(motor=motor(name), motors=len(group.devices), gearing=feedback.ratio)
        weight = _gain_volts(gearbox, gains.k_g)
        is_arm = gains.gravity_type.name == "ARM_COSINE" and weight > 0.0
        shaft = guessed_shaft(
            gearbox,
            static=_gain_volts(gearbox, gains.k_s),
            kv=gains.k_v,
            ka=gains.k_a,
            weight=weight,
            arm=_arm(device, config) if is_arm else None,
        )
        source, remote = feedback.source, DeviceAddress(feedback.remote_id, device.address.bus)
        sensors: tuple[DeviceKey, ...] = ()
        if "CANCODER" in source or ("CANDI" in source and "QUADRATURE" not in source):  # not simulated
            sensors = (("CANcoder" if "CANCODER" in source else "CANdi", remote),)
        is_clockwise = config.motor_output.inverted.name == "CLOCKWISE_POSITIVE"
        return Guess(
            mechanism=shaft,
            motor=name,
            sensors=sensors,
            has_wired_sensor=source in _WIRED,
            inverted=is_clockwise,
            feedback=feedback,
        )

    def connect(self, group: FollowerGroup, mechanism: ShaftSim, mounting: Mounting | None = None) -> TalonFXMotorSim:
        return _connected(group, mechanism, mounting or Mounting())

    def connect_guess(
        self, group: FollowerGroup, guess: GuessedMechanism, sensors: Sequence[BuiltDevice]
    ) -> TalonFXMotorSim:
        assert isinstance(guess, Guess)
        feedback, encoder = guess.feedback, None
        for sensor in sensors:
            made = sensor.hardware
            is_candi = sensor.model == "CANdi"
            encoder = CANdiEncoderSim(made, int(feedback.source[-1])) if is_candi else CANcoderSim(made)
        return _connected(
            group,
            guess.mechanism,
            Mounting(encoder=encoder, encoder_gearing=feedback.sensor_per_mechanism),
            inverted=guess.inverted,
            sensor_gearing=feedback.rotor_per_sensor if guess.has_wired_sensor else None,
        )

    def friction_volts(self, motor: BuiltDevice, gearbox: GearboxConfig) -> float:
        return abs(_gain_volts(gearbox, talon_configuration(motor.hardware, motor.model).slot0.k_s))

    def gyro_port(self, gyro: BuiltDevice) -> GyroPort:
        return Pigeon2Sim(gyro.hardware)

    def drivetrain(self, settings: RobotSettings, folder: Path) -> CtreDrivetrain | None:
        if not swerve.known_drivetrains():
            return None
        return CtreDrivetrain(swerve.only_drivetrain(), settings, folder)

    def settle(self) -> None:
        emulator: Any = getattr(Native.instance(), "emulator", None)
        if emulator is None:
            time.sleep(_SHOWN)
            return
        for device in 2 * [*emulator]:  # twice, because a motor controller reads the previous value of its encoder
            device.send_frame()


def _connected(group: FollowerGroup, mechanism: ShaftSim, mounting: Mounting, **known: Any) -> TalonFXMotorSim:
    """Connect Talons to a mechanism; `known` holds further arguments of `TalonFXMotorSim`."""
    is_small = group.leader.model == "TalonFX" and mounting.motor.startswith("Kraken X44")
    return TalonFXMotorSim(
        group.leader.hardware,
        mechanism,
        followers=[f.hardware for f in group.followers],
        opposed=group.opposed,
        reversed=mounting.reversed,
        zero_at=mechanism.position,
        motor_type=MotorType.KRAKEN_X44 if is_small else None,
        encoder=mounting.encoder,
        encoder_gearing=mounting.encoder_gearing,
        **known,
    )


def _leader(device: BuiltDevice) -> tuple[Any, bool]:
    """Return the leader's model and address, and whether the device turns opposite to the leader.

    The first value is None without a follower request. The function assumes that the leader is the same model as the
    device.
    """
    request = device.hardware.control_request
    leader = getattr(request, "leader_id", None) if request.name in ("Follower", "StrictFollower") else None
    is_opposed = getattr(getattr(request, "motor_alignment", None), "name", "ALIGNED") == "OPPOSED"
    return (None if leader is None else (device.model, DeviceAddress(leader, device.address.bus))), is_opposed


def _arrangement(config: Any) -> str:
    return str(config.commutation.motor_arrangement.name) if hasattr(config, "commutation") else ""


def _usual_motor(config: Any) -> str:
    """Return the motor in a TalonFXS configuration (NEO if unset), or a Kraken X60 FOC for a TalonFX."""
    return MOTORS_OF_TALON_FXS.get(_arrangement(config), "NEO") if hasattr(config, "commutation") else "Kraken X60 FOC"


def _arm(device: BuiltDevice, config: Any) -> tuple[float, float]:
    """Return the lower stop and current angle of an arm [rad], from the reverse soft limit and the position reading."""
    position = device.hardware.get_position()
    position.wait_for_update(0.1)
    start = device.hardware.get_position().value * math.tau
    limits = config.software_limit_switch
    low = limits.reverse_soft_limit_threshold * math.tau if limits.reverse_soft_limit_enable else start
    return min(low, start), start


def _gain_volts(gearbox: GearboxConfig, gain: float) -> float:
    """Return a kS or kG gain in volts; a gain above 1 counts as amperes, times the resistance."""
    return float(gain) if abs(gain) <= _MOST_VOLTS else float(gain) * gearbox.resistance


MAKER = _Ctre(DEVICES)
"""`Maker` of CTRE's devices, for `simcore.robotcode.program.makers`."""
