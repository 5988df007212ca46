"""Robot controller that follows a script, with commands for driving, collecting and shooting.

A script is a generator that yields once per tick. The coordinates in a script are for a blue robot. For a red robot,
the controller flips poses and commands according to the field's symmetry.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Generator, Iterable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from simcore.errors import ConfigError
from simcore.match.game import PlayedMatch
from simcore.match.scoring import Alliance
from simcore.pieces.shot_solver import NoShotError, Shot, solve_shot
from simcore.quantities import ACCELERATION, ANGLE, ROBOT_PLACE, SIGNED_VOLTAGE, require_fields
from simcore.robot.gearbox import PositionController, VelocityController
from simcore.robot.mechanisms import ArmSim, ElevatorSim, FlywheelConfig
from simcore.robot.robot import Robot
from simcore.robot.robot_config import telemetry_name
from simcore.robot.swerve_drive import SwerveDrive
from simcore.typing import FloatArray
from simcore.units import TICK, degrees
from simcore.world.rotation import wrap_angle
from simcore.world.symmetry import Pose

__all__ = ["Script", "ScriptSettings", "ScriptedRobot", "Steps"]

_log = logging.getLogger(__name__)

Steps: TypeAlias = Generator[None, None, None]
"""Generator of a script, which yields once per tick."""
Script: TypeAlias = "Callable[[ScriptedRobot], Steps]"
"""Function of the scripted robot that returns the generator of a script."""

# Tolerances of a robot that is ready to shoot. Each shifts a shot of 2.5 m and 1.2 s by 40 to 60 mm at the target.
_WHEEL_TOLERANCE = 0.01  # of the wheel speed; the range of a shot varies with the square of the speed
_HEADING_TOLERANCE = degrees(1.0)
_MOST_SPEED = 0.05  # over ground [m/s]
_AT_TARGET = 0.1  # [m]; zones this close to a target are zones of the target
_LYING = 0.3  # [m]; pieces whose center is higher are in the air or on something


@dataclass(frozen=True, slots=True, kw_only=True)
class ScriptSettings:
    """Settings of a `ScriptedRobot`."""

    acceleration: float = 6.0
    """Limit of the horizontal acceleration [m/s^2]; the default is about half of the tires' limit."""
    shot_elevation: float = degrees(60.0)
    """Elevation of shots above the horizontal, for shooters with a hood [rad]."""
    feed_volts: Mapping[str, float] = field(default_factory=dict)
    """Voltage of each mechanism that feeds pieces to the shooter, while feeding [V], by mechanism name."""
    roller_volts: float = 9.0
    """Voltage of the intake's roller while the script commands the intake to deploy [V]."""
    intake_x: float = -0.6
    """Position of the intake along the robot's x axis [m]."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            acceleration=ACCELERATION,
            shot_elevation=ANGLE,
            roller_volts=SIGNED_VOLTAGE,
            feed_volts=SIGNED_VOLTAGE,
            intake_x=ROBOT_PLACE,
        )

    def controller(self, script: Script) -> Callable[[PlayedMatch, Alliance], ScriptedRobot]:
        """Return a function of match and alliance that returns a controller for a script, for `Auto.controller`."""
        return lambda match, alliance: ScriptedRobot(script, match, alliance, self)


class ScriptedRobot:
    """Controller that commands a robot with a swerve drive according to a script.

    Args:
        script: Script to follow.
        match: Match in which the robot plays.
        alliance: Alliance of the robot.
        settings: Settings for the robot; None for the defaults.
    """

    def __init__(
        self, script: Script, match: PlayedMatch, alliance: Alliance, settings: ScriptSettings | None = None
    ) -> None:
        self._script = script
        self._match = match
        self._alliance: Alliance = alliance
        self._symmetry = match.game.field.symmetry
        self.settings = settings or ScriptSettings()
        self._steps: Steps
        self._velocity = (0.0, 0.0, 0.0)  # commanded, blue field frame
        self._wheel_goal = 0.0
        self._feed = False
        self._intake = False
        self._from_below: dict[tuple[float, float, float], bool] = {}  # by target: whether a rising shot may reach it
        self._positions: dict[str, float] = {}
        self._volts: dict[str, float] = {}
        self._position_loop = PositionController(kp=25.0)
        self._deploy_loop = PositionController(kp=3.0, kd=0.05)
        self._wheel_loops: dict[str, VelocityController] = {}
        self._robot: Robot | None = None
        self.pose: Pose = (0.0, 0.0, 0.0)
        """Pose of the robot in this tick according to odometry without errors, blue field frame [m, m, rad]."""
        self.is_done = False
        """Whether the script's generator has ended."""
        self.aim_error = (0.0, 0.0)
        """Aiming error added to each solved shot: heading, counter-clockwise positive [rad], and relative speed [-]."""

    @property
    def match(self) -> PlayedMatch:
        """Match in which the robot plays."""
        return self._match

    @property
    def alliance(self) -> Alliance:
        """Alliance of the robot."""
        return self._alliance

    def __call__(self, robot: Robot, time: float) -> None:
        """Run one tick of the script and command the robot; start the script for a new robot, e.g. after a reset."""
        if self._robot is not robot:
            self.begin(robot)
        self.pose = self.as_blue(robot.reckoned_pose)
        self.is_done = next(self._steps, _END) is _END
        if self.is_done:
            self.stop()
        self._drive()
        self._command_mechanisms()

    def begin(self, robot: Robot) -> None:
        """Start the script for a robot, and clear all commands.

        Raises:
            ConfigError: If the robot does not have a swerve drive.
        """
        if not isinstance(robot.drive, SwerveDrive):
            kind = type(robot.drive).__name__
            raise ConfigError(f"robot {robot.number}: a scripted robot needs swerve, got {kind}")
        self._robot = robot
        self._velocity = (0.0, 0.0, 0.0)
        self._wheel_goal = 0.0
        self._feed = self._intake = False
        self._positions.clear()
        self._volts.clear()
        if robot.shooters:
            for name in robot.shooters[0].config.wheels:
                wheel = robot.config.mechanisms[name]
                assert isinstance(wheel, FlywheelConfig), "a shooter's wheels are flywheels"
                self._wheel_loops[name] = VelocityController.for_gearbox(wheel.gearbox, kp=0.08)
        self._steps = self._script(self)

    # --- state that a script reads ------------------------------------------------------------------------------

    @property
    def robot(self) -> Robot:
        """Robot that the script commands."""
        assert self._robot is not None, "a script runs inside a tick"
        return self._robot

    def as_blue(self, pose: Pose) -> Pose:
        """Convert a field-frame pose to the blue field frame: flip the pose if this robot is red [m, m, rad]."""
        return pose if self._alliance == "blue" else self._symmetry.flip_pose(*pose)

    @property
    def held(self) -> int:
        """Number of pieces that the robot holds."""
        return len(self.robot.held)

    def piece_positions(self, kind: str | None = None) -> FloatArray:
        """Return the positions of pieces on the field and in the air, blue field frame [m], shape (n, 3).

        Args:
            kind: Name of the kind of pieces; None for all kinds.
        """
        pieces = self._match.pieces
        positions = pieces.state.pos[pieces.on_field(kind)]
        return positions if self._alliance == "blue" else self._symmetry.flip_points(positions)

    # --- commands of a script -----------------------------------------------------------------------------------

    def stop(self) -> None:
        """Command zero chassis velocity at once, without the acceleration limit."""
        self._velocity = (0.0, 0.0, 0.0)

    def accelerate_to(self, vx: float, vy: float, turn: float = 0.0) -> None:
        """Change the commanded velocity toward a goal within the acceleration limit, and turn to correct the heading.

        Args:
            vx: Goal of the x velocity, blue field frame [m/s].
            vy: Goal of the y velocity, blue field frame [m/s].
            turn: Heading error to correct, counter-clockwise positive [rad].
        """
        ox, oy, _ = self._velocity
        dx, dy = vx - ox, vy - oy
        size, limit = math.hypot(dx, dy), self.settings.acceleration * TICK
        if size > limit:
            dx, dy = dx * limit / size, dy * limit / size
        self._velocity = (ox + dx, oy + dy, max(-6.0, min(6.0, 7.0 * turn)))

    def intake(self, on: bool) -> None:
        """Command the first intake to deploy with the roller on, or to retract with the roller off."""
        self._intake = on

    def set_position(self, mechanism: str, position: float) -> None:
        """Command a mechanism to move to a shaft position [rad] and hold the position; cancel the voltage command."""
        self._volts.pop(mechanism, None)
        self._positions[mechanism] = position

    def set_volts(self, mechanism: str, volts: float) -> None:
        """Command a constant voltage of a mechanism [V], and cancel the mechanism's position command."""
        self._positions.pop(mechanism, None)
        self._volts[mechanism] = volts

    def wait(self, seconds: float) -> Steps:
        """Keep the current commands for a duration [s]."""
        for _ in range(round(seconds / TICK)):
            yield

    def drive_to(
        self, x: float, y: float, yaw: float, *, speed: float = 3.0, tolerance: float = 0.06, timeout: float = 6.0
    ) -> Steps:
        """Drive in a straight line to a pose and stop at the pose.

        Args:
            x: x coordinate of the goal, blue field frame [m].
            y: y coordinate of the goal, blue field frame [m].
            yaw: Heading to hold [rad].
            speed: Cruising speed [m/s].
            tolerance: Distance from the goal at which the robot stops if the heading error is below 3 degrees [m].
            timeout: Time after which the robot stops in any case [s].
        """
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
        """Drive along straight lines through points and stop at the last point.

        Args:
            points: Corners of the path, blue field frame [m].
            yaw: Heading to hold [rad].
            speed: Cruising speed [m/s].
            tolerance: Distance from the last point at which the robot stops if the heading error is < 3 degrees [m].
            corner: Distance from a corner at which the robot turns toward the next point [m].
            timeout: Time after which the robot stops in any case [s].
        """
        way = list(points)
        for _ in range(round(timeout / TICK)):
            left = self.steer_along(way, yaw, speed=speed, corner=corner, stop_before=0.5 * tolerance)
            if len(way) == 1 and left < tolerance and abs(wrap_angle(yaw - self.pose[2])) < degrees(3.0):
                break
            yield
        self.stop()
        yield

    def steer_along(
        self,
        way: list[tuple[float, float]],
        yaw: float,
        *,
        speed: float,
        corner: float = 0.35,
        stop_before: float = 0.0,
    ) -> float:
        """Command the velocity in this tick along a path of straight lines, and slow down before the last point.

        Args:
            way: Corners of the path, blue field frame [m]; the function removes corners that the robot has reached.
            yaw: Heading to turn to [rad].
            speed: Cruising speed [m/s].
            corner: Distance from a corner at which the robot turns toward the next point [m].
            stop_before: Distance before the last point at which to stop [m].

        Returns:
            Remaining length of the path [m].
        """
        x, y, heading = self.pose
        while len(way) > 1 and math.hypot(way[0][0] - x, way[0][1] - y) < corner:
            way.pop(0)
        dx, dy = way[0][0] - x, way[0][1] - y
        ahead = math.hypot(dx, dy)
        left = ahead
        for a, b in pairwise(way):
            left += math.dist(a, b)
        want = min(speed, self._braking_speed(left - stop_before)) / max(ahead, 1e-9)
        self.accelerate_to(want * dx, want * dy, wrap_angle(yaw - heading))
        return left

    def collect_in(
        self,
        low: tuple[float, float],
        high: tuple[float, float],
        *,
        aside: float,
        timeout: float,
        speed: float = 1.2,
        kind: str | None = None,
        yaw: float = 0.0,
    ) -> Steps:
        """Drive to the pieces in a rectangle, nearest first, until no piece is left or the robot is full.

        Call `intake(True)` before this method.

        Args:
            low: Corner of the rectangle with the smallest x and y, blue field frame [m].
            high: Corner of the rectangle with the largest x and y, blue field frame [m].
            aside: Largest distance of the robot along y from the rectangle's center [m].
            timeout: Time after which the robot stops in any case [s].
            speed: Speed of the approach [m/s].
            kind: Kind of pieces to take in; None for any kind.
            yaw: Heading to hold, 0 or pi [rad].
        """
        back = -self.settings.intake_x * math.cos(yaw)
        middle = 0.5 * (low[1] + high[1])
        robot = self.robot
        reach = aside + robot.intakes[0].zone.y_max - 0.02
        low, high = (low[0], max(low[1], middle - reach)), (high[0], min(high[1], middle + reach))
        for _ in range(round(timeout / TICK)):
            places = self.piece_positions(kind)
            inside = ((places[:, :2] > low) & (places[:, :2] < high)).all(axis=1)
            near = places[inside & (places[:, 2] < _LYING)]
            if not len(near) or robot.storage.room == 0:
                break
            here_x, here_y, _ = self.pose
            away = np.hypot(near[:, 0] + back - here_x, near[:, 1] - here_y)
            goal_x, goal_y, _ = near[int(np.argmin(away))]
            goal = goal_x + back, min(max(goal_y, middle - aside), middle + aside)
            self.steer_along([goal], yaw, speed=speed)
            yield
        self.stop()
        yield

    def shoot_until_empty(self, target: tuple[float, float, float], *, timeout: float = 5.0) -> Steps:
        """Turn the robot toward a target and shoot all pieces, without driving.

        If no shot is possible, the method logs the reason once. If rising pieces also score in the target's zone
        (`downward=False`), a shot may enter the zone on the way up.

        Args:
            target: Point to aim at, blue field frame [m].
            timeout: Time after which the robot stops shooting [s].
        """
        patience, has_logged = round(timeout / TICK), False
        robot = self.robot
        while robot.storage.pieces and patience:
            patience -= 1
            try:
                shot = self._solve(target)
            except NoShotError as error:
                if not has_logged:
                    _log.warning("robot %d at %.2f s: %s", self.robot.number, self._match.time, error)
                self._feed, has_logged = False, True
                yield
                continue
            to_left, faster = self.aim_error
            self._wheel_goal = self.robot.shooters[0].config.wheel_speed_for(shot.speed * (1.0 + faster))
            turn = wrap_angle(shot.yaw + to_left - self.pose[2])
            self.accelerate_to(0.0, 0.0, turn)
            self._feed = self._is_ready(turn)
            yield
        self.hold_fire()
        yield

    @property
    def is_feeding(self) -> bool:
        """Whether the script commands the mechanisms in `feed_volts` to feed pieces to the shooter."""
        return self._feed

    def hold_fire(self) -> None:
        """Stop the mechanisms that feed pieces to the shooter; the wheels keep spinning."""
        self._feed = False

    def spin_up(self, target: tuple[float, float, float]) -> None:
        """Command the wheel speed for a shot from the current pose at a target, blue field frame [m].

        Do nothing if no shot is possible.
        """
        try:
            self._wheel_goal = self.robot.shooters[0].config.wheel_speed_for(self._solve(target).speed)
        except NoShotError:
            return

    # --- inside -------------------------------------------------------------------------------------------------

    def _solve(self, target: tuple[float, float, float]) -> Shot:
        x, y, yaw = self.pose
        if target not in self._from_below:
            place, around = np.array(target), _AT_TARGET * np.eye(3)
            zones = [one for one in self._match.game.zones if one.zone.crossed(place - around, place + around).any()]
            self._from_below[target] = any(not zone.downward for zone in zones)
        rising = self._from_below[target]
        shooter = self.robot.shooters[0].config
        launch = shooter.launch
        muzzle = (x + launch.forward * math.cos(yaw), y + launch.forward * math.sin(yaw), launch.height)
        drag = self._match.game.pieces[0].kind.air.drag
        return solve_shot(muzzle, target, drag=drag, elevation=self._elevation_goal, rising=rising)

    @property
    def _elevation_goal(self) -> float:
        shooter = self.robot.shooters[0].config
        return shooter.elevation if shooter.hood is None else self.settings.shot_elevation

    @property
    def _hood_goal(self) -> float:
        shooter = self.robot.shooters[0].config
        return (self._elevation_goal - shooter.elevation) / shooter.elevation_per_hood

    def _is_ready(self, turn: float) -> bool:
        robot = self.robot
        shooter = robot.shooters[0]
        hood = shooter.config.hood
        aimed = hood is None or abs(robot.mechanisms[hood].position - self._hood_goal) < degrees(1.5)
        still = math.hypot(*robot.chassis.vel) < _MOST_SPEED
        up = abs(shooter.wheel_speed / self._wheel_goal - 1.0) < _WHEEL_TOLERANCE
        return abs(turn) < _HEADING_TOLERANCE and aimed and still and up

    def _braking_speed(self, distance: float) -> float:
        """Return the speed [m/s] from which the robot stops within a distance [m] at half of the acceleration limit."""
        return math.sqrt(2.0 * 0.5 * self.settings.acceleration * max(0.0, distance))

    def _drive(self) -> None:
        vx, vy, omega = self._velocity
        yaw = self.pose[2]
        c, s = math.cos(yaw), math.sin(yaw)
        ahead, left = c * vx + s * vy, c * vy - s * vx
        if self._alliance == "red" and not self._symmetry.keeps_hands:
            left, omega = -left, -omega
        drive = self.robot.drive
        assert isinstance(drive, SwerveDrive)
        drive.set_chassis_speeds(ahead, left, omega)

    def _command_mechanisms(self) -> None:
        robot, s = self.robot, self.settings
        robot.setpoints.clear()
        for name, loop in self._wheel_loops.items():
            wheel = robot.mechanisms[name]
            wheel.set_volts(loop.volts(self._wheel_goal, wheel.velocity))
            robot.setpoints[f"{telemetry_name(name)}VelocityRPS"] = self._wheel_goal / math.tau
        hood_name = robot.shooters[0].config.hood if robot.shooters else None
        if hood_name is not None:
            self._hold(hood_name, self._hood_goal)
        for name, goal in self._positions.items():
            self._hold(name, goal)
        for name, volts in self._volts.items():
            robot.mechanisms[name].set_volts(volts)
        for name, volts in s.feed_volts.items():
            robot.mechanisms[name].set_volts(volts if self._feed else 0.0)
        for intake in robot.config.intakes[:1]:
            if intake.deploy is not None:
                deploy = robot.mechanisms[intake.deploy]
                low, high = deploy.stops if intake.deployed_at == "upper" else deploy.stops[::-1]
                goal = high if self._intake else low
                robot.setpoints[f"{telemetry_name(intake.deploy)}PositionRot"] = goal / math.tau
                deploy.set_volts(self._deploy_loop.volts(goal, deploy.position, deploy.velocity))
            if intake.roller is not None:
                robot.mechanisms[intake.roller].set_volts(s.roller_volts if self._intake else 0.0)

    def _hold(self, name: str, goal: float) -> None:
        robot = self.robot
        mechanism = robot.mechanisms[name]
        robot.setpoints[f"{telemetry_name(name)}PositionRot"] = goal / math.tau
        weight = mechanism.holding_volts if isinstance(mechanism, (ArmSim, ElevatorSim)) else 0.0
        position, velocity = mechanism.position, mechanism.velocity
        mechanism.set_volts(self._position_loop.volts(goal, position, velocity, feedforward=weight))


_END = object()
