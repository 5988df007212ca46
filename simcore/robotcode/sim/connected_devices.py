"""Exchange of motor voltages and sensor readings between robot code's devices and one robot of a match.

The robot reads the controllers before each substep of at most 5 ms, because a steer loop overshoots if voltages are
constant for 20 ms. Engine, pieces and gyro keep their own steps. In simulated time, the clock of the devices advances
with the substeps, so `RobotPhysics` can run a tick in one part. On the wall clock, `RobotPhysics` divides a tick into
parts of 5 ms, and the devices run between the parts.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from simcore.errors import ConfigError
from simcore.robot.robot import Robot
from simcore.robot.robot_config import telemetry_name
from simcore.robot.swerve_drive import NO_STATES
from simcore.robotcode.program.motor_ports import MotorDevices
from simcore.robotcode.program.motor_sim import MotorSim
from simcore.typing import FloatArray

__all__ = ["ConnectedDevices", "DeviceClock", "DrivetrainDevices"]


class DrivetrainDevices(Protocol):
    """Motor controllers and sensors of a drivetrain.

    `SwerveDrivetrainSim`, `SwervePorts` and `ShaftPorts` implement this protocol.
    """

    def read(self, battery_voltage: float) -> None:
        """Write the battery voltage [V] to the devices, and set the drivetrain's motor voltages from the devices."""
        ...

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """Write the drivetrain's motion to the encoders, and the angles [rad] and rates [rad/s] to the gyro."""
        ...


class DeviceClock(Protocol):
    """Clock that advances devices in simulated time. `PhoenixTime` implements this protocol."""

    def step(self, dt: float) -> None:
        """Advance the devices by dt [s]."""
        ...


class ConnectedDevices:
    """Connection between one robot and all of the robot's devices, for `Robot.connect`.

    Args:
        robot: Robot in the match.
        drivetrain: Devices of the robot's drivetrain; None if the robot has no drivetrain.
        motors: Devices of the robot's mechanisms.
        clock: Clock of the devices in simulated time; None if the devices run on the wall clock.

    Raises:
        ConfigError: A device has no `read` or no `write` method.
    """

    def __init__(
        self,
        robot: Robot,
        drivetrain: DrivetrainDevices | None,
        motors: Sequence[MotorDevices],
        *,
        clock: DeviceClock | None = None,
    ) -> None:
        for device in (*motors, *(() if drivetrain is None else (drivetrain,))):
            if not (callable(getattr(device, "read", None)) and callable(getattr(device, "write", None))):
                raise ConfigError(f"RobotPhysics: {device!r} has no read and write; wrap it, e.g. in TalonFXMotorSim")
        self._pending_time = 0.0  # motion of mechanisms and drivetrain since the controllers last ran [s]
        self._motors = list(motors)
        self._robot = robot
        self._drivetrain = drivetrain
        self._clock = clock
        self._note_gyro()

    def add(self, motor: MotorDevices) -> None:
        """Connect the devices of an additional mechanism."""
        self._motors.append(motor)

    def remove(self, motor: MotorDevices) -> None:
        """Disconnect the devices of a mechanism."""
        self._motors.remove(motor)

    def step(self, h: float, yaw_rate: float) -> None:
        """Update the sensors, run the controllers and read the motor voltages before the robot moves for one substep.

        Args:
            h: Length of the substep [s].
            yaw_rate: Yaw rate of the robot after the last tire step [rad/s].
        """
        if self._pending_time:  # the drivetrain has moved since the last `write`
            self._show(self._yaw + self._turned, self._pitch, self._roll, (self._rate_x, self._rate_y, yaw_rate))
            self._run_controllers()
        else:
            self._note_gyro()
        self._read_volts()
        self._turned += yaw_rate * h
        self._pending_time = h

    def setpoints(self) -> dict[str, float]:
        """Return the closed-loop setpoints of the mechanisms' controllers, by telemetry name with quantity and unit."""
        names = {id(mechanism): telemetry_name(name) for name, mechanism in self._robot.mechanisms.items()}
        motors = [motor for motor in self._motors if isinstance(motor, MotorSim) and id(motor.mechanism) in names]
        goals = [(names[id(motor.mechanism)], motor.setpoint()) for motor in motors]
        return {f"{name}{goal[0]}": goal[1] for name, goal in goals if goal is not None}

    def module_setpoints(self) -> FloatArray:
        """Return speed [m/s] and angle [rad] setpoints of each swerve module, shape (n, 2); no rows while disabled."""
        ask = getattr(self._drivetrain, "module_setpoints", None)
        return NO_STATES if ask is None or not self._robot.drive.enabled else ask()  # type: ignore[no-any-return]

    def write(self) -> None:
        """Write the robot's motion and gyro readings to the sensors after a part of a tick, and run the controllers."""
        gyro = self._robot.gyro
        self._show(gyro.yaw, gyro.pitch, gyro.roll, gyro.rates.tolist())
        self._run_controllers()

    def _show(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        if self._drivetrain is not None:
            self._drivetrain.write(yaw, pitch, roll, rates)
        for motor in self._motors:
            motor.write()

    def _run_controllers(self) -> None:
        """Advance the clock of simulated time and the devices' own loops by the time since the last call."""
        h, self._pending_time = self._pending_time, 0.0
        if self._clock is not None:
            self._clock.step(h)
        for device in (self._drivetrain, *self._motors):
            run = getattr(device, "run", None)
            if run is not None:
                run(h)

    def _read_volts(self) -> None:
        battery = self._robot.battery
        volts, powered = battery.voltage, not battery.browned_out
        if self._drivetrain is not None:
            self._drivetrain.read(volts)
        for motor in self._motors:
            motor.read(volts, powered=powered)

    def _note_gyro(self) -> None:
        """Record the gyro's angles and rates, from which `step` extrapolates the yaw until the next reading."""
        gyro = self._robot.gyro
        self._yaw, self._pitch, self._roll = gyro.yaw, gyro.pitch, gyro.roll
        self._rate_x, self._rate_y, _ = gyro.rates.tolist()
        self._turned = 0.0
