"""Connects under `--simcore` what is no motor on CAN: ports of the roboRIO, pneumatics, sensors and lights.

Mechanisms and sensors of `simcore.toml` find their ports; the lights of any program are shown; and what is left has its
name in the list of who moves what.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from simcore import season
from simcore.devices.makers import find_device, maker_of, makers
from simcore.devices.motor_controllers import BuiltDevice
from simcore.devices.motor_ports import AnglePort, MotorDevices, MotorPort
from simcore.devices.ownership import Ownership
from simcore.errors import ConfigError
from simcore.match.match import Match
from simcore.quantities import DeviceKey
from simcore.robot.mechanisms import ElevatorSim, PistonSim, RackSim, ServoSim, ShaftSim
from simcore.robot.robot import Robot
from simcore.robot_file.robot_settings import PORT_CONTROLLERS, MechanismSettings, RobotSettings
from simcore.robot_file.sensor_tables import SensorSettings
from simcore.robotpy.built_ports import BuiltPort, built_ports, encoder_range, pneumatics_module, ports_text
from simcore.robotpy.piece_sensors import PieceSensor
from simcore.robotpy.port_devices import (
    DigitalSwitch,
    LimitSwitchInput,
    PistonValve,
    PortMotorSim,
    PotentiometerInput,
    ServoSignal,
    Switch,
)
from simcore.robotpy.wpilib_ports import AbsoluteEncoderPort, EncoderPort, PWMMotorPort, RelayPort
from simcore.typing import IntArray

if TYPE_CHECKING:
    from simcore.phoenix6.sensor_ports import CANrangeSim

__all__ = ["PortAssignment"]

_STRIP_EVERY = 5  # ticks between two looks at an LED strip


def _connect_mechanism(m: MechanismSettings, robot: Robot, ownership: Ownership) -> MotorDevices:
    """The devices of a mechanism of the file that is on ports, on that mechanism.

    Raises:
        ConfigError: The program has built no such device.
    """
    where, mechanism = f"simcore.toml [[mechanism]] {m.name!r}", robot.mechanisms[m.name]
    _require_ports(where, m.keys)
    if isinstance(mechanism, PistonSim):
        return PistonValve(pneumatics_module(m.module), m.channels, mechanism, reversed=m.reversed)
    if isinstance(mechanism, ServoSim):
        return ServoSignal(m.leader.number, mechanism, reversed=m.reversed)
    encoder = None
    if m.cancoder is not None:
        cancoder = find_device(where, "CANcoder", m.cancoder)
        encoder = maker_of(cancoder).encoder_port(cancoder)
        ownership.claim(cancoder.key, m.name)
    if m.controller == "PWM":
        leader = _controller(m.leader.number)
        ports: list[MotorPort] = [PWMMotorPort(number, leader=leader, coasts=m.coasts) for number in m.channels]
    else:
        ports = [RelayPort(number, coasts=m.coasts) for number in m.channels]
    signs = [-1.0 if (device in m.opposed) != m.reversed else 1.0 for device in m.devices]
    return PortMotorSim(ports, mechanism, signs=signs, encoder=encoder, encoder_gearing=m.cancoder_gearing)


def _controller(channel: int) -> Any:
    """Robot code's motor controller on a PWM channel; None if nobody has seen it built, or it is a bare `PWM`."""
    found = [port.device for port in built_ports() if port.model == "PWM" and channel in port.channels]
    return next((device for device in found if hasattr(device, "setInverted")), None)


def _require_ports(where: str, keys: Sequence[DeviceKey]) -> None:
    there = {key for port in built_ports() for key in port.keys}
    for model, channel in (key for key in keys if key not in there):
        raise ConfigError(
            f"{where}: the robot program builds nothing on {model} {channel}; of {model} it builds: {ports_text(model)}"
        )


class _MechanismInputs:
    """What mechanisms show at inputs of the roboRIO and of CAN devices, as `MotorDevices`."""

    def __init__(self) -> None:
        self._shown: list[tuple[ShaftSim, AnglePort]] = []

    def add(self, mechanism: ShaftSim, shown: AnglePort) -> None:
        shown.write(mechanism.position, mechanism.velocity)
        self._shown.append((mechanism, shown))

    def read(self, battery_voltage: float, *, powered: bool = True) -> None:
        """Inputs ask for nothing."""

    def write(self) -> None:
        for mechanism, shown in self._shown:
            shown.write(mechanism.position, mechanism.velocity)


