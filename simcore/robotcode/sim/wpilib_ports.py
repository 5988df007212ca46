"""WPILib's own devices: motor controllers on PWM and relays, encoders on DIO and analog inputs, gyros.

Each is a port of a drivetrain or a mechanism, and all are one maker's. None runs on the wall clock, so a robot of
these devices can be stepped as fast as the machine allows, and repeats exactly.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from simcore import season
from simcore.errors import ConfigError
from simcore.quantities import GEARING, DeviceAddress, require
from simcore.robot_file.drivetrain_table import ON_PORTS
from simcore.robotcode.program.makers import Maker, MotorFacts
from simcore.robotcode.program.motor_controllers import BuiltDevice, FollowerGroup, group_by_leader
from simcore.robotcode.program.motor_ports import AnglePort, GyroPort, MotorPort
from simcore.robotcode.program.recorder import Answers, after_call
from simcore.robotcode.sim.built_ports import BuiltPort, built_ports, encoder_range
from simcore.typing import FloatSupplier

wpilib = season.wpilib
ADIS16448_IMU = season.class_before_2027("wpilib", "ADIS16448_IMU")
ADIS16470_IMU = season.class_before_2027("wpilib", "ADIS16470_IMU")
ADXRS450_Gyro = season.class_before_2027("wpilib", "ADXRS450_Gyro")
AnalogEncoder = season.wpilib.AnalogEncoder
AnalogGyro = season.class_before_2027("wpilib", "AnalogGyro")
DutyCycleEncoder = season.wpilib.DutyCycleEncoder
RobotState = season.wpilib.RobotState
ADXRS450_GyroSim = season.class_before_2027("wpilib.simulation", "ADXRS450_GyroSim")
AnalogGyroSim = season.class_before_2027("wpilib.simulation", "AnalogGyroSim")
AnalogInputSim = season.wpilib_simulation.AnalogInputSim
DutyCycleSim = season.wpilib_simulation.DutyCycleSim
EncoderSim = season.wpilib_simulation.EncoderSim
PWMSim = season.wpilib_simulation.PWMSim
SimDeviceSim = season.wpilib_simulation.SimDeviceSim

__all__ = [
    "MAKER", "ADISGyroPort", "AbsoluteEncoderPort", "ChannelMotor", "EncoderPort", "PWMMotorPort", "WPILibGyroPort",
]  # fmt: skip

_RAIL = 5.0  # [V] at the roboRIO's analog inputs


class ChannelMotor(MotorPort):
    """Motor controller on a port of the roboRIO, without sensor and configuration; off while disabled.

    Args:
        share: Returns its duty cycle [-].
        coasts: Whether zero opens the circuit instead of braking.
    """

    def __init__(self, share: FloatSupplier, *, coasts: bool = False) -> None:
        self._share = share
        self._coasts = coasts
        self._supply = 12.0

    def set_supply(self, volts: float) -> None:
        """Set the voltage at its terminals [V]."""
        self._supply = volts

    def is_open(self) -> bool:
        """Return whether the circuit is open at zero."""
        return self._coasts

    def volts(self) -> float:
        """Return the voltage on the motor [V]."""
        return self._share() * self._supply if RobotState.is_enabled() else 0.0

    def duty_cycle(self) -> float:
        """Return the duty cycle, its only output [-]."""
        return self.volts() / self._supply

    def write(self, rotations: float, rps: float) -> None:
        """Ignore the rotor, which no sensor reads; see `MotorPort`."""


class PWMMotorPort(ChannelMotor):
    """A PWM motor controller without its own encoder: `PWMSparkMax`, `Talon`, `VictorSP`.

    Signs are those of robot code, whatever `setInverted` says; the roboRIO resolves the output to 0.4 %.
    Disabled, the roboRIO holds PWM neutral; WPILib's simulation does not, so this class does.

    Args:
        controller: Controller of robot code, or its channel; followers (`addFollower`) need no port.
        leader: Robot code's first controller on the shaft, whose inversion counts; None: that of
            `controller`, without inversion for a channel.
        coasts: Whether its jumper says coast instead of brake.
    """

    def __init__(self, controller: Any, *, leader: Any = None, coasts: bool = False) -> None:
        is_channel = isinstance(controller, int)
        sim = PWMSim(controller if is_channel else controller.get_channel())
        inverting = controller if leader is None and not is_channel else leader

        def share() -> float:
            speed = season.pwm_speed(sim)
            return -speed if inverting is not None and inverting.get_inverted() else speed

        super().__init__(share, coasts=coasts)


class EncoderPort:
    """A quadrature `Encoder` on a shaft: zero at the shaft's first position, and where robot code resets it.

    Positive is forward, whatever the encoder's configured direction.

    Args:
        encoder: Encoder of robot code, with its distance per pulse set; or its DIO channel A.
        pulses_per_turn: Pulses per turn of the encoder.
        gearing: Turns of the encoder per turn of the model's shaft (wheel, azimuth, mechanism) [-].
        reversed: Whether it counts down while the shaft turns in the positive direction.
        start: Initial angle of the shaft [rad].

    Raises:
        ConfigError: A number is not above zero.
    """

    def __init__(
        self,
        encoder: Any,
        *,
        pulses_per_turn: float,
        gearing: float = 1.0,
        reversed: bool = False,
        start: float = 0.0,
    ) -> None:
        require("EncoderPort", "pulses_per_turn", pulses_per_turn, GEARING)
        require("EncoderPort", "gearing", gearing, GEARING)
        self._sim = EncoderSim.create_for_channel(encoder) if isinstance(encoder, int) else EncoderSim(encoder)
        self._per_rad = pulses_per_turn * (-gearing if reversed else gearing) / math.tau
        self._base = self._written = start * self._per_rad

    def write(self, angle: float, rate: float) -> None:
        """Write whole counts; see `AnglePort`."""
        if self._sim.get_reset():
            self._base = self._written
        pulses = angle * self._per_rad
        self._sim.set_count(round(pulses - self._base))
        self._sim.set_rate(rate * self._per_rad * self._sim.get_distance_per_pulse())
        self._sim.set_direction(rate * self._per_rad > 0.0)
        self._written = pulses


class AbsoluteEncoderPort:
    """A `DutyCycleEncoder` or `AnalogEncoder` on a shaft: knows its angle from the start.

    These have their own position in simulation; a bare `DutyCycle` reads the duty cycle of the pulse and an
    `AnalogInput` or `AnalogPotentiometer` the volts of that angle.

    Args:
        encoder: Encoder of robot code; or its port, `("DIO", 4)` or `("Analog", 0)`, whatever class reads it.
        zero: Reading of `get()` while the module points forward, in the encoder's own unit.
        gearing: Turns of the encoder per turn of the shaft [-].
        reversed: Whether it counts down while the module turns counter-clockwise.

    Raises:
        ConfigError: It is neither of the two.
    """

    def __init__(self, encoder: Any, *, zero: float = 0.0, gearing: float = 1.0, reversed: bool = False) -> None:
        model, channel = _port_of(encoder)
        device = f"DutyCycle:DutyCycleEncoder[{channel}]" if model == "DIO" else f"AnalogEncoder[{channel}]"
        self._position = None
        if device in SimDeviceSim.enumerate_devices():
            self._position = SimDeviceSim(device).get_double("Position")
        self._show: Callable[[float], object]
        if model == "DIO":
            self._show, self._per_turn = DutyCycleSim.create_for_channel(channel).set_output, 1.0
        else:
            self._show, self._per_turn = AnalogInputSim(channel).set_voltage, _RAIL
        self._turns_per_rad = (-gearing if reversed else gearing) / math.tau
        self._range = encoder_range(model, channel)
        self._zero = zero / self._range

    def write(self, angle: float, rate: float) -> None:
        """Write the angle within one turn; see `AnglePort`."""
        turns = (self._zero + angle * self._turns_per_rad) % 1.0
        if self._position is not None:
            self._position.set(turns * self._range)
        self._show(turns * self._per_turn)


def _port_of(encoder: Any) -> tuple[str, int]:
    """Return model and channel of an absolute encoder."""
    if isinstance(encoder, tuple):
        return encoder
    if isinstance(encoder, DutyCycleEncoder):
        return "DIO", encoder.get_source_channel()
    if isinstance(encoder, AnalogEncoder):
        return "Analog", encoder.get_channel()
    raise ConfigError(f"AbsoluteEncoderPort: want a DutyCycleEncoder or AnalogEncoder, got {type(encoder).__name__}")


class WPILibGyroPort:
    """An `ADXRS450_Gyro` or `AnalogGyro`: clockwise positive in degrees, like the devices; `reset()` works.

    Another simulation's value lasts until the next `write`.

    Args:
        gyro: Gyro of robot code.

    Raises:
        ConfigError: It is neither of the two.
    """

    def __init__(self, gyro: Any) -> None:
        if isinstance(gyro, ADXRS450_Gyro):
            self._sim: Any = ADXRS450_GyroSim(gyro)
        elif isinstance(gyro, AnalogGyro):
            self._sim = AnalogGyroSim(gyro)
        else:
            raise ConfigError(f"WPILibGyroPort: want an ADXRS450_Gyro or AnalogGyro, got {type(gyro).__name__}")
        self._turned = self._zero = 0.0  # clockwise [deg]
        _analog.attach(gyro, self)
        for cls in (ADXRS450_Gyro, AnalogGyro):
            _analog.wrap(cls, {"reset": lambda port: port.reset()}, also_original=True)

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """Write the yaw, its only measurement; see `simcore.robotcode.program.motor_ports.GyroPort`."""
        self._turned = -math.degrees(yaw)
        self._sim.setAngle(self._turned - self._zero)
        self._sim.setRate(-math.degrees(rates[2]))

    def reset(self) -> None:
        """Zero its angle, as robot code asks."""
        self._zero = self._turned


_analog = Answers[WPILibGyroPort]()

_AXES = ("x", "y", "z")


class ADISGyroPort:
    """An `ADIS16448_IMU` or `ADIS16470_IMU`: counter-clockwise positive in degrees about each of its axes.

    Its configured axes give the mounting, each pointing forward, left or up. WPILib's simulation has no `reset`,
    does not set the tilt from the accelerometer, and `calibrate` of the ADIS16470 ends the program: this class
    replaces them. Not simulated: accelerometer, magnetometer.

    Args:
        imu: IMU of robot code.
    """

    def __init__(self, imu: Any) -> None:
        made: Any = imu
        is_16470 = isinstance(imu, ADIS16470_IMU)
        sim = SimDeviceSim(f"Gyro:{'ADIS16470' if is_16470 else 'ADIS16448'}[{imu.getPort()}]")
        self._angles = [sim.get_double(f"gyro_angle_{axis}") for axis in _AXES]
        self._rates = [sim.get_double(f"gyro_rate_{axis}") for axis in _AXES]
        yaw = int(imu.getYawAxis())
        pitch, roll = (int(made.getPitchAxis()), int(made.getRollAxis())) if is_16470 else _others(yaw)
        self._places = (roll, pitch, yaw)  # places that read rotation about the robot's x, y, z
        self._turned = [0.0, 0.0, 0.0]  # about the sensor's axes [deg]
        self._shown = [0.0, 0.0, 0.0]
        _adis.attach(imu, self)

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """See `simcore.robotcode.program.motor_ports.GyroPort`."""
        for place, angle, rate in zip(self._places, (roll, pitch, yaw), rates, strict=True):
            turned = math.degrees(angle)
            self.set_angle(place, self._shown[place] + turned - self._turned[place])
            self._turned[place] = turned
            self._rates[place].set(math.degrees(rate))

    def set_angle(self, place: int, angle: float) -> None:
        """Set the reading of an axis, by number [deg]."""
        self._shown[place] = angle
        self._angles[place].set(angle)

    def reset(self) -> None:
        """Zero all angles."""
        for place in range(3):
            self.set_angle(place, 0.0)

    def tilt(self, number: int) -> float:
        """Return the tilt by gravity about the robot's x (0) or y (1) [deg]."""
        return self._turned[self._places[number]]

    def place_of(self, axis: Any) -> int:
        """Return the number of an axis that robot code names: a sensor's axis, or yaw, pitch or roll."""
        return {3: self._places[2], 4: self._places[1], 5: self._places[0]}.get(int(axis), int(axis))


