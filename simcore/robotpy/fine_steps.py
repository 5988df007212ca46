"""Motor controllers that think as often as the drivetrain moves, so that the rest of the game need not be cut.

On the wall clock a tick is cut into parts of 5 ms for the controllers' sake: volts that stand for 20 ms make a steer
loop overshoot. In simulated time the controllers can be asked in the middle of the tick instead, before every inner
step of the swerve model (5 ms or less); engine, fuel and sensors keep their own pace. On the example's auto 4.5 ms of a
tick became 3.7.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from simcore.robotpy.seams import DrivetrainDevices, MotorDevices, Plant
from simcore.robotpy.simulated_phoenix import PhoenixTime

__all__ = ["FineSteps"]


class FineSteps:
    """Steps a robot's devices and mechanisms with its drivetrain.

    Args:
        plant: The robot; `supports` says whether it can.
        drivetrain: Its devices.
        motors: Devices of its mechanisms.
        phoenix: Their clock.
    """

    @staticmethod
    def supports(plant: Any) -> bool:
        """Whether a plant lets others in between: a swerve drive's `before_inner`, `steps_own_mechanisms`."""
        return hasattr(getattr(plant, "drive", None), "before_inner") and hasattr(plant, "steps_own_mechanisms")

    def __init__(
        self, plant: Any, drivetrain: DrivetrainDevices, motors: Sequence[MotorDevices], phoenix: PhoenixTime
    ) -> None:
        self._plant = plant
        self._robot: Plant = plant
        self._drivetrain = drivetrain
        self._motors = motors
        self._phoenix = phoenix
        self.begin()
        plant.steps_own_mechanisms = False
        plant.drive.before_inner = self._step

    def begin(self) -> None:
        """The gyro has just been read by the game; from here its yaw is carried on."""
        gyro = self._robot.gyro
        self._yaw, self._pitch, self._roll = gyro.yaw, gyro.pitch, gyro.roll
        self._rate_x, self._rate_y, _ = gyro.rates.tolist()
        self._turned = 0.0

    def _step(self, h: float, omega: float) -> None:
        """Before an inner step of h [s]: what sensors show now, the controllers' answer to it, and the mechanisms.

        Args:
            h: [s]
            omega: Yaw rate [rad/s].
        """
        plant = self._plant
        volts = plant.battery.voltage
        powered = not plant.battery.browned_out
        rates = (self._rate_x, self._rate_y, omega)
        self._drivetrain.write(self._yaw + self._turned, self._pitch, self._roll, rates)
        self._turned += omega * h
        self._phoenix.step(h)
        self._drivetrain.read(volts)
        for motor in self._motors:
            motor.read(volts, powered=powered)
        plant.drive.other_current = plant.mechanism_current
        plant.step_mechanisms(h)
        for motor in self._motors:
            motor.write()
