"""How a robot's body moves by what its driver changes: as in a leapfrog scheme, beside what the engine does to it.

The engine moves a body by x += h v with the v that it has after contacts (semi-implicit Euler). Were v the velocity at
the end of the sub-step, a robot that accelerates with a would be a h / 2 per second ahead, and its path would depend on
who else needs how many sub-steps. So the body moves with the mean velocity of the sub-step:

    given to the engine        v + mean(dv) - w h / 2           dv(t): what the driver changes within the sub-step
    what comes back            v + mean(dv) + w' h - w h / 2    w': what the world does, all of it at once
    true velocity afterwards   v + dv(h) + w' h                 the rest, dv(h) - mean(dv) + w h / 2, is added

w is what the world did in the last sub-step; where it does the same again (w' = w: a slope, a wall that holds) the body
moves by exactly the integral of its velocity. The last line holds for any w': no impulse is lost or counted twice, and
where a wall takes all the velocity, mean(dv) = -w h / 2 leaves no rest. Yaw is moved in the same way.

Walls and other robots are no part of w: before the engine's step `physics/bumper_contacts` says what they change of the
mean velocity, which goes to the body, and of that at the end, which is added with the rest.
"""

from __future__ import annotations

import math

from simcore.geometry.rotation import Vector, rotate, rotate_back
from simcore.physics.bumper_contacts import RobotMotion
from simcore.physics.world import PhysicsWorld
from simcore.robot.level_body import LevelBody
from simcore.robot.mass_distribution import MassDistribution

__all__ = ["DrivenBody"]

_STEADY = 0.95  # share of the moment that would lift a wheel; less than that the carpet takes
_LIFTED = 0.001  # [m]; a hit that tips a level robot so that its center rises by less leaves it level
_ZERO: Vector = (0.0, 0.0, 0.0)


