"""A differential (tank) drive: two chained sides on the same motors, tires and solver as the swerve."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from simcore.errors import ConfigError, NonFiniteError, require_finite, require_non_negative, require_positive
from simcore.robot.battery import Battery
from simcore.robot.capability import free_speed, launch_accel
from simcore.robot.electrical import ShaftMotor, bus_voltage
from simcore.robot.encoders import angles_after
from simcore.robot.motor import MotorModel, motor
from simcore.robot.swerve_module import MotorReadout
from simcore.robot.tire import WheelContact
from simcore.robot.tire_solver import DriveShaft, TireSolver
from simcore.robot.wheeled_drive import WheeledDrive
from simcore.typing import FloatArray

__all__ = ["TankConfig", "TankDrive"]


@dataclass(frozen=True, slots=True, kw_only=True)
class TankConfig:
    """A kit-bot: wheels in a row on each side, chained to one gearbox per side. Defaults are FIRST's AM14U class."""

    wheel_xs: tuple[float, ...] = (0.28, 0.0, -0.28)
    """Of the wheels of one side, forward of the robot center [m]."""
    track: float = 0.56
    """Between left and right wheels [m]."""
    motor: MotorModel = field(default_factory=lambda: motor("NEO"))
    motors_per_side: int = 2
    gearing: float = 8.45
    """Rotor turns per wheel turn [-]; kit-bot toughbox 10.71 or 8.45."""
    wheel_radius: float = 0.0762
    """[m]"""
    tread: float = 1.0
    """Coefficient of friction [-]."""
    wheel_inertia: float = 1.5e-3
    """Of one wheel with its sprocket [kg m^2]; estimate, +-50 %."""
    rolling_resistance: float = 0.015
    """Drag per load [-]; estimate for carpet and chains, +-50 %."""
    slip_ratio: float = 0.01
    """See `SwerveModuleConfig`."""
    slip_speed: float = 0.002
    """See `SwerveModuleConfig` [m/s]."""
    friction_volts: float = 0.2
    """Voltage that just turns a free side [V]."""
    efficiency: float = 0.90
    """Of gearbox and chains, both ways [-]."""
    stator_limit: float = math.inf
    """Per motor [A]."""
    supply_limit: float = math.inf
    """Per motor [A], drawing and regenerating."""
    brake: bool = True
    """At zero command: short the motors, or else open the circuit."""
    kp: float = 1.0
    """Feedback of the on-board speed loop [V per m/s]."""
    mass: float = 50.0
    """[kg]"""
    yaw_inertia: float = 5.3
    """[kg m^2]"""
    center_of_mass: tuple[float, float, float] = (0.0, 0.0, 0.2)
    """From the robot center on the floor [m]."""
    positions: tuple[tuple[float, float], ...] = field(init=False, repr=False, compare=False)
    """Of the wheels relative to the center of mass, left side first [m]."""

    def __post_init__(self) -> None:
        if not self.wheel_xs:
            raise ConfigError("tank: wheel_xs must name at least one wheel per side, got none")
        for x in (*self.wheel_xs, *self.center_of_mass):
            require_finite("tank", "wheel_xs and center_of_mass", x, "m")
        for name in (
            *("track", "gearing", "wheel_radius", "wheel_inertia", "slip_ratio", "slip_speed", "efficiency"),
            *("mass", "yaw_inertia"),
        ):
            require_positive("tank", name, getattr(self, name))
        for name in ("tread", "rolling_resistance", "friction_volts", "kp"):
            require_non_negative("tank", name, getattr(self, name))
        if self.efficiency > 1.0:
            raise ConfigError(f"tank: efficiency must be within 0..1, got {self.efficiency}")
        if self.motors_per_side < 1:
            raise ConfigError(f"tank: motors_per_side must be at least 1, got {self.motors_per_side}")
        for name in ("stator_limit", "supply_limit"):
            if not getattr(self, name) >= 0.0:
                raise ConfigError(f"tank: {name} must be >= 0 A (math.inf for none), got {getattr(self, name)}")
        cx, cy, _ = self.center_of_mass
        object.__setattr__(self, "positions", tuple((x - cx, y - cy) for x, y in self.wheel_positions))

    @property
    def wheel_positions(self) -> tuple[tuple[float, float], ...]:
        """Centers of the wheels, robot frame, left side first [m]."""
        return tuple((x, side * 0.5 * self.track) for side in (1.0, -1.0) for x in self.wheel_xs)

    @property
    def wheel_cof(self) -> float:
        """Coefficient of friction [-]."""
        return self.tread


