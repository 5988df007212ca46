"""Ports between a drivetrain's model and its devices of any maker: volts come in, wheel and gyro readings go out."""

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
    """Goal of the closed loop of a motor controller, positive as its volts."""

    is_velocity: bool
    is_rotor: bool
    """Whether its sensor is the rotor's, and not one on what the motor turns."""
    turns: float
    """Velocity of the sensor's shaft [turns/s], or how far the shaft is to go from where it is now [turns]."""


class MotorPort:
    """Motor controller as a drivetrain needs it; derive from it. Positive is as robot code has it."""

    def set_supply(self, volts: float) -> None:
        """Take the voltage at the controller's terminals [V]."""
        raise NotImplementedError

    def volts(self) -> float:
        """Return what it puts on the motor [V]."""
        raise NotImplementedError

    def is_open(self) -> bool:
        """Return whether its circuit is open (coast); else zero volts brake. Asked while `volts` are zero."""
        raise NotImplementedError

    def write(self, rotations: float, rps: float) -> None:
        """Show where the rotor is [rotations] and how fast it turns [rotations/s], for its own encoder."""
        raise NotImplementedError

    def duty_cycle(self) -> float | None:
        """Return the share of its supply that it holds until it is asked next, positive as its volts; None: volts."""
        return None

    def limits(self) -> tuple[float, float]:
        """Return limits of the current of stator and supply that the model is to keep for it, of one motor [A]."""
        return math.inf, math.inf

    def setpoint(self) -> Setpoint | None:
        """Return the goal of its loop; None: no loop of a position or a velocity runs, or it does not say."""
        return None

    def show_motor(self, volts: float, amps: float) -> None:
        """Show robot code what is at one motor [V] and flows in it [A], as the model has it, positive as `volts`."""

    def run(self, dt: float) -> None:
        """Let loops that no vendor's library runs in simulation run for dt [s]."""


class AnglePort(Protocol):
    """Sensor of a shaft: an encoder on a wheel, an azimuth or a mechanism, or a switch that it presses."""

    def write(self, angle: float, rate: float) -> None:
        """Show where the shaft is, any number of turns [rad], and its rate [rad/s]; of a piston [m, m/s]."""
        ...


class GyroPort(Protocol):
    """A gyro."""

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """Show angles since it was switched on, yaw continuous over turns [rad], and rates about the axes [rad/s]."""
        ...


class MotorDevices(Protocol):
    """Devices of a mechanism: `TalonFXMotorSim`, `SparkMotorSim`; one with loops of its own has `MotorPort.run`."""

    def read(self, battery_voltage: float, *, powered: bool = True) -> None:
        """Take the supply, and set the mechanism's volts [V]."""
        ...

    def write(self) -> None:
        """Show the mechanism's motion to the sensors."""
        ...


class SuppliedMotor(MotorPort):
    """A motor controller of any maker, by callables: for example REV's, whose simulation robot code can reach.

    Args:
        volts: What the controller puts on the motor, positive as robot code has it [V].
        write: Takes the rotor's position [rotations] and speed [rotations/s], for the controller's encoder; None: it
            has none.
        supply: Takes the battery's voltage [V]; None: it does not want to know.
        coasts: Whether zero volts open the circuit instead of braking.

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
        """Take the voltage at the controller's terminals [V]."""
        if self._supply is not None:
            self._supply(volts)

    def volts(self) -> float:
        """Return what it puts on the motor [V].

        Raises:
            NonFiniteError: The supplier gave no finite number.
        """
        volts = float(self._volts())
        if not math.isfinite(volts):
            raise NonFiniteError(f"SuppliedMotor: volts must be a finite number, got {volts}")
        return volts

    def is_open(self) -> bool:
        """Return whether zero volts open the circuit."""
        return self._coasts

    def write(self, rotations: float, rps: float) -> None:
        """Show the rotor to the controller's encoder."""
        if self._write is not None:
            self._write(rotations, rps)


def _requests(ports: Sequence[MotorPort], back_emf: Callable[[int], float]) -> tuple[list[int], list[float]]:
    """Ask controllers what they want of their motors: kinds of requests, and volts or duty cycles.

    An open circuit carries no current, as at exactly its back-EMF [V], asked for by number. Few circuits are open, so
    few are asked for it. Volts that were a share of the supply some milliseconds ago must not stay while it sags: the
    next share would be of a supply that has recovered, and so to and fro.
    """
    modes, values = [VOLTS] * len(ports), [port.volts() for port in ports]
    for k, port in enumerate(ports):
        if values[k] == 0.0 and port.is_open():
            values[k] = back_emf(k)
        elif (share := port.duty_cycle()) is not None:
            modes[k], values[k] = DUTY, share
    return modes, values


