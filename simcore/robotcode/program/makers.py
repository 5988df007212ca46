"""Makers of motor controllers, encoders and gyros: how to find, read, guess and connect a program's devices.

To add a maker: derive from `Maker` in a module of the maker's own package (say `makers/navx/navx_maker.py`),
name its models and override the methods that apply; put an object of it into `MAKER` of that module, and
the module with the Python package that it needs into `MAKER_MODULES` here. Its `watch` records classes in `devices`.
A maker of gyros alone overrides `watch` and `gyro_port`. Nothing else in simcore knows a maker.

A port passes the model's measurements to robot code and its requests to the model: `motor_ports` has the `MotorPort` to
derive from, and the protocols `AnglePort` and `GyroPort`.
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
"""Python package that a maker needs, and the module of simcore with its `MAKER`; in order of preference."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorFacts:
    """Configuration of a motor controller, as far as its drivetrain needs it."""

    motor: str
    """Motor: one of `simcore.robot.dc_motor.MOTOR_NAMES`."""
    is_guess: bool = True
    """Whether the motor is the usual one behind this controller instead of a configured one."""
    stator_limit: float | None = None
    """Stator current limit [A]; None: the factory default."""
    supply_limit: float | None = None
    """Supply current limit [A]; None: the factory default."""
    brakes: bool = True
    """Whether it brakes in neutral; else it coasts."""
    units_per_rotor_turn: float = 1.0
    """Position that robot code reads per turn of the rotor; 1 also where the controller has no encoder."""
    sensor: DeviceKey | None = None
    """Encoder other than the rotor's that closes its position loop: another device's, or its own (its own key)."""
    rotor_per_sensor: float | None = None
    """Rotor turns per turn of that encoder [-]; None: not configured."""
    has_gains: bool = False
    """Whether the controller has a configured loop; else the program closes it."""
    free_speed_volts: float | None = None
    """Velocity feed-forward voltage at the motor's free speed, some 12 if it is right [V]; None: without."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Mounting:
    """Mounting of motors on a mechanism, where no configuration gives it."""

    reversed: bool = False
    """Whether positive in robot code is negative for the mechanism."""
    encoder: AnglePort | None = None
    """Encoder on the mechanism, as a device by itself."""
    encoder_gearing: float = 1.0
    """Turns of that encoder, or of one wired to the leader, per turn of the mechanism [-]."""
    motor: str = ""
    """Motor: one of `simcore.robot.dc_motor.MOTOR_NAMES`; empty: as configured."""


class MakersDrivetrain(Protocol):
    """A drivetrain with everything that its model needs."""

    @property
    def found(self) -> FoundDrivetrain:
        """Devices and measures."""
        ...

    @property
    def config(self) -> SwerveConfig | TankConfig | MecanumConfig:
        """Model of the drivetrain."""
        ...

    def connect(self, drive: Any) -> Any:
        """Connect its devices to that model; the result has `read`, `write` and `devices`."""
        ...


class LightsShown(Protocol):
    """State of a device with lights."""

    changes: int
    """Number of changes so far."""

    @property
    def colors(self) -> IntArray:
        """Color of each LED, 0xRRGGBB, shape (n,)."""
        ...

    @property
    def shows(self) -> str:
        """Requests in words."""
        ...


class Maker:
    """Devices of one maker; a subclass overrides what the maker makes.

    Methods that query a device raise `ConfigError` if it does not answer.
    """

    name: str = ""
    """Name in documents."""
    motors: tuple[str, ...] = ()
    """Models of motor controllers, as simcore.toml names them."""
    encoders: tuple[str, ...] = ()
    """Models of encoders on their own shaft."""
    pulse_encoders: tuple[str, ...] = ()
    """Models of encoders whose pulses per turn only the program knows."""
    gyros: tuple[str, ...] = ()
    """Models of gyros."""
    others: tuple[str, ...] = ()
    """Models of further devices that no drivetrain has: sensors of pieces, lights."""
    unserved: tuple[str, ...] = ()
    """Classes of its package that simcore does not simulate."""
    sim_devices: tuple[str, ...] = ()
    """Parts of the names of WPILib's SimDevices that simcore serves."""
    gyro_errors: str = "pigeon2"
    """Error model of its gyros: one of `simcore.robot.gyro.GYROS`."""
    on_ports: bool = False
    """Whether its motors and encoders use roboRIO ports, so that channels name them and simcore guesses nothing."""

    def __init__(self, devices: BuiltDevices | None = None) -> None:
        self.devices = BuiltDevices() if devices is None else devices
        """Devices that the program has built."""

    def watch(self) -> None:
        """Record devices that a program builds from now on; may be called again."""

    def watch_simulations(self, may_write: Callable[[DeviceKey], bool]) -> None:
        """Ask before each write of a team's own simulation to a device; may be called again.

        Args:
            may_write: Function of model and address; False drops the write, because the device belongs to simcore.
        """

    def built(self) -> list[BuiltDevice]:
        """Return the devices that the program has built, sensors and lights too, one per model and address."""
        return self.devices.devices()

    def device_of(self, made: Any) -> BuiltDevice | None:
        """Return the device behind an object of robot code or of a class derived from it; None: another maker's."""
        return self.devices.find(made)

    def require_distinct(self) -> None:
        """Check that the simulation tells all devices apart.

        Raises:
            ConfigError: It makes one of two.
        """

    def lights(self) -> Mapping[str, LightsShown]:
        """Return the state of its lights, by device name."""
        return {}

    # --- motor controllers ----------------------------------------------------------------------------------------

    def groups(self, motors: Sequence[BuiltDevice]) -> list[FollowerGroup]:
        """Return motors grouped by leader, as configured now; a single motor is a group too."""
        return [FollowerGroup(motor) for motor in motors]

    def has_wheel_encoder(self, motor: BuiltDevice) -> bool:
        """Return whether a motor controller measures the wheel instead of its rotor."""
        return False

    def facts(self, motor: BuiltDevice) -> MotorFacts:
        """Return the configuration of a motor controller."""
        raise ConfigError(f"{motor} is no motor controller")

    def motor_port(self, motor: BuiltDevice) -> MotorPort:
        """Return its simulated side; signs are those of robot code."""
        raise ConfigError(f"{motor} is no motor controller")

    def guess(self, group: FollowerGroup) -> GuessedMechanism:
        """Return the likely mechanism of motors that no table describes."""
        raise ConfigError(f"{group} is configured with nothing that tells what it turns")

    def connect(self, group: FollowerGroup, mechanism: ShaftSim, mounting: Mounting | None = None) -> MotorDevices:
        """Connect motors to a mechanism.

        Args:
            group: Leader and followers.
            mechanism: Mechanism that they turn.
            mounting: Mounting; None: the defaults of its fields.
        """
        raise ConfigError(f"{group} is no motor controller on CAN")

    def connect_guess(
        self, group: FollowerGroup, guess: GuessedMechanism, sensors: Sequence[BuiltDevice]
    ) -> MotorDevices:
        """Connect motors to the mechanism that they probably turn.

        Args:
            group: Leader and followers.
            guess: Mechanism from this maker's `guess`.
            sensors: Sensors of the guess that the program has built and that nothing else writes.
        """
        return self.connect(group, guess.mechanism)

    def friction_volts(self, motor: BuiltDevice, gearbox: GearboxConfig) -> float:
        """Return the kS of a controller [V]; 0: none."""
        return 0.0

    # --- sensors, and drivetrains of libraries --------------------------------------------------------------------

    def encoder_port(self, encoder: BuiltDevice, port: MotorPort | None = None) -> AnglePort:
        """Connect an encoder on the shaft; the angle written is the one that robot code reads, one turn being 2 pi.

        Args:
            encoder: Encoder of this maker; a motor controller with an encoder wired to it counts.
            port: Port of this motor controller, where it is one.
        """
        raise ConfigError(f"{encoder} has no encoder that is simulated")

    def gyro_port(self, gyro: BuiltDevice) -> GyroPort:
        """Connect a gyro; its port takes the robot's rotation since the gyro was switched on, counter-clockwise."""
        raise ConfigError(f"{gyro} is no gyro that is simulated")

    def drivetrain(self, settings: RobotSettings, folder: Path) -> MakersDrivetrain | None:
        """Return a drivetrain that the maker's library drives, such as CTRE's `SwerveDrivetrain`; None: there is none.

        Args:
            settings: Settings of simcore.toml.
            folder: Folder of robot.py.

        Raises:
            ConfigError: Its constants make no sense.
        """
        return None

    def settle(self) -> None:
        """Make written values visible to robot code before its first loop."""


