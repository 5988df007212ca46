"""Makers of motor controllers, encoders and gyros: how a program's devices are found, asked, guessed and connected.

How a maker is added: derive from `Maker` in a module of the maker's own package (say `makers/navx/navx_maker.py`),
name the models that it makes, and answer what there is to answer; put an object of it into `MAKER` of that module, and
the module with the Python package that it needs into `MAKER_MODULES` here. Its `watch` records classes into `devices`.
A maker of gyros alone answers `watch` and `gyro_port`, no more. Nothing else in simcore knows a maker.

A port shows robot code what physics measures and takes what robot code asks for: `motor_ports` has the `MotorPort` to
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
"""Python package that a maker needs, and the module of simcore with its `MAKER`; in the order of tables."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorFacts:
    """What a motor controller is configured with, as far as its drivetrain needs it."""

    motor: str
    """One of `simcore.robot.dc_motor.MOTOR_NAMES`."""
    is_guess: bool = True
    """Whether the motor is what mostly sits behind this controller, and not read anywhere."""
    stator_limit: float | None = None
    """[A]; None: as the controller is delivered."""
    supply_limit: float | None = None
    """[A]; None: as the controller is delivered."""
    brakes: bool = True
    """In neutral; else it coasts."""
    units_per_rotor_turn: float = 1.0
    """What robot code reads as position per turn of the rotor; 1 also where the controller has no encoder."""
    sensor: DeviceKey | None = None
    """Encoder beside the rotor that closes its position loop: of another device, or of its own (its own key)."""
    rotor_per_sensor: float | None = None
    """Rotor turns per turn of that encoder; None: it is configured nowhere [-]."""
    has_gains: bool = False
    """Whether a loop of the controller is configured; else the program closes it."""
    free_speed_volts: float | None = None
    """What its feed-forward of velocity gives at the motor's free speed, some 12 if it is right [V]; None: without."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Mounting:
    """How motors sit on a mechanism, where no configuration says it."""

    reversed: bool = False
    """Whether positive in robot code is negative for the mechanism."""
    encoder: AnglePort | None = None
    """On the mechanism, of a device of its own."""
    encoder_gearing: float = 1.0
    """Turns of that, or of one wired to the leader, per turn of the mechanism [-]."""
    motor: str = ""
    """One of `simcore.robot.dc_motor.MOTOR_NAMES`; empty: as it is configured."""


class MakersDrivetrain(Protocol):
    """A drivetrain with all that its model needs."""

    @property
    def found(self) -> FoundDrivetrain:
        """Its devices and measures."""
        ...

    @property
    def config(self) -> SwerveConfig | TankConfig | MecanumConfig:
        """Its model."""
        ...

    def connect(self, drive: Any) -> Any:
        """Its devices on that model, with `read`, `write` and `devices`."""
        ...


class LightsShown(Protocol):
    """What a device with lights shows."""

    changes: int
    """How often that has changed."""

    @property
    def colors(self) -> IntArray:
        """Of each LED, 0xRRGGBB, shape (n,)."""
        ...

    @property
    def shows(self) -> str:
        """The requests in words."""
        ...


class Maker:
    """Devices of one maker; what a maker does not make stays as it is here.

    What asks a device raises `ConfigError` if that does not answer.
    """

    name: str = ""
    """For documents."""
    motors: tuple[str, ...] = ()
    """Models of motor controllers, as simcore.toml names them."""
    encoders: tuple[str, ...] = ()
    """Models of encoders on a shaft of their own."""
    pulse_encoders: tuple[str, ...] = ()
    """Those of them whose pulses per turn the program alone knows."""
    gyros: tuple[str, ...] = ()
    """Models of gyros."""
    others: tuple[str, ...] = ()
    """Models of further devices, which no drivetrain has: sensors of pieces, lights."""
    unserved: tuple[str, ...] = ()
    """Classes of its package that nothing simulates."""
    sim_devices: tuple[str, ...] = ()
    """What is in the names of WPILib's SimDevices of what is simulated."""
    gyro_errors: str = "pigeon2"
    """How much they err: one of `simcore.robot.gyro.GYROS`."""
    on_ports: bool = False
    """Whether its motors and encoders are on ports of the roboRIO, where channels name them and nothing is guessed."""

    def __init__(self, devices: BuiltDevices | None = None) -> None:
        self.devices = BuiltDevices() if devices is None else devices
        """What the program has built."""

    def watch(self) -> None:
        """Note from now on what a program builds; again is harmless."""

    def watch_simulations(self, may_write: Callable[[DeviceKey], bool]) -> None:
        """Ask before each write of a team's own simulation into a device; again is for anew.

        Args:
            may_write: Gets model and address; False drops the write, as the device belongs to simcore.
        """

    def built(self) -> list[BuiltDevice]:
        """What the program has built, sensors and lights too, one per model and address."""
        return self.devices.devices()

    def device_of(self, made: Any) -> BuiltDevice | None:
        """The device that an object of robot code is, of whatever class the program derived; None: another maker's."""
        return self.devices.find(made)

    def require_distinct(self) -> None:
        """Make sure that the simulation tells all devices apart.

        Raises:
            ConfigError: It makes one of two.
        """

    def lights(self) -> Mapping[str, LightsShown]:
        """What its lights show, by the names of the devices."""
        return {}

    # --- motor controllers ----------------------------------------------------------------------------------------

    def groups(self, motors: Sequence[BuiltDevice]) -> list[FollowerGroup]:
        """Motors by who follows whom, as they are configured now; one alone is a group too."""
        return [FollowerGroup(motor) for motor in motors]

    def has_wheel_encoder(self, motor: BuiltDevice) -> bool:
        """Whether a motor controller knows nothing of its rotor: the encoder wired to it turns with the wheel."""
        return False

    def facts(self, motor: BuiltDevice) -> MotorFacts:
        """What a motor controller is configured with."""
        raise ConfigError(f"{motor} is no motor controller")

    def motor_port(self, motor: BuiltDevice) -> MotorPort:
        """Its simulated side; positive is as robot code has it."""
        raise ConfigError(f"{motor} is no motor controller")

    def guess(self, group: FollowerGroup) -> GuessedMechanism:
        """What motors probably turn that no table describes."""
        raise ConfigError(f"{group} is configured with nothing that tells what it turns")

    def connect(self, group: FollowerGroup, mechanism: ShaftSim, mounting: Mounting | None = None) -> MotorDevices:
        """Motors on a mechanism.

        Args:
            group: Leader and followers.
            mechanism: What they turn.
            mounting: How; None: as the fields' defaults are.
        """
        raise ConfigError(f"{group} is no motor controller on CAN")

    def connect_guess(
        self, group: FollowerGroup, guess: GuessedMechanism, sensors: Sequence[BuiltDevice]
    ) -> MotorDevices:
        """Motors on what they probably turn.

        Args:
            group: Leader and followers.
            guess: As this maker has it.
            sensors: Those of the guess that are built, and that nothing else writes.
        """
        return self.connect(group, guess.mechanism)

    def friction_volts(self, motor: BuiltDevice, gearbox: GearboxConfig) -> float:
        """The kS that a controller is configured with; 0: none [V]."""
        return 0.0

    # --- sensors, and what a library drives itself ----------------------------------------------------------------

    def encoder_port(self, encoder: BuiltDevice, port: MotorPort | None = None) -> AnglePort:
        """An encoder on the shaft; the angle that is written is the one that robot code reads, as a turn of 2 pi.

        Args:
            encoder: Of the maker's; a motor controller with an encoder wired to it is one, too.
            port: That of this motor controller, where it is one.
        """
        raise ConfigError(f"{encoder} has no encoder that is simulated")

    def gyro_port(self, gyro: BuiltDevice) -> GyroPort:
        """A gyro; it is written what the robot has turned since the gyro was switched on, counter-clockwise."""
        raise ConfigError(f"{gyro} is no gyro that is simulated")

    def drivetrain(self, settings: RobotSettings, folder: Path) -> MakersDrivetrain | None:
        """A whole drivetrain that the maker's library drives, as CTRE's `SwerveDrivetrain`; None: there is none.

        Args:
            settings: Of simcore.toml.
            folder: Where robot.py is.

        Raises:
            ConfigError: Its constants make no sense.
        """
        return None

    def settle(self) -> None:
        """Let what has been written reach robot code, before its first loop."""