class DrivetrainPorts:
    """Motor controllers and gyro of a drivetrain of any kind; the gyro reads zero where it is switched on.

    Args:
        motors: All of them.
        gyro: None if there is none.
    """

    def __init__(self, motors: Sequence[MotorPort], gyro: GyroPort | None) -> None:
        self.devices: tuple[DeviceKey, ...] = ()
        """Keys of all devices; who connects them says so."""
        self.gyro_upside_down = self.gyro_reversed = False
        """How the gyro is mounted; who connects it says so."""
        self._motors = list(motors)
        self._gyro = gyro
        self._yaw_at_start: float | None = None

    def run(self, dt: float) -> None:
        """Let controllers run the loops of their own for dt [s]."""
        for motor in self._motors:
            motor.run(dt)

    def read(self, battery_voltage: float) -> None:
        """Hand the devices their supply [V] and the model their volts."""
        for motor in self._motors:
            motor.set_supply(battery_voltage)

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """Hand the sensors what the model did.

        Args:
            yaw: Of the gyro, continuous over turns; where it starts is where the device reads zero [rad].
            pitch: [rad]
            roll: [rad]
            rates: About the robot's axes [rad/s], shape (3,).
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
    """Ports of a swerve drive: motor controllers' volts move the model, the model's motion moves their sensors.

    Args:
        drive: The model; its owner steps it with the chassis.
        drive_motors: One per module, in the model's order.
        steer_motors: The same.
        steer_encoders: On the azimuths; None where there is none.
        wheel_encoders: On the wheels, for motors without an encoder; left out where there are none.
        gyro: None if there is none.

    Raises:
        ConfigError: Another number than the model has modules.
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
                raise ConfigError(f"swerve: {len(ports)} {what} for a model of {n} modules; want as many")
        super().__init__([*drive_motors, *steer_motors], gyro)
        self._drive = drive
        self._drive_ports, self._steer_ports = self._motors[:n], self._motors[n:]
        self._steer_encoders, self._wheel_encoders = list(steer_encoders), list(wheel_encoders)
        self._gears = [(m.drive_gearing, m.coupling_ratio, m.steer_gearing) for m in drive.config.modules]
        self._kv = [(m.free_speed_share * m.drive_motor.kv, m.steer_motor.kv) for m in drive.config.modules]

    def read(self, battery_voltage: float) -> None:
        """See `DrivetrainPorts.read`."""
        super().read(battery_voltage)
        modes, drive = _requests(self._drive_ports, self._drive_emf)
        more, steer = _requests(self._steer_ports, self._steer_emf)
        self._drive.set_requests([*modes, *more], [*drive, *steer])
        self._drive.keep_limits([port.limits() for port in self._motors])

    def module_setpoints(self) -> FloatArray:
        """Return speeds [m/s] and angles [rad] that the controllers' loops are to reach, shape (n, 2).

        No rows where one controller has no such loop: drive motors of many programs are told volts.
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
        """Return volts at which the drive motor of module k carries no current, as in an open circuit [V]."""
        speeds, (drive_gearing, coupling, _) = self._drive.shafts["speed"], self._gears[k]
        n = len(self._gears)
        return float(drive_gearing * speeds[k] + coupling * speeds[n + k]) * (1.0 / self._kv[k][0])

    def _steer_emf(self, k: int) -> float:
        """Return those of its steer motor [V]."""
        return self._gears[k][2] * float(self._drive.shafts["speed"][len(self._gears) + k]) * (1.0 / self._kv[k][1])

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """See `DrivetrainPorts.write`."""
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
    """Ports of a drive whose wheels do not steer: one controller or more a shaft, the first drives the model.

    Args:
        drive: The model; its owner steps it with the chassis.
        shafts: Motor controllers of each: of a tank left and right, of a mecanum drive front left, front right, rear
            left, rear right; positive drives forward.
        encoders: On the shafts, for motors without an encoder; left out where there are none.
        gyro: None if there is none.

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
            raise ConfigError(f"drivetrain: want a motor controller or more for each of {n} shafts, got {got}")
        super().__init__([port for ports in shafts for port in ports], gyro)
        self._drive = drive
        self._shafts = [list(ports) for ports in shafts]
        self._first = [ports[0] for ports in self._shafts]
        self._encoders = list(encoders) or [None] * n

    def read(self, battery_voltage: float) -> None:
        """See `DrivetrainPorts.read`."""
        super().read(battery_voltage)
        self._drive.set_requests(*_requests(self._first, self._drive.shaft_emf))
        self._drive.keep_limits([port.limits() for port in self._first])

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """See `DrivetrainPorts.write`."""
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
