"""WPILib's own devices as ports of a drivetrain or a mechanism: motor controllers on PWM and relays, encoders, gyros.

Nothing here lives on the wall clock, so a robot of these devices can be stepped as fast as the machine can, and does
exactly the same every time.
"""

from __future__ import annotations

import math
import weakref
from collections.abc import Callable, Sequence
from typing import Any

from simcore import season
from simcore.devices.answers import Answers
from simcore.devices.motor_ports import MotorPort
from simcore.devices.recorder import after_call
from simcore.errors import ConfigError, UnknownNameError
from simcore.quantities import GEARING, POSITIVE, require

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
RelaySim = season.class_before_2027("wpilib.simulation", "RelaySim")
SimDeviceSim = season.wpilib_simulation.SimDeviceSim

__all__ = [
    "ADISGyroPort",
    "AbsoluteEncoderPort",
    "EncoderPort",
    "PWMMotorPort",
    "RelayPort",
    "SimDeviceGyroPort",
    "WPILibGyroPort",
    "answer_for_adis",
]

_RAIL = 5.0  # [V] at the roboRIO's analog inputs


class _ChannelPort(MotorPort):
    """What ports without a sensor or a configuration have in common.

    Args:
        coasts: Whether zero opens the circuit instead of braking.
    """

    def __init__(self, *, coasts: bool) -> None:
        self._coasts = coasts
        self._supply = 12.0

    def set_supply(self, volts: float) -> None:
        """Voltage at its terminals [V]."""
        self._supply = volts

    def is_open(self) -> bool:
        """Whether the circuit is open at zero."""
        return self._coasts

    def duty_cycle(self) -> float:
        """A share of its supply is all that it knows [-]."""
        return self.volts() / self._supply

    def write(self, rotations: float, rps: float) -> None:
        """Nobody reads it."""


class PWMMotorPort(_ChannelPort):
    """A PWM motor controller without an encoder of its own: `PWMSparkMax`, `Talon`, `VictorSP`.

    Positive is what robot code calls positive, whatever `setInverted` says; the roboRIO resolves the output to 0.4 %.
    Disabled, it holds PWM neutral; WPILib's simulation does not, so this does.

    Args:
        controller: Of the robot code, or its channel; followers (`addFollower`) need no port of their own.
        leader: The robot code's object of the first controller on the shaft, whose inversion counts; None: that of
            `controller`, and of a mere channel none.
        coasts: Whether its jumper says coast instead of brake.
    """

    def __init__(self, controller: Any, *, leader: Any = None, coasts: bool = False) -> None:
        super().__init__(coasts=coasts)
        is_channel = isinstance(controller, int)
        self._sim = PWMSim(controller if is_channel else controller.get_channel())
        self._leader = controller if leader is None and not is_channel else leader

    def volts(self) -> float:
        """Its duty cycle of the supply [V]; the roboRIO holds PWM neutral while disabled, its simulation does not."""
        if not RobotState.is_enabled():
            return 0.0
        volts = season.pwm_speed(self._sim) * self._supply
        return -volts if self._leader is not None and self._leader.get_inverted() else volts


class RelayPort(_ChannelPort):
    """A Spike on a relay channel: the whole battery one way or the other, or nothing.

    Args:
        channel: Of the roboRIO.
        coasts: Whether nothing opens the circuit instead of braking.
    """

    def __init__(self, channel: int, *, coasts: bool = False) -> None:
        super().__init__(coasts=coasts)
        self._sim = RelaySim(channel)

    def volts(self) -> float:
        """What it puts on the motor [V]."""
        if not RobotState.is_enabled():
            return 0.0
        return self._supply * (float(self._sim.getForward()) - float(self._sim.getReverse()))


