"""Motor controllers whose own 1 kHz loops simcore runs, on a wheel, an azimuth or a mechanism.

REV's, and those of CTRE's Phoenix 5. The loops run on the clock of the physics, the same in real time and in simulated
time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

from simcore import season
from simcore.devices.makers import Maker
from simcore.errors import ConfigError
from simcore.quantities import ANGLE, GEARING, require
from simcore.robot.motor_controllers import BuiltDevice
from simcore.robot.motor_ports import AnglePort, MotorPort
from simcore.robot.shaft import ShaftSim

RobotController = season.wpilib.RobotController

__all__ = ["LoopDrivePort", "LoopMaker", "LoopMotorSim", "LoopPort", "WiredEncoder"]

_LOOP = 1e-3  # [s]


class LoopPort(Protocol):
    """The simulated side of one controller: `SparkPort`, `TalonSRXPort`. Positive is as for what it turns."""

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

    def volts(self, emf: float, resistance: float) -> float:
        """What it puts on a motor of this back-EMF [V] and winding [ohm], within its current limits [V]."""
        ...

    def show_output(self, output: float) -> None:
        """Of a follower: the duty cycle that it applies [-]."""
        ...

    def write(self, rotor: float, rotor_rps: float, encoder: float, encoder_rps: float, amps: float) -> None:
        """Set what its sensors read: turns and rates of rotor and encoder [1/s], current of one motor [A]."""
        ...


class _Pace:
    """How many loops a controller owes."""

    def __init__(self) -> None:
        self._owed = 0.0

    def loops(self, dt: float) -> int:
        """Whole loops of the next dt [s]."""
        self._owed += dt
        loops = int(self._owed / _LOOP + 0.5)
        self._owed -= loops * _LOOP
        return loops


class LoopDrivePort:
    """A controller that drives a wheel or an azimuth: `simcore.robot.motor_ports.MotorPort`, `OwnLoops`.

    Its current limits act in the model of the motor.

    Args:
        port: Of the controller.
    """

    def __init__(self, port: LoopPort) -> None:
        self._port = port
        self._pace = _Pace()
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


class LoopMotorSim:
    """Connects a controller, and those that follow it, with any mechanism.

    Args:
        name: Of the leader, in messages.
        mechanism: What it turns.
        leader: Its controller; positive is as for the mechanism.
        followers: The same.
        zero_at: Angle of the mechanism at which the rotors' encoders were when they were switched on [rad].
        encoder_gearing: Turns of a wired encoder per turn of the mechanism [-].

    Raises:
        ConfigError: The mechanism's gearbox has another number of motors than there are devices.
    """

    def __init__(
        self,
        name: str,
        mechanism: ShaftSim,
        leader: LoopPort,
        followers: Sequence[LoopPort] = (),
        *,
        zero_at: float = 0.0,
        encoder_gearing: float = 1.0,
    ) -> None:
        require(name, "zero_at", zero_at, ANGLE)
        require(name, "encoder_gearing", encoder_gearing, GEARING)
        devices = 1 + len(followers)
        if followers and mechanism.motors != devices:
            raise ConfigError(
                f"{name}: {devices} devices (leader and {len(followers)} followers) turn a gearbox of "
                f"{mechanism.motors} motors; write GearboxConfig(motors={devices}, ...)"
            )
        self.mechanism = mechanism
        """What the motor turns."""
        self._leader = leader
        self._followers = list(followers)
        self._zero_at = zero_at
        self._encoder_gearing = encoder_gearing
        self._pace = _Pace()
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
        supply = RobotController.get_battery_voltage() if battery_voltage is None else battery_voltage
        self.run(dt)
        self.read(supply, powered=powered)
        self.mechanism.step(dt, supply)
        self.write()

    def run(self, dt: float) -> None:
        """Let the controller's 1 kHz loops run for dt [s]; what its encoders read stays as it is meanwhile."""
        loops = self._pace.loops(dt)
        if loops > 0:
            self._leader.run(loops)

    def read(self, battery_voltage: float, *, powered: bool = True) -> None:
        """Supply in, volts out, for a mechanism that is stepped elsewhere [V]."""
        leader, m = self._leader, self.mechanism
        leader.set_supply(battery_voltage)
        volts = leader.volts(m.velocity * m.gearbox.volts_per_speed, m.gearbox.resistance) if powered else 0.0
        for port in self._followers:
            port.set_supply(battery_voltage)
            port.show_output(volts / max(battery_voltage, 1.0))
        if not powered or (volts == 0.0 and not leader.brakes):
            m.coast()
        else:
            m.set_volts(volts)

    def write(self) -> None:
        """The mechanism's motion to the encoders, and its current to the meters."""
        m = self.mechanism
        rotor, rps = (m.position - self._zero_at) * m.gearing / math.tau, m.velocity * m.gearing / math.tau
        turns, rate = m.position * self._encoder_gearing / math.tau, m.velocity * self._encoder_gearing / math.tau
        amps = m.current / m.motors
        for port in (self._leader, *self._followers):
            port.write(rotor, rps, turns, rate, amps)
