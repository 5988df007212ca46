"""Robot code's devices on one robot of a match: volts in, sensor readings out, once a part of a tick or more often.

On the wall clock a tick is cut into parts of 5 ms for the controllers' sake: volts that stand for 20 ms make a steer
loop overshoot. In simulated time the controllers can be asked in the middle of the tick instead, before every inner
step of the drivetrain (5 ms or less); engine, pieces and sensors keep their own pace. On the example's auto 4.5 ms of a
tick became 3.7.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from simcore.errors import ConfigError
from simcore.robot.motor_controllers import OwnLoops
from simcore.robot.robot import Robot

__all__ = ["ConnectedDevices", "DeviceClock", "DrivetrainDevices", "MotorDevices"]


class DrivetrainDevices(Protocol):
    """The devices of a drivetrain: `SwerveDrivetrainSim`, `SwervePorts`, `TankPorts`."""

    def read(self, battery_voltage: float) -> None:
        """Supply in, volts out to the model [V]."""
        ...

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """The model's motion and the gyro's reading to the sensors [rad, rad/s]."""
        ...


class MotorDevices(Protocol):
    """The devices of a mechanism: `TalonFXMotorSim`."""

    def read(self, battery_voltage: float, *, powered: bool = True) -> None:
        """Supply in, volts out to the mechanism [V]."""
        ...

    def write(self) -> None:
        """The mechanism's motion to the sensors."""
        ...


class DeviceClock(Protocol):
    """The clock of devices in simulated time: `PhoenixTime`."""

    def step(self, dt: float) -> None:
        """Let the devices run for dt [s]."""
        ...


class ConnectedDevices:
    """All devices of one robot, as `Robot.connect` wants them.

    Args:
        robot: In the match.
        drivetrain: Devices of its drivetrain; None: it has none.
        motors: Devices of its mechanisms.
        clock: Of the devices, in simulated time; None on the wall clock.
        at_inner_steps: Whether they are asked before every inner step of the drivetrain, in simulated time.

    Raises:
        ConfigError: Something among the devices cannot be read and written.
    """

    def __init__(
        self,
        robot: Robot,
        drivetrain: DrivetrainDevices | None,
        motors: Sequence[MotorDevices],
        *,
        clock: DeviceClock | None = None,
        at_inner_steps: bool = False,
    ) -> None:
        for device in (*motors, *(() if drivetrain is None else (drivetrain,))):
            if not (callable(getattr(device, "read", None)) and callable(getattr(device, "write", None))):
                raise ConfigError(f"RobotPhysics: {device!r} has no read and write; wrap it, e.g. in TalonFXMotorSim")
        self.at_inner_steps = at_inner_steps
        self._motors = list(motors)
        self._own_loops = [motor for motor in motors if isinstance(motor, OwnLoops)]
        self._robot = robot
        self._drivetrain = drivetrain
        self._clock = clock
        self._note_gyro()

    def add(self, motor: MotorDevices) -> None:
        """Connect one more motor."""
        self._motors.append(motor)
        if isinstance(motor, OwnLoops):
            self._own_loops.append(motor)

    def remove(self, motor: MotorDevices) -> None:
        """Disconnect a motor."""
        self._motors.remove(motor)
        if isinstance(motor, OwnLoops):
            self._own_loops.remove(motor)

    def read(self) -> None:
        """Before a part of a tick: supply voltage to the controllers, their volts to drivetrain and mechanisms."""
        if self.at_inner_steps:
            self._note_gyro()
        else:
            self._read_volts()

    def inner_step(self, h: float, omega: float) -> None:
        """Before an inner step of the drivetrain: sensors show the present, controllers answer, mechanisms move.

        Args:
            h: Length of the step [s].
            omega: Yaw rate [rad/s].
        """
        robot = self._robot
        if self._drivetrain is not None:
            rates = (self._rate_x, self._rate_y, omega)
            self._drivetrain.write(self._yaw + self._turned, self._pitch, self._roll, rates)
        self._turned += omega * h
        if self._clock is not None:
            self._clock.step(h)
        for loops in self._own_loops:
            loops.run(h)
        self._read_volts()
        robot.drive.other_current = robot.mechanism_current
        robot.step_mechanisms(h)
        for motor in self._motors:
            motor.write()

    def write(self, h: float) -> None:
        """After a part of a tick of h [s]: what the sensors show."""
        if self.at_inner_steps:
            return  # the next inner step comes before anybody looks
        if self._drivetrain is not None:
            gyro = self._robot.gyro
            self._drivetrain.write(gyro.yaw, gyro.pitch, gyro.roll, gyro.rates.tolist())
        for motor in self._motors:
            motor.write()
        if self._clock is not None:
            self._clock.step(h)
        for loops in self._own_loops:
            loops.run(h)

    def _read_volts(self) -> None:
        battery = self._robot.battery
        volts, powered = battery.voltage, not battery.browned_out
        if self._drivetrain is not None:
            self._drivetrain.read(volts)
        for motor in self._motors:
            motor.read(volts, powered=powered)

    def _note_gyro(self) -> None:
        """The match has just read the gyro; during a part its yaw is carried on from here."""
        gyro = self._robot.gyro
        self._yaw, self._pitch, self._roll = gyro.yaw, gyro.pitch, gyro.roll
        self._rate_x, self._rate_y, _ = gyro.rates.tolist()
        self._turned = 0.0