@cache
def _maker(module: str) -> Maker:
    maker = importlib.import_module(module).MAKER
    assert isinstance(maker, Maker), module
    return maker


def makers() -> list[Maker]:
    """Makers whose packages the program has imported."""
    return [_maker(module) for package, module in MAKER_MODULES if package in sys.modules]


def installed_makers() -> list[Maker]:
    """All whose packages are installed; loads them."""
    return [_maker(module) for package, module in MAKER_MODULES if find_spec(package) is not None]


def watch_makers(may_write: Callable[[DeviceKey], bool] | None = None) -> None:
    """Note from now on what a program builds, of every maker and of WPILib; before the program is imported.

    A maker's package is watched as soon as the program imports it: none is loaded for nothing.

    Args:
        may_write: See `Maker.watch_simulations`; None: nobody asks.
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
    """Make sure that simulations tell all devices apart that the program has built.

    Raises:
        ConfigError: One makes one of two.
    """
    for maker in makers():
        maker.require_distinct()


def maker_of(device: BuiltDevice) -> Maker:
    """Who makes a device.

    Raises:
        ConfigError: No maker whose package the program imports.
    """
    for maker in makers():
        if device.model in (*maker.motors, *maker.encoders, *maker.gyros, *maker.others):
            return maker
    raise ConfigError(f"{device}: the program imports no package of its maker")


def device_of(made: Any) -> BuiltDevice | None:
    """The device that an object of robot code is; None: it is none that is known."""
    for maker in makers():
        device = maker.device_of(made)
        if device is not None:
            return device
    return None


def known_device(made: Any) -> BuiltDevice:
    """The device that an object of robot code is.

    Raises:
        ConfigError: It was built before simcore was there.
    """
    device = made if isinstance(made, BuiltDevice) else device_of(made)
    if device is None:
        raise ConfigError(
            f"{type(made).__name__}: built before simcore was there; a physics.py calls "
            "simcore.robotcode.program.makers.watch_makers() at its top"
        )
    return device


def find_device(where: str, models: str | Sequence[str], address: DeviceAddress) -> BuiltDevice:
    """A device that the program has built.

    Args:
        where: In messages, what asks for it.
        models: As their makers write them; the first that there is at this address.
        address: Without a bus the only one of its number, on whichever bus, is meant as well.

    Raises:
        ConfigError: It has built no such device, or the library of its maker is not installed.
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
