"""Connection of a robot program's ports, pneumatics, sensors and lights to the simulated robot.

The tables `_OUTPUTS` and `_INPUTS` contain one function for each kind of wiring between `simcore.toml` and a port.
Telemetry records the lights of every program. `PortAssignment.idle` lists the unconnected ports. The module finds ports
by channel in the HAL's simulation data, so the location of robot code's objects does not matter.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from simcore import season
from simcore.errors import ConfigError
from simcore.match.match import Match
from simcore.quantities import DeviceKey
from simcore.robot.mechanisms import ElevatorSim, PistonSim, RackSim, ServoSim, ShaftSim
from simcore.robot.robot import Robot
from simcore.robot_file.robot_settings import PORT_CONTROLLERS, MechanismSettings, RobotSettings
from simcore.robot_file.sensor_tables import SensorSettings
from simcore.robotcode.program.makers import find_device, maker_of, makers
from simcore.robotcode.program.motor_controllers import BuiltDevice
from simcore.robotcode.program.motor_ports import AnglePort, MotorDevices, MotorPort
from simcore.robotcode.program.ownership import Ownership
from simcore.robotcode.sim.built_ports import BuiltPort, built_ports, pneumatics_module, ports_text
from simcore.robotcode.sim.piece_sensors import PieceSensor
from simcore.robotcode.sim.wpilib_ports import AbsoluteEncoderPort, ChannelMotor, EncoderPort, PWMMotorPort
from simcore.typing import IntArray

if TYPE_CHECKING:
    from simcore.robotcode.makers.phoenix6.sensor_ports import CANrangeSim

RobotState = season.wpilib.RobotState
AnalogInputSim = season.wpilib_simulation.AnalogInputSim
DIOSim = season.wpilib_simulation.DIOSim
PWMSim = season.wpilib_simulation.PWMSim
RelaySim = season.class_before_2027("wpilib.simulation", "RelaySim")

__all__ = ["PortAssignment"]

_STRIP_EVERY = 5  # number of ticks between two readings of an LED strip

Ask: TypeAlias = Callable[[float, bool], None]
"""Function that drives a mechanism. The arguments are the supply voltage [V] and whether outputs are enabled."""
Show: TypeAlias = Callable[[float, float], object]
"""Function that writes a sensor for a mechanism's position and velocity [rad, rad/s]; [m, m/s] for a piston."""
Switch: TypeAlias = Callable[[bool], object]
"""Function that writes a sensor. The argument is whether the switch is pressed or the sensor detects a piece."""


class _PortDevices:
    """`MotorDevices` that connect one mechanism to outputs and sensors on ports."""

    def __init__(self, mechanism: Any, ask: Ask | None = None, show: Show | None = None) -> None:
        self._mechanism = mechanism
        self._ask = ask
        self._show = show
        if ask is None:
            self.write()

    def read(self, battery_voltage: float, *, powered: bool = True) -> None:
        if self._ask is not None:
            self._ask(battery_voltage, powered)

    def write(self) -> None:
        if self._show is not None:
            self._show(self._mechanism.position, self._mechanism.velocity)


# --- outputs ------------------------------------------------------------------------------------------------------


def _servo(m: MechanismSettings, servo: ServoSim) -> Ask:
    """Return a function that moves a servo to the angle of the PWM pulse.

    The servo coasts without a pulse, while the robot is disabled, or while outputs are off.
    """
    pwm = PWMSim(m.leader.number)
    low, high = servo.stops[::-1] if m.reversed else servo.stops

    def ask(supply: float, powered: bool) -> None:
        if powered and RobotState.is_enabled() and pwm.get_pulse_microsecond() > 0:
            servo.set_goal(low + (high - low) * season.pwm_position(pwm))
        else:
            servo.coast()

    return ask


def _valve(m: MechanismSettings, piston: PistonSim) -> Ask:
    """Return a function that switches a cylinder's valve with one or two coils.

    All coils are off while the robot is disabled or outputs are off.
    """
    module, channels, out = pneumatics_module(m.module), m.channels, -12.0 if m.reversed else 12.0

    def ask(supply: float, powered: bool) -> None:
        is_on = powered and RobotState.is_enabled()
        coils = [is_on and bool(module.get_solenoid_output(channel)) for channel in channels]
        piston.set_volts(out * (float(coils[0]) - float(coils[1:] == [True])))

    return ask


