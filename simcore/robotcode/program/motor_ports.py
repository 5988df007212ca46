"""Ports that pass motor requests of robot code to a drivetrain's model, and the model's motion to the sensors."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from simcore.errors import ConfigError, NonFiniteError
from simcore.loop.robot_state import DUTY, VOLTS
from simcore.quantities import DeviceKey
from simcore.robot.fixed_wheel_drive import MecanumDrive, TankDrive
from simcore.robot.swerve_drive import NO_STATES, SwerveDrive
from simcore.typing import FloatArray, FloatSupplier

__all__ = [
    "AnglePort", "DrivetrainPorts", "GyroPort", "MotorDevices", "MotorPort", "Setpoint", "ShaftPorts", "SuppliedMotor",
    "SwervePorts",
]  # fmt: skip


class Setpoint(NamedTuple):
    """Set-point of a motor controller's closed loop, with the sign of the controller's volts."""

    is_velocity: bool
    is_rotor: bool
    """Whether the loop uses the rotor's sensor instead of a sensor on the mechanism."""
    turns: float
    """Commanded velocity of the sensor's shaft [turns/s], or remaining distance to the commanded position [turns]."""


class MotorPort:
    """Base class of the ports of motor controllers, with robot code's signs."""

    def set_supply(self, volts: float) -> None:
        """Set the supply voltage of the controller [V]."""
        raise NotImplementedError

    def volts(self) -> float:
        """Return the motor voltage [V]."""
        raise NotImplementedError

    def is_open(self) -> bool:
        """Return whether the motor circuit is open at zero volts (coast) instead of shorted (brake)."""
        raise NotImplementedError

    def write(self, rotations: float, rps: float) -> None:
        """Write the rotor position [rotations] and speed [rotations/s] to the controller's encoder."""
        raise NotImplementedError

    def duty_cycle(self) -> float | None:
        """Return the duty cycle [-] with the sign of `volts`, or None if the controller commands volts."""
        return None

    def limits(self) -> tuple[float, float]:
        """Return the stator and supply current limits for the model to apply, per motor [A]."""
        return math.inf, math.inf

    def setpoint(self) -> Setpoint | None:
        """Return the set-point of the running position or velocity loop, or None without a running loop."""
        return None

    def show_motor(self, volts: float, amps: float) -> None:
        """Write the modelled voltage [V] and current [A] of one motor, with the sign of `volts`."""

    def run(self, dt: float) -> None:
        """Advance by dt [s] the loops that no vendor library simulates."""


class AnglePort(Protocol):
    """Port of a position sensor: an encoder on a wheel, steering axis or mechanism, or a limit switch."""

    def write(self, angle: float, rate: float) -> None:
        """Write the shaft angle, continuous over turns [rad], and rate [rad/s]; for a piston [m] and [m/s]."""
        ...


class GyroPort(Protocol):
    """Port that writes the robot's rotation to a gyro."""

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """Write the rotation since power-on, with continuous yaw [rad], and rates about the robot's axes [rad/s]."""
        ...


class MotorDevices(Protocol):
    """Connection of devices to a mechanism, such as `TalonFXMotorSim`; may have a method `run` as in `MotorPort`."""

    def read(self, battery_voltage: float, *, powered: bool = True) -> None:
        """Set the controllers' supply [V], and pass their output to the mechanism, which coasts unless `powered`."""
        ...

    def write(self) -> None:
        """Write the mechanism's motion to the devices' sensors."""
        ...