class TankDrive(WheeledDrive[TankConfig]):
    """One robot's tank drive; stepped like `SwerveDrive`, commanded by side.

    Example:
        >>> drive = TankDrive(TankConfig())
        >>> drive.set_volts(6.0, 6.0)
        >>> drive.step(0.005, 0.0, 0.0, 0.0)[0] > 0.0
        True
    """

    def __init__(self, config: TankConfig, *, battery: Battery | None = None) -> None:
        """Stand at rest; `battery` None is a stiff 12 V supply."""
        c = config
        side = ShaftMotor.of(
            c.motor,
            gearing=c.gearing,
            efficiency=c.efficiency,
            friction_volts=c.friction_volts,
            stator_limit=c.stator_limit,
            supply_limit=c.supply_limit,
            count=c.motors_per_side,
        )
        n = len(c.wheel_xs)
        inertia = n * c.wheel_inertia + c.motors_per_side * c.motor.rotor_inertia * c.gearing**2
        self._motors = [side, side]
        solver = TireSolver(
            mass=c.mass,
            yaw_inertia=c.yaw_inertia,
            wheels=[
                WheelContact(x=x, y=y, tread=c.tread, rolling_resistance=c.rolling_resistance) for x, y in c.positions
            ],
            shafts=[
                DriveShaft(
                    inertia=inertia,
                    motor=side,
                    radius=c.wheel_radius,
                    slip_ratio=c.slip_ratio,
                    slip_speed=c.slip_speed,
                    wheels=rows,
                )
                for rows in (tuple(range(n)), tuple(range(n, 2 * n)))
            ],
        )
        super().__init__(config, battery=battery, solver=solver, shafts=2)
        self._volts = (0.0, 0.0)
        self._targets: tuple[float, float] | None = None
        self.reset()

    def reset(self) -> None:
        """Sides at rest, encoders at zero, battery rested, time at zero."""
        self._angle = [0.0, 0.0]
        self._speed = [0.0, 0.0]
        self._rest(self._speed)
        self.motors = MotorReadout([self.config.motor.resistance] * 2)
        """Left and right, each entry one motor of that side, in the last inner step."""
        self.stop()

    def set_volts(self, left: float, right: float) -> None:
        """Raw voltage per side [V].

        Raises:
            NonFiniteError: When one is missing, NaN or infinite; nothing has changed.
        """
        self._volts = _pair("volts", left, right)
        self._targets = None

    def set_speeds(self, left: float, right: float) -> None:
        """Closed loop on board: ground speed per side [m/s]; see `set_volts` for errors."""
        self._targets = _pair("speed", left, right)

    def set_chassis_speeds(self, vx: float, omega: float) -> None:
        """Closed loop on board: forward speed [m/s] and yaw rate [rad/s], if the wheels did not scrub."""
        vx, omega = _pair("chassis speed", vx, omega)
        half = 0.5 * self.config.track * omega
        self.set_speeds(vx - half, vx + half)

    def stop(self) -> None:
        """Zero command: brake or coast."""
        self._volts = (0.0, 0.0)
        self._targets = None

    def _inner(
        self, h: float, vx: float, vy: float, omega: float, loads: Sequence[float]
    ) -> tuple[float, float, float]:
        c, solver, battery = self.config, self._solver, self.battery
        request: list[float | None] = list(self._volts)
        if not self.enabled or battery.browned_out:
            request = [0.0, 0.0]
        elif self._targets is not None:
            request = [
                m.emf * v / c.wheel_radius + c.kp * (v - w * c.wheel_radius)
                for m, v, w in zip(self._motors, self._targets, self._speed, strict=True)
            ]
        if not c.brake:
            request = [v if v != 0.0 else None for v in request]
        limits = [c.stator_limit, c.stator_limit]
        emfs = [m.emf * w for m, w in zip(self._motors, self._speed, strict=True)]
        self._bus = bus_voltage(
            *(self._bus, battery.open_voltage, battery.config.resistance, self.other_current),
            *(self._motors, request, limits, emfs),
        )
        before = self._speed[:]
        result = solver.step(
            *(h, vx, vy, omega, loads, (1.0, 1.0), (0.0, 0.0), request, (0.0, 0.0), (0.0, 0.0), limits, self._bus)
        )
        self._angle = angles_after(self._angle, before, self._speed, h)
        each = self.motors.book(solver.shaft_volts, solver.shaft_current, self._bus, h)
        battery.step(h, self.other_current + each * c.motors_per_side)
        self.time += h
        if self.encoders.due <= self.time + 1e-9:
            self.encoders.record(self.time, h, self._angle, self._speed, (0.0, 0.0), (0.0, 0.0))
        return result

    @property
    def electrical_energy(self) -> float:
        """Taken by all motors since the reset [J]."""
        return self.motors.energy * self.config.motors_per_side

    @property
    def side_distances(self) -> FloatArray:
        """What left and right encoders make of it [m], shape (2,)."""
        return np.array(self._angle) * self.config.wheel_radius

    @property
    def side_speeds(self) -> FloatArray:
        """At the tread, left and right [m/s], shape (2,)."""
        return np.array(self._speed) * self.config.wheel_radius

    @property
    def max_speed(self) -> float:
        """Straight ahead at 12 V [m/s]."""
        return min(free_speed(s, self._solver.wheels, self._static_loads) for s in self._solver.shafts)

    @property
    def max_accel(self) -> float:
        """From rest on level ground at stiff 12 V [m/s^2]."""
        solver = self._solver
        return launch_accel(solver.shafts, solver.wheels, self._static_loads, (1.0, 1.0), self.config.mass)


def _pair(what: str, left: float, right: float) -> tuple[float, float]:
    for side, value in (("left", left), ("right", right)):
        if not isinstance(value, (int, float, np.floating, np.integer)) or not math.isfinite(value):
            raise NonFiniteError(f"tank {what}, {side}, must be a finite number, got {value!r}")
    return float(left), float(right)