def _others(yaw: int) -> tuple[int, int]:
    """Return axes for pitch and roll of an ADIS16448, which defines its yaw axis alone."""
    roll, pitch = (axis for axis in range(3) if axis != yaw)
    return pitch, roll


_adis = Answers[ADISGyroPort]()


def _answer_for_adis() -> None:
    """Replace the methods of both that WPILib's simulation lacks; may be called again."""
    common: dict[str, Any] = {
        "reset": lambda port: port.reset(),
        "calibrate": lambda port: port.reset(),
        "getXComplementaryAngle": lambda port: port.tilt(0),
        "getYComplementaryAngle": lambda port: port.tilt(1),
        "getXFilteredAccelAngle": lambda port: port.tilt(0),
        "getYFilteredAccelAngle": lambda port: port.tilt(1),
    }
    settable: dict[str, Any] = {
        "setGyroAngle": lambda port, axis, angle: port.set_angle(port.place_of(axis), angle),
        **{
            f"setGyroAngle{axis.upper()}": lambda port, angle, place=place: port.set_angle(place, angle)
            for place, axis in enumerate(_AXES)
        },
    }
    if not hasattr(ADIS16448_IMU, "reset"):
        return  # a season without these classes
    _adis.wrap(ADIS16448_IMU, common)
    _adis.wrap(ADIS16470_IMU, common | settable)


