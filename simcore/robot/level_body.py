"""The body of a robot in the engine, and its own motion while it stands on the flat carpet.

There the robot moves in the plane by its own equations. The body goes along, and only what pieces do to it in the plane
counts; so the robot's path depends on no rounding of the engine and on no number of its steps. Up and down, in roll and
pitch the body is the engine's all the time, so that it knows when something lifts or tips the robot: then the robot is
where its body is.
"""

from __future__ import annotations

import math

from simcore.errors import EngineError
from simcore.geometry.rotation import Quaternion, Vector, from_yaw, multiply, rotate, wrap_angle, yaw_of
from simcore.physics.world import PhysicsWorld

__all__ = ["LEVEL_HEIGHT", "LEVEL_TILT", "LevelBody"]

LEVEL_HEIGHT = 0.002
"""A robot that is nearer to the carpet than this, and turned against it by less than that, may be level [m]."""
LEVEL_TILT = 1e-3
"""Sine of half the angle [-]."""
_SPEED, _RATE = 0.05, 0.5  # [m/s, rad/s], up or down, and in roll and pitch; one that lands or tips is not level yet
_NOISE = 1e-6  # [m/s, rad/s]; what an engine's carpet changes of a level robot's motion by rounding
_ELSEWHERE = 1e-7  # [m, rad]; a body that is so far from where its robot has come by itself is put there
_ZERO: Vector = (0.0, 0.0, 0.0)