class DrivenBody:
    """The body of a robot, moved by its driver.

    Args:
        world: Where it is.
        row: Of the body.
        reach: Of the wheels from its origin [m].
        wheels: Their places, robot frame [m].
        name: For messages.
    """

    def __init__(
        self, world: PhysicsWorld, row: int, reach: float, wheels: tuple[tuple[float, float], ...], name: str
    ) -> None:
        self._world, self._engine, self._row, self._wheels = world, world.engine, row, wheels
        self.level = LevelBody(world, row, reach, name)
        """Its pose and velocity, after `read`."""
        self.h_before = 0.0
        """Length of the last step [s]; 0 after a start."""
        self.force: Vector = _ZERO
        """From outside, on the center of mass, field frame [N]."""
        self.torque: Vector = _ZERO
        """The same [N m]."""
        self._mass = MassDistribution(1.0, _ZERO, (1.0, 1.0, 1.0))
        self._half_base = 0.0  # from the center of mass to the nearest line through outer wheels [m]
        self._is_pushed = False  # whether the body moves with a mean velocity, and the rest is still to be added
        self._given: tuple[Vector, Vector] = (_ZERO, _ZERO)  # to the engine, linear and angular
        self._each: tuple[Vector, Vector] = (_ZERO, _ZERO)  # what is given anew before each sub-step
        self._rest: tuple[Vector, Vector] = (_ZERO, _ZERO)  # to be added after the sub-step
        self._outside = _ZERO  # part of the last rest that `force` made: along x and y, and about yaw
        self._motion: RobotMotion | None = None  # of the last sub-step, and what walls and robots changed of it

    def set_mass(self, mass: MassDistribution) -> None:
        """Mass, center and inertia from the next step on."""
        self._mass = mass
        (cx, cy, _), (xs, ys) = mass.center, zip(*self._wheels, strict=True)
        self._half_base = max(0.0, min(max(xs) - cx, cx - min(xs), max(ys) - cy, cy - min(ys)))

    def forget(self) -> None:
        """It was put somewhere, at rest."""
        self.h_before = 0.0
        self._is_pushed = False
        self._motion = None
        self._outside = _ZERO
        self.level.forget()

    def read(self) -> bool:
        """Take pose and velocity from the engine; whether the velocity is another than the engine's.

        Raises:
            EngineError: The engine lost the body (a value is not finite).
        """
        was_pushed, self._is_pushed = self._is_pushed, False
        is_free = self.force[2] == 0.0 and self.torque[:2] == (0.0, 0.0)
        if was_pushed:
            (gx, gy, gz), (px, py, pz) = self._given
            (rx, ry, rz), (qx, qy, qz) = self._rest
            if self._motion is not None:
                (dx, dy, turn), (ex, ey, turned) = self._motion.mean_change, self._motion.end_change
                gx, gy, pz = gx + dx, gy + dy, pz + turn
                rx, ry, qz = rx + ex - dx, ry + ey - dy, qz + turned - turn
            given, rest = ((gx, gy, gz), (px, py, pz)), ((rx, ry, rz), (qx, qy, qz))
            self.level.follow(self.h_before, given, rest, self._mass.center, is_free=is_free)
        else:
            self.level.look(is_free=is_free)
        return was_pushed

    def push(self, h: float, parts: int, change: Vector, mean: Vector, pull: Vector) -> None:
        """Give the body its mean velocity in the step by forces on the carpet, in the robot's plane, and by others.

        What carpet and gravity act against at once, up and down, in roll and pitch, is given in equal parts before each
        sub-step: all of it at once would lift wheels off the carpet.

        Args:
            h: Step [s].
            parts: Sub-steps in it; before each but the first, `go_on` follows.
            change: Of the velocity by the driver [m/s, m/s, rad/s].
            mean: Of that change over the sub-step [m/s, m/s, rad/s].
            pull: What the world is expected to do [m/s^2, m/s^2, rad/s^2].
        """
        mass, (_, _, height), (ix, iy, iz) = self._mass
        quat = self.level.quat
        lever = mass * height
        half = 0.5 * h
        ax, ay, alpha = (p * half for p in pull)
        now = rotate(quat, (mean[0] - ax, mean[1] - ay, 0.0))
        later = rotate(quat, (change[0] - mean[0] + ax, change[1] - mean[1] + ay, 0.0))
        # Grip acts below the center of mass.
        tilt_x, tilt_y, turn = lever * change[1] / ix, -lever * change[0] / iy, mean[2] - alpha
        lift = 0.0
        turn_later = rotate(quat, (0.0, 0.0, change[2] - mean[2] + alpha))
        (vx, vy, vz), (wx, wy, _) = self.level.put_velocity()
        linear = [vx + now[0], vy + now[1], vz + now[2]]
        if self.force != _ZERO or self.torque != _ZERO or self._outside != _ZERO:
            # Verlet: one kick by the present force, for half of the step before and half of the one to come. Up and
            # down, and in roll and pitch, the carpet or gravity acts against it, whole and at once: so does the force,
            # in each sub-step.
            tx, ty, tz = rotate_back(quat, self.torque)
            ax, ay, az = (f / mass for f in self.force)
            kick = half + 0.5 * self.h_before
            ox, oy, oz = self._outside
            linear = [linear[0] - ox + kick * ax, linear[1] - oy + kick * ay, linear[2]]
            lift = h * az
            tilt_x, tilt_y, turn = tilt_x + tx * h / ix, tilt_y + ty * h / iy, turn + kick * tz / iz - oz
            ox, oy, oz = self._outside = (half * ax, half * ay, half * tz / iz)
            later = (later[0] + ox, later[1] + oy, later[2])
            spin = rotate(quat, (0.0, 0.0, oz))
            turn_later = (turn_later[0] + spin[0], turn_later[1] + spin[1], turn_later[2] + spin[2])
        hold, held = 0.0, (0.0, 0.0)
        if self.level.is_level:
            weight = mass * self._world.gravity
            hold = _STEADY * weight * self._half_base * h
            if math.hypot(tilt_x * ix, tilt_y * iy) < hold:
                held, tilt_x, tilt_y = (tilt_x * ix, tilt_y * iy), 0.0, 0.0
            hold = max(hold, math.sqrt(2.0 * min(ix, iy) * weight * _LIFTED))
            self.level.stay()
        share = 1.0 / parts
        now = rotate(quat, (0.0, 0.0, turn))
        x, y, z = wx + now[0], wy + now[1], self.level.rate[2] + now[2]
        wx, wy, wz = rotate(quat, (tilt_x, tilt_y, 0.0))
        self._given = (linear[0], linear[1], linear[2] + lift), (x + wx, y + wy, z + wz)
        self._each = (0.0, 0.0, share * lift), (share * wx, share * wy, share * wz)
        self._engine.set_velocity(
            self._row,
            (linear[0], linear[1], linear[2] + share * lift),
            (x + share * wx, y + share * wy, z + share * wz),
        )
        self._rest = (later, turn_later)
        self.h_before = h
        self._is_pushed = True
        self._tell_bumpers(h, pull, hold, held)

    def go_on(self) -> None:
        """Continue the step before another one of the engine's."""
        if self._is_pushed and self._each != (_ZERO, _ZERO):
            (dx, dy, dz), (wx, wy, wz) = self._each
            (vx, vy, vz), (rx, ry, rz) = self._engine.velocity(self._row)
            self._engine.set_velocity(self._row, (vx + dx, vy + dy, vz + dz), (rx + wx, ry + wy, rz + wz))

    def bumped(self) -> tuple[float, float, float, float]:
        """Acceleration by walls and robots in the last sub-step, robot's plane [m/s^2, m/s^2, rad/s^2], and where [m].

        The height is that above the carpet.
        """
        motion = self._motion
        if motion is None or self.h_before == 0.0 or motion.end_change == _ZERO:
            return 0.0, 0.0, 0.0, 0.0
        ax, ay, alpha = (change / self.h_before for change in motion.end_change)
        ax, ay, _ = rotate_back(self.level.quat, (ax, ay, 0.0))
        return ax, ay, alpha, motion.height

    def _tell_bumpers(self, h: float, pull: Vector, hold: float, held: tuple[float, float]) -> None:
        """Say how the robot moves in the next step if it touches no wall and no robot; the engine does as expected.

        Args:
            h: Step [s].
            pull: What the engine is expected to do [m/s^2, m/s^2, rad/s^2].
            hold: Angular impulse that its weight takes in the step without a wheel coming off [N m s].
            held: Of it, what it takes of the tires, in roll and pitch, robot axes [N m s].
        """
        level = self.level
        ax, ay, _ = rotate(level.quat, (h * pull[0], h * pull[1], 0.0))
        (gx, gy, _), (_, _, gz) = self._given
        (rx, ry, _), (_, _, rz) = self._rest
        mean = (gx + ax, gy + ay, gz + h * pull[2])
        x, y, z = rotate(level.quat, self._mass.center)
        self._motion = RobotMotion(
            row=self._row,
            h=h,
            pos=level.pos,
            quat=level.quat,
            center=(level.pos[0] + x, level.pos[1] + y, level.pos[2] + z),
            mass=self._mass.mass,
            inertia=self._mass.inertia,
            start=(level.vel[0], level.vel[1], level.rate[2]),
            mean=mean,
            end=(mean[0] + rx, mean[1] + ry, mean[2] + rz),
            hold=hold,
            held=held,
        )
        self._world.bumpers.submit(self._motion)
