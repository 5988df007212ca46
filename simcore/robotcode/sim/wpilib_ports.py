"""WPILib's own devices: motor controllers on PWM and relays, encoders on DIO and analog inputs, and gyros.

The port classes connect the devices to a drivetrain or mechanism. `MAKER` describes all WPILib devices for the device
search. WPILib's devices do not use the wall clock. A robot with only WPILib devices therefore runs as fast as possible
and repeats exactly.
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

_RAIL = 5.0  # full-scale voltage of the roboRIO's analog inputs [V]


class ChannelMotor(MotorPort):
    """Motor controller on a port of the roboRIO, without sensor or configuration.

    The output is zero while the robot is disabled.

    Args:
        share: Function that returns the duty cycle [-].
        coasts: Whether the controller coasts at zero output; False for brake.
    """

    def __init__(self, share: FloatSupplier, *, coasts: bool = False) -> None:
        self._share = share
        self._coasts = coasts
        self._supply = 12.0

    def set_supply(self, volts: float) -> None:
        """Set the supply voltage of the controller [V]."""
        self._supply = volts

    def is_open(self) -> bool:
        """Return whether the motor circuit is open at zero output (coast) instead of shorted (brake)."""
        return self._coasts

    def volts(self) -> float:
        """Return the motor voltage [V]; 0 while the robot is disabled."""
        return self._share() * self._supply if RobotState.is_enabled() else 0.0

    def duty_cycle(self) -> float:
        """Return the duty cycle [-]; 0 while the robot is disabled."""
        return self.volts() / self._supply

    def write(self, rotations: float, rps: float) -> None:
        """Ignore the rotor position and velocity, because the controller has no sensor."""


class PWMMotorPort(ChannelMotor):
    """PWM motor controller without an encoder, e.g. `PWMSparkMax`, `Talon` or `VictorSP`.

    The output has robot code's sign, because the class undoes the inversion by `setInverted`. The output is zero while
    the robot is disabled. WPILib's simulation does not ensure this zero output.

    Args:
        controller: Robot code's controller object, or the PWM channel. Followers (`addFollower`) need no port.
        leader: Robot code's first controller on the shaft, whose inversion the class undoes. None for the inversion of
            `controller`, or for no inversion with a channel.
        coasts: Whether the controller's jumper selects coast; False for brake.
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
    """Quadrature `Encoder` on a shaft.

    The count is zero at the shaft's initial angle, and at the angle of the last reset in robot code. The direction
    configured in robot code has no effect.

    Args:
        encoder: Robot code's encoder, with the distance per pulse set, or the DIO channel A of the encoder.
        pulses_per_turn: Pulses per turn of the encoder.
        gearing: Encoder turns per turn of the model's shaft (wheel, steering axis, mechanism) [-].
        reversed: Whether the encoder counts down while the shaft turns in the positive direction.
        start: Initial angle of the shaft [rad].

    Raises:
        ConfigError: `pulses_per_turn` or `gearing` is not above zero.
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
        """Write the encoder count for the shaft's angle [rad], and the encoder rate for the shaft's rate [rad/s]."""
        if self._sim.get_reset():
            self._base = self._written
        pulses = angle * self._per_rad
        self._sim.set_count(round(pulses - self._base))
        self._sim.set_rate(rate * self._per_rad * self._sim.get_distance_per_pulse())
        self._sim.set_direction(rate * self._per_rad > 0.0)
        self._written = pulses


class AbsoluteEncoderPort:
    """Absolute encoder on a shaft, which robot code reads on a DIO or analog input.

    WPILib simulates the position of `DutyCycleEncoder` and `AnalogEncoder`. A bare `DutyCycle` reads the duty cycle for
    the angle, and an `AnalogInput` or `AnalogPotentiometer` reads the voltage for the angle.

    Args:
        encoder: Robot code's encoder, or the port of any class, for example `("DIO", 4)` or `("Analog", 0)`.
        zero: Reading of `get()` at a shaft angle of zero (wheel pointing forward), in the encoder's unit.
        gearing: Encoder turns per turn of the shaft [-].
        reversed: Whether the encoder counts down while the shaft turns in the positive direction.

    Raises:
        ConfigError: `encoder` is an object of another class.
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
        """Write the encoder position for the shaft's angle [rad], within one turn. The rate has no effect."""
        turns = (self._zero + angle * self._turns_per_rad) % 1.0
        if self._position is not None:
            self._position.set(turns * self._range)
        self._show(turns * self._per_turn)


def _port_of(encoder: Any) -> tuple[str, int]:
    """Return the kind of port, `DIO` or `Analog`, and the channel of an absolute encoder.

    Raises:
        ConfigError: `encoder` is an object of another class.
    """
    if isinstance(encoder, tuple):
        return encoder
    if isinstance(encoder, DutyCycleEncoder):
        return "DIO", encoder.get_source_channel()
    if isinstance(encoder, AnalogEncoder):
        return "Analog", encoder.get_channel()
    raise ConfigError(
        f"AbsoluteEncoderPort: the encoder must be a DutyCycleEncoder or AnalogEncoder, got {type(encoder).__name__}"
    )