class LevelBody:
    """Pose and velocity of a robot, from its body and its own equations.

    Args:
        world: Where it is.
        row: Of the body.
        reach: Of the wheels from its origin [m].
        name: For messages.
    """

    def __init__(self, world: PhysicsWorld, row: int, reach: float, name: str) -> None:
        self._world, self._engine, self._row, self._reach, self._name = world, world.engine, row, reach, name
        self.is_level = False
        """Whether it moves in the plane."""
        self.is_touched = False
        """Whether the engine has changed more of its motion in the last step than a flat carpet does."""
        self.pos: Vector = _ZERO
        """Of its origin, field frame [m]."""
        self.quat: Quaternion = (0.0, 0.0, 0.0, 1.0)
        self.vel: Vector = _ZERO
        """Of its center of mass, field frame [m/s]."""
        self.rate: Vector = _ZERO
        """Angular velocity, field frame [rad/s]."""
        self.pulled: tuple[Vector, Vector] = (_ZERO, _ZERO)
        """Acceleration by the engine in the last step [m/s^2, rad/s^2]."""
        self._seen: tuple[Vector, Quaternion] = (_ZERO, self.quat)  # pose of the body when last asked for
        self._told: tuple[Vector, Vector] = (_ZERO, _ZERO)  # velocity that it was given last
        self._beside: Vector = _ZERO  # of a level one's body: velocity up, angular velocity along x and y

    def forget(self) -> None:
        """It was put somewhere."""
        self.is_level = self.is_touched = False

    def put_velocity(self) -> tuple[Vector, Vector]:
        """Velocity that the body should have for `vel` and `rate`: what the engine has of it beside the plane stays."""
        if not self.is_level:
            return self.vel, self.rate
        vz, wx, wy = self._beside
        return (self.vel[0], self.vel[1], vz), (wx, wy, self.rate[2])

    def tell(self) -> None:
        """Give the body that velocity."""
        self._told = self.put_velocity()
        self._engine.set_velocity(self._row, *self._told)

    def look(self, *, is_free: bool) -> None:
        """Take pose and velocity from the body, which has not moved by itself since; they may have been set.

        Args:
            is_free: Whether nothing but carpet and pieces may lift or tip it.
        """
        pos, quat, vel, rate = self._read()
        (ax, ay, az), (bx, by, bz, bw) = self._seen
        seen, told = (ax, ay, az, bx, by, bz, bw), (*self._told[0], *self._told[1])
        now = (*pos, *quat, *vel, *rate)
        if not self.is_level or any(abs(a - b) > 1e-12 for a, b in zip(now, (*seen, *told), strict=True)):
            self._take(pos, quat, vel, rate, is_level=is_free and self._stands_level(pos, quat, vel, rate))

    def follow(
        self, h: float, given: tuple[Vector, Vector], rest: tuple[Vector, Vector], center: Vector, *, is_free: bool
    ) -> None:
        """Take pose and velocity after a step.

        Args:
            h: Its length [s].
            center: Center of mass, robot frame [m].
            given: Velocity of the body in it, linear and angular.
            rest: What is to be added at its end.
            is_free: As of `look`.
        """
        pos, quat, (vx, vy, vz), (wx, wy, wz) = self._read()
        (gx, gy, gz), (px, py, pz) = given
        (rx, ry, rz), (qx, qy, qz) = rest
        was_level = self.is_level
        is_level = is_free and self._stands_level(pos, quat, (vx, vy, vz), (wx, wy, wz))
        self.is_touched = not is_level or max(abs(vx - gx), abs(vy - gy), abs(wz - pz)) > _NOISE
        if was_level and is_level:
            (x, y, _), (old, old_quat) = self.pos, self._seen
            if self.is_touched:
                way_x, way_y, turn = pos[0] - old[0], pos[1] - old[1], wrap_angle(yaw_of(quat) - yaw_of(old_quat))
            else:  # by its own equations, to the last bit, in however many steps of the engine
                vx, vy, wz = gx, gy, pz
                way_x, way_y, turn = h * vx, h * vy, h * wz
                if center[0] or center[1]:  # what moves so is the center of mass; the origin turns about it
                    (bx, by, _), (ax, ay, _) = rotate(self.quat, center), rotate(self._turned(turn), center)
                    way_x, way_y = way_x + bx - ax, way_y + by - ay
            self._beside, self._seen = (vz, wx, wy), (pos, quat)
            self.pulled = ((vx - gx) / h, (vy - gy) / h, 0.0), (0.0, 0.0, (wz - pz) / h)
            self.pos, self.quat = (x + way_x, y + way_y, 0.0), self._turned(turn)
            self.vel, self.rate = (vx + rx, vy + ry, 0.0), (0.0, 0.0, wz + qz)
            return
        self.pulled = (
            ((vx - gx) / h, (vy - gy) / h, (vz - gz) / h),
            ((wx - px) / h, (wy - py) / h, (wz - pz) / h),
        )
        vel, rate = (vx + rx, vy + ry, vz + rz), (wx + qx, wy + qy, wz + qz)
        self._take(pos, quat, vel, rate, is_level=is_level)

    def stay(self) -> None:
        """Put the body where the robot has come in the plane, if it is elsewhere; its velocity must follow."""
        (x, y, _), (seen, quat) = self.pos, self._seen
        turn = wrap_angle(yaw_of(self.quat) - yaw_of(quat))
        if self.is_level and max(abs(x - seen[0]), abs(y - seen[1]), abs(turn)) > _ELSEWHERE:
            self._seen = (x, y, seen[2]), multiply(from_yaw(turn), quat)
            self._engine.set_pose(self._row, *self._seen)

    def _turned(self, turn: float) -> Quaternion:
        """Attitude of a level robot after a turn [rad]."""
        return from_yaw(wrap_angle(yaw_of(self.quat) + turn))

    def _read(self) -> tuple[Vector, Quaternion, Vector, Vector]:
        pos, quat = self._engine.pose(self._row)
        vel, rate = self._engine.velocity(self._row)
        if not all(map(math.isfinite, (*pos, *vel, *rate))):
            raise EngineError(f"{self._name}: the engine returned a pose or velocity that is not finite: {pos}")
        return pos, quat, vel, rate

    def _take(self, pos: Vector, quat: Quaternion, vel: Vector, rate: Vector, *, is_level: bool) -> None:
        """Take over a pose and velocity of the body; of a level one what is in the plane."""
        self.is_level = is_level
        self._seen, self._told = (pos, quat), (vel, rate)
        self.pos, self.quat, self.vel, self.rate = pos, quat, vel, rate
        if is_level:
            self._beside = vel[2], rate[0], rate[1]
            self.pos, self.quat = (pos[0], pos[1], 0.0), from_yaw(yaw_of(quat))
            self.vel, self.rate = (vel[0], vel[1], 0.0), (0.0, 0.0, rate[2])

    def _stands_level(self, pos: Vector, quat: Quaternion, vel: Vector, rate: Vector) -> bool:
        """Whether it stands on the flat carpet, and nothing lifts or tips it."""
        return (
            abs(pos[2]) < LEVEL_HEIGHT
            and math.hypot(quat[0], quat[1]) < LEVEL_TILT
            and abs(vel[2]) < _SPEED
            and math.hypot(rate[0], rate[1]) < _RATE
            and self._world.is_flat(pos[0], pos[1], self._reach)
        )