@cache
def _maker(module: str) -> Maker:
    maker = importlib.import_module(module).MAKER
    assert isinstance(maker, Maker), module
    return maker


def makers() -> list[Maker]:
    """Return makers whose packages the program has imported."""
    return [_maker(module) for package, module in MAKER_MODULES if package in sys.modules]


def installed_makers() -> list[Maker]:
    """Load and return all makers whose packages are installed."""
    return [_maker(module) for package, module in MAKER_MODULES if find_spec(package) is not None]


def watch_makers(may_write: Callable[[DeviceKey], bool] | None = None) -> None:
    """Record devices of every maker and of WPILib from now on; call it before the program is imported.

    A maker's package is watched as soon as the program imports it, so that no unused package is loaded.

    Args:
        may_write: See `Maker.watch_simulations`; None: every write is allowed.
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
    """Check that simulations tell all devices apart that the program has built.

    Raises:
        ConfigError: One makes one of two.
    """
    for maker in makers():
        maker.require_distinct()


def maker_of(device: BuiltDevice) -> Maker:
    """Return the maker of a device.

    Raises:
        ConfigError: Its maker's package is not imported by the program.
    """
    for maker in makers():
        if device.model in (*maker.motors, *maker.encoders, *maker.gyros, *maker.others):
            return maker
    raise ConfigError(f"{device}: the program imports no package of its maker")


def device_of(made: Any) -> BuiltDevice | None:
    """Return the device behind an object of robot code; None: unknown."""
    for maker in makers():
        device = maker.device_of(made)
        if device is not None:
            return device
    return None


def known_device(made: Any) -> BuiltDevice:
    """Return the device behind an object of robot code.

    Raises:
        ConfigError: It was built before simcore was loaded.
    """
    device = made if isinstance(made, BuiltDevice) else device_of(made)
    if device is None:
        raise ConfigError(
            f"{type(made).__name__}: built before simcore was loaded; a physics.py calls "
            "simcore.robotcode.program.makers.watch_makers() at its top"
        )
    return device


def find_device(where: str, models: str | Sequence[str], address: DeviceAddress) -> BuiltDevice:
    """Return a device that the program has built.

    Args:
        where: Part of the file that asks for it, in messages.
        models: Models as their makers write them; the first one at this address is taken.
        address: Address; without a bus it also means the only device of its number on any bus.

    Raises:
        ConfigError: The program has built no such device, or its maker's library is not installed.
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
