"""Robot code's devices on one robot of a match: volts in, sensor readings out, every 5 ms or more often.

They are asked before each part of the robot's step, of 5 ms or less: volts that stand for 20 ms make a steer loop
overshoot. In simulated time the clock of the devices follows, so that a tick may be one part; engine, pieces and gyro
keep their own pace. On the wall clock a tick is cut into parts of 5 ms, and the devices have time of their own between.
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
    """The devices of a drivetrain: `SwerveDrivetrainSim`, `SwervePorts`, `ShaftPorts`."""

    def read(self, battery_voltage: float) -> None:
        """Take the supply, and set the model's volts [V]."""
        ...

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """Show the model's motion and the gyro's reading to the sensors [rad, rad/s]."""
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
    ) -> None:
        for device in (*motors, *(() if drivetrain is None else (drivetrain,))):
            if not (callable(getattr(device, "read", None)) and callable(getattr(device, "write", None))):
                raise ConfigError(f"RobotPhysics: {device!r} has no read and write; wrap it, e.g. in TalonFXMotorSim")
        self._owed = 0.0  # for how long mechanisms and drivetrain have moved since the controllers ran [s]
        self._motors = list(motors)
        self._robot = robot
        self._drivetrain = drivetrain
        self._clock = clock
        self._note_gyro()

    def add(self, motor: MotorDevices) -> None:
        """Connect one more motor."""
        self._motors.append(motor)

    def remove(self, motor: MotorDevices) -> None:
        """Disconnect a motor."""
        self._motors.remove(motor)

    def step(self, h: float, yaw_rate: float) -> None:
        """Before mechanisms and drivetrain move for h [s]: sensors show the present, controllers answer.

        Args:
            h: Length of the step [s].
            yaw_rate: Of the robot as its tires leave it [rad/s].
        """
        if self._owed:  # the drivetrain has moved since the last `write`
            self._show(self._yaw + self._turned, self._pitch, self._roll, (self._rate_x, self._rate_y, yaw_rate))
            self._run_controllers()
        else:
            self._note_gyro()
        self._read_volts()
        self._turned += yaw_rate * h
        self._owed = h

    def setpoints(self) -> dict[str, float]:
        """Return what closed loops of controllers are to reach, as `Robot.setpoints`."""
        names = {id(mechanism): telemetry_name(name) for name, mechanism in self._robot.mechanisms.items()}
        motors = [motor for motor in self._motors if isinstance(motor, MotorSim) and id(motor.mechanism) in names]
        goals = [(names[id(motor.mechanism)], motor.setpoint()) for motor in motors]
        return {f"{name}{goal[0]}": goal[1] for name, goal in goals if goal is not None}

    def module_setpoints(self) -> FloatArray:
        """Return what the program wants of the modules of a swerve drive, as `Robot.module_setpoints`."""
        ask = getattr(self._drivetrain, "module_setpoints", None)
        return NO_STATES if ask is None or not self._robot.drive.enabled else ask()  # type: ignore[no-any-return]

    def write(self) -> None:
        """After a part of a tick: what the sensors show."""
        gyro = self._robot.gyro
        self._show(gyro.yaw, gyro.pitch, gyro.roll, gyro.rates.tolist())
        self._run_controllers()

    def _show(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        if self._drivetrain is not None:
            self._drivetrain.write(yaw, pitch, roll, rates)
        for motor in self._motors:
            motor.write()

    def _run_controllers(self) -> None:
        """In simulated time the devices' clock goes on by what has moved since; loops of our own always do."""
        h, self._owed = self._owed, 0.0
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
        """Note the gyro as it has just been read; until the next time its yaw is carried on from here."""
        gyro = self._robot.gyro
        self._yaw, self._pitch, self._roll = gyro.yaw, gyro.pitch, gyro.roll
        self._rate_x, self._rate_y, _ = gyro.rates.tolist()
        self._turned = 0.0