class EncoderPort:
    """A quadrature `Encoder` on a shaft: zero where the shaft is at first, and where robot code resets it.

    Positive is forward, whatever direction the encoder is configured with.

    Args:
        encoder: Of the robot code, with its distance per pulse set; or the DIO channel A of it.
        pulses_per_turn: Of the encoder, per turn of itself.
        gearing: Turns of the encoder per turn of the shaft that the model moves (wheel, azimuth, mechanism) [-].
        reversed: Whether it counts down while that turns the positive way.
        start: Angle of the shaft at first [rad].

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
        """See `AnglePort`; counts are whole."""
        if self._sim.get_reset():
            self._base = self._written
        pulses = angle * self._per_rad
        self._sim.set_count(round(pulses - self._base))
        self._sim.set_rate(rate * self._per_rad * self._sim.get_distance_per_pulse())
        self._sim.set_direction(rate * self._per_rad > 0.0)
        self._written = pulses


class AbsoluteEncoderPort:
    """A `DutyCycleEncoder` or `AnalogEncoder` on a shaft: knows its angle from the start.

    These read a position of their own in simulation; a bare `DutyCycle` reads the share of the pulse and an
    `AnalogInput` or `AnalogPotentiometer` volts, which are those of the same angle.

    Args:
        encoder: Of the robot code; or its port, `("DIO", 4)` or `("Analog", 0)`, whatever class reads it.
        zero: What `get()` shows while the module points ahead, in the encoder's own unit.
        full_range: What a whole turn is, in the same unit; 1 unless robot code has said otherwise.
        gearing: Turns of the encoder per turn of the shaft [-].
        reversed: Whether it counts down while the module turns counter-clockwise.

    Raises:
        ConfigError: It is neither of the two, or the range is not above zero.
    """

    def __init__(
        self,
        encoder: Any,
        *,
        zero: float = 0.0,
        full_range: float = 1.0,
        gearing: float = 1.0,
        reversed: bool = False,
    ) -> None:
        require("AbsoluteEncoderPort", "full_range", full_range, POSITIVE)
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
        self._zero = zero / full_range
        self._range = full_range

    def write(self, angle: float, rate: float) -> None:
        """See `AnglePort`; within one turn."""
        turns = (self._zero + angle * self._turns_per_rad) % 1.0
        if self._position is not None:
            self._position.set(turns * self._range)
        self._show(turns * self._per_turn)


def _port_of(encoder: Any) -> tuple[str, int]:
    """Model and channel of an absolute encoder."""
    if isinstance(encoder, tuple):
        return encoder
    if isinstance(encoder, DutyCycleEncoder):
        return "DIO", encoder.get_source_channel()
    if isinstance(encoder, AnalogEncoder):
        return "Analog", encoder.get_channel()
    raise ConfigError(f"AbsoluteEncoderPort: want a DutyCycleEncoder or AnalogEncoder, got {type(encoder).__name__}")


class WPILibGyroPort:
    """An `ADXRS450_Gyro` or `AnalogGyro`: clockwise positive in degrees, as these are; `reset()` works.

    What another simulation writes into it lasts until the next `write`.

    Args:
        gyro: Of the robot code.

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
        _gyros[gyro] = self
        for cls in (ADXRS450_Gyro, AnalogGyro):
            after_call(cls, "reset", _note_reset)

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """See `simcore.devices.motor_ports.GyroPort`; only yaw is measured."""
        self._turned = -math.degrees(yaw)
        self._sim.setAngle(self._turned - self._zero)
        self._sim.setRate(-math.degrees(rates[2]))

    def reset(self) -> None:
        """Robot code has made its angle zero."""
        self._zero = self._turned


_gyros: weakref.WeakKeyDictionary[Any, WPILibGyroPort] = weakref.WeakKeyDictionary()


def _note_reset(gyro: Any, _: Any, args: tuple[Any, ...], settings: dict[str, Any]) -> None:
    if gyro in _gyros:
        _gyros[gyro].reset()


_AXES = ("x", "y", "z")


