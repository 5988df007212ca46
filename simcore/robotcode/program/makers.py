"""Makers of motor controllers, encoders and gyros, and the connection of a program's devices to the models.

To add a maker, derive a class from `Maker` in the maker's own package (for example `makers/navx/navx_maker.py`), list
the models and override the methods that apply. `watch` records the maker's classes in `devices`; for a maker that only
has gyros, `watch` and `gyro_port` are enough. Assign an instance to `MAKER` in the new module, and add the module to
`MAKER_MODULES` here, with the Python package that the module needs. The rest of simcore does not depend on makers.

A port passes the model's motion to robot code, and robot code's requests to the model. Derive the port of a motor
controller from `MotorPort`, and implement `AnglePort` for an encoder and `GyroPort` for a gyro; all three are in
`motor_ports`.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Protocol

from simcore.errors import ConfigError
from simcore.quantities import DeviceAddress, DeviceKey
from simcore.robot.fixed_wheel_config import MecanumConfig, TankConfig
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import GuessedMechanism, ShaftSim
from simcore.robot.swerve_config import SwerveConfig
from simcore.robot_file.drivetrain_table import NO_PHOENIX_5
from simcore.robot_file.robot_settings import RobotSettings
from simcore.robotcode.program.found_drivetrain import FoundDrivetrain
from simcore.robotcode.program.import_watch import after_import, refuse_import
from simcore.robotcode.program.motor_controllers import BuiltDevice, FollowerGroup
from simcore.robotcode.program.motor_ports import AnglePort, GyroPort, MotorDevices, MotorPort
from simcore.robotcode.program.recorder import BuiltDevices, watch_program
from simcore.typing import IntArray

__all__ = [
    "MAKER_MODULES",
    "LightsShown",
    "Maker",
    "MakersDrivetrain",
    "MotorFacts",
    "Mounting",
    "device_of",
    "find_device",
    "installed_makers",
    "known_device",
    "maker_of",
    "makers",
    "require_distinct_devices",
    "watch_makers",
]

MAKER_MODULES: list[tuple[str, str]] = [
    ("phoenix6", "simcore.robotcode.makers.phoenix6.ctre_maker"),
    ("rev", "simcore.robotcode.makers.revlib.rev_maker"),
    ("navx", "simcore.robotcode.makers.navx.navx_maker"),
    ("wpilib", "simcore.robotcode.sim.wpilib_ports"),
]
"""Python package of each maker, and the simcore module that defines `MAKER`, in order of preference."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorFacts:
    """Motor controller settings that a drivetrain model needs."""

    motor: str
    """Motor name, one of `simcore.robot.dc_motor.MOTOR_NAMES`."""
    is_guess: bool = True
    """Whether `motor` is a guess from the controller's model, and not configured in robot code."""
    stator_limit: float | None = None
    """Stator current limit [A]; None for the factory default."""
    supply_limit: float | None = None
    """Supply current limit [A]; None for the factory default."""
    brakes: bool = True
    """Whether the neutral mode is brake instead of coast."""
    units_per_rotor_turn: float = 1.0
    """Change of the position reading per rotor turn, in robot code's units; 1 if the controller has no encoder."""
    sensor: DeviceKey | None = None
    """Key of the encoder that closes the loop; the controller's key for a wired encoder, None for the rotor sensor."""
    rotor_per_sensor: float | None = None
    """Rotor turns per turn of `sensor` [-]; None if not configured."""
    has_gains: bool = False
    """Whether the controller's slot 0 has a P or velocity gain; if not, simcore assumes a loop in robot code."""
    free_speed_volts: float | None = None
    """Velocity feedforward voltage at the motor's free speed [V], about 12 if correct; None if not configured."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Mounting:
    """Properties of the motors and the encoder of a mechanism that no device configuration contains."""

    reversed: bool = False
    """Whether positive output in robot code moves the mechanism in the negative direction."""
    encoder: AnglePort | None = None
    """Port of a separate encoder on the mechanism; None without a separate encoder."""
    encoder_gearing: float = 1.0
    """Turns of `encoder`, or of an encoder wired to the leader, per turn of the mechanism [-]."""
    motor: str = ""
    """Motor name, one of `simcore.robot.dc_motor.MOTOR_NAMES`; empty for the configured motor."""


class MakersDrivetrain(Protocol):
    """Drivetrain whose devices, measures and model configuration are known."""

    @property
    def found(self) -> FoundDrivetrain:
        """Wheels, devices and measures of the drivetrain."""
        ...

    @property
    def config(self) -> SwerveConfig | TankConfig | MecanumConfig:
        """Configuration of the drivetrain's model."""
        ...

    def connect(self, drive: Any) -> Any:
        """Connect the devices to the model `drive`; return ports with `read`, `write` and `devices`."""
        ...


