"""Motor controllers on a mechanism: controller volts drive the model, whose motion sets the sensor readings."""

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
    """Motor controllers of one maker on a mechanism; the leader's output drives the mechanism.

    Args:
        name: Name of the leader in messages.
        mechanism: Mechanism that the motors turn.
        followers: Number of followers.
        opposed: Indices of followers mounted face to face with the leader.
        zero_at: Angle of the mechanism at which the rotor position reads zero [rad].
        encoder_gearing: Turns of an encoder on the mechanism per turn of the mechanism [-].

    Raises:
        ConfigError: `mechanism` is not a mechanism, the number of devices differs from the number of motors in the
            gearbox, or an index in `opposed` is out of range.
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
        """Mechanism that the motors turn."""
        self._zero_at = zero_at
        self._encoder_gearing = encoder_gearing

    _ports: Sequence[MotorPort]
    """Ports of the controllers, leader first."""

    @property
    def volts(self) -> float:
        """Motor voltage at the last `read` [V]."""
        return self.mechanism.volts

    @property
    def supply_current(self) -> float:
        """Total supply current of all motors of the gearbox [A]."""
        return self.mechanism.supply_current

    def setpoint(self) -> tuple[str, float] | None:
        """Return the set-point of the leader's closed loop in turns of the mechanism; None without a closed loop.

        Returns:
            `VelocityRPS` and the velocity [turns/s], or `PositionRot` and the position [turns].
        """
        goal = self._ports[0].setpoint()
        if goal is None:
            return None
        turns = goal.turns / (self.mechanism.gearing if goal.is_rotor else self._encoder_gearing)
        return (
            ("VelocityRPS", turns) if goal.is_velocity else ("PositionRot", self.mechanism.position / math.tau + turns)
        )

    def run(self, dt: float) -> None:
        """Advance by dt [s] the leader's loops that no vendor library simulates."""
        self._ports[0].run(dt)

    def update(self, dt: float, battery_voltage: float | None = None, *, powered: bool = True) -> None:
        """Advance the model by one step: loops, supply, volts, mechanism, sensors.

        Args:
            dt: Time step [s]; at most 5 ms for the stability of the devices' own 1 kHz loops.
            battery_voltage: Battery voltage [V]; None for the roboRIO's measurement, as set by the battery's step.
            powered: Whether the roboRIO's outputs are enabled; if not (brownout), the motor coasts.
        """
        self.run(dt)
        supply = RobotController.get_battery_voltage() if battery_voltage is None else battery_voltage
        self.read(supply, powered=powered)
        self.mechanism.step(dt, supply)
        self.write()

    def read(self, battery_voltage: float, *, powered: bool = True) -> None:
        """Set the controllers' supply, and pass current limits and volts or duty cycle to the mechanism.

        Call this method before the mechanism's step.

        Args:
            battery_voltage: Battery voltage [V].
            powered: Whether the roboRIO's outputs are enabled; if not, the motor coasts.
        """
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
        """Return the leader's motor voltage within the controller's limits [V]."""
        return self._ports[0].volts()

    def _show_output(self, duty_cycle: float) -> None:
        """Write the followers' duty cycle [-], if the maker's library does not write the duty cycle."""

    def write(self) -> None:
        """Write motor volts and currents, rotor positions and velocities, after the mechanism's step."""
        m = self.mechanism
        rotations, rps = (m.position - self._zero_at) * m.gearing / math.tau, m.velocity * m.gearing / math.tau
        for port in self._ports:
            port.show_motor(*m.motor_output)
            port.write(rotations, rps)