class SuppliedMotor(MotorPort):
    """Motor controller connected through callables, for a maker whose simulated devices robot code can access.

    Args:
        volts: Function that returns the motor voltage, with robot code's sign [V].
        write: Function that takes the rotor position [rotations] and speed [rotations/s] for the controller's encoder;
            None without an encoder.
        supply: Function that takes the battery voltage [V]; None if the controller does not need the voltage.
        coasts: Whether the motor coasts at zero volts instead of braking.

    >>> written = []
    >>> port = SuppliedMotor(volts=lambda: 6.0, write=lambda rotations, rps: written.append(rps))
    >>> port.write(1.0, 20.0)
    >>> port.volts(), written
    (6.0, [20.0])
    """

    def __init__(
        self,
        volts: FloatSupplier,
        write: Callable[[float, float], object] | None = None,
        *,
        supply: Callable[[float], object] | None = None,
        coasts: bool = False,
    ) -> None:
        self._volts = volts
        self._write = write
        self._supply = supply
        self._coasts = coasts

    def set_supply(self, volts: float) -> None:
        """Pass the battery voltage [V] to `supply`, if given."""
        if self._supply is not None:
            self._supply(volts)

    def volts(self) -> float:
        """Return the motor voltage from the supplier [V].

        Raises:
            NonFiniteError: The supplier's value is not finite.
        """
        volts = float(self._volts())
        if not math.isfinite(volts):
            raise NonFiniteError(f"SuppliedMotor: volts must be a finite number, got {volts}")
        return volts

    def is_open(self) -> bool:
        """Return whether the motor coasts at zero volts."""
        return self._coasts

    def write(self, rotations: float, rps: float) -> None:
        """Write the rotor position [rotations] and speed [rotations/s] to the controller's encoder, if any."""
        if self._write is not None:
            self._write(rotations, rps)


def _requests(ports: Sequence[MotorPort], back_emf: Callable[[int], float]) -> tuple[list[int], list[float]]:
    """Return each controller's request: the mode, `VOLTS` or `DUTY`, and the voltage [V] or duty cycle [-].

    An open circuit carries no current, as if the voltage were exactly the back-EMF [V]; the back-EMF is computed only
    for open circuits, which are rare. A duty cycle must not be converted to fixed volts while the supply sags: the next
    duty cycle would refer to a recovered supply, and supply and volts would oscillate.
    """
    modes, values = [VOLTS] * len(ports), [port.volts() for port in ports]
    for k, port in enumerate(ports):
        if values[k] == 0.0 and port.is_open():
            values[k] = back_emf(k)
        elif (share := port.duty_cycle()) is not None:
            modes[k], values[k] = DUTY, share
    return modes, values


class DrivetrainPorts:
    """Motor controllers and gyro of a drivetrain of any kind; the gyro's yaw reads zero at power-on.

    Args:
        motors: All motor controllers.
        gyro: Gyro; None if the robot has no gyro.
    """

    def __init__(self, motors: Sequence[MotorPort], gyro: GyroPort | None) -> None:
        self.devices: tuple[DeviceKey, ...] = ()
        """Keys of all devices, set by the caller that connects the devices."""
        self.gyro_upside_down = self.gyro_reversed = False
        """Whether the gyro is upside down, and whether the gyro's yaw is reversed; the caller sets both flags."""
        self._motors = list(motors)
        self._gyro = gyro
        self._yaw_at_start: float | None = None

    def run(self, dt: float) -> None:
        """Advance the controllers' own loops by dt [s]."""
        for motor in self._motors:
            motor.run(dt)

    def read(self, battery_voltage: float) -> None:
        """Set the supply voltage [V] of all controllers; subclasses also pass motor requests to the model."""
        for motor in self._motors:
            motor.set_supply(battery_voltage)

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """Write the model's motion to the sensors.

        Args:
            yaw: Yaw of the robot, continuous over turns [rad]; the gyro reads zero at the first value.
            pitch: Pitch of the robot [rad].
            roll: Roll of the robot [rad].
            rates: Angular velocity about the robot's axes [rad/s], shape (3,).
        """
        if self._yaw_at_start is None:
            self._yaw_at_start = yaw
        turned, (x, y, z) = yaw - self._yaw_at_start, rates
        if self.gyro_upside_down:
            turned, pitch, roll, y, z = -turned, -pitch, math.remainder(roll + math.pi, math.tau), -y, -z
        if self.gyro_reversed:
            turned, z = -turned, -z
        if self._gyro is not None:
            self._gyro.write(turned, pitch, roll, (x, y, z))