def _pwm_motors(m: MechanismSettings, mechanism: ShaftSim) -> Ask:
    found = [port.device for port in built_ports() if port.model == "PWM" and m.leader.number in port.channels]
    # the leader's constructor call may be unrecorded, and a bare `PWM` has no inversion
    leader = next((device for device in found if hasattr(device, "setInverted")), None)
    return _motors(m, mechanism, [PWMMotorPort(number, leader=leader, coasts=m.coasts) for number in m.channels])


def _relay_motors(m: MechanismSettings, mechanism: ShaftSim) -> Ask:
    """Return a function that drives motors through Spike relays: full battery voltage in either direction, or off."""

    def share_of(relay: Any) -> Callable[[], float]:
        return lambda: float(relay.getForward()) - float(relay.getReverse())

    return _motors(m, mechanism, [ChannelMotor(share_of(RelaySim(n)), coasts=m.coasts) for n in m.channels])


def _motors(m: MechanismSettings, mechanism: ShaftSim, ports: Sequence[MotorPort]) -> Ask:
    """Return a function that drives a mechanism through controllers with one motor each.

    Motors on one shaft have the same speed. The total current therefore equals the current of all motors at the mean
    voltage. The mechanism coasts if outputs are off or all controllers are in coast at zero volts.
    """
    signs = [-1.0 if (device in m.opposed) != m.reversed else 1.0 for device in m.devices]

    def ask(supply: float, powered: bool) -> None:
        for port in ports:
            port.set_supply(supply)
        volts = [port.volts() for port in ports]
        if not powered or not any(shown or not port.is_open() for port, shown in zip(ports, volts, strict=True)):
            mechanism.coast()
        else:
            mechanism.set_volts(sum(sign * shown for sign, shown in zip(signs, volts, strict=True)) / len(ports))

    return ask


_OUTPUTS: dict[str, Callable[[MechanismSettings, Any], Ask]] = {
    "PWM": _pwm_motors,
    "Relay": _relay_motors,
    "Servo": _servo,
    "Solenoid": _valve,
}
"""Functions that build the `Ask` function of a mechanism, by controller name in `PORT_CONTROLLERS`."""


def _connect_mechanism(m: MechanismSettings, robot: Robot, ownership: Ownership) -> MotorDevices:
    """Connect a mechanism from `simcore.toml` to its ports and CANcoder, and return the connected devices.

    Raises:
        ConfigError: The program has not built one of the ports or the CANcoder.
    """
    where, mechanism = f"simcore.toml [[mechanism]] {m.name!r}", robot.mechanisms[m.name]
    _require_ports(where, m.keys)
    show: Show | None = None
    if m.cancoder is not None:
        cancoder = find_device(where, "CANcoder", m.cancoder)
        show = _geared(maker_of(cancoder).encoder_port(cancoder), m.cancoder_gearing)
        ownership.claim(cancoder.key, m.name)
    return _PortDevices(mechanism, _OUTPUTS[m.controller](m, mechanism), show)


def _geared(encoder: AnglePort, turns: float) -> Show:
    return lambda position, velocity: encoder.write(position * turns, velocity * turns)


def _require_ports(where: str, keys: Sequence[DeviceKey]) -> None:
    there = {key for port in built_ports() for key in port.keys}
    for model, channel in (key for key in keys if key not in there):
        raise ConfigError(
            f"{where}: the robot program builds nothing on {model} {channel}; of {model} it builds: {ports_text(model)}"
        )


# --- inputs -------------------------------------------------------------------------------------------------------


def _potentiometer(where: str, sensor: SensorSettings, mechanism: ShaftSim) -> Show:
    """Return a function that writes a potentiometer's voltage, a linear function of the position between the stops."""
    _require_ports(where, sensor.keys)
    sim, (low, high), (first, last) = AnalogInputSim(_channel(sensor)), mechanism.stops, sensor.volts
    return lambda position, velocity: sim.set_voltage(first + (position - low) * ((last - first) / (high - low)))


def _encoder(where: str, sensor: SensorSettings, mechanism: ShaftSim) -> Show:
    _require_ports(where, sensor.keys)
    model, channel, pulses = sensor.keys[0][0], _channel(sensor), sensor.pulses_per_turn
    mounting: dict[str, Any] = {"gearing": abs(sensor.gearing), "reversed": sensor.gearing < 0.0}
    try:
        if sensor.kind == "encoder":
            return EncoderPort(channel, pulses_per_turn=pulses, start=mechanism.position, **mounting).write
        return AbsoluteEncoderPort((model, channel), zero=sensor.zero, **mounting).write
    except IndexError:
        said = f"the robot program reads no duty cycle on DIO {channel}"
        if sensor.kind == "encoder":
            said = f"DIO {channel} is channel A of no Encoder of the robot program"
        raise ConfigError(f"{where}: {said}; of DIO it builds: {ports_text('DIO')}") from None


