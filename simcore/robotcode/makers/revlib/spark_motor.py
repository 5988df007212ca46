"""Connection of SPARKs to a mechanism, and port of an encoder wired to a drivetrain's SPARK."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from simcore.robot.mechanisms import ShaftSim
from simcore.robotcode.makers.revlib.spark_port import SparkPort
from simcore.robotcode.program.makers import known_device
from simcore.robotcode.program.motor_sim import MotorSim

__all__ = ["SparkMotorSim", "WiredEncoder"]


class SparkMotorSim(MotorSim):
    """Connection of a SPARK MAX or SPARK Flex and its followers to a mechanism.

    Robot code and mechanism have the same sign, as with `TalonFXMotorSim`: positive output in robot code, with any
    configured inversion, pushes the mechanism in the positive direction, and the encoders count up.

    Args:
        controller: Device object of the leader in robot code.
        mechanism: Mechanism that the motors turn.
        followers: Followers on the same shaft; `write` also writes their encoders and currents.
        opposed: Indices of followers configured as inverted.
        reversed: Whether positive output in robot code moves the mechanism in its negative direction.
        zero_at: Angle of the mechanism at which the primary encoder reads zero [rad].
        encoder_gearing: Turns of an encoder wired to the leader per turn of the mechanism [-].

    Raises:
        ConfigError: The number of devices differs from the number of motors in the mechanism's gearbox, or a device
            was built before simcore was imported.

    Example:
        intake = SparkMotorSim(robot.intake.motor, RollerSim(config))
        intake.update(0.005)  # every 5 ms, after the battery
    """

    _ports: list[SparkPort]

    def __init__(
        self,
        controller: Any,
        mechanism: ShaftSim,
        *,
        followers: Sequence[Any] = (),
        opposed: Sequence[int] = (),
        reversed: bool = False,
        zero_at: float = 0.0,
        encoder_gearing: float = 1.0,
    ) -> None:
        super().__init__(
            *(str(known_device(controller)), mechanism, len(followers), opposed),
            zero_at=zero_at,
            encoder_gearing=encoder_gearing,
        )
        sign = -1.0 if reversed else 1.0
        signs = [sign, *(-sign if k in opposed else sign for k in range(len(followers)))]
        self._ports = [SparkPort(one, sign=s) for one, s in zip((controller, *followers), signs, strict=True)]
        self.write()

    def _leader_volts(self) -> float:
        gearbox = self.mechanism.gearbox
        return self._ports[0].volts(self.mechanism.velocity * gearbox.volts_per_speed, gearbox.resistance)

    def _show_output(self, duty_cycle: float) -> None:
        for port in self._ports[1:]:
            port.show_output(duty_cycle)

    def write(self) -> None:
        """Write the mechanism's motion to all encoders, and the motor current to the current readings."""
        m = self.mechanism
        rotor, rps = (m.position - self._zero_at) * m.gearing / math.tau, m.velocity * m.gearing / math.tau
        turns = self._encoder_gearing / math.tau
        for port in self._ports:
            port.show_motor(0.0, m.current / m.motors)
            port.write(rotor, rps, (m.position * turns, m.velocity * turns))


class WiredEncoder:
    """Port of an encoder that is wired to a SPARK of the drivetrain; implements `AnglePort`."""

    def __init__(self, port: SparkPort) -> None:
        self._port = port

    def write(self, angle: float, rate: float) -> None:
        """Write the angle [rad] and rate [rad/s] of the shaft to the encoder."""
        self._port.write_encoder(angle / math.tau, rate / math.tau)
