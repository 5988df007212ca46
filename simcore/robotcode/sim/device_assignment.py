"""Assignment of each device under `--simcore` to the drivetrain, simcore.toml, the team's physics.py or a guess."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from simcore.errors import ConfigError
from simcore.quantities import DeviceKey
from simcore.robot.mechanisms import GuessedMechanism, PistonConfig, ServoConfig
from simcore.robot.robot import Robot
from simcore.robot_file.robot_settings import PORT_CONTROLLERS, MechanismSettings, RobotSettings
from simcore.robotcode.program.makers import Maker, Mounting, find_device, maker_of, makers
from simcore.robotcode.program.motor_controllers import BuiltDevice, FollowerGroup
from simcore.robotcode.program.motor_ports import MotorDevices
from simcore.robotcode.program.ownership import DRIVETRAIN, Ownership
from simcore.robotcode.sim.port_assignment import PortAssignment
from simcore.robotcode.sim.robot_physics import RobotPhysics

__all__ = ["DeviceAssignment", "connect_mechanism", "short_names", "with_configuration"]

_log = logging.getLogger(__name__)

_OBSERVE = 5  # number of ticks in which a team's physics.py reveals the devices that it writes
_LONGEST = 50  # largest number of ticks to wait for a team's physics.py


@dataclass(frozen=True, slots=True)
class _Guessed:
    """Group of motor controllers on one shaft, with the guessed mechanism."""

    maker: Maker
    group: FollowerGroup
    guess: GuessedMechanism

    @property
    def keys(self) -> list[DeviceKey]:
        """Keys of the group's motor controllers, without sensors."""
        return [device.key for device in self.group.devices]


class DeviceAssignment:
    """Assignment of a program's CAN devices to owners, with a guessed mechanism for each motor without an owner.

    Args:
        physics: Physics that runs the motors.
        robot: Robot that steps the mechanisms.
        ownership: Record of the owner of each device.
        settings: Settings from the robot description file.
        drivetrain: Keys of the drivetrain's devices.
        ports: Connection of the ports other than CAN; None to ignore ports.
        on_assigned: Function to call once, after the assignment of all devices; None for no call.
    """

    def __init__(
        self,
        physics: RobotPhysics,
        robot: Robot,
        ownership: Ownership,
        settings: RobotSettings,
        drivetrain: Sequence[DeviceKey],
        ports: PortAssignment | None = None,
        *,
        on_assigned: Callable[[], None] | None = None,
    ) -> None:
        self._physics = physics
        self._robot = robot
        self._ownership = ownership
        self._settings = settings
        self._ports = ports
        self._drivetrain = tuple(drivetrain)
        self._guessed: list[tuple[_Guessed, MotorDevices]] = []
        self._on_assigned = on_assigned
        self._ticks = 0
        self._has_decided = False
        for key in drivetrain:
            ownership.claim(key, DRIVETRAIN)
        self._guesses = self._guess()

    def after_tick(self, *, has_seen_loops: bool = True) -> None:
        """Connect the guessed mechanisms after an observation period. Later, disconnect motors that physics.py writes.

        Args:
            has_seen_loops: Whether the project's own physics has run several times. On a busy computer, several ticks
                may precede the first run.
        """
        self._ticks += 1
        if not self._has_decided:
            if self._ticks >= (_OBSERVE if has_seen_loops else _LONGEST):
                self._has_decided = True
                self._connect_rest()
        elif self._guessed:
            for entry in [e for e in self._guessed if not self._ownership.foreign.isdisjoint(e[0].keys)]:
                self._disconnect(*entry)

    @property
    def drivetrain(self) -> str:
        """Text that lists the devices of the drivetrain."""
        return short_names(self._drivetrain)

    @property
    def described(self) -> list[tuple[str, str]]:
        """Texts (devices, name with guesses) for each mechanism in the robot description file."""
        rows = []
        for m in self._settings.mechanisms:
            sensor = [] if m.cancoder is None else [("CANcoder", m.cancoder)]
            guesses = f" (guessed: {m.guesses})" if m.guesses else ""
            rows.append((short_names([*m.keys, *sensor]), f"{m.name!r}{guesses}"))
        return rows

    @property
    def guessed(self) -> list[tuple[str, str]]:
        """Texts (devices, guessed mechanism) for each connected group of motors."""
        return [
            (str(g.group) + "".join(f", {model} {address}" for model, address in g.guess.sensors), str(g.guess))
            for g, _ in self._guessed
        ]

    @property
    def foreign(self) -> list[DeviceKey]:
        """Keys of the unassigned devices that the project's own physics writes."""
        return [key for key in self._others() if key in self._ownership.foreign]

    @property
    def idle(self) -> list[DeviceKey]:
        """Keys of the CAN devices and gyros that no model writes."""
        return [key for key in self._others() if key not in self._ownership.foreign]

    def _others(self) -> Iterator[DeviceKey]:
        known = {key for guessed, _ in self._guessed for key in (*guessed.keys, *guessed.guess.sensors)}
        known |= self._ownership.claimed
        known |= set() if self._ports is None else self._ports.keys
        return (device.key for device in _all_devices() if device.key not in known)

    def _guess(self) -> list[_Guessed]:
        """Return guessed mechanisms for the unclaimed motors, and log a warning for each group without a guess."""
        taken = self._ownership.claimed | self._ownership.foreign
        guesses = []
        for maker in makers():
            free = [d for d in maker.built() if d.model in maker.motors and d.key not in taken]
            for group in () if maker.on_ports else maker.groups(free):
                try:
                    guesses.append(_Guessed(maker, group, maker.guess(group)))
                except ConfigError as error:
                    _log.warning("%s is left alone: %s", group, error)
        return guesses

    def _connect_rest(self) -> None:
        for guessed in self._guesses:
            if self._ownership.foreign.isdisjoint(guessed.keys):
                own = [d for d in guessed.maker.built() if d.key in guessed.guess.sensors]
                sensors = [d for d in own if d.key not in self._ownership.foreign]
                motor = guessed.maker.connect_guess(guessed.group, guessed.guess, sensors)
                self._robot.add_estimated_mechanism(guessed.guess.mechanism)
                self._physics.add_motor(motor)
                self._guessed.append((guessed, motor))
        if self._on_assigned is not None:
            self._on_assigned()

    def _disconnect(self, guessed: _Guessed, motor: MotorDevices) -> None:
        self._guessed.remove((guessed, motor))
        self._physics.remove_motor(motor)
        self._robot.remove_estimated_mechanism(guessed.guess.mechanism)
        _log.info("%s is written by the project's own physics: simcore stops writing it", guessed.group)


