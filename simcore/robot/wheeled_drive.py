"""What every drivetrain on wheels shares: limits, battery, wheels and tires, and readings that are the same for all."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from operator import mul
from typing import Generic, TypeVar

import numpy as np

from simcore.errors import ConfigError, NonFiniteError
from simcore.geometry.rotation import Vector
from simcore.robot.battery import Battery, BatteryConfig
from simcore.robot.drive_shaft import DriveShaft, WheelContact, free_speed, launch_accel
from simcore.robot.motor_bus import MotorReadout, bus_voltage
from simcore.robot.tire_solver import TireSolver
from simcore.robot.wheel_config import DrivetrainConfig, RobotMass
from simcore.robot.wheel_loads import LoadTransfer, normal_loads
from simcore.typing import FloatArray
from simcore.units import GRAVITY, plain_sum

__all__ = ["MAX_INNER_STEP", "WheeledDrive", "checked_number"]

MAX_INNER_STEP = 0.005
"""Longest step of motors and tires [s]; a longer step of the owner is cut into equal parts.

With 5 ms all of `scripts/drivetrain_figures.py` is within tolerance, as with 4 and 1, and a robot whose tires hold ends
5 s of rough commands within some millimeters of where it ends with 0.16 ms.
"""

SLIDING_INNER_STEP = 0.00125
"""The same while a tire slides [s]: its force follows the slip within milliseconds.