class PortAssignment:
    """Mechanisms and sensors of `simcore.toml` that are on ports, and the lights of the program, on one robot.

    Args:
        match: With the robot.
        robot: In the match.
        settings: The file's.
        ownership: Who has written which device.

    Raises:
        ConfigError: The program has built no such device, or the robot has no such part.
    """

    def __init__(self, match: Match, robot: Robot, settings: RobotSettings, ownership: Ownership) -> None:
        self._match = match
        self._robot = robot
        self._settings = settings
        self.of_drivetrain: Sequence[Any] = ()
        """Objects of robot code on ports that its drivetrain has."""
        self._ticks = 0
        self._light_changes: dict[str, int] = {}
        strips = [port.channels[0] for port in built_ports() if port.made_by == "AddressableLED"]
        self._strips = {f"AddressableLED{n}": season.led_sim(n) for n in strips}
        self._found: set[DeviceKey] = set()
        self._limits: dict[str, LimitSwitchInput] = {}
        self._piece_sensors: dict[str, PieceSensor] = {}
        on_ports = (m for m in settings.mechanisms if m.controller in PORT_CONTROLLERS)
        self._inputs = _MechanismInputs()
        self.devices: list[MotorDevices] = [*(_connect_mechanism(m, robot, ownership) for m in on_ports), self._inputs]
        """What moves mechanisms, and then what shows how they have moved."""
        for sensor in settings.sensors:
            self._connect(f"simcore.toml [[sensor]] {sensor.name!r}", sensor)
        self._look_at_sensors()

    @property
    def keys(self) -> set[DeviceKey]:
        """CAN devices that are simulated here."""
        return self._found | {device.key for device in _candles()}

    def after_tick(self) -> None:
        """Sensors see the pieces of this tick; telemetry gets them and the lights."""
        self._look_at_sensors()
        self._look_at_lights()
        self._ticks += 1

    @property
    def sensors(self) -> list[tuple[str, str]]:
        """Ports of the file's sensors, and what they are, as text."""
        return [(_port_text(sensor), _meaning(sensor)) for sensor in self._settings.sensors]

    @property
    def lights(self) -> list[str]:
        """Lights of the program, as text."""
        return [*map(str, _candles())] + [str(port) for port in built_ports() if port.made_by == "AddressableLED"]

    @property
    def idle(self) -> list[str]:
        """Ports that nobody simulates, as text: outputs move nothing, inputs read as if nothing were there."""
        taken = {key for sensor in self._settings.sensors for key in sensor.keys}
        taken |= {key for m in self._settings.mechanisms for key in m.keys}
        ports = [p for p in built_ports() if p.made_by != "AddressableLED" and taken.isdisjoint(p.keys)]
        ports = [p for p in ports if not any(p.device is device for device in self.of_drivetrain)]
        return _by_class(ports)

    # --- connecting -----------------------------------------------------------------------------------------------

    def _connect(self, where: str, sensor: SensorSettings) -> None:
        if sensor.kind == "beam break":
            self._watch(sensor, self._switch(where, sensor).set_active)
        elif sensor.sees is not None:
            device, distances = self._range(where, sensor), (sensor.empty, sensor.distance)
            self._watch(sensor, lambda is_seen: device.write(distances[is_seen]))
        else:
            assert sensor.mechanism is not None
            mechanism = self._robot.mechanisms[sensor.mechanism]
            self._inputs.add(mechanism, self._input(where, sensor, mechanism))

    def _input(self, where: str, sensor: SensorSettings, mechanism: ShaftSim) -> AnglePort:
        """What shows where a mechanism is."""
        if sensor.kind == "canrange":
            return _SlideRange(self._range(where, sensor), mechanism, sensor.distance)
        if sensor.kind == "limit switch":
            low, high = sensor.pressed
            limit = self._limits[sensor.name] = LimitSwitchInput(self._switch(where, sensor), low=low, high=high)
            return limit
        _require_ports(where, sensor.keys)
        if sensor.kind == "potentiometer":
            return PotentiometerInput(sensor.keys[0][1].number, stops=mechanism.stops, volts=sensor.volts)
        return _encoder(where, sensor, mechanism)

    def _watch(self, sensor: SensorSettings, show: Callable[[bool], object]) -> None:
        assert sensor.sees is not None
        self._piece_sensors[sensor.name] = PieceSensor(sensor.sees, self._robot, self._kind_of, show)

    def _switch(self, where: str, sensor: SensorSettings) -> Switch:
        if sensor.keys[0][0] == "CANdi":
            from simcore.phoenix6.sensor_ports import CANdiSwitchSim

            return CANdiSwitchSim(self._device(where, sensor), sensor.pin, normally_closed=sensor.normally_closed)
        _require_ports(where, sensor.keys)
        return DigitalSwitch(sensor.keys[0][1].number, normally_closed=sensor.normally_closed)

    def _range(self, where: str, sensor: SensorSettings) -> CANrangeSim:
        from simcore.phoenix6.sensor_ports import CANrangeSim

        return CANrangeSim(self._device(where, sensor))

    def _device(self, where: str, sensor: SensorSettings) -> Any:
        """Robot code's object of a sensor on CAN."""
        device = find_device(where, *sensor.keys[0])
        self._found.add(device.key)
        return device.hardware

    def _kind_of(self, slot: int) -> str:
        number = int(self._match.pieces.state.kind[slot])
        return self._match.game.pieces[number].kind.name

    # --- each tick ------------------------------------------------------------------------------------------------

    def _look_at_sensors(self) -> None:
        states = self._robot.sensor_states
        for name, sensor in self._piece_sensors.items():
            sensor.update()
            states[name] = sensor.is_active
        for name, limit in self._limits.items():
            states[name] = limit.is_pressed

    def _look_at_lights(self) -> None:
        robot = self._robot
        for maker in makers():
            for name, lights in maker.lights().items():
                if self._light_changes.get(name) != lights.changes:
                    self._light_changes[name] = lights.changes
                    robot.light_colors[name] = lights.colors
                    robot.light_requests[name] = lights.shows
        if self._ticks % _STRIP_EVERY == 0:
            for name, strip in self._strips.items():
                robot.light_colors[name] = _strip_colors(strip)