class SwervePorts(DrivetrainPorts):
    """Ports of a swerve drive: the controllers' volts drive the model, whose motion drives the sensors.

    Args:
        drive: Model of the drive, which the caller steps with the chassis.
        drive_motors: Drive motor of each module, in the model's order.
        steer_motors: Steer motor of each module.
        steer_encoders: Absolute encoder of each module's steering axis; None for a module without an absolute encoder.
        wheel_encoders: Encoder on each wheel, None for a wheel without an encoder; empty if no wheel has an encoder.
        gyro: Gyro; None if the robot has no gyro.

    Raises:
        ConfigError: The number of ports differs from the number of modules in the model.
    """

    def __init__(
        self,
        drive: SwerveDrive,
        drive_motors: Sequence[MotorPort],
        steer_motors: Sequence[MotorPort],
        *,
        steer_encoders: Sequence[AnglePort | None],
        wheel_encoders: Sequence[AnglePort | None] = (),
        gyro: GyroPort | None = None,
    ) -> None:
        n = len(drive.config.modules)
        wheel_encoders = wheel_encoders or [None] * n
        for what, ports in (
            ("drive motors", drive_motors),
            ("steer motors", steer_motors),
            ("steer encoders", steer_encoders),
            ("wheel encoders", wheel_encoders),
        ):
            if len(ports) != n:
                raise ConfigError(f"swerve: {len(ports)} {what} for a model of {n} modules; there must be one for each")
        super().__init__([*drive_motors, *steer_motors], gyro)
        self._drive = drive
        self._drive_ports, self._steer_ports = self._motors[:n], self._motors[n:]
        self._steer_encoders, self._wheel_encoders = list(steer_encoders), list(wheel_encoders)
        self._gears = [(m.drive_gearing, m.coupling_ratio, m.steer_gearing) for m in drive.config.modules]
        self._kv = [(m.free_speed_share * m.drive_motor.kv, m.steer_motor.kv) for m in drive.config.modules]

    def read(self, battery_voltage: float) -> None:
        """Set the supply voltage [V]; pass the controllers' volts or duty cycles and current limits to the model."""
        super().read(battery_voltage)
        modes, drive = _requests(self._drive_ports, self._drive_emf)
        more, steer = _requests(self._steer_ports, self._steer_emf)
        self._drive.set_requests([*modes, *more], [*drive, *steer])
        self._drive.keep_limits([port.limits() for port in self._motors])

    def module_setpoints(self) -> FloatArray:
        """Return each module's speed [m/s] and angle [rad] set-points, shape (n, 2).

        The result has no rows unless all drive motors run velocity loops and all steer motors position loops. Many
        programs command the volts of drive motors instead.
        """
        rows = []
        for k, (drive, steer) in enumerate(zip(self._drive_ports, self._steer_ports, strict=True)):
            speed, turn, module = drive.setpoint(), steer.setpoint(), self._drive.config.modules[k]
            if speed is None or turn is None or not speed.is_velocity or turn.is_velocity:
                return NO_STATES
            rate = math.tau * speed.turns / (module.drive_gearing if speed.is_rotor else 1.0)
            rest = math.tau * turn.turns / (module.steer_gearing if turn.is_rotor else 1.0)
            rows.append((rate * module.wheel_radius, float(self._drive.state.steer_angle[k]) + rest))
        return np.array(rows)

    def _drive_emf(self, k: int) -> float:
        """Return the back-EMF of module k's drive motor [V], the voltage at which no current flows."""
        speeds, (drive_gearing, coupling, _) = self._drive.shafts["speed"], self._gears[k]
        n = len(self._gears)
        return float(drive_gearing * speeds[k] + coupling * speeds[n + k]) * (1.0 / self._kv[k][0])

    def _steer_emf(self, k: int) -> float:
        """Return the back-EMF of module k's steer motor [V], the voltage at which no current flows."""
        return self._gears[k][2] * float(self._drive.shafts["speed"][len(self._gears) + k]) * (1.0 / self._kv[k][1])

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """Write the modelled motor output and the motion of wheels, steering and robot; see `DrivetrainPorts.write`."""
        n, shafts = len(self._gears), self._drive.shafts
        angles, speeds = shafts["position"].tolist(), shafts["speed"].tolist()
        for motor, volts, amps in zip(self._motors, shafts["volts"].tolist(), shafts["current"].tolist(), strict=True):
            motor.show_motor(volts, amps)
        turn = math.tau
        for drive, steer, steer_encoder, wheel_encoder, gears, wheel, azimuth, wheel_rate, azimuth_rate in zip(
            self._drive_ports,
            self._steer_ports,
            self._steer_encoders,
            self._wheel_encoders,
            self._gears,
            angles[:n],
            angles[n:],
            speeds[:n],
            speeds[n:],
            strict=True,
        ):
            drive_gearing, coupling, steer_gearing = gears
            drive.write(
                (wheel * drive_gearing + azimuth * coupling) / turn,
                (wheel_rate * drive_gearing + azimuth_rate * coupling) / turn,
            )
            steer.write(azimuth * steer_gearing / turn, azimuth_rate * steer_gearing / turn)
            if steer_encoder is not None:
                steer_encoder.write(azimuth, azimuth_rate)
            if wheel_encoder is not None:
                wheel_encoder.write(wheel, wheel_rate)
        super().write(yaw, pitch, roll, rates)


