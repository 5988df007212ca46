"""Motor controllers on a mechanism: volts move the mechanism, and what their sensors read follows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Protocol

from simcore import season
from simcore.devices.makers import known_device
from simcore.errors import ConfigError
from simcore.quantities import ANGLE, GEARING, require
from simcore.robot.mechanisms import ShaftSim
from simcore.robot.motor_controllers import ClosedLoop

RobotController = season.wpilib.RobotController

__all__ = ["LoopMotorSim", "LoopPace", "LoopPort", "MotorSim"]

_LOOP = 1e-3  # [s]


class MotorSim:
    """What all motor controllers on a mechanism have in common.

    Args:
        name: Of the leader, in messages.
        mechanism: What it turns.
        followers: How many devices follow it.
        opposed: Which of them are mounted face to face with the leader, by index.
        zero_at: Angle of the mechanism at which the rotor was when it was switched on [rad].

    Raises:
        ConfigError: The mechanism's gearbox has another number of motors than there are devices, or an `opposed` index
            names no follower.
    """

    def __init__(
        self, name: str, mechanism: ShaftSim, followers: int, opposed: Sequence[int], *, zero_at: float
    ) -> None:
        require(name, "zero_at", zero_at, ANGLE)
        motors, devices = getattr(mechanism, "motors", None), 1 + followers
        if followers and motors is not None and motors != devices:
            raise ConfigError(
                f"{name}: {devices} devices (leader and {followers} followers) turn a gearbox of {motors} motors; "
                f"write GearboxConfig(motors={devices}, ...)"
            )
        if any(not 0 <= k < followers for k in opposed):
            raise ConfigError(f"{name}: opposed names followers 0..{followers - 1}, got {list(opposed)}")
        self.mechanism = mechanism
        """What the motor turns."""
        self._zero_at = zero_at

    @property
    def volts(self) -> float:
        """What the controller put on the motor at the last `read` [V]."""
        return self.mechanism.volts

    @property
    def supply_current(self) -> float:
        """From the battery, all motors of the gearbox together [A]."""
        return self.mechanism.supply_current

    _leader: object
    _encoder_gearing: float

    def setpoint(self) -> tuple[str, float] | None:
        """What the closed loop of the leader is to reach, for the mechanism; None: none runs, or it does not say.

        Returns:
            `VelocityRPS` and turns/s, or `PositionRot` and turns.
        """
        goal = self._leader.setpoint() if isinstance(self._leader, ClosedLoop) else None
        if goal is None:
            return None
        turns = goal.turns / (self.mechanism.gearing if goal.is_rotor else self._encoder_gearing)
        return (
            ("VelocityRPS", turns) if goal.is_velocity else ("PositionRot", self.mechanism.position / math.tau + turns)
        )

    def update(self, dt: float, battery_voltage: float | None = None, *, powered: bool = True) -> None:
        """One step of the physics: supply, volts, mechanism, sensors.

        Args:
            dt: Length [s]; 5 ms or less keeps the devices' own 1 kHz loops as stable as on the robot.
            battery_voltage: None: what the roboRIO measures; then step the battery first [V].
            powered: False: the roboRIO holds its outputs off (brown-out), and the motor coasts.
        """
        supply = RobotController.get_battery_voltage() if battery_voltage is None else battery_voltage
        self.read(supply, powered=powered)
        self.mechanism.step(dt, supply)
        self.write()

    def read(self, battery_voltage: float, *, powered: bool = True) -> None:
        """The first half of `update`, for a mechanism that is stepped elsewhere: supply in, volts out [V]."""
        raise NotImplementedError

    def write(self) -> None:
        """The second half of `update`: the mechanism's motion to the sensors."""
        raise NotImplementedError


# --- controllers whose loops simcore runs -----------------------------------------------------------------------------


class LoopPort(Protocol):
    """The simulated side of one controller: `SparkPort`. Positive is as for what it turns."""

    @property
    def brakes(self) -> bool:
        """Whether it is configured to brake in neutral."""
        ...

    def run(self, loops: int) -> None:
        """Let its control loop run for so many milliseconds."""
        ...

    def set_supply(self, volts: float) -> None:
        """Voltage at its terminals [V]."""
        ...

    @property
    def duty_cycle(self) -> float | None:
        """The share of its supply that it holds until its next loop, as `volts` were last; None: it holds volts [-]."""
        ...

    def volts(self, emf: float, resistance: float) -> float:
        """What it puts on a motor of this back-EMF [V] and winding [ohm], within its current limits [V]."""
        ...

    def show_output(self, output: float) -> None:
        """Of a follower: the duty cycle that it applies [-]."""
        ...

    def write(self, rotor: float, rotor_rps: float, encoder: float, encoder_rps: float, amps: float) -> None:
        """Set what its sensors read: turns and rates of rotor and encoder [1/s], current of one motor [A]."""
        ...