class _SlideRange:
    """A CANrange that looks at a mechanism which slides away from it."""

    def __init__(self, device: CANrangeSim, mechanism: ShaftSim, distance: float) -> None:
        self._device = device
        self._mechanism = mechanism
        self._distance = distance

    def write(self, position: float, velocity: float) -> None:
        """See `AnglePort`."""
        m = self._mechanism
        way = m.height if isinstance(m, ElevatorSim) else m.extension if isinstance(m, RackSim) else position
        self._device.write(max(0.0, self._distance + way))


def _candles() -> list[BuiltDevice]:
    return [device for maker in makers() for device in maker.built() if device.model == "CANdle"]


def _encoder(where: str, sensor: SensorSettings, mechanism: ShaftSim) -> AnglePort:
    model, channel = sensor.keys[0][0], sensor.keys[0][1].number
    gearing, reversed = abs(sensor.gearing), sensor.gearing < 0.0
    try:
        if sensor.kind == "encoder":
            return EncoderPort(
                channel,
                pulses_per_turn=sensor.pulses_per_turn,
                gearing=gearing,
                reversed=reversed,
                start=mechanism.position,
            )
        full_range = encoder_range(model, channel)
        return AbsoluteEncoderPort(
            (model, channel), zero=sensor.zero, full_range=full_range, gearing=gearing, reversed=reversed
        )
    except IndexError:
        said = f"the robot program reads no duty cycle on DIO {channel}"
        if sensor.kind == "encoder":
            said = f"DIO {channel} is channel A of no Encoder of the robot program"
        raise ConfigError(f"{where}: {said}; of DIO it builds: {ports_text('DIO')}") from None


def _strip_colors(strip: Any) -> IntArray:
    """Of each LED of a strip, 0xRRGGBB, shape (n,); dark until robot code has started it."""
    if not season.is_led_running(strip):
        return np.zeros(int(strip.get_length()), dtype=np.int64)
    return np.array([led.r << 16 | led.g << 8 | led.b for led in strip.get_data()], dtype=np.int64)


# --- words --------------------------------------------------------------------------------------------------------


def _port_text(sensor: SensorSettings) -> str:
    (model, _), numbers = sensor.keys[0], " ".join(str(address) for _, address in sensor.keys)
    return f"{model} {numbers}" + (f" pin {sensor.pin}" if sensor.pin else "")


def _meaning(sensor: SensorSettings) -> str:
    if sensor.sees is not None:
        return f"{sensor.name!r} {sensor.sees}"
    return f"{sensor.name!r}, {'distance' if sensor.kind == 'canrange' else sensor.kind} of {sensor.mechanism!r}"


def _by_class(ports: Any) -> list[str]:
    """`PWM 3 5 (VictorSP)`: ports of one class in one text."""
    groups: dict[tuple[str, str], list[int]] = {}
    for port in ports:
        groups.setdefault((port.model, port.made_by), []).extend(port.channels)
    return [str(BuiltPort(model, tuple(channels), made_by)) for (model, made_by), channels in groups.items()]
