"""Motor controllers on a mechanism: their volts move it, and its motion sets their sensors."""

from __future__ import annotations

import math
from collections.abc import Sequence

from simcore import season
from simcore.errors import ConfigError
from simcore.quantities import ANGLE, GEARING, require
from simcore.robot.mechanisms import ShaftSim
from simcore.robotcode.program.motor_ports import MotorPort

RobotController = season.wpilib.RobotController

__all__ = ["MotorSim"]


class MotorSim:
    """Motor controllers of one maker on a mechanism; the leader drives it.

    Args:
        name: Name of the leader in messages.
        mechanism: Mechanism that it turns.
        followers: Number of devices that follow it.
        opposed: Indices of followers mounted face to face with the leader.
        zero_at: Angle of the mechanism when the rotor was switched on [rad].
        encoder_gearing: Turns of an encoder on the mechanism per turn of the mechanism [-].

    Raises:
        ConfigError: `mechanism` is none; its gearbox and the devices differ in number; or an
            `opposed` index names no follower.
    """

    def __init__(
        self,
        name: str,
        mechanism: ShaftSim,
        followers: int,
        opposed: Sequence[int],
        *,
        zero_at: float,
        encoder_gearing: float,
    ) -> None:
        if not isinstance(mechanism, ShaftSim):
            raise ConfigError(f"{name}: mechanism must be a mechanism such as FlywheelSim, got {mechanism!r}")
        require(name, "zero_at", zero_at, ANGLE)
        require(name, "encoder_gearing", encoder_gearing, GEARING)
        motors, devices = getattr(mechanism, "motors", None), 1 + followers
        if followers and motors is not None and motors != devices:
            raise ConfigError(
                f"{name}: {devices} devices (leader and {followers} followers) turn a gearbox of {motors} motors; "
                f"write GearboxConfig(motors={devices}, ...)"
            )
        if any(not 0 <= k < followers for k in opposed):
            raise ConfigError(f"{name}: opposed names followers 0..{followers - 1}, got {list(opposed)}")
        self.mechanism = mechanism
        """Mechanism that the motor turns."""
        self._zero_at = zero_at
        self._encoder_gearing = encoder_gearing

    _ports: Sequence[MotorPort]
    """Simulated sides of the controllers, leader first."""

    @property
    def volts(self) -> float:
        """Voltage on the motor at the last `read` [V]."""
        return self.mechanism.volts

    @property
    def supply_current(self) -> float:
        """Supply current of all motors of the gearbox together [A]."""
        return self.mechanism.supply_current

    def setpoint(self) -> tuple[str, float] | None:
        """Return the goal of the leader's closed loop, for the mechanism; None: no loop runs, or it gives none.

        Returns:
            `VelocityRPS` and turns/s, or `PositionRot` and turns.
        """
        goal = self._ports[0].setpoint()
        if goal is None:
            return None
        turns = goal.turns / (self.mechanism.gearing if goal.is_rotor else self._encoder_gearing)
        return (
            ("VelocityRPS", turns) if goal.is_velocity else ("PositionRot", self.mechanism.position / math.tau + turns)
        )

    def run(self, dt: float) -> None:
        """Advance loops of the leader that no vendor's library simulates by dt [s]."""
        self._ports[0].run(dt)

    def update(self, dt: float, battery_voltage: float | None = None, *, powered: bool = True) -> None:
        """Advance the model by one step: loops, supply, volts, mechanism, sensors.

        Args:
            dt: Length [s]; 5 ms or less keeps the devices' own 1 kHz loops as stable as on the robot.
            battery_voltage: Voltage [V]; None: the roboRIO's measurement, so step the battery first.
            powered: False: the roboRIO disables its outputs (brown-out), and the motor coasts.
        """
        self.run(dt)
        supply = RobotController.get_battery_voltage() if battery_voltage is None else battery_voltage
        self.read(supply, powered=powered)
        self.mechanism.step(dt, supply)
        self.write()

    def read(self, battery_voltage: float, *, powered: bool = True) -> None:
        """Do the first half of `update`, for a mechanism that another object steps: supply in, volts out [V]."""
        leader, m = self._ports[0], self.mechanism
        for port in self._ports:
            port.set_supply(battery_voltage)
        m.keep_limits(*leader.limits())
        volts = self._leader_volts() if powered else 0.0
        self._show_output(volts / max(battery_voltage, 1.0))
        if not powered or (volts == 0.0 and leader.is_open()):
            m.coast()
        elif (share := leader.duty_cycle()) is not None:
            m.set_duty_cycle(share)
        else:
            m.set_volts(volts)

    def _leader_volts(self) -> float:
        """Return the leader's voltage on its motor, within its limits [V]."""
        return self._ports[0].volts()

    def _show_output(self, duty_cycle: float) -> None:
        """Write the duty cycle of followers, where no vendor's library does [-]."""

    def write(self) -> None:
        """Do the second half of `update`: write the motors' currents, and the rotors' position and velocity."""
        m = self.mechanism
        rotations, rps = (m.position - self._zero_at) * m.gearing / math.tau, m.velocity * m.gearing / math.tau
        for port in self._ports:
            port.show_motor(*m.motor_output)
            port.write(rotations, rps)