class LoopPace:
    """How many loops a controller owes."""

    def __init__(self) -> None:
        self._owed = 0.0

    def loops(self, dt: float) -> int:
        """Whole loops of the next dt [s]."""
        self._owed += dt
        loops = int(self._owed / _LOOP + 0.5)
        self._owed -= loops * _LOOP
        return loops


class LoopMotorSim(MotorSim):
    """Connects a controller, and those that follow it, with any mechanism: `SparkMotorSim`.

    Positive is the same thing on both sides, as with `TalonFXMotorSim`: an output that robot code calls positive, after
    whatever inversion it has configured, pushes the mechanism in its positive direction, and encoders count up.

    Args:
        controller: The device of the robot code.
        mechanism: What it turns.
        followers: Devices that follow it; their encoders and currents are written too.
        opposed: Which of the followers are configured to follow it inverted, by index.
        reversed: Whether positive in robot code is negative for the mechanism.
        zero_at: Angle of the mechanism at which the encoder of the rotor was when it was switched on [rad].
        encoder_gearing: Turns of an encoder that is wired to the controller per turn of the mechanism [-].

    Raises:
        ConfigError: The mechanism's gearbox has another number of motors than there are devices, or a device was built
            before simcore was imported.
    """

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
        name = str(known_device(controller))
        if not isinstance(mechanism, ShaftSim):
            raise ConfigError(f"{name}: mechanism must be a mechanism such as RollerSim, got {mechanism!r}")
        super().__init__(name, mechanism, len(followers), opposed, zero_at=zero_at)
        require(name, "encoder_gearing", encoder_gearing, GEARING)
        self._shaft = mechanism
        self._encoder_gearing = encoder_gearing
        sign = -1.0 if reversed else 1.0
        self._leader: LoopPort = self.port(controller, sign)
        self._followers = [self.port(one, -sign if k in opposed else sign) for k, one in enumerate(followers)]
        self._pace = LoopPace()
        self.write()

    def port(self, controller: Any, sign: float) -> LoopPort:
        """The simulated side of a controller; `sign` is -1 where positive in robot code is negative for the mechanism.

        Raises:
            ConfigError: It was built before simcore was imported.
        """
        raise NotImplementedError

    def update(self, dt: float, battery_voltage: float | None = None, *, powered: bool = True) -> None:
        """See `MotorSim.update`; the controller's loops run first."""
        self.run(dt)
        super().update(dt, battery_voltage, powered=powered)

    def run(self, dt: float) -> None:
        """Let the controller's 1 kHz loops run for dt [s]; what its encoders read stays as it is meanwhile."""
        loops = self._pace.loops(dt)
        if loops > 0:
            self._leader.run(loops)

    def read(self, battery_voltage: float, *, powered: bool = True) -> None:
        """Supply in, volts out, for a mechanism that is stepped elsewhere [V]."""
        leader, m = self._leader, self._shaft
        leader.set_supply(battery_voltage)
        volts = leader.volts(m.velocity * m.gearbox.volts_per_speed, m.gearbox.resistance) if powered else 0.0
        for port in self._followers:
            port.set_supply(battery_voltage)
            port.show_output(volts / max(battery_voltage, 1.0))
        if not powered or (volts == 0.0 and not leader.brakes):
            m.coast()
        elif leader.duty_cycle is not None:
            m.set_duty_cycle(leader.duty_cycle)
        else:
            m.set_volts(volts)

    def write(self) -> None:
        """The mechanism's motion to the encoders, and its current to the meters."""
        m = self._shaft
        rotor, rps = (m.position - self._zero_at) * m.gearing / math.tau, m.velocity * m.gearing / math.tau
        turns, rate = m.position * self._encoder_gearing / math.tau, m.velocity * self._encoder_gearing / math.tau
        amps = m.current / m.motors
        for port in (self._leader, *self._followers):
            port.write(rotor, rps, turns, rate, amps)