class LightsShown(Protocol):
    """LED state of a controller, as requested by robot code."""

    changes: int
    """Number of requests so far that have changed the lights."""

    @property
    def colors(self) -> IntArray:
        """Color of each LED as 0xRRGGBB, shape (n,)."""
        ...

    @property
    def shows(self) -> str:
        """Text that describes the active requests."""
        ...


class Maker:
    """Devices of one maker; a subclass overrides the members that apply to the maker's products.

    Methods that query a device raise `ConfigError` if the device does not respond.
    """

    name: str = ""
    """Name of the maker in the documentation."""
    motors: tuple[str, ...] = ()
    """Models of motor controllers, as named in simcore.toml."""
    encoders: tuple[str, ...] = ()
    """Models of stand-alone encoders."""
    pulse_encoders: tuple[str, ...] = ()
    """Models of encoders whose pulses per turn are set only in robot code."""
    gyros: tuple[str, ...] = ()
    """Models of gyros, as named in simcore.toml."""
    others: tuple[str, ...] = ()
    """Models of devices outside the drivetrain: game piece sensors, lights."""
    unserved: tuple[str, ...] = ()
    """Classes of the maker's package that simcore does not simulate."""
    sim_devices: tuple[str, ...] = ()
    """Substrings of the names of WPILib SimDevices that simcore simulates."""
    gyro_errors: str = "pigeon2"
    """Error model of the maker's gyros, one of `simcore.robot.gyro.GYROS`."""
    on_ports: bool = False
    """Whether motors and encoders are wired to roboRIO ports; simcore guesses no mechanism for these motors."""

    def __init__(self, devices: BuiltDevices | None = None) -> None:
        self.devices = BuiltDevices() if devices is None else devices
        """Record of the maker's devices that the program has built."""

    def watch(self) -> None:
        """Record devices that the program builds from now on; safe to call more than once."""

    def watch_simulations(self, may_write: Callable[[DeviceKey], bool]) -> None:
        """Check each write of a team's own simulation to a device with `may_write`; safe to call more than once.

        Args:
            may_write: Function that takes model and address, and returns whether the write may pass: False for a
                device that simcore's physics writes.
        """

    def built(self) -> list[BuiltDevice]:
        """Return the devices that the program has built, including sensors and lights, one per model and address."""
        return self.devices.devices()

    def device_of(self, made: Any) -> BuiltDevice | None:
        """Return the device behind an object of robot code, or None if the object is not a device of this maker."""
        return self.devices.find(made)

    def require_distinct(self) -> None:
        """Check that the maker's simulation distinguishes all devices.

        Raises:
            ConfigError: Two devices share one simulated state.
        """

    def lights(self) -> Mapping[str, LightsShown]:
        """Return the state of the maker's LED controllers, by device name."""
        return {}

    # --- motor controllers ----------------------------------------------------------------------------------------

    def groups(self, motors: Sequence[BuiltDevice]) -> list[FollowerGroup]:
        """Group motors by the configured leader; a motor without leader and followers forms its own group."""
        return [FollowerGroup(motor) for motor in motors]

    def has_wheel_encoder(self, motor: BuiltDevice) -> bool:
        """Return whether a motor controller reads an encoder on the wheel instead of a rotor sensor."""
        return False

    def facts(self, motor: BuiltDevice) -> MotorFacts:
        """Return the settings of a motor controller that a drivetrain model needs."""
        raise ConfigError(f"{motor} is not a motor controller")

    def motor_port(self, motor: BuiltDevice) -> MotorPort:
        """Return the port of a motor controller, with robot code's signs."""
        raise ConfigError(f"{motor} is not a motor controller")

    def guess(self, group: FollowerGroup) -> GuessedMechanism:
        """Return the most likely mechanism of motors that simcore.toml does not describe."""
        raise ConfigError(f"the configuration of {group} does not say what it turns")

    def connect(self, group: FollowerGroup, mechanism: ShaftSim, mounting: Mounting | None = None) -> MotorDevices:
        """Connect motors to a mechanism, and return the connected devices.

        Args:
            group: Leader and followers.
            mechanism: Mechanism that the motors turn.
            mounting: Mounting of the motors; None for the defaults of `Mounting`.
        """
        raise ConfigError(f"{group} is not a motor controller on CAN")

    def connect_guess(
        self, group: FollowerGroup, guess: GuessedMechanism, sensors: Sequence[BuiltDevice]
    ) -> MotorDevices:
        """Connect motors to a guessed mechanism, and return the connected devices.

        Args:
            group: Leader and followers.
            guess: Mechanism from the maker's `guess`.
            sensors: Sensors of the guessed mechanism that the program has built and that nothing else writes.
        """
        return self.connect(group, guess.mechanism)

    def friction_volts(self, motor: BuiltDevice, gearbox: GearboxConfig) -> float:
        """Return the kS configured in a controller [V], or 0 without a kS."""
        return 0.0

    # --- sensors, and drivetrains of libraries --------------------------------------------------------------------

    def encoder_port(self, encoder: BuiltDevice, port: MotorPort | None = None) -> AnglePort:
        """Return the port of an encoder; robot code reads the angle written to the port, 2 pi per turn.

        Args:
            encoder: Encoder of this maker, or a motor controller with an encoder wired to it.
            port: Port of the motor controller, if `encoder` is one.
        """
        raise ConfigError(f"{encoder} has no encoder that simcore simulates")

    def gyro_port(self, gyro: BuiltDevice) -> GyroPort:
        """Return the port of a gyro, for the rotation since power-on, counter-clockwise positive."""
        raise ConfigError(f"{gyro} is not a gyro that simcore simulates")

    def drivetrain(self, settings: RobotSettings, folder: Path) -> MakersDrivetrain | None:
        """Return the drivetrain that the maker's library controls, such as CTRE's `SwerveDrivetrain`.

        The result is None if the program has no such drivetrain.

        Args:
            settings: Settings of simcore.toml.
            folder: Folder of robot.py.

        Raises:
            ConfigError: The drivetrain constants are inconsistent.
        """
        return None

    def settle(self) -> None:
        """Make written values visible to robot code before the first loop."""


