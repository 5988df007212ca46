"""Makers of motor controllers as physics sees them: what a program has built of them, guessed, and connected.

Each family answers the same questions, so that assignment, survey and table know no maker.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from typing import Any, Protocol

from simcore.errors import ConfigError
from simcore.phoenix6.built_devices import built_devices, group_followers
from simcore.phoenix6.configuration import talon_configuration
from simcore.phoenix6.fallback import Guess, gain_volts, guess_mechanism
from simcore.phoenix6.ownership import Ownership
from simcore.phoenix6.sensor_ports import CANcoderSim, CANdiEncoderSim
from simcore.phoenix6.talon_motor import AngleSensor, MotorType, TalonFXMotorSim
from simcore.robot.motor_controllers import BuiltDevice, FollowerGroup
from simcore.robot.positioned_mechanisms import PistonConfig, ServoConfig
from simcore.robot.shaft import ShaftSim
from simcore.robot_file.robot_settings import MechanismSettings
from simcore.robotpy.connected_devices import MotorDevices

__all__ = ["FAMILIES", "MechanismGuess", "MotorFamily", "family_of", "find_device", "watch_devices"]

Key = tuple[str, int]


class MechanismGuess(Protocol):
    """What a group of devices probably turns: `Guess`, `SparkGuess`; as text, what `simcore` says of it."""

    @property
    def mechanism(self) -> ShaftSim:
        """Made of the configuration."""
        ...

    @property
    def has_weight(self) -> bool:
        """Whether gravity acts on it."""
        ...


class MotorFamily(Protocol):
    """Motor controllers of one maker."""

    @property
    def controllers(self) -> tuple[str, ...]:
        """As `controller` in simcore.toml names them."""
        ...

    def devices(self) -> list[BuiltDevice]:
        """Everything of this maker that the program has built, sensors too."""
        ...

    def groups(self, devices: Sequence[BuiltDevice]) -> list[FollowerGroup]:
        """Motor controllers by what they turn."""
        ...

    def guess(self, group: FollowerGroup) -> MechanismGuess:
        """What they probably turn.

        Raises:
            ConfigError: A device does not answer.
        """
        ...

    def sensor_keys(self, guess: Any) -> list[Key]:
        """Further devices that the guess writes."""
        ...

    def connect_guess(self, group: FollowerGroup, guess: Any, ownership: Ownership) -> MotorDevices:
        """The devices on the guessed mechanism."""
        ...

    def connect(
        self, settings: MechanismSettings, devices: Sequence[BuiltDevice], mechanism: ShaftSim, encoder: Any
    ) -> MotorDevices:
        """The devices on a mechanism of the file."""
        ...

    def friction_volts(self, settings: MechanismSettings, leader: BuiltDevice) -> float:
        """The kS that the leader is configured with; 0: none [V].

        Raises:
            ConfigError: It does not answer.
        """
        ...


class _Talons:
    """CTRE's TalonFX and TalonFXS."""

    controllers = ("TalonFX", "TalonFXS")

    def devices(self) -> list[BuiltDevice]:
        return built_devices()

    def groups(self, devices: Sequence[BuiltDevice]) -> list[FollowerGroup]:
        return group_followers([d for d in devices if d.model in self.controllers])

    def guess(self, group: FollowerGroup) -> Guess:
        return guess_mechanism(group)

    def sensor_keys(self, guess: Guess) -> list[Key]:
        # a quadrature of a CANdi is not simulated
        if guess.sensor is None or "QUADRATURE" in guess.sensor[0]:
            return []
        return [("CANdi" if "CANDI" in guess.sensor[0] else "CANcoder", guess.sensor[1])]

    def connect_guess(self, group: FollowerGroup, guess: Guess, ownership: Ownership) -> TalonFXMotorSim:
        sensor: AngleSensor | None = None
        for key in self.sensor_keys(guess):
            made = next((d.hardware for d in built_devices() if d.key == key), None)
            if made is not None and guess.sensor is not None and key not in ownership.foreign:
                source = guess.sensor[0]
                sensor = CANcoderSim(made) if key[0] == "CANcoder" else CANdiEncoderSim(made, int(source[-1]))
        return TalonFXMotorSim(
            group.leader.hardware,
            guess.mechanism,
            followers=[f.hardware for f in group.followers],
            opposed=group.opposed,
            inverted=guess.inverted,
            zero_at=guess.mechanism.position,
            encoder=sensor,
            encoder_gearing=guess.sensor_gearing,
            sensor_gearing=guess.wired_gearing,
        )

    def connect(
        self, settings: MechanismSettings, devices: Sequence[BuiltDevice], mechanism: ShaftSim, encoder: Any
    ) -> TalonFXMotorSim:
        m = settings
        is_small = m.controller == "TalonFX" and m.motor.startswith("Kraken X44")
        return TalonFXMotorSim(
            devices[0].hardware,
            mechanism,
            followers=[d.hardware for d in devices[1:]],
            opposed=[k for k, number in enumerate(m.followers) if number in m.opposed],
            reversed=m.reversed,
            zero_at=mechanism.position,
            motor_type=MotorType.KRAKEN_X44 if is_small else None,
            encoder=None if encoder is None else CANcoderSim(encoder),
            encoder_gearing=m.cancoder_gearing,
        )

    def friction_volts(self, settings: MechanismSettings, leader: BuiltDevice) -> float:
        assert not isinstance(settings.config, (PistonConfig, ServoConfig)), "they have no motor on CAN"
        gains = talon_configuration(leader.hardware, leader.model).slot0
        return abs(gain_volts(settings.config.gearbox, gains.k_s))