class ADISGyroPort:
    """An `ADIS16448_IMU` or `ADIS16470_IMU`: counter-clockwise positive in degrees about each of its axes.

    Mounted as its configured axes say, each pointing forward, to the left or up. WPILib's simulation knows no `reset`,
    its tilt from the accelerometer is not set at all, and `calibrate` of the ADIS16470 ends the program: all are
    answered here. Not simulated: accelerometer, magnetometer.

    Args:
        imu: Of the robot code.
    """

    def __init__(self, imu: Any) -> None:
        made: Any = imu
        is_16470 = isinstance(imu, ADIS16470_IMU)
        sim = SimDeviceSim(f"Gyro:{'ADIS16470' if is_16470 else 'ADIS16448'}[{imu.getPort()}]")
        self._angles = [sim.get_double(f"gyro_angle_{axis}") for axis in _AXES]
        self._rates = [sim.get_double(f"gyro_rate_{axis}") for axis in _AXES]
        yaw = int(imu.getYawAxis())
        pitch, roll = (int(made.getPitchAxis()), int(made.getRollAxis())) if is_16470 else _others(yaw)
        self._places = (roll, pitch, yaw)  # where what turns about the robot's x, y, z is read
        self._turned = [0.0, 0.0, 0.0]  # about the sensor's axes [deg]
        self._shown = [0.0, 0.0, 0.0]
        _adis.attach(imu, self)

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """See `simcore.devices.motor_ports.GyroPort`."""
        for place, angle, rate in zip(self._places, (roll, pitch, yaw), rates, strict=True):
            turned = math.degrees(angle)
            self.set_angle(place, self._shown[place] + turned - self._turned[place])
            self._turned[place] = turned
            self._rates[place].set(math.degrees(rate))

    def set_angle(self, place: int, angle: float) -> None:
        """Make an axis, by number, read this [deg]."""
        self._shown[place] = angle
        self._angles[place].set(angle)

    def reset(self) -> None:
        """Make all angles zero."""
        for place in range(3):
            self.set_angle(place, 0.0)

    def tilt(self, number: int) -> float:
        """By gravity, about the robot's x (0) or y (1) [deg]."""
        return self._turned[self._places[number]]

    def place_of(self, axis: Any) -> int:
        """Number of an axis that robot code names: of the sensor, or yaw, pitch or roll."""
        return {3: self._places[2], 4: self._places[1], 5: self._places[0]}.get(int(axis), int(axis))


def _others(yaw: int) -> tuple[int, int]:
    """Axes for pitch and roll of an ADIS16448, which knows its yaw axis alone."""
    roll, pitch = (axis for axis in range(3) if axis != yaw)
    return pitch, roll


_adis = Answers[ADISGyroPort]()


def answer_for_adis() -> None:
    """Answer what WPILib's simulation of both does not; again is harmless."""
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
        return  # a season without them
    _adis.wrap(ADIS16448_IMU, common)
    _adis.wrap(ADIS16470_IMU, common | settable)


class SimDeviceGyroPort:
    """A gyro of any maker that shows a WPILib `SimDevice`, such as a navX (`navX-Sensor[4]`, value `Yaw`).

    Args:
        device: Name of the SimDevice.
        yaw: Name of its yaw value, in degrees.
        rate: Name of its yaw rate value, in degrees a second; None: it has none.
        clockwise: Whether it counts clockwise positive, as a navX does.

    Raises:
        ConfigError: The device has no such value.
        UnknownNameError: There is no such device; it names those that there are.
    """

    def __init__(self, device: str, *, yaw: str = "Yaw", rate: str | None = None, clockwise: bool = True) -> None:
        known = SimDeviceSim.enumerate_devices()
        if device not in known:
            raise UnknownNameError("SimDevice", device, known)
        sim = SimDeviceSim(device)
        self._yaw = _value(sim, device, yaw)
        self._rate = None if rate is None else _value(sim, device, rate)
        self._sign = -1.0 if clockwise else 1.0

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """See `simcore.devices.motor_ports.GyroPort`; only yaw is measured."""
        self._yaw.set(self._sign * math.degrees(yaw))
        if self._rate is not None:
            self._rate.set(self._sign * math.degrees(rates[2]))


def _value(sim: Any, device: str, name: str) -> Any:
    value = sim.get_double(name)
    if not value:
        known = [v[0] for v in sim.enumerate_values()]
        raise ConfigError(f"SimDevice {device!r} has no value {name!r}; it has {known}")
    return value