@cache
def _maker(module: str) -> Maker:
    maker = importlib.import_module(module).MAKER
    assert isinstance(maker, Maker), module
    return maker


def makers() -> list[Maker]:
    """Return the makers whose packages the program has imported."""
    return [_maker(module) for package, module in MAKER_MODULES if package in sys.modules]


def installed_makers() -> list[Maker]:
    """Load and return every maker whose package is installed."""
    return [_maker(module) for package, module in MAKER_MODULES if find_spec(package) is not None]


def watch_makers(may_write: Callable[[DeviceKey], bool] | None = None) -> None:
    """Record devices of every maker and objects of WPILib from now on; call this function before the program's import.

    Watching of a maker's package begins when the program imports the package, so unused packages are not loaded. An
    import of `phoenix5` raises a `VendorError`.

    Args:
        may_write: Check of `Maker.watch_simulations`; None to allow every write.
    """
    watch_program()
    refuse_import("phoenix5", NO_PHOENIX_5)
    for package, module in MAKER_MODULES:
        after_import(package, partial(_watch, module, may_write))


def _watch(module: str, may_write: Callable[[DeviceKey], bool] | None, _: Any) -> None:
    maker = _maker(module)
    maker.watch()
    if may_write is not None:
        maker.watch_simulations(may_write)


def require_distinct_devices() -> None:
    """Check that the makers' simulations distinguish all devices that the program has built.

    Raises:
        ConfigError: Two devices share one simulated state.
    """
    for maker in makers():
        maker.require_distinct()


def maker_of(device: BuiltDevice) -> Maker:
    """Return the maker of a device.

    Raises:
        ConfigError: The program has not imported the package of the device's maker.
    """
    for maker in makers():
        if device.model in (*maker.motors, *maker.encoders, *maker.gyros, *maker.others):
            return maker
    raise ConfigError(f"{device}: the program does not import its maker's package")


def device_of(made: Any) -> BuiltDevice | None:
    """Return the device behind an object of robot code, or None if the object is unknown."""
    for maker in makers():
        device = maker.device_of(made)
        if device is not None:
            return device
    return None


def known_device(made: Any) -> BuiltDevice:
    """Return the device behind an object of robot code; raise an error for an unknown object.

    Raises:
        ConfigError: The object was built before simcore was loaded.
    """
    device = made if isinstance(made, BuiltDevice) else device_of(made)
    if device is None:
        raise ConfigError(
            f"{type(made).__name__}: built before simcore was loaded; call "
            "simcore.robotcode.program.makers.watch_makers() at the top of physics.py"
        )
    return device


def find_device(where: str, models: str | Sequence[str], address: DeviceAddress) -> BuiltDevice:
    """Return a device that the program has built, by model and address.

    Args:
        where: Part of simcore.toml that names the device, for messages.
        models: Model name, or alternatives in order of preference.
        address: Address of the device; the bus may be omitted if the number is unique across buses.

    Raises:
        ConfigError: The program has built no such device, or the maker's library is not installed.
    """
    first, *more = (models,) if isinstance(models, str) else models
    if first.startswith("SPARK") and find_spec("rev") is None:
        raise ConfigError(f"{where}: a {first} needs REVLib, which is not installed: pip install robotpy-rev")
    built = {device.key: device for maker in makers() for device in reversed(maker.built())}
    for model in (first, *more):
        key = model, address.among(at for m, at in built if m == model)
        if key in built:
            return built[key]
    there = ", ".join(str(at) for model, at in sorted(built) if model == first)
    raise ConfigError(f"{where}: the robot program builds no {first} {address}; it builds {first} [{there}]")
