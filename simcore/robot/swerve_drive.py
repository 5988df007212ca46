"""Swerve drive: motor commands, module states and encoder readings."""

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
"""Empty array of module states, for a drive without setpoints, shape (0, 2)."""
NO_STATES.setflags(write=False)


@dataclass(slots=True)
class ModuleState:
    """Angles and speeds of n modules; each field is a view of the loop's arrays, shape (n,)."""

    wheel_angle: FloatArray
    """Angle of the wheel about the axle, continuous over turns [rad]."""
    wheel_speed: FloatArray
    """Angular velocity of the wheel about the axle [rad/s]."""
    steer_angle: FloatArray
    """Steer angle from the encoder, counter-clockwise from forward, continuous over turns [rad]."""
    steer_speed: FloatArray
    """Angular velocity of the module about the steer axis, counter-clockwise positive [rad/s]."""
    cos: FloatArray
    """Cosine of the true steer angle."""
    sin: FloatArray
    """Sine of the true steer angle."""


def desaturate(speeds: list[float], limit: float) -> list[float]:
    """Return the speeds [m/s], scaled by a common factor if necessary so that no magnitude exceeds `limit` [m/s].

    The scaling does not change the direction of travel.
    """
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
    """Compute the wheel speed and steer angle of every module for robot-relative chassis speeds.

    Args:
        positions: Positions of the modules, robot frame [m].
        vx: Forward velocity [m/s].
        vy: Leftward velocity [m/s].
        omega: Yaw rate, counter-clockwise positive [rad/s].
        limit: Top speed of a module [m/s]; the function scales all speeds down if a module would exceed the limit.
        present: Current steer angles, which the function returns for modules at zero speed [rad].

    Returns:
        Wheel speeds, not negative [m/s], and steer angles [rad].
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
    """Swerve drive of a robot; see `WheeledDrive` for the properties and methods common to all drives.

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
        """Create the drive at rest, in neutral, with the wheels pointing forward.

        Args:
            config: Nominal drivetrain, as assumed by robot code and the on-board loops.
            battery: Battery of the robot; None for a stiff 12 V supply.
            built: Motors, wheels and encoders as actually built; None for the values in the config.
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
        """Readings of the steer motors in the last step."""
        self.reset()

    def _set_module(self, k: int, module: SwerveModuleConfig, known: SwerveModuleConfig) -> None:
        """Write the parameters of a module to the records.

        Args:
            k: Index of the module.
            module: True parameters, for the motion of the module.
            known: Nominal parameters, for the on-board loops.
        """
        n, load = self._n, self.static_loads[k]
        wheel, azimuth = self.shafts[k : k + 1], self.shafts[n + k : n + k + 1]
        set_motor(azimuth, module.limited_steer_motor)
        wheel["request"]["brakes"], azimuth["request"]["brakes"] = known.drive_brake, known.steer_brake
        wheel, azimuth = wheel["model"], azimuth["model"]
        azimuth["kind"], azimuth["inertia"], azimuth["zero"] = AZIMUTH, module.azimuth_inertia, module.steer_offset
        azimuth["scrub"] = module.scrub_radius
        azimuth["coupling"] = module.coupling_ratio * module.drive_motor.kt
        azimuth["partner"], wheel["partner"] = k, n + k
        # Coupling by steering: back-EMF of the drive motor [V s/rad], and inertia of the drive rotor [kg m^2].
        wheel["coupled_emf"] = module.coupling_ratio / module.drive_motor.kv
        wheel["coupled_inertia"] = module.drive_motor.rotor_inertia * module.drive_gearing * module.coupling_ratio
        drive, steer = known.limited_drive_motor, known.limited_steer_motor
        wheel["known_radius"], wheel["feedforward"] = known.wheel_radius, drive.emf / known.wheel_radius
        wheel["loop_coupled"], wheel["kp"] = known.coupling_ratio / known.drive_motor.kv, known.drive_kp
        # Feed-forward against friction, rolling drag and scrub, like a team's kS [V].
        drag = drive.friction + known.rolling_resistance * load * known.wheel_radius
        wheel["ks"], wheel["ks_slope"] = drag / drive.torque_driving * drive.winding, 20.0
        scrub = steer.friction + known.wheel_cof * known.scrub_radius * load
        azimuth["ks"], azimuth["ks_slope"] = scrub / steer.torque_driving * steer.winding, 100.0
        azimuth["kp"] = known.steer_kp

    # ---------------------------------------------------------------- commands

    def set_volts(self, drive: Sequence[float], steer: Sequence[float]) -> None:
        """Command the voltage of every motor until the next command [V].

        Raises:
            NonFiniteError: If a voltage is not a finite number; the message names the module, and the old command stays
                in effect.
            ConfigError: If the number of voltages is not the number of modules.
        """
        drive_ = self._checked("drive volts", drive)
        steer_ = self._checked("steer volts", steer)
        self._ask(VOLTS, drive_, steer_)

    def set_duty_cycles(self, drive: Sequence[float], steer: Sequence[float]) -> None:
        """Command the duty cycle of every motor, clamped to -1..1, until the next command.

        Raises the same errors as `set_volts`.
        """
        drive_ = [min(1.0, max(-1.0, d)) for d in self._checked("drive duty cycle", drive)]
        steer_ = [min(1.0, max(-1.0, d)) for d in self._checked("steer duty cycle", steer)]
        self._ask(DUTY, drive_, steer_)

    def set_torque_currents(self, drive: Sequence[float], steer: Sequence[float]) -> None:
        """Command the stator current of each drive motor [A] and the voltage of each steer motor [V].

        Raises the same errors as `set_volts`.
        """
        drive_ = self._checked("drive current", drive)
        steer_ = self._checked("steer volts", steer)
        self._ask(CURRENT, drive_, steer_, steer_mode=VOLTS)

    def set_module_states(self, speeds: Sequence[float], angles: Sequence[float]) -> None:
        """Set the target tread speed [m/s] and steer angle [rad] of each module's on-board loops.

        The loops optimize each state: a wheel turns backward if the steer error would otherwise exceed a quarter turn.
        Raises the same errors as `set_volts`.
        """
        speeds_ = self._checked("module speed", speeds)
        angles_ = self._checked("module angle", angles)
        self._ask(TARGET, speeds_, angles_)

    def set_chassis_speeds(self, vx: float, vy: float, omega: float) -> None:
        """Set the targets of the on-board loops for robot-relative chassis speeds [m/s, m/s, rad/s].

        The method scales all wheel speeds down if a module would exceed `max_speed`.

        Raises:
            NonFiniteError: If a speed is NaN or infinite; the old command is kept.
        """
        for name, value in (("vx", vx), ("vy", vy), ("omega", omega)):
            checked_number(f"chassis speed {name}", value)
        speeds, angles = module_targets(self._positions, vx, vy, omega, self.max_speed, self._present_angles())
        self._ask(TARGET, speeds, angles)

    def stop(self) -> None:
        """Command neutral output; motors brake or coast, as configured."""
        self._ask(NEUTRAL, self._zeros, self._zeros)

    def _ask(self, mode: int, drive: list[float], steer: list[float], *, steer_mode: int | None = None) -> None:
        self._command(mode, [*drive, *steer])
        if steer_mode is not None:
            self.shafts["request"]["mode"][self._n :] = steer_mode

    def reset(
        self, *, angles: Sequence[float] | None = None, vx: float = 0.0, vy: float = 0.0, omega: float = 0.0
    ) -> None:
        """Zero drive encoders and time, reset the battery, command neutral, and set the wheels for a chassis velocity.

        Each wheel speed is the component of the velocity along the steer direction. The velocity of the chassis itself
        does not change.

        Args:
            angles: New steer angles [rad]; None for the direction of travel of each wheel, or forward for a wheel at
                rest.
            vx: Forward velocity of the center of mass [m/s].
            vy: Leftward velocity of the center of mass [m/s].
            omega: Yaw rate [rad/s].

        Raises:
            NonFiniteError: If an argument is not finite; the drive is left unchanged.
            ConfigError: If the number of angles is not the number of modules.
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
            [  # adding 0.0 avoids minus zero
                (0.0 + c * wx + s * wy) / m.wheel_radius
                for (wx, wy), c, s, m in zip(ways, cos, sin, self._modules, strict=True)
            ]
        )
        self.shafts["cos"][: self._n], self.shafts["sin"][: self._n] = cos, sin
        self.shafts["position"][self._n :] = turned

    @property
    def state(self) -> ModuleState:
        """Views of the current angles and speeds of the modules in the arrays of the loop."""
        n, angles, speeds = self._n, self.shafts["position"], self.shafts["speed"]
        cos, sin = self.shafts["cos"], self.shafts["sin"]
        return ModuleState(angles[:n], speeds[:n], angles[n:], speeds[n:], cos[:n], sin[:n])

    # ---------------------------------------------------------------- readings

    def wheel_angles(self) -> list[float]:
        """Return the steer angle of each module, counter-clockwise from forward, continuous over turns [rad]."""
        angles: list[float] = self.shafts["position"][self._n :].tolist()
        return angles

    def motor_currents(self) -> dict[str, list[float]]:
        """Return the stator currents of the `drive` and `steer` motors in the last step, in module order [A]."""
        return {"drive": self.drive_motors.current, "steer": self.steer_motors.current}

    @property
    def gearing(self) -> dict[str, list[float]]:
        """Gear ratios in module order [-]: rotor turns per wheel turn (`drive`) and per module turn (`steer`)."""
        modules = self.config.modules
        return {"drive": [m.drive_gearing for m in modules], "steer": [m.steer_gearing for m in modules]}

    @property
    def steer_angles(self) -> FloatArray:
        """Copy of the steer angles from the encoders, continuous over turns [rad], shape (n,)."""
        return np.array(self.state.steer_angle)

    @property
    def drive_rotor_angles(self) -> FloatArray:
        """Rotor angles of the drive motors, including gearing and coupling by steering [rad], shape (n,)."""
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
        """Largest yaw rate without translation at 12 V [rad/s], limited by the top speed of the modules."""
        arms = self._arms()
        return min((v / r for v, r in zip(self._free_speeds, arms, strict=True) if r > 1e-9), default=0.0)

    @property
    def max_angular_accel(self) -> float:
        """Yaw acceleration from rest at a stiff 12 V within traction, motor and stator limits [rad/s^2].

        Each wheel points perpendicular to the line from the center of mass to the wheel.
        """
        return launch_accel(self._shafts, self._wheel_configs, self.static_loads, self._arms(), self.robot.yaw_inertia)

    # ---------------------------------------------------------------- helpers

    def _arms(self) -> list[float]:
        return [math.hypot(x, y) for x, y in self.robot.positions]

    def _present_angles(self) -> list[float]:
        """Return the steer angles that modules at zero speed keep [rad]: the current targets.

        Without targets, return the current steer angles.
        """
        request = self.shafts["request"][self._n :]
        targets: list[float] = request["value"].tolist()
        return targets if request["mode"][0] == TARGET else self.wheel_angles()

    def _checked(self, what: str, values: Sequence[object]) -> list[float]:
        require_count(what, values, self._n, "modules")
        return [  # module names are built only for messages: names for all values took 20 us per tick
            v if type(v) is float and abs(v) < 1e6 else checked_number(f"{what} of {self.config.module_name(k)}", v)
            for k, v in enumerate(values)
        ]
