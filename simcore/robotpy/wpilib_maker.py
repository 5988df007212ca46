"""WPILib's own devices on a drivetrain: PWM motor controllers, encoders on DIO and analog inputs, gyros."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from simcore import season
from simcore.devices.makers import Maker, MotorFacts
from simcore.devices.motor_controllers import BuiltDevice, FollowerGroup, group_by_leader
from simcore.devices.motor_ports import AnglePort, GyroPort, MotorPort
from simcore.devices.recorder import after_call
from simcore.quantities import DeviceAddress
from simcore.robot_file.drivetrain_table import ON_PORTS
from simcore.robotpy.built_ports import BuiltPort, built_ports, encoder_range
from simcore.robotpy.wpilib_ports import (
    AbsoluteEncoderPort,
    ADISGyroPort,
    EncoderPort,
    PWMMotorPort,
    WPILibGyroPort,
    answer_for_adis,
)

wpilib = season.wpilib

__all__ = ["MAKER"]

_MOTORS = {"PWMSparkMax": "NEO", "PWMSparkFlex": "NEO Vortex", "PWMTalonFX": "Falcon 500"}
"""What mostly turns behind a PWM controller; behind others it is a CIM."""
_PULSES = 2048.0
"""Of an `Encoder` per turn of its shaft; any number does, as robot code knows distances per pulse."""
_GYROS = ("ADIS16448_IMU", "ADIS16470_IMU", "ADXRS450_Gyro", "AnalogGyro")
_followers: list[tuple[Any, Any]] = []
"""Leader and follower on PWM, as `addFollower` had them."""


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
        answer_for_adis()
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
        port_of = ("DIO" if encoder.model.startswith("DutyCycle") else "Analog"), encoder.address.number
        return AbsoluteEncoderPort(port_of, full_range=encoder_range(*port_of))

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
"""See `simcore.devices.makers`."""
