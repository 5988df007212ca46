"""WPILib's own devices as ports of a drivetrain: PWM motor controllers, encoders on DIO, gyros.

Nothing here lives on the wall clock, so a robot of these devices can be stepped as fast as the machine can, and does
exactly the same every time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from simcore import season
from simcore.devices.answers import Answers
from simcore.errors import ConfigError, UnknownNameError
from simcore.quantities import GEARING, POSITIVE, require
from simcore.robotpy.port_devices import AbsoluteEncoderInput, PWMChannelPort, QuadratureInput

ADIS16448_IMU = season.class_before_2027("wpilib", "ADIS16448_IMU")
ADIS16470_IMU = season.class_before_2027("wpilib", "ADIS16470_IMU")
ADXRS450_Gyro = season.class_before_2027("wpilib", "ADXRS450_Gyro")
AnalogEncoder = season.wpilib.AnalogEncoder
AnalogGyro = season.class_before_2027("wpilib", "AnalogGyro")
DutyCycleEncoder = season.wpilib.DutyCycleEncoder
Encoder = season.wpilib.Encoder
PWMMotorController = season.wpilib.PWMMotorController
ADXRS450_GyroSim = season.class_before_2027("wpilib.simulation", "ADXRS450_GyroSim")
AnalogGyroSim = season.class_before_2027("wpilib.simulation", "AnalogGyroSim")
EncoderSim = season.wpilib_simulation.EncoderSim
SimDeviceSim = season.wpilib_simulation.SimDeviceSim

__all__ = [
    "ADISGyroPort",
    "AbsoluteEncoderPort",
    "EncoderPort",
    "PWMMotorPort",
    "SimDeviceGyroPort",
    "WPILibGyroPort",
    "answer_for_adis",
]


class PWMMotorPort(PWMChannelPort):
    """A PWM motor controller without an encoder of its own: `PWMSparkMax`, `Talon`, `VictorSP`.

    Positive is what robot code calls positive, whatever `setInverted` says. Disabled, the roboRIO holds PWM neutral;
    WPILib's simulation does not, so this does.

    Args:
        controller: Of the robot code; followers (`addFollower`) need no port of their own.
        coasts: Whether its jumper says coast instead of brake.
    """

    def __init__(self, controller: Any, *, coasts: bool = False) -> None:
        super().__init__(controller.get_channel(), controller, coasts=coasts)


class EncoderPort(QuadratureInput):
    """A quadrature `Encoder` on a shaft; `reset()` in robot code starts it from zero, as on the robot.

    Positive is forward, whatever direction the encoder is configured with.

    Args:
        encoder: Of the robot code, with its distance per pulse set.
        pulses_per_turn: Of the encoder, per turn of the shaft.
        gearing: Turns of the encoder per turn of the shaft that the model moves (wheel or azimuth) [-].

    Raises:
        ConfigError: A number is not above zero.
    """

    def __init__(self, encoder: Any, *, pulses_per_turn: float, gearing: float = 1.0) -> None:
        require("EncoderPort", "pulses_per_turn", pulses_per_turn, GEARING)
        require("EncoderPort", "gearing", gearing, GEARING)
        super().__init__(EncoderSim(encoder), pulses_per_turn=pulses_per_turn, gearing=gearing)


class AbsoluteEncoderPort(AbsoluteEncoderInput):
    """A `DutyCycleEncoder` or `AnalogEncoder` on an azimuth: knows its angle from the start.

    Args:
        encoder: Of the robot code.
        zero: What `get()` shows while the module points ahead, in the encoder's own unit.
        full_range: What a whole turn is, in the same unit; 1 unless robot code has said otherwise.
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
        reversed: bool = False,
    ) -> None:
        require("AbsoluteEncoderPort", "full_range", full_range, POSITIVE)
        if isinstance(encoder, DutyCycleEncoder):
            model, channel = "DIO", encoder.get_source_channel()
        elif isinstance(encoder, AnalogEncoder):
            model, channel = "Analog", encoder.get_channel()
        else:
            raise ConfigError(
                f"AbsoluteEncoderPort: want a DutyCycleEncoder or AnalogEncoder, got {type(encoder).__name__}"
            )
        super().__init__(model, channel, gearing=-1.0 if reversed else 1.0, zero=zero, full_range=full_range)


class WPILibGyroPort:
    """An `ADXRS450_Gyro` or `AnalogGyro`: clockwise positive in degrees, as these are; `reset()` works.

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
        self._gyro = gyro
        self._shown = 0.0
        self._offset = 0.0

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """See `simcore.robot.motor_ports.GyroPort`; only yaw is measured."""
        shown = float(self._gyro.getAngle())
        if abs(shown - self._shown) > 1e-6:  # robot code has reset it
            self._offset += shown - self._shown
        self._shown = self._offset - math.degrees(yaw)
        self._sim.setAngle(self._shown)
        self._sim.setRate(-math.degrees(rates[2]))
        self._shown = float(self._gyro.getAngle())  # as the device rounds it


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
        """See `simcore.robot.motor_ports.GyroPort`."""
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
        """See `simcore.robot.motor_ports.GyroPort`; only yaw is measured."""
        self._yaw.set(self._sign * math.degrees(yaw))
        if self._rate is not None:
            self._rate.set(self._sign * math.degrees(rates[2]))


def _value(sim: Any, device: str, name: str) -> Any:
    value = sim.get_double(name)
    if not value:
        known = [v[0] for v in sim.enumerate_values()]
        raise ConfigError(f"SimDevice {device!r} has no value {name!r}; it has {known}")
    return value
