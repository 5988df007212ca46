"""What every drivetrain on wheels shares: limits, battery, wheels and tires, and readings that are the same for all."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

import numpy as np

from simcore.errors import ConfigError, NonFiniteError
from simcore.robot.battery import Battery, BatteryConfig
from simcore.robot.drive_shaft import DriveShaft, WheelContact, free_speed, launch_accel
from simcore.robot.motor_bus import MotorReadout, bus_voltage
from simcore.robot.tire_solver import TireSolver
from simcore.robot.wheel_loads import WheeledRobot, normal_loads
from simcore.typing import FloatArray
from simcore.units import GRAVITY

__all__ = ["MAX_INNER_STEP", "WheeledDrive", "checked_number"]

MAX_INNER_STEP = 0.005
"""Longest step of motors and tires [s]; a longer step of the owner is cut into equal parts.

With 5 ms all of `scripts/drivetrain_figures.py` is within tolerance, as with 4 and 1; a tick of a robot in the open
takes four inner steps, with 4 ms it took 5.2 on average.
"""

ConfigT = TypeVar("ConfigT", bound=WheeledRobot)


def checked_number(what: str, value: object) -> float:
    """A command as a plain float.

    Args:
        what: Name for the message.
        value: From outside.

    Raises:
        NonFiniteError: It is not a number, or not finite.
    """
    if not isinstance(value, (int, float, np.floating, np.integer)) or not math.isfinite(value):
        raise NonFiniteError(f"{what} must be a finite number, got {value!r}")
    return float(value)


class WheeledDrive(ABC, Generic[ConfigT]):
    """Base of `SwerveDrive` and `TankDrive`: they say what voltage each drive motor is asked for in `_requests`.

    A drive owns wheels, motors, battery and encoders, not the pose: each physics step of the owner is one call of
    `step`, which takes the velocity that the chassis really has (walls and other robots have had their say) and
    returns the change that the tires make. Several drives share nothing.
    """

    def __init__(
        self,
        config: ConfigT,
        *,
        battery: Battery | None,
        wheels: Sequence[WheelContact],
        shafts: Sequence[DriveShaft],
    ) -> None:
        """At rest, not bound to a chassis yet.

        Args:
            config: The robot.
            battery: Its battery; None is a stiff 12 V supply. The drive steps it: nobody else must.
            wheels: In the order of `config.positions`.
            shafts: What turns them; each wheel is on one shaft.
        """
        self.config = config
        self.battery = battery if battery is not None else Battery(BatteryConfig.stiff(12.0))
        self.other_current = 0.0
        """Drawn by everything but the drivetrain, set by the owner at any time [A]."""
        self.enabled = True
        """False: motors go to neutral, as a disabled robot's do."""
        self.before_inner: Callable[[float, float], None] | None = None
        """Called before each inner step with its length [s] and the yaw rate [rad/s]: motor controllers that think as
        often as the drivetrain moves set their volts here."""
        self.time = 0.0
        """Simulated time since the reset [s]."""
        self._solver = TireSolver(mass=config.mass, yaw_inertia=config.yaw_inertia, wheels=wheels, shafts=shafts)
        self._wheels = len(config.positions)
        self._motors = [shaft.motor for shaft in shafts]
        self._emf_per_speed = [motor.emf for motor in self._motors]
        self._stator_limits = [motor.stator_limit for motor in self._motors]
        self._motors_per_shaft = self._motors[0].count
        self._static_loads = normal_loads(config, [True] * self._wheels, (0.0, 0.0, -GRAVITY))
        self._free_speeds = [free_speed(s, self._solver.wheels, self._static_loads) for s in shafts]
        self._shaft_of_wheel = [g for k in range(self._wheels) for g, s in enumerate(shafts) if k in s.wheels]
        self._wheel_radii = [shafts[g].radius for g in self._shaft_of_wheel]
        self._forces: list[tuple[list[float], list[float]]] = []
        self._rest([0.0] * len(shafts))

    def _rest(self, shaft_speeds: list[float]) -> None:
        """Time at zero, battery rested, encoders at zero, drive shafts at these speeds [rad/s]."""
        self.time = 0.0
        self.shaft_angles = [0.0] * len(shaft_speeds)
        """Of the drive shafts since the reset, seen at the wheel, any number of turns [rad]; changed in place."""
        self.shaft_speeds = shaft_speeds
        """[rad/s]; changed in place."""
        self.drive_motors = MotorReadout([motor.resistance for motor in self._motors])
        """One motor of each drive shaft in the last inner step."""
        self._solver.rest(shaft_speeds)
        self._forces = []
        self.battery.reset()
        self._bus = self.battery.voltage
        self._bus_due = 0.0

    # ---------------------------------------------------------------- the step

    def step(
        self,
        h: float,
        vx: float,
        vy: float,
        omega: float,
        normal_loads: Sequence[float] | None = None,
        ax: float = 0.0,
        ay: float = 0.0,
    ) -> tuple[float, float, float]:
        """Change of velocity that the tires make in `h` on a free planar body.

        All vectors are in the robot axes at the START of the step; the turn of the robot within the step is followed
        inside. It is force times time over mass, nothing else: add it to the field-frame velocity rotated by the yaw
        at the start of the step, and no term omega x v is needed.

        Args:
            h: Time step of the owner [s]; cut into parts of at most 5 ms.
            vx: Velocity of the center of mass that the chassis really has, forward [m/s].
            vy: To the left [m/s].
            omega: Yaw rate [rad/s].
            normal_loads: Per wheel [N], 0 off the ground; None is the robot at rest on level ground.
            ax: Acceleration that the owner will add itself in this step (gravity along a slope), forward [m/s^2].
                Knowing it, the tires hold a parked robot on a ramp without creeping. It is not in the result.
            ay: To the left [m/s^2].

        Returns:
            Change of vx, vy [m/s] and omega [rad/s].

        Raises:
            NonFiniteError: When an argument is not finite, or h is not above zero; nothing has changed.
            ConfigError: When there is not one load per wheel.
        """
        loads = self._static_loads if normal_loads is None else normal_loads
        if len(loads) != self._wheels:
            raise ConfigError(f"drivetrain step needs {self._wheels} normal loads, got {len(loads)}")
        if not (h > 0.0 and all(map(math.isfinite, (h, vx, vy, omega, ax, ay, *loads)))):
            raise NonFiniteError(
                f"drivetrain step needs finite numbers and h > 0, got h={h}, velocity=({vx}, {vy}, {omega}), "
                f"acceleration=({ax}, {ay}), loads={list(loads)}"
            )
        # A numpy number from the owner would turn all arithmetic below into numpy calls, ten times slower.
        vx, vy, omega, loads = float(vx), float(vy), float(omega), [float(load) for load in loads]
        parts = math.ceil(h / MAX_INNER_STEP - 1e-9)
        dt = h / parts
        dx = dy = turned = 0.0
        start = omega
        forces = []
        c, s = 1.0, 0.0
        # A robot that spins at 12 rad/s turns by 3.4 degrees in 5 ms: each inner step sees the velocity in the axes of
        # its own moment, and its impulse is turned back to the axes of the start.
        for part in range(parts):
            if part > 0:
                turned += omega * dt
                c = math.cos(turned)
                s = math.sin(turned)
            wx = vx + dx + ax * dt * (part + 1)
            wy = vy + dy + ay * dt * (part + 1)
            ux = c * wx + s * wy
            uy = c * wy - s * wx
            nx, ny, omega = self._inner(dt, ux, uy, omega, loads)
            jx = nx - ux
            jy = ny - uy
            dx += c * jx - s * jy
            dy += s * jx + c * jy
            forces.append((self._solver.force_x, self._solver.force_y))
        self._forces = forces
        return dx, dy, omega - start

    def _inner(
        self, h: float, vx: float, vy: float, omega: float, loads: Sequence[float]
    ) -> tuple[float, float, float]:
        """One inner step of `h` [s]: requests, battery, azimuths, tires and wheels; the new velocity."""
        if self.before_inner is not None:
            self.before_inner(h, omega)
        solver, battery = self._solver, self.battery
        volts, limits = self._requests(h, self._bus, battery.browned_out or not self.enabled)
        bus = self._bus = self._bus_voltage(volts, limits)
        azimuth_supply = self._turn_azimuths(h, loads, bus)
        speeds = self.shaft_speeds
        before = speeds[:]
        result = solver.step(h, vx, vy, omega, loads, volts, limits, bus)
        angles = self.shaft_angles
        half = 0.5 * h
        for g, after in enumerate(speeds):  # with the mean speed, as the robot itself moves
            angles[g] = angles[g] + (before[g] + after) * half
        supply = self.drive_motors.accumulate(solver.shaft_volts, solver.shaft_current, bus, h)
        battery.step(h, self.other_current + supply * self._motors_per_shaft + azimuth_supply)
        self.time += h
        return result

    def _bus_voltage(self, volts: Sequence[float | None], limits: Sequence[float]) -> float:
        """Voltage of battery and drive motors, solved together every 5 ms or at a new command [V]."""
        battery = self.battery
        if battery.config.resistance == 0.0:
            return battery.open_voltage
        if self._bus_due > self.time + 1e-9:  # solving costs a quarter of the tires' step
            return self._bus
        self._bus_due = self.time + MAX_INNER_STEP
        return bus_voltage(
            *(self._bus, battery.open_voltage, battery.config.resistance, self._background_current()),
            *(self._motors, volts, limits, self._back_emf()),
        )

    def _new_command(self) -> None:
        """Solve the bus voltage anew in the next inner step."""
        self._bus_due = self.time

    # ---------------------------------------------------------------- what a kind of drive adds

    @abstractmethod
    def _requests(self, h: float, bus: float, neutral: bool) -> tuple[Sequence[float | None], Sequence[float]]:
        """Voltage wanted per drive shaft [V], None for an open circuit, and stator limit in force [A].

        Args:
            h: Time step [s].
            bus: Voltage of the last inner step [V].
            neutral: Whether outputs are off: disabled or browned out.
        """

    def _turn_azimuths(self, h: float, loads: Sequence[float], bus: float) -> float:
        """Move what steers; the current that its motors take from the battery [A]."""
        return 0.0

    def _back_emf(self) -> list[float]:
        """Of the drive motors now [V]."""
        return [e * w for e, w in zip(self._emf_per_speed, self.shaft_speeds, strict=True)]

    def _background_current(self) -> float:
        """Drawn by everything but the drive motors [A]."""
        return self.other_current

    @abstractmethod
    def wheel_angles(self) -> list[float]:
        """Azimuth of each wheel, in the order of `config.positions` [rad]; any number of turns."""

    @abstractmethod
    def motor_currents(self) -> dict[str, list[float]]:
        """Stator current of every motor in the last inner step, by group [A]."""

    @property
    @abstractmethod
    def gearing(self) -> dict[str, list[float]]:
        """Rotor turns per turn of the wheel or azimuth, of every motor, by group as in `motor_currents` [-]."""

    # ---------------------------------------------------------------- readings

    def wheel_distances(self) -> list[float]:
        """How far each wheel has rolled since the reset, in the order of `config.positions` [m]."""
        angles = self.shaft_angles
        return [angles[g] * r for g, r in zip(self._shaft_of_wheel, self._wheel_radii, strict=True)]

    def wheel_speeds(self) -> list[float]:
        """Speed of each tread against the robot, in the order of `config.positions` [m/s]."""
        speeds = self.shaft_speeds
        return [speeds[g] * r for g, r in zip(self._shaft_of_wheel, self._wheel_radii, strict=True)]

    def wheel_loads(
        self, touching: Sequence[bool], gravity: Sequence[float], acceleration: Sequence[float]
    ) -> list[float]:
        """Load of each wheel [N] for `step`; see `simcore.robot.wheel_loads.normal_loads`."""
        return normal_loads(self.config, touching, gravity, acceleration)

    @property
    def wheel_forces(self) -> FloatArray:
        """Ground on wheels, robot axes, averaged over the last `step` [N], shape (n, 2)."""
        if not self._forces:
            return np.zeros((self._wheels, 2))
        mean: FloatArray = np.mean(np.array(self._forces), axis=0).T
        return mean

    @property
    def robot(self) -> ConfigT:
        """The same as `config`, under the name that a chassis asks for."""
        return self.config

    @property
    def bus_voltage(self) -> float:
        """Battery voltage that the motors had in the last inner step [V]."""
        return self._bus

    @property
    def browned_out(self) -> bool:
        """Whether the roboRIO holds the outputs off."""
        return self.battery.browned_out

    @property
    def supply_current(self) -> float:
        """From the battery in the last inner step, drivetrain only [A]."""
        return self.drive_motors.supply_total * self._motors_per_shaft

    @property
    def electrical_energy(self) -> float:
        """Taken by all motors since the reset: the integral of V I [J]."""
        return self.drive_motors.energy * self._motors_per_shaft

    @property
    def max_speed(self) -> float:
        """Straight ahead at 12 V, where motor torque meets friction and rolling drag [m/s]."""
        return min(self._free_speeds)

    @property
    def max_accel(self) -> float:
        """From rest on level ground at stiff 12 V: grip, motors and stator limits of every wheel counted [m/s^2]."""
        solver = self._solver
        ones = [1.0] * len(solver.shafts)
        return launch_accel(solver.shafts, solver.wheels, self._static_loads, ones, self.config.mass)