def _slide_range(where: str, sensor: SensorSettings, mechanism: ShaftSim) -> Show:
    """Return a function that writes the distance from a CANrange to a mechanism that slides away from the sensor."""
    device, m = _canrange(where, sensor), mechanism

    def show(position: float, velocity: float) -> None:
        way = m.height if isinstance(m, ElevatorSim) else m.extension if isinstance(m, RackSim) else position
        device.write(max(0.0, sensor.distance + way))

    return show


_INPUTS: dict[str, Callable[[str, SensorSettings, ShaftSim], Show]] = {
    "encoder": _encoder,
    "duty cycle encoder": _encoder,
    "analog encoder": _encoder,
    "potentiometer": _potentiometer,
    "canrange": _slide_range,
}
"""Functions that build the `Show` function of a mechanism sensor other than a limit switch, by sensor kind."""


def _channel(sensor: SensorSettings) -> int:
    return sensor.keys[0][1].number


def _canrange(where: str, sensor: SensorSettings) -> CANrangeSim:
    from simcore.robotcode.makers.phoenix6.sensor_ports import CANrangeSim

    return CANrangeSim(find_device(where, *sensor.keys[0]).hardware)


def _switch(where: str, sensor: SensorSettings) -> Switch:
    """Return a function that writes the state of a switch or beam break on a CANdi or DIO.

    An open contact on a DIO reads True.
    """
    if sensor.keys[0][0] == "CANdi":
        from simcore.robotcode.makers.phoenix6.sensor_ports import CANdiSwitchSim

        candi = find_device(where, *sensor.keys[0]).hardware
        return CANdiSwitchSim(candi, sensor.pin, normally_closed=sensor.normally_closed).set_active
    _require_ports(where, sensor.keys)
    sim = DIOSim(_channel(sensor))
    sim.set_value(not sensor.normally_closed)
    return lambda is_active: sim.set_value(is_active == sensor.normally_closed)


def _range(where: str, sensor: SensorSettings) -> Switch:
    """Return a function that writes the distance of a CANrange with or without a piece in front."""
    canrange = _canrange(where, sensor)
    return lambda is_seen: canrange.write(sensor.distance if is_seen else sensor.empty)


