"""Swerve drive: motor commands, tire forces, battery and encoders."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from simcore.loop.robot_state import AZIMUTH, CURRENT, DUTY, NEUTRAL, TARGET, VOLTS
from simcore.quantities import checked_number, require_count
from simcore.robot.battery import Battery
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.wheeled_drive import (
    DriveShaft,
    MotorReadout,
    WheeledDrive,
    launch_accel,
    set_motor,
)
from simcore.typing import FloatArray

__all__ = ["NO_STATES", "ModuleState", "SwerveDrive", "desaturate", "module_targets"]

NO_STATES: FloatArray = np.empty((0, 2))
"""States of no modules: nothing is commanded."""
NO_STATES.setflags(write=False)


@dataclass(slots=True)
class ModuleState:
    """Angles and speeds of n modules: views of the loop's arrays, shape (n,) each."""

    wheel_angle: FloatArray
    """Angle of the wheel about its axle, continuous over turns [rad]."""
    wheel_speed: FloatArray
    """Speed of the wheel about its axle [rad/s]."""
    steer_angle: FloatArray
    """Azimuth as its encoder shows it, counter-clockwise from forward, continuous over turns [rad]."""
    steer_speed: FloatArray
    """Rate of the azimuth [rad/s]."""
    cos: FloatArray
    """Cosine of the true azimuth."""
    sin: FloatArray
    """Sine of the true azimuth."""


def desaturate(speeds: list[float], limit: float) -> list[float]:
    """Scale all speeds by one factor so that none exceeds the limit: the direction of travel stays."""
    top = max(map(abs, speeds), default=0.0)
    if top <= limit:
        return speeds
    return [s * (limit / top) for s in speeds]


def module_targets(
    positions: Sequence[tuple[float, float]],
    vx: float,
    vy: float,
    omega: float,
    limit: float,
    present: Sequence[float],
) -> tuple[list[float], list[float]]:
    """Compute speed and direction of every module for a chassis velocity.

    Args:
        positions: Positions of the modules [m].
        vx: Velocity forward [m/s].
        vy: Velocity to the left [m/s].
        omega: Yaw rate, counter-clockwise positive [rad/s].
        limit: Top speed of a module; faster commands are scaled down together [m/s].
        present: Current angles, which modules with zero speed keep [rad].

    Returns:
        Speeds [m/s] and steer angles [rad].
    """
    speeds: list[float] = []
    angles: list[float] = []
    for (x, y), held in zip(positions, present, strict=True):
        wx = vx - omega * y
        wy = vy + omega * x
        speed = math.hypot(wx, wy)
        speeds.append(speed)
        angles.append(math.atan2(wy, wx) if speed > 1e-6 else held)
    return desaturate(speeds, limit), angles


