"""A drivetrain alone on flat ground: no engine, no walls. For figures, tests and quick studies."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from simcore.quantities import ANGLE, DURATION, require
from simcore.robot.wheeled_drive import WheeledDrive
from simcore.units import GRAVITY

__all__ = ["PlanarChassis"]


class PlanarChassis:
    """Pose and velocity of a robot on a plane, level or sloped up along the field's x axis.

    Example:
        >>> from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
        >>> from simcore.robot.swerve_drive import SwerveDrive
        >>> drive = SwerveDrive(SwerveConfig.square(0.527, SwerveModuleConfig(x=0, y=0)))
        >>> robot = PlanarChassis(drive)
        >>> drive.set_volts([12.0] * 4, [0.0] * 4)
        >>> robot.run(3.0)
        >>> 4.6 < robot.vx < 4.76
        True
    """

    def __init__(self, drive: WheeledDrive[Any], *, slope: float = 0.0) -> None:
        """Stand at the origin, facing along x.

        Args:
            drive: Any drivetrain.
            slope: Of the ground, up along x [rad].
        """
        require("planar chassis", "slope", slope, ANGLE)
        self.drive = drive
        self.slope = slope
        self.reset()

    def reset(
        self, x: float = 0.0, y: float = 0.0, yaw: float = 0.0, *, vx: float = 0.0, vy: float = 0.0, omega: float = 0.0
    ) -> None:
        """Put the robot somewhere, with a velocity in field axes."""
        self.x, self.y, self.yaw = x, y, yaw
        """Pose of the center of mass, along the ground [m, m, rad]."""
        self.vx, self.vy, self.omega = vx, vy, omega
        """Velocity, field axes along the ground [m/s, m/s, rad/s]."""
        self.ax, self.ay = 0.0, 0.0
        """Acceleration in the last step, field axes [m/s^2]."""
        self.time = 0.0
        self.loads: list[float] = []
        """Normal loads in the last step [N]."""
        for name in ("followed", "tires"):
            self.drive.robot_record[name] = 0.0

    def step(self, h: float, *, force: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> None:
        """Advance by `h` [s] with an outside force (x, y [N], torque [N m], field axes) on the center of mass."""
        config, record = self.drive.robot, self.drive.robot_record
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        g_along = -GRAVITY * math.sin(self.slope)
        ex = g_along + force[0] / config.mass
        ey = force[1] / config.mass
        spin_up = force[2] / config.yaw_inertia
        record["gravity"] = (c * g_along, -s * g_along, -GRAVITY * math.cos(self.slope))
        record["felt"] = (c * g_along, -s * g_along, 0.0)  # an outside force acts at the center: it shifts no load
        record["pull"] = (ex, ey, spin_up)
        record["yaw"], record["vx"], record["vy"], record["omega"] = self.yaw, self.vx, self.vy, self.omega
        self.drive.advance_alone(h)
        dx, dy, dw = self.drive.change
        self.loads = self.drive.normal_loads
        self.ax, self.ay = dx / h + ex, dy / h + ey
        spin = dw + spin_up * h
        mx, my, mw = self.drive.mean_change
        share = 1.0 - float(record["early"][0])  # of what outside forces change, in the mean of the loop's steps
        self.x += (self.vx + mx + share * ex * h) * h
        self.y += (self.vy + my + share * ey * h) * h
        self.yaw += (self.omega + mw + share * spin_up * h) * h
        self.vx += self.ax * h
        self.vy += self.ay * h
        self.omega += spin
        self.time += h

    def run(self, seconds: float, *, h: float = 0.005, each: Callable[[], None] | None = None) -> None:
        """Advance by a time in steps of `h` [s], calling `each` after every one."""
        require("planar chassis", "h", h, DURATION)
        for _ in range(round(seconds / h)):
            self.step(h)
            if each is not None:
                each()

    @property
    def speed(self) -> float:
        """Over ground [m/s]."""
        return math.hypot(self.vx, self.vy)

    @property
    def kinetic_energy(self) -> float:
        """Of the chassis, without its wheels [J]."""
        c = self.drive.robot
        return 0.5 * c.mass * (self.vx**2 + self.vy**2) + 0.5 * c.yaw_inertia * self.omega**2
