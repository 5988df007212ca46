"""WPILib's own devices as ports of a drivetrain: PWM motor controllers, encoders on DIO, gyros.

Nothing here lives on the wall clock, so a robot of these devices can be stepped as fast as the machine can, and does
exactly the same every time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from wpilib import (
    ADXRS450_Gyro,
    AnalogEncoder,
    AnalogGyro,
    DutyCycleEncoder,
    Encoder,
    PWMMotorController,
)
from wpilib.simulation import (
    ADXRS450_GyroSim,
    AnalogEncoderSim,
    AnalogGyroSim,
    DutyCycleEncoderSim,
    EncoderSim,
    SimDeviceSim,
)

from simcore.errors import ConfigError, UnknownNameError
from simcore.quantities import GEARING, POSITIVE, require
from simcore.robotpy.port_devices import PWMChannelPort, QuadratureInput

__all__ = ["AbsoluteEncoderPort", "EncoderPort", "PWMMotorPort", "SimDeviceGyroPort", "WPILibGyroPort"]


class PWMMotorPort(PWMChannelPort):
    """A PWM motor controller without an encoder of its own: `PWMSparkMax`, `Talon`, `VictorSP`.

    Positive is what robot code calls positive, whatever `setInverted` says. Disabled, the roboRIO holds PWM neutral;
    WPILib's simulation does not, so this does.

    Args:
        controller: Of the robot code; followers (`addFollower`) need no port of their own.
        coasts: Whether its jumper says coast instead of brake.
    """

    def __init__(self, controller: PWMMotorController, *, coasts: bool = False) -> None:
        super().__init__(controller.getChannel(), controller, coasts=coasts)


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

    def __init__(self, encoder: Encoder, *, pulses_per_turn: float, gearing: float = 1.0) -> None:
        require("EncoderPort", "pulses_per_turn", pulses_per_turn, GEARING)
        require("EncoderPort", "gearing", gearing, GEARING)
        super().__init__(EncoderSim(encoder), pulses_per_turn=pulses_per_turn, gearing=gearing)


class AbsoluteEncoderPort:
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
        encoder: DutyCycleEncoder | AnalogEncoder,
        *,
        zero: float = 0.0,
        full_range: float = 1.0,
        reversed: bool = False,
    ) -> None:
        require("AbsoluteEncoderPort", "full_range", full_range, POSITIVE)
        if isinstance(encoder, DutyCycleEncoder):
            self._sim: Any = DutyCycleEncoderSim(encoder)
        elif isinstance(encoder, AnalogEncoder):
            self._sim = AnalogEncoderSim(encoder)
        else:
            raise ConfigError(
                f"AbsoluteEncoderPort: want a DutyCycleEncoder or AnalogEncoder, got {type(encoder).__name__}"
            )
        self._zero = zero
        self._range = full_range
        self._per_rad = (-1.0 if reversed else 1.0) * full_range / math.tau

    def write(self, angle: float, rate: float) -> None:
        """Where the azimuth is [rad]; shown within one turn."""
        self._sim.set((self._zero + angle * self._per_rad) % self._range)


class WPILibGyroPort:
    """An `ADXRS450_Gyro` or `AnalogGyro`: clockwise positive in degrees, as these are; `reset()` works.

    Args:
        gyro: Of the robot code.

    Raises:
        ConfigError: It is neither of the two.
    """

    def __init__(self, gyro: ADXRS450_Gyro | AnalogGyro) -> None:
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
        known = SimDeviceSim.enumerateDevices()
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


def _value(sim: SimDeviceSim, device: str, name: str) -> Any:
    value = sim.getDouble(name)
    if not value:
        known = [v[0] for v in sim.enumerateValues()]
        raise ConfigError(f"SimDevice {device!r} has no value {name!r}; it has {known}")
    return value