class ShaftPorts(DrivetrainPorts):
    """Ports of a tank or mecanum drive: the first controller of each shaft drives the model.

    Args:
        drive: Model of the drive, which the caller steps with the chassis.
        shafts: Motor controllers of each shaft, positive forward. Tank: left, right. Mecanum: front left, front
            right, rear left, rear right.
        encoders: Encoder on each shaft, None for a shaft without an encoder; empty if no shaft has an encoder.
        gyro: Gyro; None if the robot has no gyro.

    Raises:
        ConfigError: A shaft has no motor controller.
    """

    def __init__(
        self,
        drive: TankDrive | MecanumDrive,
        shafts: Sequence[Sequence[MotorPort]],
        *,
        encoders: Sequence[AnglePort | None] = (),
        gyro: GyroPort | None = None,
    ) -> None:
        n = len(drive.shaft_speeds)
        if len(shafts) != n or not all(shafts):
            got = ", ".join(str(len(ports)) for ports in shafts)
            raise ConfigError(f"drivetrain: each of the {n} shafts needs at least one motor controller, got {got}")
        super().__init__([port for ports in shafts for port in ports], gyro)
        self._drive = drive
        self._shafts = [list(ports) for ports in shafts]
        self._first = [ports[0] for ports in self._shafts]
        self._encoders = list(encoders) or [None] * n

    def read(self, battery_voltage: float) -> None:
        """Set the supply voltage [V]; pass the controllers' volts or duty cycles and current limits to the model."""
        super().read(battery_voltage)
        self._drive.set_requests(*_requests(self._first, self._drive.shaft_emf))
        self._drive.keep_limits([port.limits() for port in self._first])

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """Write the modelled motor output and the motion of wheels and robot; see `DrivetrainPorts.write`."""
        drive = self._drive
        gearing = drive.config.gearing
        rows = zip(self._shafts, self._encoders, drive.shaft_angles.tolist(), drive.shaft_speeds.tolist(), strict=True)
        motors = zip(drive.drive_motors.volts, drive.drive_motors.current, strict=True)
        for (ports, encoder, angle, rate), (volts, amps) in zip(rows, motors, strict=True):
            for port in ports:
                port.show_motor(volts, amps)
                port.write(angle * gearing / math.tau, rate * gearing / math.tau)
            if encoder is not None:
                encoder.write(angle, rate)
        super().write(yaw, pitch, roll, rates)
