"""A robot that plays a script: it drives by wheel states, aims by solving the shot, and commands volts like robot code.

Scripts are generators that yield once a tick. They think as a blue robot; for a red one, places are turned by 180
degrees on the way in and out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterable
from itertools import pairwise

import numpy as np

from games.rebuilt.field import FIELD_SIZE, HUB_TARGET
from games.rebuilt.fuel import FUEL
from games.rebuilt.robot import RebuiltRobot
from games.rebuilt.sim import DT
from simcore.geometry.symmetry import turn_half, turn_half_pose, wrap_angle
from simcore.match.scoring import Alliance
from simcore.pieces.shot_solver import NoShotError, Shot, solve_shot
from simcore.robot.mechanism_control import PositionController, VelocityController
from simcore.typing import FloatArray
from simcore.units import degrees, plain_sum

__all__ = ["Script", "ScriptedRobot", "Steps"]

Steps = Generator[None, None, None]
"""Yields once a tick."""
Script = Callable[["ScriptedRobot"], Steps]
"""What to do, from the first tick to the last."""


_ACCELERATION = 6.0  # [m/s^2]; half of what the tires can give, so the wheels do not skid
_HOOD_FOR_SHOTS = degrees(42.0)  # 68 degrees above the horizontal: steep enough to fall into the funnel


class ScriptedRobot:
    """Robot code that follows a script.

    Args:
        script: What to do.
        alliance: Whose robot it is.
        held: How much fuel a robot holds, asked with its number.
        fuel_places: Where fuel is, field frame [m], shape (n, 3): what a camera would tell.
    """

    def __init__(
        self,
        script: Script,
        *,
        alliance: Alliance,
        held: Callable[[int], int],
        fuel_places: Callable[[], FloatArray],
    ) -> None:
        self._script = script
        self._alliance = alliance
        self._held = held
        self._fuel_places = fuel_places
        self._steps: Steps | None = None
        self._robot: RebuiltRobot | None = None
        self._velocity = (0.0, 0.0, 0.0)  # commanded, blue field frame
        self._wheel_goal = 0.0
        self._hood_goal = _HOOD_FOR_SHOTS
        self._feed = False
        self._intake = False
        self._hood_loop = PositionController(kp=25.0)
        self._deploy_loop = PositionController(kp=3.0, kd=0.05)
        self._wheel_loop: VelocityController | None = None

    def __call__(self, robot: RebuiltRobot, time: float) -> None:
        """One tick of robot code."""
        self._robot = robot
        if self._steps is None:
            self._wheel_loop = VelocityController.for_gearbox(robot.config.shooter.gearbox, kp=0.08)
            self._steps = self._script(self)
        self.is_done = next(self._steps, _END) is _END
        if self.is_done:
            self.stop()
        self._drive()
        self._command_mechanisms()

    is_done = False
    """Whether the script has ended."""

    # --- what a script sees -------------------------------------------------------------------------------------

    @property
    def robot(self) -> RebuiltRobot:
        """The robot that the script plays."""
        assert self._robot is not None, "a script runs inside a tick"
        return self._robot

    @property
    def pose(self) -> tuple[float, float, float]:
        """Where the robot is, as a blue one [m, m, rad]."""
        pose = self.robot.chassis.pose
        return pose if self._alliance == "blue" else turn_half_pose(*pose, FIELD_SIZE)

    @property
    def fuel(self) -> int:
        """How much fuel the robot holds."""
        return self._held(self.robot.number)

    # --- what a script does -------------------------------------------------------------------------------------

    def stop(self) -> None:
        """Stand still."""
        self._velocity = (0.0, 0.0, 0.0)

    def intake(self, on: bool) -> None:
        """Put the intake out and turn its roller, or pull it in."""
        self._intake = on

    def wait(self, seconds: float) -> Steps:
        """Go on doing the same."""
        for _ in range(round(seconds / DT)):
            yield

    def drive_to(
        self, x: float, y: float, yaw: float, *, speed: float = 3.0, tolerance: float = 0.06, timeout: float = 6.0
    ) -> Steps:
        """Drive straight to a pose and stop there [m, m, rad]; gives up after `timeout` [s]."""
        yield from self.drive_through([(x, y)], yaw, speed=speed, tolerance=tolerance, timeout=timeout)

    def drive_through(
        self,
        points: Iterable[tuple[float, float]],
        yaw: float,
        *,
        speed: float = 3.0,
        tolerance: float = 0.06,
        corner: float = 0.35,
        timeout: float = 10.0,
    ) -> Steps:
        """Drive along straight lines through points and stop at the last one.

        Args:
            points: Corners of the path [m].
            yaw: Heading to hold [rad].
            speed: Cruising speed [m/s].
            tolerance: How near to the last point counts as there [m].
            corner: From how near a corner the next one is aimed at [m].
            timeout: Gives up after this long [s].
        """
        way = list(points)
        for _ in range(round(timeout / DT)):
            x, y, heading = self.pose
            while len(way) > 1 and math.hypot(way[0][0] - x, way[0][1] - y) < corner:
                way.pop(0)
            dx, dy = way[0][0] - x, way[0][1] - y
            ahead = math.hypot(dx, dy)
            left = ahead + plain_sum(math.dist(a, b) for a, b in pairwise(way))
            turn = wrap_angle(yaw - heading)
            if len(way) == 1 and ahead < tolerance and abs(turn) < degrees(3.0):
                break
            want = min(speed, math.sqrt(2.0 * 0.5 * _ACCELERATION * max(0.0, left - 0.5 * tolerance)))
            self._accelerate_to(want * dx / max(ahead, 1e-9), want * dy / max(ahead, 1e-9), turn)
            yield
        self.stop()
        yield

    def collect_in(self, low: tuple[float, float], high: tuple[float, float], *, aside: float, timeout: float) -> Steps:
        """Take in the fuel of a region, the nearest first, backing up to it with the heading at zero.

        Args:
            low: Smallest corner of the region, blue field frame [m].
            high: Largest corner [m].
            aside: How far the robot may leave the region's middle line along y [m].
            timeout: Gives up after this long [s].
        """
        back = 0.62  # from the robot's center to the middle of the intake zone, rack out [m]
        middle = 0.5 * (low[1] + high[1])
        reach = aside + self.robot.config.intake.y_max - 0.02
        low, high = (low[0], max(low[1], middle - reach)), (high[0], min(high[1], middle + reach))
        patience = round(timeout / DT)
        while patience:
            patience -= 1
            places = self._fuel_places()
            if self._alliance == "red":
                places = turn_half(places, FIELD_SIZE)
            near = places[((places[:, :2] > low) & (places[:, :2] < high)).all(axis=1) & (places[:, 2] < 0.3)]
            if not len(near):
                break
            here_x, here_y, heading = self.pose
            away = np.hypot(near[:, 0] + back - here_x, near[:, 1] - here_y)
            goal_x, goal_y, _ = near[int(np.argmin(away))]
            goal_y = min(max(goal_y, middle - aside), middle + aside)
            dx, dy = goal_x + back - here_x, goal_y - here_y
            ahead = math.hypot(dx, dy)
            pace = min(1.2, math.sqrt(2.0 * 0.5 * _ACCELERATION * ahead)) / max(ahead, 1e-9)
            self._accelerate_to(pace * dx, pace * dy, wrap_angle(-heading))
            yield
        self.stop()
        yield

    def shoot_until_empty(self, *, timeout: float = 5.0) -> Steps:
        """Aim at the own hub and shoot all fuel."""
        patience = round(timeout / DT)
        while self.fuel and patience:
            patience -= 1
            try:
                shot = self._solve()
            except NoShotError:
                self._feed = False
                yield
                continue
            self._wheel_goal = self.robot.wheel_speed_for(shot.speed)
            turn = wrap_angle(shot.yaw - self.pose[2])
            self._accelerate_to(0.0, 0.0, turn)
            self._feed = self._is_ready(turn)
            yield
        self._feed = False
        yield

    def spin_up(self) -> None:
        """Bring the shooter wheels to the speed for a shot from here, if there is one."""
        try:
            self._wheel_goal = self.robot.wheel_speed_for(self._solve().speed)
        except NoShotError:
            return

    # --- inside -------------------------------------------------------------------------------------------------

    def _solve(self) -> Shot:
        x, y, yaw = self.pose
        launch = self.robot.config.launch
        muzzle = (x + launch.forward * math.cos(yaw), y + launch.forward * math.sin(yaw), launch.height)
        return solve_shot(muzzle, HUB_TARGET, drag=FUEL.air.drag, elevation=degrees(110.0) - self._hood_goal)

    def _is_ready(self, turn: float) -> bool:
        speed = self.robot.shooter_wheels.velocity
        hood = abs(self.robot.hood.position - self._hood_goal) < degrees(1.5)
        slow = math.hypot(*self.robot.chassis.vel) < 0.15
        return abs(turn) < degrees(2.0) and hood and slow and abs(speed / self._wheel_goal - 1.0) < 0.025

    def _accelerate_to(self, vx: float, vy: float, turn: float) -> None:
        """Move the commanded velocity (blue field frame) toward a goal; turn toward a heading error [rad]."""
        ox, oy, _ = self._velocity
        dx, dy = vx - ox, vy - oy
        size, limit = math.hypot(dx, dy), _ACCELERATION * DT
        if size > limit:
            dx, dy = dx * limit / size, dy * limit / size
        self._velocity = (ox + dx, oy + dy, max(-6.0, min(6.0, 7.0 * turn)))

    def _drive(self) -> None:
        vx, vy, omega = self._velocity
        yaw = self.pose[2]
        c, s = math.cos(yaw), math.sin(yaw)
        self.robot.drive.set_chassis_speeds(c * vx + s * vy, c * vy - s * vx, omega)

    def _command_mechanisms(self) -> None:
        robot = self.robot
        assert self._wheel_loop is not None
        robot.shooter_wheels.set_volts(self._wheel_loop.volts(self._wheel_goal, robot.shooter_wheels.velocity))
        hood = robot.hood
        robot.hood.set_volts(
            self._hood_loop.volts(self._hood_goal, hood.position, hood.velocity, feedforward=hood.holding_volts)
        )
        robot.feeder.set_volts(9.0 if self._feed else 0.0)
        robot.spindexer.set_volts(6.0 if self._feed else 0.0)
        out = robot.config.deploy.travel / robot.config.deploy.pinion_radius if self._intake else 0.0
        robot.deploy.set_volts(self._deploy_loop.volts(out, robot.deploy.position, robot.deploy.velocity))
        robot.roller.set_volts(9.0 if self._intake else 0.0)


_END = object()