# --- the maker ------------------------------------------------------------------------------------------------------

_MOTORS = {"PWMSparkMax": "NEO", "PWMSparkFlex": "NEO Vortex", "PWMTalonFX": "Falcon 500"}
"""Usual motor behind each PWM controller; behind others it is a CIM."""
_PULSES = 2048.0
"""Pulses of an `Encoder` per turn of its shaft; any number works, as robot code sets the distance per pulse."""
_GYROS = ("ADIS16448_IMU", "ADIS16470_IMU", "ADXRS450_Gyro", "AnalogGyro")
_followers: list[tuple[Any, Any]] = []
"""Pairs of leader and follower on PWM from `addFollower`."""


class _WPILib(Maker):
    name = "WPILib (ports of the roboRIO)"
    motors = ("PWM",)
    pulse_encoders = ("Encoder",)
    encoders = ("Encoder", *ON_PORTS)
    gyros = _GYROS
    gyro_errors = "generic"
    unserved = ("ADXL345_I2C", "ADXL345_SPI", "ADXL362", "I2C", "SPI", "SerialPort")
    sim_devices = ("DutyCycle:", "AnalogEncoder[", "Ultrasonic[", "Gyro:")

    on_ports = True

    def watch(self) -> None:
        _answer_for_adis()
        for name in _GYROS:
            self.devices.record(season.class_before_2027("wpilib", name), name, _port_of_gyro)
        after_call(
            wpilib.PWMMotorController, season.own_name(wpilib.PWMMotorController, "add_follower"), _note_follower
        )

    def groups(self, motors: Sequence[BuiltDevice]) -> list[FollowerGroup]:
        leaders = {id(follower): leader for leader, follower in _followers}
        return group_by_leader(motors, lambda d: (leaders.get(id(d.hardware)), False))

    def built(self) -> list[BuiltDevice]:
        ports = (port for port in built_ports() if port.device is not None and _model(port))
        return [
            *(BuiltDevice(_model(p), DeviceAddress(p.channels[0]), p.device) for p in ports),
            *self.devices.devices(),
        ]

    def device_of(self, made: Any) -> BuiltDevice | None:
        if not type(made).__module__.startswith("wpilib") and not isinstance(made, wpilib.PWMMotorController):
            return None
        return next((d for d in self.built() if d.hardware is made), None)

    def facts(self, motor: BuiltDevice) -> MotorFacts:
        made_by = next((c.__name__ for c in type(motor.hardware).__mro__ if c.__name__ in _MOTORS), "")
        return MotorFacts(motor=_MOTORS.get(made_by, "CIM"))

    def motor_port(self, motor: BuiltDevice) -> MotorPort:
        return PWMMotorPort(motor.hardware)

    def encoder_port(self, encoder: BuiltDevice, port: MotorPort | None = None) -> AnglePort:
        if encoder.model == "Encoder":
            return EncoderPort(encoder.hardware, pulses_per_turn=_PULSES)
        model = "DIO" if encoder.model.startswith("DutyCycle") else "Analog"
        return AbsoluteEncoderPort((model, encoder.address.number))

    def gyro_port(self, gyro: BuiltDevice) -> GyroPort:
        return (ADISGyroPort if gyro.model.startswith("ADIS") else WPILibGyroPort)(gyro.hardware)


def _model(port: BuiltPort) -> str:
    if port.made_by in _WPILib.encoders:
        return port.made_by
    return "PWM" if isinstance(port.device, wpilib.PWMMotorController) else ""


def _note_follower(leader: Any, _: Any, args: tuple[Any, ...], settings: dict[str, Any]) -> None:
    _followers.append((leader, next(iter((*args, *settings.values())))))


def _port_of_gyro(made: Any, args: tuple[Any, ...], settings: dict[str, Any]) -> DeviceAddress:
    return DeviceAddress(next((int(value) for value in (*args, *settings.values()) if isinstance(value, int)), 0))


MAKER = _WPILib()
"""Maker object; see `simcore.robotcode.program.makers`."""