class _Sparks:
    """REV's SPARK MAX and SPARK Flex; nothing is asked of REVLib before there is one to ask about."""

    controllers = ("SPARK MAX", "SPARK Flex")

    def devices(self) -> list[BuiltDevice]:
        if find_spec("rev") is None:
            return []
        from simcore.revlib.built_sparks import built_sparks

        return built_sparks()

    def groups(self, devices: Sequence[BuiltDevice]) -> list[FollowerGroup]:
        if not devices:
            return []
        from simcore.revlib.built_sparks import group_sparks

        return group_sparks(devices)

    def guess(self, group: FollowerGroup) -> MechanismGuess:
        from simcore.revlib.spark_guess import guess_spark_mechanism

        return guess_spark_mechanism(group)

    def sensor_keys(self, guess: Any) -> list[Key]:
        return []

    def connect_guess(self, group: FollowerGroup, guess: Any, ownership: Ownership) -> MotorDevices:
        from simcore.revlib.spark_motor import SparkMotorSim

        return SparkMotorSim(
            group.leader.hardware,
            guess.mechanism,
            followers=[f.hardware for f in group.followers],
            opposed=group.opposed,
            zero_at=guess.mechanism.position,
        )

    def connect(
        self, settings: MechanismSettings, devices: Sequence[BuiltDevice], mechanism: ShaftSim, encoder: Any
    ) -> MotorDevices:
        from simcore.revlib.spark_motor import SparkMotorSim

        return SparkMotorSim(
            devices[0].hardware,
            mechanism,
            followers=[d.hardware for d in devices[1:]],
            opposed=[k for k, number in enumerate(settings.followers) if number in settings.opposed],
            reversed=settings.reversed,
            zero_at=mechanism.position,
            encoder_gearing=settings.encoder_gearing,
        )

    def friction_volts(self, settings: MechanismSettings, leader: BuiltDevice) -> float:
        return abs(float(leader.hardware.configAccessor.closedLoop.feedForward.getkS()))


FAMILIES: tuple[MotorFamily, ...] = (_Talons(), _Sparks())
"""In the order in which tables show them."""


def family_of(controller: str) -> MotorFamily:
    """The maker of a controller of simcore.toml."""
    return next(family for family in FAMILIES if controller in family.controllers)


def find_device(where: str, model: str, number: int) -> BuiltDevice:
    """A device that the program has built.

    Args:
        where: In messages, what asks for it.
        model: As its maker writes it.
        number: CAN id.

    Raises:
        ConfigError: It has built no such device, or the library of its maker is not installed.
    """
    if model.startswith("SPARK") and find_spec("rev") is None:
        raise ConfigError(f"{where}: a {model} needs REVLib, which is not installed: pip install robotpy-rev")
    devices = [device for family in FAMILIES for device in family.devices()]
    for device in devices:
        if device.key == (model, number):
            return device
    there = sorted(d.device_id for d in devices if d.model == model)
    raise ConfigError(f"{where}: the robot program builds no {model} {number}; it builds {model} {there}")


def watch_devices() -> Ownership:
    """Note from now on which devices a program builds, and which of them its own simulation writes."""
    ownership = Ownership()
    if find_spec("rev") is not None:
        from simcore.revlib.built_sparks import built_sparks
        from simcore.revlib.spark_ownership import watch_spark_sims

        built_sparks()
        watch_spark_sims(ownership.may_write)
    return ownership
