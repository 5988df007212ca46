"""A SPARK on a mechanism: the controller's volts move the mechanism, and its encoders follow."""

from __future__ import annotations

from typing import Any

from simcore.devices.motor_sim import LoopMotorSim, LoopPort
from simcore.revlib.spark_port import SparkPort

__all__ = ["SparkMotorSim"]


class SparkMotorSim(LoopMotorSim):
    """Connects a SPARK MAX or SPARK Flex, and those that follow it, with any mechanism; arguments as `LoopMotorSim`.

    Example:
        intake = SparkMotorSim(robot.intake.motor, RollerSim(config))
        intake.update(0.005)  # every 5 ms, after the battery
    """

    def port(self, controller: Any, sign: float) -> LoopPort:
        """See `LoopMotorSim`."""
        return SparkPort(controller, sign=sign)  # type: ignore[no-any-return]