class SwerveDrive(WheeledDrive[SwerveConfig]):
    """Swerve drive of one robot; see `WheeledDrive` for what it shares with other drives.

    Example:
        >>> from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
        >>> from simcore.testing.benches import hold
        >>> drive = SwerveDrive(SwerveConfig.square(0.527, SwerveModuleConfig(x=0, y=0)))
        >>> drive.set_volts([6.0] * 4, [0.0] * 4)
        >>> dvx, dvy, domega = hold(drive, 0.005, (0.0, 0.0, 0.0))
        >>> dvx > 0.0
        True
    """

    def __init__(
        self, config: SwerveConfig, *, battery: Battery | None = None, built: SwerveConfig | None = None
    ) -> None:
        """Start at rest with the wheels pointing forward.

        Args:
            config: Robot as robot code and the on-board loops know it.
            battery: Battery of the robot; None: a stiff 12 V supply. The drive steps it.
            built: Motors, wheels and encoders as actually built; None: as in the config.
        """
        modules = config.modules if built is None else built.modules
        super().__init__(
            config,
            battery=battery,
            wheels=modules,
            radii=[m.wheel_radius for m in config.modules],
            azimuths=len(modules),
            shafts=[
                DriveShaft.of(m, inertia=m.drive_inertia, motor=m.limited_drive_motor, wheels=(k,))
                for k, m in enumerate(modules)
            ],
        )
        self._n = len(modules)
        self._zeros = [0.0] * self._n
        self._modules = modules
        self._positions = [(m.x, m.y) for m in config.modules]
        for k, (built_module, known) in enumerate(zip(modules, config.modules, strict=True)):
            self._set_module(k, built_module, known)
        self.steer_motors = MotorReadout(self, slice(self._n, 2 * self._n))
        """Motors of the azimuths."""
        self.reset()

    def _set_module(self, k: int, module: SwerveModuleConfig, known: SwerveModuleConfig) -> None:
        """Write a module into the records: its true values, and those that the on-board loops know."""
        n, load = self._n, self.static_loads[k]
        wheel, azimuth = self.shafts[k : k + 1], self.shafts[n + k : n + k + 1]
        set_motor(azimuth, module.limited_steer_motor)
        wheel["request"]["brakes"], azimuth["request"]["brakes"] = known.drive_brake, known.steer_brake
        wheel, azimuth = wheel["model"], azimuth["model"]
        azimuth["kind"], azimuth["inertia"], azimuth["zero"] = AZIMUTH, module.azimuth_inertia, module.steer_offset
        azimuth["scrub"] = module.scrub_radius
        azimuth["coupling"] = module.coupling_ratio * module.drive_motor.kt
        azimuth["partner"], wheel["partner"] = k, n + k
        # Azimuth coupling: back-EMF [V s/rad], and inertia of the rotor that the azimuth turns as well [kg m^2].
        wheel["coupled_emf"] = module.coupling_ratio / module.drive_motor.kv
        wheel["coupled_inertia"] = module.drive_motor.rotor_inertia * module.drive_gearing * module.coupling_ratio
        drive, steer = known.limited_drive_motor, known.limited_steer_motor
        wheel["known_radius"], wheel["feedforward"] = known.wheel_radius, drive.emf / known.wheel_radius
        wheel["loop_coupled"], wheel["kp"] = known.coupling_ratio / known.drive_motor.kv, known.drive_kp
        # Feed-forward against friction, rolling drag and scrub, as in a team's kS [V].
        drag = drive.friction + known.rolling_resistance * load * known.wheel_radius
        wheel["ks"], wheel["ks_slope"] = drag / drive.torque_driving * drive.winding, 20.0
        scrub = steer.friction + known.wheel_cof * known.scrub_radius * load
        azimuth["ks"], azimuth["ks_slope"] = scrub / steer.torque_driving * steer.winding, 100.0
        azimuth["kp"] = known.steer_kp

    # ---------------------------------------------------------------- commands

    def set_volts(self, drive: Sequence[float], steer: Sequence[float]) -> None:
        """Command a voltage for every motor, kept until the next command [V].

        Raises:
            NonFiniteError: A voltage is missing, NaN or infinite; the message names the module, and nothing has
                changed.
            ConfigError: There is not one voltage per module.
        """
        drive_ = self._checked("drive volts", drive)
        steer_ = self._checked("steer volts", steer)
        self._ask(VOLTS, drive_, steer_)

    def set_duty_cycles(self, drive: Sequence[float], steer: Sequence[float]) -> None:
        """Command a fraction of the battery voltage for every motor, -1 to 1; raises as `set_volts`."""
        drive_ = [min(1.0, max(-1.0, d)) for d in self._checked("drive duty cycle", drive)]
        steer_ = [min(1.0, max(-1.0, d)) for d in self._checked("steer duty cycle", steer)]
        self._ask(DUTY, drive_, steer_)

    def set_torque_currents(self, drive: Sequence[float], steer: Sequence[float]) -> None:
        """Command stator current of the drive motors [A] and voltage of the steer motors [V]; raises as `set_volts`."""
        drive_ = self._checked("drive current", drive)
        steer_ = self._checked("steer volts", steer)
        self._ask(CURRENT, drive_, steer_, steer_mode=VOLTS)

    def set_module_states(self, speeds: Sequence[float], angles: Sequence[float]) -> None:
        """Command the on-board loops: ground speed [m/s] and steer angle [rad] per module; raises as `set_volts`."""
        speeds_ = self._checked("module speed", speeds)
        angles_ = self._checked("module angle", angles)
        self._ask(TARGET, speeds_, angles_)

    def set_chassis_speeds(self, vx: float, vy: float, omega: float) -> None:
        """Command the on-board loops: robot-frame velocity [m/s, m/s, rad/s]; scaled down if too fast.

        Raises:
            NonFiniteError: A speed is NaN or infinite; nothing has changed.
        """
        for name, value in (("vx", vx), ("vy", vy), ("omega", omega)):
            checked_number(f"chassis speed {name}", value)
        speeds, angles = module_targets(self._positions, vx, vy, omega, self.max_speed, self._present_angles())
        self._ask(TARGET, speeds, angles)

    def stop(self) -> None:
        """Command neutral: every motor brakes or coasts, as configured."""
        self._ask(NEUTRAL, self._zeros, self._zeros)

    def _ask(self, mode: int, drive: list[float], steer: list[float], *, steer_mode: int | None = None) -> None:
        self._command(mode, [*drive, *steer])
        if steer_mode is not None:
            self.shafts["request"]["mode"][self._n :] = steer_mode

    def reset(
        self, *, angles: Sequence[float] | None = None, vx: float = 0.0, vy: float = 0.0, omega: float = 0.0
    ) -> None:
        """Reset everything: encoders and time to zero, battery rested, wheels rolling with the chassis.

        Args:
            angles: Azimuths [rad]; None: each wheel's direction of travel, or forward at rest.
            vx: Forward velocity of the center of mass with which the wheels roll [m/s]. The chassis velocity is
                separate.
            vy: Velocity to the left [m/s].
            omega: Yaw rate [rad/s].

        Raises:
            NonFiniteError: A number is not finite; nothing has changed.
            ConfigError: There is not one angle per module.
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
        self.shafts["cos"][: self._n], self.shafts["sin"][: self._n] = cos, sin
        self.shafts["position"][self._n :] = turned

    @property
    def state(self) -> ModuleState:
        """Current angles and speeds of the modules."""
        n, angles, speeds = self._n, self.shafts["position"], self.shafts["speed"]
        cos, sin = self.shafts["cos"], self.shafts["sin"]
        return ModuleState(angles[:n], speeds[:n], angles[n:], speeds[n:], cos[:n], sin[:n])

    # ---------------------------------------------------------------- readings

    def wheel_angles(self) -> list[float]:
        """Return the azimuth of each module, counter-clockwise from forward, continuous over turns [rad]."""
        angles: list[float] = self.shafts["position"][self._n :].tolist()
        return angles

    def motor_currents(self) -> dict[str, list[float]]:
        """Return stator currents in the last inner step, module by module: `drive` and `steer` [A]."""
        return {"drive": self.drive_motors.current, "steer": self.steer_motors.current}

    @property
    def gearing(self) -> dict[str, list[float]]:
        """Rotor turns per turn of the wheel (`drive`) and of the azimuth (`steer`), module by module [-]."""
        modules = self.config.modules
        return {"drive": [m.drive_gearing for m in modules], "steer": [m.steer_gearing for m in modules]}

    @property
    def steer_angles(self) -> FloatArray:
        """Azimuths, continuous over turns [rad], shape (n,)."""
        return np.array(self.state.steer_angle)

    @property
    def drive_rotor_angles(self) -> FloatArray:
        """Readings of the drive motors' own encoders: gearing and azimuth coupling included [rad], shape (n,)."""
        s = self.state
        return np.array(
            [
                m.drive_gearing * a + m.coupling_ratio * t
                for m, a, t in zip(self.config.modules, s.wheel_angle, s.steer_angle, strict=True)
            ]
        )

    # ---------------------------------------------------------------- limits

    @property
    def max_omega(self) -> float:
        """Yaw rate on the spot at 12 V [rad/s]; the first module at its top speed limits it."""
        arms = self._arms()
        return min((v / r for v, r in zip(self._free_speeds, arms, strict=True) if r > 1e-9), default=0.0)

    @property
    def max_angular_accel(self) -> float:
        """Yaw acceleration on the spot from rest, wheels across the radius [rad/s^2]; see `max_accel`."""
        return launch_accel(self._shafts, self._wheel_configs, self.static_loads, self._arms(), self.robot.yaw_inertia)

    # ---------------------------------------------------------------- helpers

    def _arms(self) -> list[float]:
        return [math.hypot(x, y) for x, y in self.robot.positions]

    def _present_angles(self) -> list[float]:
        """Return the angles that modules without a direction keep: their targets if any, else the current ones."""
        request = self.shafts["request"][self._n :]
        targets: list[float] = request["value"].tolist()
        return targets if request["mode"][0] == TARGET else self.wheel_angles()

    def _checked(self, what: str, values: Sequence[object]) -> list[float]:
        require_count(what, values, self._n, "modules")
        return [  # builds a module's name only for a message: names of all values took 20 us per tick
            v if type(v) is float and abs(v) < 1e6 else checked_number(f"{what} of {self.config.module_name(k)}", v)
            for k, v in enumerate(values)
        ]
