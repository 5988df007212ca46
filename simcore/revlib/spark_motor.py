"""A SPARK on a mechanism: the controller's volts move the mechanism, and its encoders follow."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from wpilib import RobotController

from simcore.errors import ConfigError
from simcore.quantities import ANGLE, GEARING, require
from simcore.revlib.built_sparks import built_sparks
from simcore.revlib.spark_port import SparkPort
from simcore.robot.motor_controllers import BuiltDevice
from simcore.robot.shaft import ShaftSim

__all__ = ["SparkMotorSim"]

_LOOP = 1e-3  # [s]


class SparkMotorSim:
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
        leader = _device(spark)
        name = str(leader)
        if not isinstance(mechanism, ShaftSim):
            raise ConfigError(f"{name}: mechanism must be a ShaftSim such as RollerSim, got {mechanism!r}")
        require(name, "zero_at", zero_at, ANGLE)
        require(name, "encoder_gearing", encoder_gearing, GEARING)
        devices = 1 + len(followers)
        if followers and mechanism.motors != devices:
            raise ConfigError(
                f"{name}: {devices} devices (leader and {len(followers)} followers) turn a gearbox of "
                f"{mechanism.motors} motors; write GearboxConfig(motors={devices}, ...)"
            )
        if any(not 0 <= k < len(followers) for k in opposed):
            raise ConfigError(f"{name}: opposed names followers 0..{len(followers) - 1}, got {list(opposed)}")
        self.mechanism = mechanism
        """What the motor turns."""
        sign = -1.0 if reversed else 1.0
        self._sign = sign
        self._leader = SparkPort(leader, sign=sign)
        self._followers = [
            (SparkPort(_device(f), sign=-sign if k in opposed else sign), -1.0 if k in opposed else 1.0)
            for k, f in enumerate(followers)
        ]
        self._zero_at = zero_at
        self._encoder_gearing = encoder_gearing
        self._owed = 0.0
        self.write()

    @property
    def volts(self) -> float:
        """What the controller put on the motor at the last `read` [V]."""
        return self.mechanism.volts

    @property
    def supply_current(self) -> float:
        """From the battery, all motors of the gearbox together [A]."""
        return self.mechanism.supply_current

    def update(self, dt: float, battery_voltage: float | None = None, *, powered: bool = True) -> None:
        """One step of the physics: the controller's loops, supply, volts, mechanism, encoders.

        Args:
            dt: Length [s].
            battery_voltage: None: what the roboRIO measures; then step the battery first [V].
            powered: False: the roboRIO holds its outputs off (brown-out), and the motor coasts.
        """
        supply = RobotController.getBatteryVoltage() if battery_voltage is None else battery_voltage
        self.run(dt)
        self.read(supply, powered=powered)
        self.mechanism.step(dt, supply)
        self.write()

    def run(self, dt: float) -> None:
        """Let the controller's 1 kHz loops run for dt [s]; what its encoders read stays as it is meanwhile."""
        self._owed += dt
        loops = int(self._owed / _LOOP + 0.5)
        if loops > 0:
            self._owed -= loops * _LOOP
            self._leader.run(loops)

    def read(self, battery_voltage: float, *, powered: bool = True) -> None:
        """Supply in, volts out, for a mechanism that is stepped elsewhere [V]."""
        leader, m = self._leader, self.mechanism
        leader.set_supply(battery_voltage)
        volts = leader.volts(m.velocity * m.gearbox.volts_per_speed, m.gearbox.resistance) if powered else 0.0
        for port, turn in self._followers:
            port.set_supply(battery_voltage)
            port.show_output(turn * self._sign * volts / max(battery_voltage, 1.0))
        if not powered or (volts == 0.0 and not leader.config.brakes):
            m.coast()
        else:
            m.set_volts(volts)

    def write(self) -> None:
        """The mechanism's motion to the encoders, and its current to the meters."""
        m = self.mechanism
        rotor, rps = (m.position - self._zero_at) * m.gearing / math.tau, m.velocity * m.gearing / math.tau
        turns, rate = m.position * self._encoder_gearing / math.tau, m.velocity * self._encoder_gearing / math.tau
        amps = m.current / m.motors
        self._leader.write(rotor, rps, turns, rate, amps)
        for port, _ in self._followers:
            port.write(rotor, rps, turns, rate, amps)


def _device(spark: Any) -> BuiltDevice:
    for device in built_sparks():
        if device.hardware is spark:
            return device
    raise ConfigError(
        f"{type(spark).__name__} {spark.getDeviceId()}: built before simcore was there; import simcore.revlib first, "
        "which a physics.py does at its top"
    )