class PortAssignment:
    """Connections between one robot and the ports, sensors and lights of the robot program.

    Args:
        match: Match that contains the robot.
        robot: Robot in the match.
        settings: Settings from `simcore.toml`.
        ownership: Record of the mechanism that owns each device.

    Raises:
        ConfigError: The program has not built a device in `simcore.toml`, or the robot lacks a part in `simcore.toml`.
    """

    def __init__(self, match: Match, robot: Robot, settings: RobotSettings, ownership: Ownership) -> None:
        self._match = match
        self._robot = robot
        self._settings = settings
        self.of_drivetrain: Sequence[Any] = ()
        """Robot code's objects on the ports that the drivetrain uses."""
        self._ticks = 0
        self._light_changes: dict[str, int] = {}
        strips = [port.channels[0] for port in built_ports() if port.made_by == "AddressableLED"]
        self._strips = {f"AddressableLED{n}": season.led_sim(n) for n in strips}
        self._readers: dict[str, Callable[[], bool]] = {}
        """Functions that return whether a sensor is pressed or detects a piece now, by sensor name."""
        on_ports = (m for m in settings.mechanisms if m.controller in PORT_CONTROLLERS)
        self.devices: list[MotorDevices] = [_connect_mechanism(m, robot, ownership) for m in on_ports]
        """Connections of mechanisms to outputs, and then connections of mechanisms to sensors."""
        for sensor in settings.sensors:
            self._connect(f"simcore.toml [[sensor]] {sensor.name!r}", sensor)
        self._look_at_sensors()

    @property
    def keys(self) -> set[DeviceKey]:
        """Keys of the devices that this object simulates: CANdis and CANranges in `simcore.toml`, and CANdles."""
        sensors = [s.keys[0] for s in self._settings.sensors if s.keys[0][0] in ("CANdi", "CANrange")]
        return {device.key for device in (*(find_device("", *key) for key in sensors), *_candles())}

    def after_tick(self) -> None:
        """Update the piece sensors, and copy sensor states and light colors to the robot for telemetry."""
        self._look_at_sensors()
        self._look_at_lights()
        self._ticks += 1

    @property
    def sensors(self) -> list[tuple[str, str]]:
        """Texts (port, meaning) that describe each sensor in `simcore.toml`."""
        return [(_port_text(sensor), _meaning(sensor)) for sensor in self._settings.sensors]

    @property
    def lights(self) -> list[str]:
        """Texts that describe the CANdles and LED strips in the robot program."""
        return [*map(str, _candles())] + [str(port) for port in built_ports() if port.made_by == "AddressableLED"]

    @property
    def idle(self) -> list[str]:
        """Texts that describe the unconnected ports, grouped by class.

        An unconnected output has no effect, and an unconnected input keeps the idle value.
        """
        taken = {key for sensor in self._settings.sensors for key in sensor.keys}
        taken |= {key for m in self._settings.mechanisms for key in m.keys}
        ports = [p for p in built_ports() if p.made_by != "AddressableLED" and taken.isdisjoint(p.keys)]
        return _by_class([p for p in ports if not any(p.device is device for device in self.of_drivetrain)])

    # --- connecting -----------------------------------------------------------------------------------------------

    def _connect(self, where: str, sensor: SensorSettings) -> None:
        if sensor.sees is not None:
            self._watch_pieces(where, sensor)
            return
        assert sensor.mechanism is not None
        mechanism = self._robot.mechanisms[sensor.mechanism]
        if sensor.kind == "limit switch":
            show = self._limit(where, sensor)
        else:
            show = _INPUTS[sensor.kind](where, sensor, mechanism)
        self.devices.append(_PortDevices(mechanism, show=show))

    def _watch_pieces(self, where: str, sensor: SensorSettings) -> None:
        assert sensor.sees is not None
        eye = PieceSensor(sensor.sees, self._robot, self._kind_of)
        show = (_switch if sensor.kind == "beam break" else _range)(where, sensor)

        def look() -> bool:
            is_seen = eye.look()
            show(is_seen)
            return is_seen

        self._readers[sensor.name] = look

    def _limit(self, where: str, sensor: SensorSettings) -> Show:
        """Return a function that writes a limit switch. The switch is pressed in a range of mechanism positions."""
        switch, (low, high), is_pressed = _switch(where, sensor), sensor.pressed, [False]

        def show(position: float, velocity: float) -> None:
            is_pressed[0] = low <= position <= high
            switch(is_pressed[0])

        self._readers[sensor.name] = lambda: is_pressed[0]
        return show

    def _kind_of(self, slot: int) -> str:
        number = int(self._match.pieces.state.kind[slot])
        return self._match.game.pieces[number].kind.name

    # --- each tick ------------------------------------------------------------------------------------------------

    def _look_at_sensors(self) -> None:
        for name, look in self._readers.items():
            self._robot.sensor_states[name] = look()

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


def _candles() -> list[BuiltDevice]:
    return [device for maker in makers() for device in maker.built() if device.model == "CANdle"]


def _strip_colors(strip: Any) -> IntArray:
    """Return the color of each LED of a strip as 0xRRGGBB, shape (n,); black until robot code starts the strip."""
    if not season.is_led_running(strip):
        return np.zeros(int(strip.get_length()), dtype=np.int64)
    return np.array([led.r << 16 | led.g << 8 | led.b for led in strip.get_data()], dtype=np.int64)


# --- text ---------------------------------------------------------------------------------------------------------


def _port_text(sensor: SensorSettings) -> str:
    (model, _), numbers = sensor.keys[0], " ".join(str(address) for _, address in sensor.keys)
    return f"{model} {numbers}" + (f" pin {sensor.pin}" if sensor.pin else "")


def _meaning(sensor: SensorSettings) -> str:
    if sensor.sees is not None:
        return f"{sensor.name!r} {sensor.sees}"
    return f"{sensor.name!r}, {'distance' if sensor.kind == 'canrange' else sensor.kind} of {sensor.mechanism!r}"


def _by_class(ports: Sequence[BuiltPort]) -> list[str]:
    """Return one text for each kind of port and WPILib class, for example `PWM 3 5 (VictorSP)`."""
    groups: dict[tuple[str, str], list[int]] = {}
    for port in ports:
        groups.setdefault((port.model, port.made_by), []).extend(port.channels)
    return [str(BuiltPort(model, tuple(channels), made_by)) for (model, made_by), channels in groups.items()]
