"""Motor controllers whose own 1 kHz loops simcore runs, on a wheel or an azimuth, and their makers: REV's.

The loops run on the clock of the physics, the same in real time and in simulated time.
"""

from __future__ import annotations

import math
from typing import ClassVar

from simcore.devices.makers import Maker, Mounting
from simcore.devices.motor_sim import LoopMotorSim, LoopPace, LoopPort
from simcore.robot.mechanisms import ShaftSim
from simcore.robot.motor_controllers import BuiltDevice, ClosedLoop, FollowerGroup, Setpoint
from simcore.robot.motor_ports import AnglePort, MotorPort

__all__ = ["LoopDrivePort", "LoopMaker", "WiredEncoder"]


class LoopDrivePort:
    """A controller that drives a wheel or an azimuth: `simcore.robot.motor_ports.MotorPort`, `OwnLoops`.

    Its current limits act in the model of the motor.

    Args:
        port: Of the controller.
    """

    def __init__(self, port: LoopPort) -> None:
        self._port = port
        self._pace = LoopPace()
        self._rotor = self._encoder = (0.0, 0.0)
        self._amps = 0.0

    def set_supply(self, volts: float) -> None:
        """Voltage at its terminals [V]."""
        self._port.set_supply(volts)

    def volts(self) -> float:
        """What it puts on the motor [V]."""
        return self._port.volts(0.0, math.inf)

    def is_open(self) -> bool:
        """Whether it is configured to coast."""
        return not self._port.brakes

    def duty_cycle(self) -> float | None:
        """See `simcore.robot.motor_controllers.DutyHolder`."""
        return self._port.duty_cycle

    def setpoint(self) -> Setpoint | None:
        """See `simcore.robot.motor_controllers.ClosedLoop`."""
        return self._port.setpoint() if isinstance(self._port, ClosedLoop) else None

    def run(self, dt: float) -> None:
        """Let its loops run for dt [s]."""
        loops = self._pace.loops(dt)
        if loops > 0:
            self._port.run(loops)

    def show_current(self, amps: float) -> None:
        """Of its motor [A]; shown with the next `write`."""
        self._amps = amps

    def write(self, rotations: float, rps: float) -> None:
        """Where its rotor is [rotations], and how fast it turns [rotations/s]."""
        self._rotor = rotations, rps
        self._show()

    def write_encoder(self, turns: float, rps: float) -> None:
        """The same of the encoder that is wired to it."""
        self._encoder = turns, rps
        self._show()

    def _show(self) -> None:
        self._port.write(*self._rotor, *self._encoder, self._amps)


class WiredEncoder:
    """The encoder wired to a controller of the drivetrain: `simcore.robot.motor_ports.AnglePort`."""

    def __init__(self, port: LoopDrivePort) -> None:
        self._port = port

    def write(self, angle: float, rate: float) -> None:
        """Where its shaft is [rad], and how fast it turns [rad/s]."""
        self._port.write_encoder(angle / math.tau, rate / math.tau)


class LoopMaker(Maker):
    """A maker whose motor controllers are `LoopPort`s."""

    motor_sim: ClassVar[type[LoopMotorSim]]
    """What connects them with a mechanism."""

    def port(self, motor: BuiltDevice) -> LoopPort:
        """The simulated side of a controller.

        Raises:
            ConfigError: It does not answer.
        """
        raise NotImplementedError

    def motor_port(self, motor: BuiltDevice) -> LoopDrivePort:
        """See `Maker`."""
        return LoopDrivePort(self.port(motor))

    def encoder_port(self, encoder: BuiltDevice, port: MotorPort | None = None) -> AnglePort:
        """See `Maker`; it is wired to a controller of the drivetrain."""
        assert isinstance(port, LoopDrivePort), f"{encoder} is no encoder of its own"
        return WiredEncoder(port)

    def connect(self, group: FollowerGroup, mechanism: ShaftSim, mounting: Mounting | None = None) -> LoopMotorSim:
        """See `Maker`."""
        m = mounting or Mounting()
        return self.motor_sim(
            group.leader,
            mechanism,
            followers=group.followers,
            opposed=group.opposed,
            reversed=m.reversed,
            zero_at=mechanism.position,
            encoder_gearing=m.encoder_gearing,
        )
