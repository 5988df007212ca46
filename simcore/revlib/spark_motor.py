"""A SPARK on a mechanism: the controller's volts move the mechanism, and its encoders follow."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from simcore.devices.loop_ports import LoopMotorSim
from simcore.devices.makers import known_device
from simcore.errors import ConfigError
from simcore.revlib.spark_port import SparkPort
from simcore.robot.shaft import ShaftSim

__all__ = ["SparkMotorSim"]


class SparkMotorSim(LoopMotorSim):
    """Connects a SPARK MAX or SPARK Flex, and those that follow it, with any mechanism.

    Positive is the same thing on both sides, as with `TalonFXMotorSim`: an output that robot code calls positive, after
    whatever inversion it has configured, pushes the mechanism in its positive direction, and encoders count up.

    Args:
        spark: The device of the robot code, a `SparkMax` or `SparkFlex`.
        mechanism: What it turns.
        followers: Devices that follow it; their encoders and currents are written too.
        opposed: Which of the followers are configured to follow it inverted, by index.
        reversed: Whether positive in robot code is negative for the mechanism.
        zero_at: Angle of the mechanism at which the relative encoders were when they were switched on [rad].
        encoder_gearing: Turns of an absolute, alternate or external encoder per turn of the mechanism [-].

    Raises:
        ConfigError: The mechanism's gearbox has another number of motors than there are devices, or a device was built
            before simcore was imported.

    Example:
        intake = SparkMotorSim(robot.intake.motor, RollerSim(config))
        intake.update(0.005)  # every 5 ms, after the battery
    """

    def __init__(
        self,
        spark: Any,
        mechanism: ShaftSim,
        *,
        followers: Sequence[Any] = (),
        opposed: Sequence[int] = (),
        reversed: bool = False,
        zero_at: float = 0.0,
        encoder_gearing: float = 1.0,
    ) -> None:
        device = known_device(spark)
        name = str(device)
        if not isinstance(mechanism, ShaftSim):
            raise ConfigError(f"{name}: mechanism must be a ShaftSim such as RollerSim, got {mechanism!r}")
        if any(not 0 <= k < len(followers) for k in opposed):
            raise ConfigError(f"{name}: opposed names followers 0..{len(followers) - 1}, got {list(opposed)}")
        sign = -1.0 if reversed else 1.0
        super().__init__(
            *(name, mechanism, SparkPort(device, sign=sign)),
            [SparkPort(known_device(f), sign=-sign if k in opposed else sign) for k, f in enumerate(followers)],
            zero_at=zero_at,
            encoder_gearing=encoder_gearing,
        )