def _all_devices() -> list[BuiltDevice]:
    """Return all devices on CAN, and all gyros."""
    return [d for maker in makers() for d in maker.built() if not maker.on_ports or d.model in maker.gyros]


def short_names(keys: Sequence[DeviceKey]) -> str:
    """Return a text that lists devices by model and bus, with ranges of consecutive CAN IDs.

    >>> from simcore.quantities import DeviceAddress
    >>> short_names([("TalonFX", DeviceAddress(number)) for number in (1, 2, 3)])
    'TalonFX 1-3'
    >>> short_names([("TalonFX", DeviceAddress(3)), ("TalonFX", DeviceAddress(3, "canivore"))])
    'TalonFX 3, TalonFX canivore:3'
    """
    parts = []
    for model, bus in dict.fromkeys((model, address.bus) for model, address in keys):
        numbers = sorted(address.number for m, address in keys if (m, address.bus) == (model, bus))
        runs: list[list[int]] = []
        for number in numbers:
            if runs and number == runs[-1][-1] + 1:
                runs[-1].append(number)
            else:
                runs.append([number])
        texts = " ".join(f"{r[0]}-{r[-1]}" if len(r) > 2 else " ".join(map(str, r)) for r in runs)
        parts.append(f"{model} {f'{bus}:' * bool(bus)}{texts}")
    return ", ".join(parts)


# --- mechanisms of the file -----------------------------------------------------------------------------------------


def connect_mechanism(settings: MechanismSettings, robot: Robot, ownership: Ownership) -> MotorDevices:
    """Claim the CAN devices of a mechanism in the robot description file, and connect the devices to the mechanism.

    Raises:
        ConfigError: The program has not built one of the devices, or a follower is on another CAN bus.
    """
    m, where = settings, _where(settings)
    devices = [find_device(where, m.controller, address) for address in m.devices]
    apart = next((d for d in devices if d.address.bus != devices[0].address.bus), None)
    if apart is not None:
        raise ConfigError(f"{where}: {apart} cannot follow {devices[0]}: it is on another CAN bus")
    group = FollowerGroup(
        devices[0], tuple(devices[1:]), tuple(k for k, address in enumerate(m.followers) if address in m.opposed)
    )
    encoder = None
    if m.cancoder is not None:
        made = find_device(where, "CANcoder", m.cancoder)
        devices.append(made)
        encoder = maker_of(made).encoder_port(made)
    for device in devices:
        ownership.claim(device.key, m.name)
    gearing = m.encoder_gearing if encoder is None else m.cancoder_gearing
    mounting = Mounting(reversed=m.reversed, encoder=encoder, encoder_gearing=gearing, motor=m.motor)
    return maker_of(group.leader).connect(group, robot.mechanisms[m.name], mounting)


def with_configuration(settings: RobotSettings) -> RobotSettings:
    """Return the settings, with gearings, inertias and friction from the program for each value missing in the file.

    Raises:
        ConfigError: The program has not built one of the devices.
    """
    mechanisms = tuple(_with_guess(m) if {"gearing", "inertia"} & set(m.guessed) else m for m in settings.mechanisms)
    settings = replace(settings, mechanisms=mechanisms)
    volts: dict[str, float] = {}
    for m in settings.mechanisms:
        if m.friction_is_given or m.controller in PORT_CONTROLLERS:
            continue  # a port has no configuration
        assert not isinstance(m.config, (PistonConfig, ServoConfig)), "they have no motor on CAN"
        leader = find_device(_where(m), m.controller, m.leader)
        try:
            found = maker_of(leader).friction_volts(leader, m.config.gearbox)
        except ConfigError as error:
            _log.warning("%s keeps the default friction of its kind: %s", m.name, error)
            continue
        if found > 0.0:
            volts[m.name] = found
    return settings.with_friction(volts)


def _with_guess(m: MechanismSettings) -> MechanismSettings:
    if m.controller in PORT_CONTROLLERS:
        return m
    leader, *followers = (find_device(_where(m), m.controller, address) for address in m.devices)
    try:
        guess = maker_of(leader).guess(FollowerGroup(leader, tuple(followers))).mechanism
    except ConfigError as error:
        _log.warning("%s keeps the guess %s: %s", m.name, m.guesses, error)
        return m
    return m.with_program(guess.gearing, guess.inertia)


def _where(settings: MechanismSettings) -> str:
    return f"simcore.toml [[mechanism]] {settings.name!r}"