With 5 ms, 5 s of rough commands end up to 50 mm and 5 degrees from where they end with 0.16 ms, with 2.5 ms 30 mm and
2 degrees, with 1.25 ms 15 mm and 0.6 degrees.
"""

_PARKED_SPEED, _PARKED_PULL = 1e-6, 1e-3
"""Of a chassis that stands [m/s and rad/s, m/s^2 and rad/s^2]: the engine leaves it 1e-10, and a slope of 0.01 degrees
pulls with 2e-3."""

_ZERO = (0.0, 0.0, 0.0)

ConfigT = TypeVar("ConfigT", bound=DrivetrainConfig)


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
    """Base of `SwerveDrive`, `TankDrive` and `MecanumDrive`, whose `_requests` are the voltages of the drive motors.

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
        radii: Sequence[float],
    ) -> None:
        """At rest, not bound to a chassis yet.

        Args:
            config: The robot.
            battery: Its battery; None is a stiff 12 V supply. The drive steps it.
            wheels: In the order of `config.positions`.
            shafts: What turns them; each wheel is on one shaft.
            radii: Of the wheels, as robot code knows them [m]; a shaft has the true one.
        """
        self.config = config
        self.battery = battery if battery is not None else Battery(BatteryConfig.stiff(12.0))
        self.other_current = 0.0
        """Drawn by everything but the drivetrain, set by the owner at any time [A]."""
        self.enabled = True
        """False: motors go to neutral, as a disabled robot's do."""
        self.time = 0.0
        """Simulated time since the reset [s]."""
        self._solver = TireSolver(mass=config.mass, yaw_inertia=config.yaw_inertia, wheels=wheels, shafts=shafts)
        self._wheels = len(config.positions)
        self._motors = [shaft.motor for shaft in shafts]
        self._emf_per_speed = [motor.emf for motor in self._motors]
        self._stator_limits = [motor.stator_limit for motor in self._motors]
        self._motors_per_shaft = self._motors[0].count
        self._robot: RobotMass = config
        cx, cy, _ = config.center_of_mass
        self._wheel_places = [(x + cx, y + cy) for x, y in config.positions]
        self._static_loads = normal_loads(config, [True] * self._wheels, (0.0, 0.0, -GRAVITY))
        self._free_speeds = [free_speed(s, self._solver.wheels, self._static_loads) for s in shafts]
        self._shaft_of_wheel = [g for k in range(self._wheels) for g, s in enumerate(shafts) if k in s.wheels]
        self._wheel_radii = list(radii)
        self._forces: list[tuple[list[float], list[float]]] = []
        self._loads: list[Sequence[float]] = []
        self._shares: list[float] = []
        self._rest([0.0] * len(shafts))

    def set_mass_properties(self, mass: float, yaw_inertia: float, center_of_mass: tuple[float, float, float]) -> None:
        """What the robot weighs from the next step on, with what it holds and as its mechanisms stand.

        Robot code and its loops know nothing of it: `config` and what it says of speeds stay. The same numbers again
        cost one comparison.

        Args:
            mass: Of the whole robot [kg].
            yaw_inertia: About the vertical axis through the center of mass [kg m^2].
            center_of_mass: From the robot center on the floor, robot axes [m]. `step` takes and gives the velocity of
                this point from now on.

        Raises:
            NonFiniteError: When a number is not finite, or mass or inertia not above zero; nothing has changed.
        """
        old = self._robot
        if mass == old.mass and yaw_inertia == old.yaw_inertia and center_of_mass == old.center_of_mass:
            return
        if not (all(map(math.isfinite, (mass, yaw_inertia, *center_of_mass))) and mass > 0.0 and yaw_inertia > 0.0):
            raise NonFiniteError(
                "drivetrain needs finite mass properties, mass and inertia above zero, got "
                f"mass={mass}, yaw_inertia={yaw_inertia}, center_of_mass={center_of_mass}"
            )
        cx, cy, cz = map(float, center_of_mass)
        positions = old.positions
        if (cx, cy) != old.center_of_mass[:2]:
            positions = tuple((x - cx, y - cy) for x, y in self._wheel_places)
        robot = self._robot = RobotMass(
            mass=float(mass),
            yaw_inertia=float(yaw_inertia),
            center_of_mass=(cx, cy, cz),
            positions=positions,
            lowered=old.lowered,
        )
        self._solver.set_mass(robot.mass, robot.yaw_inertia, positions)
        self._static_loads = normal_loads(robot, [True] * self._wheels, (0.0, 0.0, -GRAVITY))

    def _rest(self, shaft_speeds: list[float]) -> None:
        """Time at zero, battery rested, encoders at zero, drive shafts at these speeds [rad/s]."""
        self.time = 0.0
        self.shaft_angles = [0.0] * len(shaft_speeds)
        """Of the drive shafts since the reset, seen at the wheel, any number of turns [rad]; changed in place."""
        self.shaft_speeds = shaft_speeds
        """[rad/s]; changed in place."""
        self.drive_motors = MotorReadout([motor.winding for motor in self._motors])
        """One motor of each drive shaft in the last inner step."""
        self._solver.rest(shaft_speeds)
        self._forces, self._loads, self._shares = [], [], []
        self._spin_up = 0.0  # angular acceleration in the last inner step [rad/s^2]
        self.change = (0.0, 0.0, 0.0)
        """Of the velocity, by the tires, in the present `step` until now [m/s, m/s, rad/s]."""
        self.mean_change = (0.0, 0.0, 0.0)
        """Mean over the last `step` of what the tires had changed until then [m/s, m/s, rad/s].

        The velocity at the start plus this, times h, is the way that they moved the robot."""
        self.yaw_rate = 0.0
        """After the last part of a step, as the tires and the expected pull leave it [rad/s]."""
        self._transfer: LoadTransfer | None = None
        self._fixed_loads: list[float] = []
        self._start, self._pull = (0.0, 0.0), (0.0, 0.0, 0.0)
        self._h = self._gone = self._turned = 0.0  # of the present step [s, s, rad]
        self._moved = (0.0, 0.0, 0.0)  # by the tires in the present step [m, m, rad]
        self.battery.reset()
        self._bus = self.battery.voltage
        self._bus_due = 0.0
        self._was_off = self.battery.browned_out
        self._was_enabled = self.enabled
        self._has_new_command = True
        self._is_still = False  # whether the chassis stands in the present step, and nothing pulls at it
        self._still_step = 0.0  # length of the last part, if nothing at all moved in it [s]

    # ---------------------------------------------------------------- the step

    def step(
        self,
        h: float,
        velocity: Vector,
        normal_loads: Sequence[float] | LoadTransfer | None = None,
        pull: Vector = (0.0, 0.0, 0.0),
    ) -> Vector:
        """Change of velocity that the tires make in `h` on a free planar body.

        All vectors are in the robot axes at the START of the step; the turn of the robot within the step is followed
        inside. It is force times time over mass, nothing else: add it to the field-frame velocity rotated by the yaw
        at the start of the step, and no term omega x v is needed.

        Args:
            h: Time step of the owner [s]; cut into parts of at most 5 ms.
            velocity: Over ground, of the point on the carpet under the center of mass: forward, to the left, yaw rate
                [m/s, m/s, rad/s].
            normal_loads: Per wheel [N], 0 off the ground; a `LoadTransfer` follows what the tires do within the step;
                None is the robot at rest on level ground.
            pull: Acceleration that the owner adds itself in this step (a slope, a wall that pushes back)
                [m/s^2, m/s^2, rad/s^2]. Knowing it, the tires hold a parked robot on a ramp without creeping. It is
                not in the result.

        Returns:
            Change of the velocity [m/s, m/s, rad/s].

        Raises:
            NonFiniteError: When an argument is not finite, or h is not above zero; nothing has changed.
            ConfigError: When there is not one load per wheel.
        """
        for dt in self.begin_step(h, velocity, normal_loads, pull):
            self.advance(dt)
        return self.change

    def begin_step(
        self,
        h: float,
        velocity: Vector,
        normal_loads: Sequence[float] | LoadTransfer | None = None,
        pull: Vector = (0.0, 0.0, 0.0),
        *,
        may_rest: bool = True,
    ) -> list[float]:
        """Begin a `step`; call `advance` with each of the lengths that it returns, then `change` is its result.

        Args:
            h: See `step`.
            velocity: See `step`.
            normal_loads: See `step`.
            pull: See `step`.
            may_rest: Whether one part is enough for a robot in which nothing moves.

        Returns:
            Lengths of its parts, at most 5 ms each [s].
        """
        self._transfer = None
        fixed: Sequence[float] = ()
        if isinstance(normal_loads, LoadTransfer):
            self._transfer = normal_loads
        else:
            fixed = self._static_loads if normal_loads is None else normal_loads
            if len(fixed) != self._wheels:
                raise ConfigError(f"drivetrain step needs {self._wheels} normal loads, got {len(fixed)}")
        if not (h > 0.0 and all(map(math.isfinite, (h, *velocity, *pull, *fixed)))):
            raise NonFiniteError(
                f"drivetrain step needs finite numbers and h > 0, got h={h}, velocity={velocity}, "
                f"acceleration={pull}, loads={list(fixed)}"
            )
        # A numpy number from the owner would turn all arithmetic below into numpy calls, ten times slower.
        (vx, vy, omega), (ax, ay, alpha) = velocity, pull
        self._start = float(vx), float(vy)
        self.yaw_rate = float(omega)
        self._pull = float(ax), float(ay), float(alpha)
        self._fixed_loads = [float(load) for load in fixed]
        is_parked = self._is_parked(velocity, pull)
        self._is_still = is_parked and velocity == _ZERO and pull == _ZERO
        count = 1 if may_rest and is_parked else math.ceil(h / MAX_INNER_STEP - 1e-9)
        self._h, self._gone, self._turned = h, 0.0, 0.0
        self.change = self.mean_change = self._moved = (0.0, 0.0, 0.0)
        self._forces, self._loads, self._shares = [], [], []
        return [h / count] * count

    def advance(self, h: float) -> None:
        """One part of the step that has begun, h [s] long."""
        if self._is_still and self._stand_still(h):
            return
        transfer, (vx, vy), (ax, ay, alpha) = self._transfer, self._start, self._pull
        (dx, dy, spun), (mean_x, mean_y, mean_spin) = self.change, self._moved
        omega, turned, gone, loads, whole = self.yaw_rate, self._turned, self._gone, self._fixed_loads, self._h
        count = math.ceil(h / SLIDING_INNER_STEP - 1e-9) if self._solver.is_sliding else 1
        dt = h / count
        # A robot that spins at 12 rad/s turns by 3.4 degrees in 5 ms. Tires that hold leave no slip in the axes at the
        # end of an inner step, and their forces act in those of its middle: so a circle is closed to second order.
        for _ in range(count):
            gone += dt
            half = 0.5 * (omega + 0.5 * self._spin_up * dt) * dt
            c_half = math.cos(half)
            s_half = math.sin(half)
            c = math.cos(turned + 2.0 * half)
            s = math.sin(turned + 2.0 * half)
            wx = vx + dx + ax * gone
            wy = vy + dy + ay * gone
            if transfer is not None:
                loads = transfer.loads(dt)
            jx, jy, jn = self._inner(dt, (c * wx + s * wy, c * wy - s * wx, omega + alpha * dt), loads)
            c_mid = c * c_half + s * s_half
            s_mid = s * c_half - c * s_half
            turn = (omega + 0.5 * (alpha * dt + jn)) * dt
            if transfer is not None:
                transfer.follow(dt, jx / dt, jy / dt, turn)
            kick_x = c_mid * jx - s_mid * jy
            kick_y = s_mid * jx + c_mid * jy
            mean_x += (dx + 0.5 * kick_x) * dt
            mean_y += (dy + 0.5 * kick_y) * dt
            mean_spin += (spun + 0.5 * jn) * dt
            dx += kick_x
            dy += kick_y
            spun += jn
            omega += alpha * dt + jn
            turned += turn
            self._spin_up = alpha + jn / dt
            self._forces.append((self._solver.force_x, self._solver.force_y))
            self._loads.append(loads)
            self._shares.append(dt / whole)
        self.change, self._moved = (dx, dy, spun), (mean_x, mean_y, mean_spin)
        self.mean_change = (mean_x / whole, mean_y / whole, mean_spin / whole)
        self.yaw_rate, self._turned, self._gone = omega, turned, gone
        self._was_enabled, self._has_new_command = self.enabled, False
        stands = self._is_still and count == 1 and min(loads) > 0.0 and self._solver.is_at_rest
        self._still_step = h if stands else 0.0

    def _stand_still(self, h: float) -> bool:
        """A part of a step that can change nothing but battery, wheel loads and time, and what it changes of these.

        That is so if the chassis stands, and the last part was of the same length and ended with nothing that turns,
        slides or carries current: without a slip tires push with nothing, whatever they carry.

        Returns:
            Whether it is so; otherwise nothing has changed.
        """
        if h != self._still_step or self._has_new_command or self.enabled != self._was_enabled:
            return False
        transfer, battery, loads = self._transfer, self.battery, self._fixed_loads
        if battery.browned_out:
            return False
        if transfer is not None:
            loads = transfer.loads(h)
        if min(loads) <= 0.0:
            return False
        if transfer is not None:
            transfer.follow(h, 0.0, 0.0, 0.0)
        bus = self._bus = self._bus_voltage((), ())
        self._rest_azimuths()
        battery.step(h, self.other_current, bus)
        self.time += h
        self._forces.append((self._solver.force_x, self._solver.force_y))
        self._loads.append(loads)
        self._shares.append(h / self._h)
        self._gone += h
        return True

    def _is_parked(self, velocity: Vector, pull: Vector) -> bool:
        """Whether nothing turns, no current flows and nothing has changed: then one inner step is as good as many.

        Args:
            velocity: Of the chassis [m/s, m/s, rad/s].
            pull: What the owner adds to it [m/s^2, m/s^2, rad/s^2].
        """
        if self._has_new_command or self.enabled != self._was_enabled or self._was_off:
            return False
        if any(self.shaft_speeds) or any(self.drive_motors.current):
            return False
        if velocity == _ZERO and pull == _ZERO:
            return True
        return max(map(abs, velocity)) < _PARKED_SPEED and max(map(abs, pull)) < _PARKED_PULL

    def _inner(self, h: float, velocity: Vector, loads: Sequence[float]) -> Vector:
        """One inner step of `h` [s]: requests, battery, azimuths, tires and wheels; the change of velocity.

        Args:
            h: Inner step [s].
            velocity: See `TireSolver.step`.
            loads: Of the wheels [N].
        """
        solver, battery = self._solver, self.battery
        if battery.browned_out != self._was_off:
            self._was_off = battery.browned_out
            self._new_command()
        if self._was_off:
            volts, limits = self._open_circuits()
        else:
            volts, limits = self._requests(h, self._bus, not self.enabled)
        bus = self._bus = self._bus_voltage(volts, limits)
        azimuth_supply = self._turn_azimuths(h, loads, bus)
        speeds = self.shaft_speeds
        before = speeds[:]
        result = solver.step(h, velocity, loads, volts, limits, bus)
        angles = self.shaft_angles
        half = 0.5 * h
        for g, after in enumerate(speeds):  # with the mean speed, as the robot itself moves
            angles[g] = angles[g] + (before[g] + after) * half
        supply = self.drive_motors.accumulate(solver.shaft_volts, solver.shaft_current, bus, h)
        battery.step(h, self.other_current + supply * self._motors_per_shaft + azimuth_supply, bus)
        self.time += h
        return result

    def _bus_voltage(self, volts: Sequence[float | None], limits: Sequence[float]) -> float:
        """Voltage of battery and drive motors, solved together every 5 ms or at a new command [V].

        Args:
            volts: Wanted per drive shaft [V]; none at all: no motor turns or carries current.
            limits: Stator limits [A].
        """
        battery = self.battery
        if battery.config.resistance == 0.0:
            return battery.open_voltage
        if self._bus_due > self.time + 1e-9:  # solving costs a quarter of the tires' step
            return self._bus
        self._bus_due = self.time + MAX_INNER_STEP
        turning = (self._motors, volts, limits, self._back_emf()) if volts else ((), (), (), ())
        return bus_voltage(
            self._bus, battery.open_voltage, battery.config.resistance, self._background_current(), *turning
        )

    def _new_command(self, is_other: bool = True) -> None:
        """Solve the bus voltage anew in the next inner step.

        Args:
            is_other: Whether it is another command than the last one.
        """
        self._bus_due = self.time
        self._has_new_command |= is_other

    # ---------------------------------------------------------------- what a kind of drive adds

    @abstractmethod
    def _requests(self, h: float, bus: float, neutral: bool) -> tuple[Sequence[float | None], Sequence[float]]:
        """Voltage wanted per drive shaft [V], None for an open circuit, and stator limit in force [A].

        Args:
            h: Time step [s].
            bus: Voltage of the last inner step [V].
            neutral: Whether the robot is disabled: motors then brake or coast as configured.
        """

    def _open_circuits(self) -> tuple[Sequence[float | None], Sequence[float]]:
        """The same in a brown-out: every bridge is off."""
        return [None] * len(self._motors), self._stator_limits

    def _turn_azimuths(self, h: float, loads: Sequence[float], bus: float) -> float:
        """Move what steers; the current that its motors take from the battery [A]."""
        return 0.0

    def _rest_azimuths(self) -> None:
        """The same where nothing steers, turns or carries current."""

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
        """How far each wheel has rolled since the reset, by encoder and config, as `config.positions` has them [m]."""
        angles = self.shaft_angles
        return [angles[g] * r for g, r in zip(self._shaft_of_wheel, self._wheel_radii, strict=True)]

    def wheel_speeds(self) -> list[float]:
        """Speed of each tread against the robot, by encoder and config, as `config.positions` has them [m/s]."""
        speeds = self.shaft_speeds
        return [speeds[g] * r for g, r in zip(self._shaft_of_wheel, self._wheel_radii, strict=True)]

    @property
    def normal_loads(self) -> list[float]:
        """Load of each wheel, averaged over the last `step` [N]."""
        if not self._loads:
            return self._static_loads[:]
        return [plain_sum(map(mul, loads, self._shares)) for loads in zip(*self._loads, strict=True)]

    @property
    def wheel_forces(self) -> FloatArray:
        """Ground on wheels, robot axes, averaged over the last `step` [N], shape (n, 2)."""
        if not self._forces:
            return np.zeros((self._wheels, 2))
        mean: FloatArray = np.tensordot(self._shares, np.array(self._forces), axes=1).T
        return mean

    @property
    def wheel_slip(self) -> float:
        """Speed of the fastest sliding tire over the ground in the last inner step [m/s]; 0 while all of them hold."""
        return max(self._solver.slip) if self._solver.is_sliding else 0.0

    @property
    def robot(self) -> RobotMass:
        """Mass and wheel positions now: `config`, until `set_mass_properties` changes them."""
        return self._robot

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
        return launch_accel(solver.shafts, solver.wheels, self._static_loads, ones, self._robot.mass)