class WPILibGyroPort:
    """Port that writes an `ADXRS450_Gyro` or `AnalogGyro` in degrees, clockwise positive.

    The port also makes robot code's `reset()` zero the reading. If other simulation code sets the gyro, the value lasts
    only until the port's next `write`.

    Args:
        gyro: Robot code's gyro.

    Raises:
        ConfigError: `gyro` is an object of another class.
    """

    def __init__(self, gyro: Any) -> None:
        if isinstance(gyro, ADXRS450_Gyro):
            self._sim: Any = ADXRS450_GyroSim(gyro)
        elif isinstance(gyro, AnalogGyro):
            self._sim = AnalogGyroSim(gyro)
        else:
            raise ConfigError(
                f"WPILibGyroPort: the gyro must be an ADXRS450_Gyro or AnalogGyro, got {type(gyro).__name__}"
            )
        self._turned = self._zero = 0.0  # clockwise [deg]
        _analog.attach(gyro, self)
        for cls in (ADXRS450_Gyro, AnalogGyro):
            _analog.wrap(cls, {"reset": lambda port: port.reset()}, also_original=True)

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """Write yaw [rad] and the yaw rate in `rates[2]` [rad/s]. The gyro does not measure pitch and roll."""
        self._turned = -math.degrees(yaw)
        self._sim.setAngle(self._turned - self._zero)
        self._sim.setRate(-math.degrees(rates[2]))

    def reset(self) -> None:
        """Zero the reading at the present angle. Robot code's `reset()` calls this method."""
        self._zero = self._turned


_analog = Answers[WPILibGyroPort]()

_AXES = ("x", "y", "z")


class ADISGyroPort:
    """Port that writes an `ADIS16448_IMU` or `ADIS16470_IMU` in degrees, counter-clockwise positive about each axis.

    The configured axes of the IMU define the mounting. Each axis points forward, left or up. In WPILib's simulation,
    `reset` has no effect, the tilt angles from the accelerometer stay zero, and `calibrate` of the ADIS16470 ends the
    program. This module replaces these methods. The port does not write the accelerometer and magnetometer.

    Args:
        imu: Robot code's IMU.
    """

    def __init__(self, imu: Any) -> None:
        made: Any = imu
        is_16470 = isinstance(imu, ADIS16470_IMU)
        sim = SimDeviceSim(f"Gyro:{'ADIS16470' if is_16470 else 'ADIS16448'}[{imu.getPort()}]")
        self._angles = [sim.get_double(f"gyro_angle_{axis}") for axis in _AXES]
        self._rates = [sim.get_double(f"gyro_rate_{axis}") for axis in _AXES]
        yaw = int(imu.getYawAxis())
        pitch, roll = (int(made.getPitchAxis()), int(made.getRollAxis())) if is_16470 else _others(yaw)
        self._places = (roll, pitch, yaw)  # numbers of the sensor axes along the robot's x, y, z
        self._turned = [0.0, 0.0, 0.0]  # rotation about the sensor's axes [deg]
        self._shown = [0.0, 0.0, 0.0]
        _adis.attach(imu, self)

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """Write the robot's angles [rad] and angular velocities about x, y, z [rad/s] to the axes of the sensor."""
        for place, angle, rate in zip(self._places, (roll, pitch, yaw), rates, strict=True):
            turned = math.degrees(angle)
            self.set_angle(place, self._shown[place] + turned - self._turned[place])
            self._turned[place] = turned
            self._rates[place].set(math.degrees(rate))

    def set_angle(self, place: int, angle: float) -> None:
        """Set the angle reading [deg] of the sensor axis with index `place` (0 for x, 1 for y, 2 for z)."""
        self._shown[place] = angle
        self._angles[place].set(angle)

    def reset(self) -> None:
        """Zero the readings of all axes."""
        for place in range(3):
            self.set_angle(place, 0.0)

    def tilt(self, number: int) -> float:
        """Return the tilt about the robot's x axis (0) or y axis (1) [deg]."""
        return self._turned[self._places[number]]

    def place_of(self, axis: Any) -> int:
        """Return the index of the sensor axis for the axis that robot code names: x, y, z, yaw, pitch or roll."""
        return {3: self._places[2], 4: self._places[1], 5: self._places[0]}.get(int(axis), int(axis))


def _others(yaw: int) -> tuple[int, int]:
    """Return the indices of the pitch and roll axes of an ADIS16448 for the configured yaw axis."""
    roll, pitch = (axis for axis in range(3) if axis != yaw)
    return pitch, roll


_adis = Answers[ADISGyroPort]()


def _answer_for_adis() -> None:
    """Replace the methods of both IMU classes that do not work in WPILib's simulation.

    The function has no effect in a season without these classes.
    """
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
"""Usual motor of a PWM controller, by class name. The usual motor of all other classes is a CIM."""
_PULSES = 2048.0
"""Pulses of an `Encoder` per turn of the shaft [-].

Any value works if robot code sets the distance per pulse."""
_GYROS = ("ADIS16448_IMU", "ADIS16470_IMU", "ADXRS450_Gyro", "AnalogGyro")
_followers: list[tuple[Any, Any]] = []
"""Pairs (leader, follower) of PWM controllers from robot code's calls of `addFollower`."""


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
"""Description of WPILib's devices, for `simcore.robotcode.program.makers`."""
