"""CTRE's Phoenix 5 devices: Talon SRX, Victor SPX, Pigeon IMU."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from phoenix5 import ErrorCode
from phoenix5.sensors import PigeonIMU, WPI_PigeonIMU
from wpimath.geometry import Rotation2d

from simcore.devices.loop_ports import LoopMaker
from simcore.devices.makers import MotorFacts
from simcore.devices.motor_controllers import BuiltDevice, FollowerGroup, group_by_leader
from simcore.devices.motor_ports import GyroPort
from simcore.phoenix5.built_talons import TALONS, record_of, watch_simulations, watch_talons
from simcore.phoenix5.talon_loop import ControlMode
from simcore.phoenix5.talon_srx_motor import TalonSRXMotorSim
from simcore.phoenix5.talon_srx_port import TalonSRXPort, answer_for_talons
from simcore.quantities import DeviceAddress, DeviceKey
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import GuessedMechanism, guessed_shaft

__all__ = ["MAKER", "PigeonIMUPort"]


class PigeonIMUPort:
    """The simulated side of a `PigeonIMU`: yaw and fused heading counter-clockwise, each with a zero of its own.

    `getAngle`, `getRate` and `reset` of WPILib's flavor are of the fused heading, clockwise. Pitch is taken to be
    positive as the nose goes up, roll as the right side goes down. Not simulated: compass, accelerometer.

    Args:
        pigeon: That robot code has built.
    """

    def __init__(self, pigeon: Any) -> None:
        self._turned = self._yaw_shift = self._fused_shift = 0.0
        self.pitch = self.roll = 0.0
        self.rates = [0.0, 0.0, 0.0]
        """About its axes, to the right, forward and up [deg/s]."""
        _answers.attach(pigeon, self)

    def write(self, yaw: float, pitch: float, roll: float, rates: Sequence[float]) -> None:
        """See `simcore.devices.motor_ports.GyroPort`."""
        self._turned, self.pitch, self.roll = math.degrees(yaw), -math.degrees(pitch), math.degrees(roll)
        self.rates = [-math.degrees(rates[1]), math.degrees(rates[0]), math.degrees(rates[2])]

    @property
    def yaw(self) -> float:
        """As robot code reads it [deg]."""
        return self._turned + self._yaw_shift

    @property
    def fused_heading(self) -> float:
        """As robot code reads it [deg]."""
        return self._turned + self._fused_shift

    def set_yaw(self, angle: float, *_: Any, **__: Any) -> Any:
        """What yaw is from now on [deg]."""
        self._yaw_shift = float(angle) - self._turned
        return ErrorCode.OK

    def set_fused_heading(self, angle: float = 0.0, *_: Any, **__: Any) -> Any:
        """What the fused heading is from now on [deg]."""
        self._fused_shift = float(angle) - self._turned
        return ErrorCode.OK


_answers = Answers[PigeonIMUPort]()
_ANSWERS: dict[str, Any] = {
    "getYaw": lambda port: port.yaw,
    "getPitch": lambda port: port.pitch,
    "getRoll": lambda port: port.roll,
    "getYawPitchRoll": lambda port, *_: (ErrorCode.OK, [port.yaw, port.pitch, port.roll]),
    "getRawGyro": lambda port, *_: (ErrorCode.OK, list(port.rates)),
    "getFusedHeading": lambda port, *_: port.fused_heading,
    "setYaw": PigeonIMUPort.set_yaw,
    "addYaw": lambda port, angle, *_: port.set_yaw(port.yaw + angle),
    "setFusedHeading": PigeonIMUPort.set_fused_heading,
    "addFusedHeading": lambda port, angle, *_: port.set_fused_heading(port.fused_heading + angle),
    "getAngle": lambda port: -port.fused_heading,
    "getRate": lambda port: -port.rates[2],
    "getRotation2d": lambda port: Rotation2d.fromDegrees(port.fused_heading),
    "reset": PigeonIMUPort.set_fused_heading,
}
_MOTOR = "CIM"
"""What mostly turns behind a controller; they do not say."""


class _Ctre5(LoopMaker):
    name = "CTRE Phoenix 5"
    motors = ("Talon SRX", "Victor SPX")
    motor_sim = TalonSRXMotorSim
    gyros = ("Pigeon IMU",)
    gyro_errors = "navx2"
    unserved = ("CANdle", "CANifier")
    sim_devices = ("CANMotor:", "CANEncoder:", "CANDutyCycle:", "CANAIn:", "CANDIO:", "CANGyro:")

    def watch(self) -> None:
        watch_talons()
        answer_for_talons()
        for cls in (PigeonIMU, WPI_PigeonIMU):
            self.devices.record(cls, "Pigeon IMU", lambda made, args, settings: DeviceAddress(made.getDeviceNumber()))
            _answers.wrap(cls, _ANSWERS)

    def watch_simulations(self, may_write: Callable[[DeviceKey], bool]) -> None:
        watch_simulations(may_write)

    def groups(self, motors: Sequence[BuiltDevice]) -> list[FollowerGroup]:
        return group_by_leader(motors, _leader)

    def has_wheel_encoder(self, motor: BuiltDevice) -> bool:
        return motor.model == "Talon SRX"

    def facts(self, motor: BuiltDevice) -> MotorFacts:
        config = record_of(motor.hardware).configuration()
        return MotorFacts(
            motor=_MOTOR,
            supply_limit=config.supply_limit,
            brakes=config.brakes,
            sensor=motor.key if motor.model == "Talon SRX" else None,
        )

    def port(self, motor: BuiltDevice) -> TalonSRXPort:
        return TalonSRXPort(motor)

    def guess(self, group: FollowerGroup) -> GuessedMechanism:
        """A free shaft: their configuration knows no gears and no units."""
        gearbox = GearboxConfig(motor=motor(_MOTOR), motors=len(group.devices), gearing=1.0)
        return GuessedMechanism(mechanism=guessed_shaft(gearbox), motor=_MOTOR)

    def gyro_port(self, gyro: BuiltDevice) -> GyroPort:
        return PigeonIMUPort(gyro.hardware)


def _leader(device: BuiltDevice) -> tuple[Any, bool]:
    """A follower's inversion is that of its place, so none opposes."""
    is_following = int(device.hardware.getControlMode()) == ControlMode.FOLLOWER
    return (record_of(device.hardware).leader if is_following else None), False


MAKER = _Ctre5(TALONS)
"""See `simcore.devices.makers`."""
