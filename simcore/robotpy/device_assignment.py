"""What moves which device under `--simcore`: the drivetrain, the file, the team's own physics.py, or a guess."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import Protocol

from simcore.errors import ConfigError
from simcore.phoenix6.built_devices import BuiltDevice, FollowerGroup, built_devices, clashes, group_followers
from simcore.phoenix6.fallback import Guess, guess_mechanism
from simcore.phoenix6.ownership import Ownership
from simcore.phoenix6.sensor_ports import CANcoderSim, CANdiEncoderSim
from simcore.phoenix6.talon_motor import AngleSensor, MotorType, TalonFXMotorSim
from simcore.robot.robot import Robot
from simcore.robot.shaft import ShaftSim
from simcore.robot_file.robot_settings import MechanismSettings, RobotSettings
from simcore.robotpy.connected_devices import MotorDevices
from simcore.robotpy.port_assignment import PortAssignment

__all__ = ["DeviceAssignment", "connect_mechanism"]

_log = logging.getLogger(__name__)

_MOTORS = ("TalonFX", "TalonFXS")
_OBSERVE = 5  # ticks in which a team's own physics.py shows what it drives


def connect_mechanism(settings: MechanismSettings, robot: Robot, ownership: Ownership) -> TalonFXMotorSim:
    """The devices of a mechanism of the file, on that mechanism.

    Raises:
        ConfigError: The program has built no such device.
    """
    m, where = settings, f"simcore.toml [[mechanism]] {settings.name!r}"
    talons = [_find(where, m.controller, number) for number in m.devices]
    encoder = None
    if m.cancoder is not None:
        encoder = _find(where, "CANcoder", m.cancoder)
        ownership.claim(encoder.key, m.name)
    for talon in talons:
        ownership.claim(talon.key, m.name)
    mechanism = robot.mechanisms[m.name]
    is_small = m.controller == "TalonFX" and m.motor.startswith("Kraken X44")
    return TalonFXMotorSim(
        talons[0].hardware,
        mechanism,
        followers=[t.hardware for t in talons[1:]],
        opposed=[k for k, number in enumerate(m.followers) if number in m.opposed],
        reversed=m.reversed,
        zero_at=mechanism.position,
        motor_type=MotorType.KRAKEN_X44 if is_small else None,
        encoder=None if encoder is None else CANcoderSim(encoder.hardware),
        encoder_gearing=m.cancoder_gearing,
    )


def _find(where: str, model: str, number: int) -> BuiltDevice:
    devices = built_devices()
    for device in devices:
        if device.key == (model, number):
            return device
    there = sorted(d.device_id for d in devices if d.model == model)
    raise ConfigError(f"{where}: the robot program builds no {model} {number}; it builds {model} {there}")


class _Motors(Protocol):
    """What runs the devices of mechanisms: `RobotPhysics`."""

    def add_motor(self, motor: MotorDevices) -> None: ...

    def remove_motor(self, motor: MotorDevices) -> None: ...


class _EstimatedMechanisms(Protocol):
    """What steps guessed mechanisms: `Robot`."""

    def add_estimated_mechanism(self, mechanism: ShaftSim) -> None: ...

    def remove_estimated_mechanism(self, mechanism: ShaftSim) -> None: ...


class DeviceAssignment:
    """Gives every motor that nothing drives a guessed mechanism, once it is clear what drives which.

    Args:
        physics: Runs the motors.
        robot: Steps the mechanisms.
        ownership: Who has written which device.
        settings: The file's.
        drivetrain: Its devices, (model, id).
        ports: What is no motor on CAN; None: nobody has looked.
    """

    def __init__(
        self,
        physics: _Motors,
        robot: _EstimatedMechanisms,
        ownership: Ownership,
        settings: RobotSettings,
        drivetrain: Sequence[tuple[str, int]],
        ports: PortAssignment | None = None,
    ) -> None:
        self._physics = physics
        self._robot = robot
        self._ownership = ownership
        self._settings = settings
        self._ports = ports
        self._drivetrain = tuple(drivetrain)
        self._guessed: list[tuple[FollowerGroup, Guess, TalonFXMotorSim]] = []
        self._ticks = 0
        for key in drivetrain:
            ownership.claim(key, "drivetrain")
        self._guesses = self._guess()

    def after_tick(self) -> None:
        """Observe; then connect what is left; later, disconnect what something else turns out to write."""
        self._ticks += 1
        if self._ticks == _OBSERVE:
            self._connect_rest()
        elif self._ticks > _OBSERVE and self._guessed:
            for guessed in [g for g in self._guessed if not self._ownership.foreign.isdisjoint(_keys(g[0]))]:
                self._disconnect(guessed)

    def table(self) -> list[tuple[str, str]]:
        """Rows of devices and what moves them."""
        rows = [(_short(self._drivetrain), "drivetrain")]
        for m in self._settings.mechanisms:
            rows.append((_short([*m.keys, *([] if m.cancoder is None else [("CANcoder", m.cancoder)])]), f"{m.name!r}"))
        for group, guess, _ in self._guessed:
            key = _sensor_key(guess)
            rows.append((str(group) + (f", {key[0]} {key[1]}" if key else ""), f"guessed: {guess}"))
        known = {key for group, guess, _ in self._guessed for key in (*_keys(group), _sensor_key(guess))}
        known |= {*self._drivetrain, *self._file_keys()}
        known |= set() if self._ports is None else self._ports.keys
        others = [device for device in built_devices() if device.key not in known]
        foreign = [d.key for d in others if d.key in self._ownership.foreign]
        idle = [d.key for d in others if d.key not in self._ownership.foreign]
        if foreign:
            rows.append((_short(foreign), "the project's physics.py"))
        if idle:
            rows.append((_short(idle), "nobody: reads what it read at start"))
        return rows if self._ports is None else rows + self._ports.rows()

    def _guess(self) -> list[tuple[FollowerGroup, Guess]]:
        """What the motors that nothing has claimed may turn; asked now, because each answer takes 50 ms."""
        taken = {*self._drivetrain, *self._file_keys(), *self._ownership.foreign}
        guesses = []
        for group in group_followers([d for d in built_devices() if d.model in _MOTORS and d.key not in taken]):
            try:
                guesses.append((group, guess_mechanism(group)))
            except ConfigError as error:
                _log.warning("%s is left alone: %s", group, error)
        return guesses

    def _connect_rest(self) -> None:
        for group, guess in self._guesses:
            if self._ownership.foreign.isdisjoint(_keys(group)):
                self._guessed.append((group, guess, self._connect(group, guess)))
        for sentence in clashes():
            _log.warning("%s", sentence)
        rows = self.table()
        width = max(len(devices) for devices, _ in rows)
        lines = [f"    {devices:<{width}}  {owner}" for devices, owner in rows]
        _log.info("who moves what\n%s", "\n".join(lines))

    def _connect(self, group: FollowerGroup, guess: Guess) -> TalonFXMotorSim:
        sensor: AngleSensor | None = None
        key = _sensor_key(guess)
        if key is not None and key not in self._ownership.foreign:
            made = next((d.hardware for d in built_devices() if d.key == key), None)
            if made is not None and guess.sensor is not None:
                source = guess.sensor[0]
                sensor = CANcoderSim(made) if key[0] == "CANcoder" else CANdiEncoderSim(made, int(source[-1]))
        motor = TalonFXMotorSim(
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
        self._robot.add_estimated_mechanism(guess.mechanism)
        self._physics.add_motor(motor)
        return motor

    def _disconnect(self, guessed: tuple[FollowerGroup, Guess, TalonFXMotorSim]) -> None:
        group, guess, motor = guessed
        self._guessed.remove(guessed)
        self._physics.remove_motor(motor)
        self._robot.remove_estimated_mechanism(guess.mechanism)
        _log.info("%s is written by the project's own physics: simcore lets go of it", group)

    def _file_keys(self) -> list[tuple[str, int]]:
        keys = [key for m in self._settings.mechanisms for key in m.keys]
        return keys + [("CANcoder", m.cancoder) for m in self._settings.mechanisms if m.cancoder is not None]


def _keys(group: FollowerGroup) -> list[tuple[str, int]]:
    return [device.key for device in group.devices]


def _sensor_key(guess: Guess) -> tuple[str, int] | None:
    """The remote encoder as (model, id); a quadrature of a CANdi is not simulated."""
    if guess.sensor is None or "QUADRATURE" in guess.sensor[0]:
        return None
    return ("CANdi" if "CANDI" in guess.sensor[0] else "CANcoder"), guess.sensor[1]


def _short(keys: Sequence[tuple[str, int]]) -> str:
    """`TalonFX 1-8, CANcoder 1-4`."""
    parts = []
    for model in dict.fromkeys(model for model, _ in keys):
        numbers = sorted(number for m, number in keys if m == model)
        runs: list[list[int]] = []
        for number in numbers:
            if runs and number == runs[-1][-1] + 1:
                runs[-1].append(number)
            else:
                runs.append([number])
        parts.append(f"{model} " + " ".join(f"{r[0]}-{r[-1]}" if len(r) > 2 else " ".join(map(str, r)) for r in runs))
    return ", ".join(parts)
