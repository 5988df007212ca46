"""The swerve drive: commands in, tire forces out, with motors, battery and encoders between."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from simcore.errors import ConfigError
from simcore.geometry.rotation import Vector
from simcore.robot.battery import Battery
from simcore.robot.drive_shaft import DriveShaft, WheelContact, launch_accel
from simcore.robot.motor_bus import MotorReadout
from simcore.robot.swerve_config import SwerveConfig
from simcore.robot.swerve_module import DriveMode, ModuleController, ModuleState, SteerBank, module_targets
from simcore.robot.wheeled_drive import WheeledDrive, checked_number
from simcore.typing import FloatArray

__all__ = ["SwerveDrive"]


class SwerveDrive(WheeledDrive[SwerveConfig]):
    """One robot's swerve drive; see `WheeledDrive` for the step and what it shares with other drives.

    Example:
        >>> from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
        >>> drive = SwerveDrive(SwerveConfig.square(0.527, SwerveModuleConfig(x=0, y=0)))
        >>> drive.set_volts([6.0] * 4, [0.0] * 4)
        >>> dvx, dvy, domega = drive.step(0.005, (0.0, 0.0, 0.0))
        >>> dvx > 0.0
        True
    """

    def __init__(
        self, config: SwerveConfig, *, battery: Battery | None = None, built: SwerveConfig | None = None
    ) -> None:
        """Wheels at rest, pointing forward.

        Args:
            config: The robot, as robot code and the loops on board know it.
            battery: Its battery; None is a stiff 12 V supply. The drive steps it.
            built: What motors, wheels and encoders really are; None: what the config says.
        """
        modules = config.modules if built is None else built.modules
        super().__init__(
            config,
            battery=battery,
            wheels=[WheelContact.of(m, place) for m, place in zip(modules, config.positions, strict=True)],
            radii=[m.wheel_radius for m in config.modules],
            shafts=[
                DriveShaft.of(m, inertia=m.drive_inertia, motor=m.limited_drive_motor, wheels=(k,))
                for k, m in enumerate(modules)
            ],
        )
        self._n = len(modules)
        self._steer = SteerBank(modules)
        self._zeros = [0.0] * self._n
        # Azimuth coupling: [V s/rad] of back-EMF, and [kg m^2] of rotor that the azimuth turns as well.
        self._coupled_emf = [m.coupling_ratio / m.drive_motor.kv for m in modules]
        self._coupled_inertia = [m.drive_motor.rotor_inertia * m.drive_gearing * m.coupling_ratio for m in modules]
        self._coupled = any(m.coupling_ratio != 0.0 for m in modules)
        self._modules = modules
        self._controller = ModuleController(config.modules, self._static_loads)
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
            checked_number(f"chassis speed {name}", value)
        positions = [(m.x, m.y) for m in self.config.modules]
        speeds, angles = module_targets(positions, vx, vy, omega, self.max_speed, self._present_angles())
        self._command(DriveMode.STATES, speeds, angles)

    def stop(self) -> None:
        """Zero command: every motor to its neutral mode, brake or coast."""
        self._command(DriveMode.NEUTRAL, self._zeros, self._zeros)

    def _command(self, mode: DriveMode, drive: list[float], steer: list[float]) -> None:
        self._new_command(is_other=self._controller.command(mode, drive, steer))

    def reset(
        self, *, angles: Sequence[float] | None = None, vx: float = 0.0, vy: float = 0.0, omega: float = 0.0
    ) -> None:
        """Everything as new: encoders at zero, battery rested, time at zero, wheels rolling with the chassis.

        Args:
            angles: Azimuths [rad]; None: along each wheel's way over ground, and forward where it stands.
            vx: Velocity of the center of mass with which the wheels roll, forward [m/s]. The chassis has its own.
            vy: To the left [m/s].
            omega: Yaw rate [rad/s].

        Raises:
            NonFiniteError: When a number is not finite; nothing has changed.
            ConfigError: When there is not one angle per module.
        """
        for name, value in (("vx", vx), ("vy", vy), ("omega", omega)):
            checked_number(f"reset {name}", value)
        ways = [(vx - omega * y, vy + omega * x) for x, y in self.robot.positions]
        if angles is None:
            turned = [math.atan2(wy, wx) if math.hypot(wx, wy) > 1e-6 else 0.0 for wx, wy in ways]
        else:
            turned = self._checked("steer angle", angles)
        stands = [a + m.steer_offset for a, m in zip(turned, self._modules, strict=True)]
        cos, sin = [math.cos(a) for a in stands], [math.sin(a) for a in stands]
        self._rest(
            [  # 0.0 first: no wheel starts at minus zero
                (0.0 + c * wx + s * wy) / m.wheel_radius
                for (wx, wy), c, s, m in zip(ways, cos, sin, self._modules, strict=True)
            ]
        )
        self.state = ModuleState(self.shaft_angles, self.shaft_speeds, turned, [0.0] * self._n, cos, sin, cos, sin)
        self.steer_motors = MotorReadout([m.winding for m in self._steer.motors])
        """Of the steer motors in the last inner step."""
        self._solver.cos = self._solver.mid_cos = cos
        self._solver.sin = self._solver.mid_sin = sin
        self._steer_supply = 0.0
        self._controller.reset()

    # ---------------------------------------------------------------- the step

    def _requests(self, h: float, bus: float, neutral: bool) -> tuple[Sequence[float | None], Sequence[float]]:
        drive, self._steer_volts, limits = self._controller.requests(h, self.state, bus, neutral)
        return drive, limits

    def _is_parked(self, velocity: Vector, pull: Vector) -> bool:
        is_turning = any(self.state.steer_speed) or any(self.steer_motors.current)
        return not is_turning and super()._is_parked(velocity, pull)

    def _open_circuits(self) -> tuple[Sequence[float | None], Sequence[float]]:
        self._steer_volts = [None] * self._n
        return super()._open_circuits()

    def _turn_azimuths(self, h: float, loads: Sequence[float], bus: float) -> float:
        state, solver = self.state, self._solver
        before = state.steer_speed[:] if self._coupled else None
        supply = self._steer.step(h, state, self._steer_volts, loads, solver.shaft_current, bus, self.steer_motors)
        self._steer_supply = 0.5 * (self._steer_supply + supply)
        solver.mid_cos, solver.mid_sin = state.mid_cos, state.mid_sin
        if before is not None:
            solver.emf_offset = [
                0.5 * k * (old + new) for k, old, new in zip(self._coupled_emf, before, state.steer_speed, strict=True)
            ]
            solver.torque_offset = [
                -j * (new - old) / h
                for j, new, old in zip(self._coupled_inertia, state.steer_speed, before, strict=True)
            ]
        return supply

    def _rest_azimuths(self) -> None:
        self._steer_supply *= 0.5

    def _back_emf(self) -> list[float]:
        emfs = super()._back_emf()
        if self._coupled:
            emfs = [e + k * w for e, k, w in zip(emfs, self._coupled_emf, self.state.steer_speed, strict=True)]
        return emfs

    def _background_current(self) -> float:
        # Azimuths spin up within a step, so what they drew in the last steps says more than their voltage.
        return self.other_current + self._steer_supply

    # ---------------------------------------------------------------- readings

    def wheel_angles(self) -> list[float]:
        """Azimuth of each module, counter-clockwise from forward, any number of turns [rad]."""
        return self.state.steer_angle[:]

    def motor_currents(self) -> dict[str, list[float]]:
        """Stator currents in the last inner step, module by module: `drive` and `steer` [A]."""
        return {"drive": self.drive_motors.current[:], "steer": self.steer_motors.current[:]}

    @property
    def gearing(self) -> dict[str, list[float]]:
        """Rotor turns per turn of the wheel, `drive`, and of the azimuth, `steer`, module by module [-]."""
        modules = self.config.modules
        return {"drive": [m.drive_gearing for m in modules], "steer": [m.steer_gearing for m in modules]}

    @property
    def supply_current(self) -> float:
        """From the battery in the last inner step, drivetrain only [A]."""
        return super().supply_current + self.steer_motors.supply_total

    @property
    def electrical_energy(self) -> float:
        """Taken by all motors since the reset: the integral of V I [J]."""
        return super().electrical_energy + self.steer_motors.energy

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
    def max_omega(self) -> float:
        """On the spot at 12 V [rad/s]; the first module to reach its top speed decides."""
        arms = self._arms()
        return min((v / r for v, r in zip(self._free_speeds, arms, strict=True) if r > 1e-9), default=0.0)

    @property
    def max_angular_accel(self) -> float:
        """On the spot from rest, wheels across the radius [rad/s^2]; see `max_accel`."""
        solver = self._solver
        return launch_accel(solver.shafts, solver.wheels, self._static_loads, self._arms(), self.robot.yaw_inertia)

    # ---------------------------------------------------------------- helpers

    def _arms(self) -> list[float]:
        return [math.hypot(x, y) for x, y in self.robot.positions]

    def _present_angles(self) -> list[float]:
        """Where a module without a direction should stay: its target if it has one, else where it is."""
        controller = self._controller
        return list(controller.steer) if controller.mode is DriveMode.STATES else list(self.state.steer_angle)

    def _checked(self, what: str, values: Sequence[object]) -> list[float]:
        if len(values) != self._n:
            raise ConfigError(f"{what}: need one value for each of {self._n} modules, got {len(values)}")
        return [  # a module's name is made up for a message only: for all values it took 20 us of a tick
            v if type(v) is float and math.isfinite(v) else checked_number(f"{what} of {self.config.module_name(k)}", v)
            for k, v in enumerate(values)
        ]
