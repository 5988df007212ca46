"""The swerve drive: commands in, tire forces out, with motors, battery and encoders between."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from simcore.errors import ConfigError, NonFiniteError
from simcore.robot.battery import Battery
from simcore.robot.capability import free_speed, launch_accel
from simcore.robot.electrical import ShaftMotor, bus_voltage
from simcore.robot.encoders import angles_after
from simcore.robot.inner_steps import MAX_INNER_STEP
from simcore.robot.module_control import DriveMode, ModuleController
from simcore.robot.module_targets import module_targets
from simcore.robot.swerve_config import SwerveConfig
from simcore.robot.swerve_module import ModuleState, MotorReadout, SteerBank
from simcore.robot.tire import WheelContact
from simcore.robot.tire_solver import DriveShaft, TireSolver
from simcore.robot.wheeled_drive import WheeledDrive
from simcore.typing import FloatArray

__all__ = ["SwerveDrive"]


class SwerveDrive(WheeledDrive[SwerveConfig]):
    """One robot's drivetrain. It owns wheels, motors, battery and encoders, not the pose.

    Each physics step of the owner is one call of `step`: it takes the velocity that the chassis really has (walls and
    other robots have had their say) and returns the change that the tires make. Several drives share nothing.

    Example:
        >>> from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
        >>> drive = SwerveDrive(SwerveConfig.square(0.527, SwerveModuleConfig(x=0, y=0)))
        >>> drive.set_volts([6.0] * 4, [0.0] * 4)
        >>> dvx, dvy, domega = drive.step(0.005, 0.0, 0.0, 0.0)
        >>> dvx > 0.0
        True
    """

    def __init__(self, config: SwerveConfig, *, battery: Battery | None = None) -> None:
        """Put wheels at rest, pointing forward.

        Args:
            config: The robot.
            battery: Its battery; None is a stiff 12 V supply. The drive steps it: nobody else must.
        """
        modules = config.modules
        n = len(modules)
        self._n = n
        self._drive_motors = [
            ShaftMotor.of(
                m.drive_motor,
                gearing=m.drive_gearing,
                efficiency=m.drive_efficiency,
                friction_volts=m.drive_friction_volts,
                stator_limit=m.drive_stator_limit,
                supply_limit=m.drive_supply_limit,
            )
            for m in modules
        ]
        solver = TireSolver(
            mass=config.mass,
            yaw_inertia=config.yaw_inertia,
            wheels=[
                WheelContact(x=x, y=y, tread=m.tread, rolling_resistance=m.rolling_resistance)
                for (x, y), m in zip(config.positions, modules, strict=True)
            ],
            shafts=[
                DriveShaft(
                    inertia=m.drive_inertia,
                    motor=motor,
                    radius=m.wheel_radius,
                    slip_ratio=m.slip_ratio,
                    slip_speed=m.slip_speed,
                    wheels=(i,),
                )
                for i, (m, motor) in enumerate(zip(modules, self._drive_motors, strict=True))
            ],
        )
        super().__init__(config, battery=battery, solver=solver, shafts=n)
        self._steer = SteerBank(modules)
        self._drive_emf = [m.emf for m in self._drive_motors]
        self._zeros = [0.0] * n
        # Azimuth coupling: [V s/rad] of back-EMF, and [kg m^2] of rotor that the azimuth turns as well.
        self._coupled_emf = [m.coupling_ratio / m.drive_motor.kv for m in modules]
        self._coupled_inertia = [m.drive_motor.rotor_inertia * m.drive_gearing * m.coupling_ratio for m in modules]
        self._coupled = any(m.coupling_ratio != 0.0 for m in modules)
        self._controller = ModuleController(modules, self._drive_motors, self._steer.motors, self._static_loads)
        self._free_speeds = [free_speed(s, solver.wheels, self._static_loads) for s in solver.shafts]
        self._max_speed = min(self._free_speeds)
        self.before_inner: Callable[[float, float], None] | None = None
        """Called before each inner step with its length [s] and the yaw rate [rad/s]: motor controllers that think as
        often as the drivetrain moves set their volts here."""
        self.reset()

    # ---------------------------------------------------------------- commands

    def set_volts(self, drive: Sequence[float], steer: Sequence[float]) -> None:
        """Raw voltage of every motor, kept until the next command [V].

        Raises:
            NonFiniteError: When a voltage is missing, NaN or infinite; it names the module, and nothing has changed.
            ConfigError: When there is not one voltage per module.
        """
        drive_ = self._checked("drive volts", drive)
        steer_ = self._checked("steer volts", steer)
        self._command(DriveMode.VOLTS, drive_, steer_)

    def set_duty_cycles(self, drive: Sequence[float], steer: Sequence[float]) -> None:
        """Share of the battery voltage per motor, -1..1; see `set_volts` for errors."""
        drive_ = [min(1.0, max(-1.0, d)) for d in self._checked("drive duty cycle", drive)]
        steer_ = [min(1.0, max(-1.0, d)) for d in self._checked("steer duty cycle", steer)]
        self._command(DriveMode.DUTY, drive_, steer_)

    def set_torque_currents(self, drive: Sequence[float], steer: Sequence[float]) -> None:
        """Stator current of the drive motors [A] and voltage of the steer motors [V]; see `set_volts` for errors."""
        drive_ = self._checked("drive current", drive)
        steer_ = self._checked("steer volts", steer)
        self._command(DriveMode.TORQUE_CURRENT, drive_, steer_)

    def set_module_states(self, speeds: Sequence[float], angles: Sequence[float]) -> None:
        """Closed loop on board: ground speed [m/s] and steer angle [rad] per module; see `set_volts` for errors."""
        speeds_ = self._checked("module speed", speeds)
        angles_ = self._checked("module angle", angles)
        self._command(DriveMode.STATES, speeds_, angles_)

    def set_chassis_speeds(self, vx: float, vy: float, omega: float) -> None:
        """Closed loop on board: velocity of the robot in its own frame [m/s, m/s, rad/s]; scaled down if too fast.

        Raises:
            NonFiniteError: When a speed is NaN or infinite; nothing has changed.
        """
        for name, value in (("vx", vx), ("vy", vy), ("omega", omega)):
            _number(f"chassis speed {name}", value)
        positions = [(m.x, m.y) for m in self.config.modules]
        speeds, angles = module_targets(positions, vx, vy, omega, self.max_speed, self._present_angles())
        self._command(DriveMode.STATES, speeds, angles)

    def stop(self) -> None:
        """Zero command: every motor to its neutral mode, brake or coast."""
        self._command(DriveMode.NEUTRAL, self._zeros, self._zeros)

    def _command(self, mode: DriveMode, drive: list[float], steer: list[float]) -> None:
        self._controller.command(mode, drive, steer)
        self._bus_due = self.time

    def reset(self, *, angles: Sequence[float] | None = None) -> None:
        """Everything as new: wheels at rest at `angles` [rad], encoders at zero, battery rested, time at zero."""
        n = self._n
        turned = [0.0] * n if angles is None else self._checked("steer angle", angles)
        self.state = ModuleState.zeros(n)
        self.state.steer_angle = turned
        self.state.cos = [math.cos(a) for a in turned]
        self.state.sin = [math.sin(a) for a in turned]
        self._rest(self.state.wheel_speed)
        self.drive_motors = MotorReadout([m.resistance for m in self._drive_motors])
        """Of the drive motors in the last inner step."""
        self.steer_motors = MotorReadout([m.resistance for m in self._steer.motors])
        """Of the steer motors in the last inner step."""
        self._steer_supply = 0.0
        self._bus_due = 0.0
        self._controller.reset()

    # ---------------------------------------------------------------- the step

    def _inner(
        self, h: float, vx: float, vy: float, omega: float, loads: Sequence[float]
    ) -> tuple[float, float, float]:
        """One inner step: requests, battery, azimuths, tires and wheels, encoders."""
        if self.before_inner is not None:
            self.before_inner(h, omega)
        state = self.state
        solver = self._solver
        battery = self.battery
        bus = self._bus
        neutral = battery.browned_out or not self.enabled
        drive, steer, limits = self._controller.requests(h, state, bus, neutral)
        coupled = self._coupled
        if battery.config.resistance == 0.0:
            bus = battery.open_voltage
        elif self._bus_due <= self.time + 1e-9:
            # Every 5 ms or at a new command: it costs a quarter of the tires' step.
            self._bus_due = self.time + MAX_INNER_STEP
            emfs = [e * w for e, w in zip(self._drive_emf, state.wheel_speed, strict=True)]
            if coupled:
                emfs = [e + k * w for e, k, w in zip(emfs, self._coupled_emf, state.steer_speed, strict=True)]
            # Azimuths spin up within a step, so what they drew in the last steps says more than their voltage.
            bus = bus_voltage(
                bus,
                battery.open_voltage,
                battery.config.resistance,
                self.other_current + self._steer_supply,
                self._drive_motors,
                drive,
                limits,
                emfs,
            )
        self._bus = bus

        before = state.steer_speed[:] if coupled else None
        steer_supply = self._steer.step(h, state, steer, loads, solver.shaft_current, bus, self.steer_motors)
        if before is not None:
            offset = [k * w for k, w in zip(self._coupled_emf, state.steer_speed, strict=True)]
            torque = [
                -j * (new - old) / h
                for j, new, old in zip(self._coupled_inertia, state.steer_speed, before, strict=True)
            ]
        else:
            offset = torque = self._zeros
        wheel_speed = state.wheel_speed[:]
        result = solver.step(h, vx, vy, omega, loads, state.cos, state.sin, drive, offset, torque, limits, bus)
        state.wheel_angle = angles_after(state.wheel_angle, wheel_speed, state.wheel_speed, h)
        supply = self.drive_motors.book(solver.shaft_volts, solver.shaft_current, bus, h)
        battery.step(h, self.other_current + supply + steer_supply)
        self._steer_supply = 0.5 * (self._steer_supply + steer_supply)
        self.time += h
        if self.encoders.due <= self.time + 1e-9:
            self.encoders.record(
                self.time, h, state.wheel_angle, state.wheel_speed, state.steer_angle, state.steer_speed
            )
        return result

    # ---------------------------------------------------------------- readings

    @property
    def supply_current(self) -> float:
        """From the battery in the last inner step, drivetrain only [A]."""
        return sum(self.drive_motors.supply, 0.0) + sum(self.steer_motors.supply, 0.0)

    @property
    def electrical_energy(self) -> float:
        """Taken by all motors since the reset: the integral of V I [J]."""
        return self.drive_motors.energy + self.steer_motors.energy

    @property
    def wheel_angles(self) -> FloatArray:
        """[rad], any number of turns, shape (n,)."""
        return np.array(self.state.wheel_angle)

    @property
    def wheel_distances(self) -> FloatArray:
        """What the drive encoders make of it [m], shape (n,)."""
        return np.array([a * m.wheel_radius for a, m in zip(self.state.wheel_angle, self.config.modules, strict=True)])

    @property
    def wheel_speeds(self) -> FloatArray:
        """At the tread [m/s], shape (n,)."""
        return np.array([w * m.wheel_radius for w, m in zip(self.state.wheel_speed, self.config.modules, strict=True)])

    @property
    def steer_angles(self) -> FloatArray:
        """[rad], any number of turns, shape (n,)."""
        return np.array(self.state.steer_angle)

    @property
    def steer_speeds(self) -> FloatArray:
        """[rad/s], shape (n,)."""
        return np.array(self.state.steer_speed)

    @property
    def drive_rotor_angles(self) -> FloatArray:
        """What the drive motors' own encoders show: gearing and azimuth coupling included [rad], shape (n,)."""
        s = self.state
        return np.array(
            [
                m.drive_gearing * a + m.coupling_ratio * t
                for m, a, t in zip(self.config.modules, s.wheel_angle, s.steer_angle, strict=True)
            ]
        )

    @property
    def drive_rotor_speeds(self) -> FloatArray:
        """[rad/s], shape (n,)."""
        s = self.state
        return np.array(
            [
                m.drive_gearing * a + m.coupling_ratio * t
                for m, a, t in zip(self.config.modules, s.wheel_speed, s.steer_speed, strict=True)
            ]
        )

    # ---------------------------------------------------------------- what it can do

    @property
    def max_speed(self) -> float:
        """Straight ahead at 12 V, where motor torque meets friction and rolling drag [m/s]."""
        return self._max_speed

    @property
    def max_omega(self) -> float:
        """On the spot at 12 V [rad/s]; the first module to reach its top speed decides."""
        arms = self._arms()
        return min((v / r for v, r in zip(self._free_speeds, arms, strict=True) if r > 1e-9), default=0.0)

    @property
    def max_accel(self) -> float:
        """From rest on level ground at stiff 12 V: grip, motors and stator limits of every wheel counted [m/s^2]."""
        solver = self._solver
        ones = [1.0] * self._n
        return launch_accel(solver.shafts, solver.wheels, self._static_loads, ones, self.config.mass)

    @property
    def max_angular_accel(self) -> float:
        """On the spot from rest, wheels across the radius [rad/s^2]; see `max_accel`."""
        solver = self._solver
        return launch_accel(solver.shafts, solver.wheels, self._static_loads, self._arms(), self.config.yaw_inertia)

    # ---------------------------------------------------------------- helpers

    def _arms(self) -> list[float]:
        return [math.hypot(x, y) for x, y in self.config.positions]

    def _present_angles(self) -> list[float]:
        """Where a module without a direction should stay: its target if it has one, else where it is."""
        controller = self._controller
        return list(controller.steer) if controller.mode is DriveMode.STATES else list(self.state.steer_angle)

    def _checked(self, what: str, values: Sequence[object]) -> list[float]:
        if len(values) != self._n:
            raise ConfigError(f"{what}: need one value for each of {self._n} modules, got {len(values)}")
        return [  # a module's name is made up for a message only: for all values it took 20 us of a tick
            v if type(v) is float and math.isfinite(v) else _number(f"{what} of {self.config.module_name(k)}", v)
            for k, v in enumerate(values)
        ]


def _number(what: str, value: object) -> float:
    if not isinstance(value, (int, float, np.floating, np.integer)) or not math.isfinite(value):
        raise NonFiniteError(f"{what} must be a finite number, got {value!r}")
    return float(value)
