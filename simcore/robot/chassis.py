"""The robot in the world: what it is driven by, and what the world makes of it.

Each sub-step the driver (a velocity to follow, forces, or a drivetrain model) asks for a change of velocity, no larger
than tires can give; the engine adds gravity, contacts and hits; what really came of it is what the driver sees next.
Poses are never forced.

The engine moves a body by x += h v with the v that it has after contacts (semi-implicit Euler). Were v the velocity at
the end of the sub-step, a robot that accelerates with a would be a h / 2 per second ahead, and its path would depend on
who else needs how many sub-steps. So the body moves with the mean velocity of the sub-step, as in a leapfrog scheme:

    given to the engine        v + mean(dv) - w h / 2           dv(t): what the driver changes within the sub-step
    what comes back            v + mean(dv) + w' h - w h / 2    w': what the world does, all of it at once
    true velocity afterwards   v + dv(h) + w' h                 the rest, dv(h) - mean(dv) + w h / 2, is added

w is what the world did in the last sub-step; where it does the same again (w' = w: a slope, a wall that holds) the body
moves by exactly the integral of its velocity. The last line holds for any w': no impulse is lost or counted twice, and
where a wall takes all the velocity, mean(dv) = -w h / 2 leaves no rest. Yaw is moved in the same way.

Walls and other robots are no part of w: before the engine's step `physics/bumper_contacts` says what they change of the
mean velocity, which goes to the body, and of that at the end, which is added with the rest. The drivetrain gets both,
w and what the bumpers met, so that a robot that leans on a wall stalls its motors.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from simcore.errors import ConfigError, NonFiniteError
from simcore.geometry.rotation import Quaternion, Vector, from_yaw, matrix, rotate, rotate_back, rpy, yaw_of
from simcore.physics.bumper_contacts import RobotMotion
from simcore.physics.substeps import Surroundings
from simcore.physics.world import PhysicsWorld
from simcore.quantities import POSE, require_row
from simcore.robot.chassis_config import ChassisConfig
from simcore.robot.level_body import LEVEL_HEIGHT, LEVEL_TILT, LevelBody
from simcore.robot.mass_distribution import MassDistribution
from simcore.robot.wheel_loads import LoadTransfer, WheeledRobot
from simcore.typing import FloatArray

__all__ = ["ChassisSimulation", "Drivetrain"]

_CONTACT_GAP = 0.004  # [m]; a wheel this close to the ground carries load
_BESIDE = 0.03  # [m]; what is farther from the bumpers than this and the way of a tick is not met in it
_STANDING = 0.3  # cosine of a tilt; a robot that leans more stands on its side
_MOST_RESISTANCE = 1.5  # [g]; more than any tire can push against for longer than a hit
_STEADY = 0.95  # share of the moment that would lift a wheel; less than that the carpet takes
_LIFTED = 0.001  # [m]; a hit that tips a level robot so that its center rises by less leaves it level
_ZERO: Vector = (0.0, 0.0, 0.0)
_START_HEIGHT = -2e-5  # [m]; a gap of exactly 0 is no contact yet, and the first step would fall


class Drivetrain(Protocol):
    """What moves a chassis: tire forces from motors, seen from the robot frame."""

    @property
    def robot(self) -> WheeledRobot:
        """Mass, center of mass and where the wheels are."""
        ...

    @property
    def normal_loads(self) -> list[float]:
        """Load of each wheel, averaged over the last `step` [N]."""
        ...

    def set_mass_properties(self, mass: float, yaw_inertia: float, center_of_mass: Vector) -> None:
        """What the robot weighs from the next step on [kg, kg m^2, m]; `robot` gives it from then on."""
        ...

    @property
    def mean_change(self) -> tuple[float, float, float]:
        """Mean over the last `step` of what the tires had changed until then [m/s, m/s, rad/s]."""
        ...

    @property
    def change(self) -> tuple[float, float, float]:
        """Of the velocity by tire forces, in the present step until now [m/s, m/s, rad/s]."""
        ...

    def begin_step(
        self,
        h: float,
        vx: float,
        vy: float,
        omega: float,
        normal_loads: LoadTransfer,
        ax: float,
        ay: float,
        alpha: float,
        *,
        may_rest: bool = True,
    ) -> list[float]:
        """Begin a step of h [s]; returns the lengths of the parts that `advance` is called for [s].

        Args:
            h: Step [s].
            vx: Velocity over ground of the point on the carpet under the center of mass, forward [m/s].
            vy: The same, to the left [m/s].
            omega: Yaw rate [rad/s].
            normal_loads: Load of each wheel, which follows what the tires do within the step.
            ax: Acceleration that the world will add by itself (a slope, a wall that pushes back), forward [m/s^2].
            ay: The same, to the left [m/s^2].
            alpha: The same for the yaw rate [rad/s^2].
            may_rest: Whether one part is enough for a robot in which nothing moves.
        """
        ...

    def advance(self, h: float) -> None:
        """Wheels and motors in the next part of the step, h [s] long."""
        ...


class ChassisSimulation:
    """A robot body, driven in one of three ways: by a velocity to follow, by forces, or by a drivetrain model.

    Args:
        world: Where it stands.
        config: Mass, shape and wheels.
        pose: Start, field frame [m, m, rad].
        drivetrain: A model of motors and tires; None: `follow_velocity` or `apply_forces` drive it.
        name: For messages.
        mass: Mass, center and inertia of the whole robot as it starts; None: as the config says.
    """

    def __init__(
        self,
        world: PhysicsWorld,
        config: ChassisConfig,
        *,
        pose: tuple[float, float, float] = (0.0, 0.0, 0.0),
        drivetrain: Drivetrain | None = None,
        name: str = "robot",
        mass: MassDistribution | None = None,
    ) -> None:
        self.config = config
        self.distribution = mass or MassDistribution(
            config.mass, (0.0, 0.0, config.center_of_mass_height), config.inertia
        )
        """With what it holds and as its mechanisms stand; see `set_mass`."""
        self.name = name
        self._world = world
        self._engine = world.engine
        self._drivetrain = drivetrain
        self._require_finite("pose", pose)
        self.row = world.add_robot_body(
            name,
            config.shape,
            mass=self.distribution.mass,
            surface=config.surface,
            center_of_mass=self.distribution.center,
            inertia=self.distribution.inertia,
            bumpers=config.bumpers,
            pos=(pose[0], pose[1], _START_HEIGHT),
            quat=from_yaw(pose[2]),
        )
        self._target: tuple[float, float, float] | None = None
        self._force: Vector = (0.0, 0.0, 0.0)
        self._torque: Vector = (0.0, 0.0, 0.0)
        r = config.wheel_radius
        self._hubs = np.array([(x, y, r) for x, y in config.wheel_positions])
        self._soles = np.array([(x, y, -_CONTACT_GAP) for x, y in config.wheel_positions])
        self._contacts = np.array([(x, y, 0.0) for x, y in config.wheel_positions])
        self._sole_reach = max(math.hypot(x, y) for x, y in config.wheel_positions)
        self._body = LevelBody(world, self.row, self._sole_reach, name)
        xs, ys = zip(*config.wheel_positions, strict=True)
        self._half_base = min(max(xs), -min(xs), max(ys), -min(ys))
        self._half_diagonal = 0.5 * math.hypot(config.bumper_length, config.bumper_width)
        self._all_touching = [True] * len(config.wheel_positions)
        self.touching = list(self._all_touching)
        """Which wheels are on the ground."""
        if drivetrain is not None:
            drivetrain.set_mass_properties(
                self.distribution.mass, self.distribution.inertia[2], self.distribution.center
            )
        self._transfer = None if drivetrain is None else LoadTransfer(drivetrain.robot)
        self._h = 0.0  # of the present step [s]
        self._expected = _ZERO  # what the world is expected to do in it, in the robot's plane [m/s^2, m/s^2, rad/s^2]
        self._h_before = 0.0  # of the last step [s]; 0 after a start
        self._is_pushed = False  # whether the body moves with a mean velocity, and the rest is still to be added
        self._given: tuple[Vector, Vector] = (_ZERO, _ZERO)  # to the engine, linear and angular
        self._each: tuple[Vector, Vector] = (_ZERO, _ZERO)  # what is given anew before each sub-step
        self._rest: tuple[Vector, Vector] = (_ZERO, _ZERO)  # to be added after the sub-step
        self._outside = _ZERO  # part of the last rest that `apply_forces` made: along x and y, and about yaw
        self._motion: RobotMotion | None = None  # of the last sub-step, and what walls and robots changed of it
        self.pos: Vector = (0.0, 0.0, 0.0)
        """Point on the robot's underside where the carpet would be, field frame [m]."""
        self.quat: Quaternion = (0.0, 0.0, 0.0, 1.0)
        """Attitude."""
        self.vel: Vector = (0.0, 0.0, 0.0)
        """Velocity of the center of mass, field frame [m/s]."""
        self.rate: Vector = (0.0, 0.0, 0.0)
        """Angular velocity, field frame [rad/s]."""
        self.read()

    # --- driving ------------------------------------------------------------------------------------------------

    def follow_velocity(self, vx: float, vy: float, omega: float) -> None:
        """Follow a velocity, robot frame [m/s, m/s, rad/s], as fast as the tires allow; until the next command.

        Raises:
            ConfigError: A drivetrain moves this robot.
            NonFiniteError: A value is not finite; the last target stays.
        """
        if self._drivetrain is not None:
            raise ConfigError(f"{self.name}: its drivetrain moves it; command that, or build the chassis without one")
        self._require_finite("velocity to follow", (vx, vy, omega))
        self._target = (vx, vy, omega)

    def coast(self) -> None:
        """Follow nothing and push nothing."""
        self._target, self._force, self._torque = None, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)

    def apply_forces(self, force: Vector, torque: Vector = (0.0, 0.0, 0.0)) -> None:
        """Push at the center of mass, field frame [N, N m], until the next command.

        Raises:
            NonFiniteError: A value is not finite; the last forces stay.
        """
        self._require_finite("force", (*force, *torque))
        self._force, self._torque = force, torque

    def set_pose(self, x: float, y: float, yaw: float) -> None:
        """Put the robot somewhere on the carpet, at rest [m, m, rad].

        Raises:
            NonFiniteError: A value is not finite; the robot stays.
            ConfigError: One is on no field; the robot stays.
        """
        self._require_finite("pose", (x, y, yaw))
        require_row(self.name, "pose", (x, y, yaw), POSE)
        self._world.set_pose(self.row, (x, y, _START_HEIGHT), from_yaw(yaw))
        self._h_before = 0.0
        self._is_pushed = False
        self._motion = None
        self._body.forget()
        self._outside = _ZERO
        if self._transfer is not None:
            self._transfer.reset()
        self.read()

    def set_mass(self, mass: MassDistribution, vel: Vector, rate: Vector) -> None:
        """Take in another mass, center and inertia, between two steps; its body stays where it is.

        Args:
            mass: From now on.
            vel: Of the new center of mass, field frame [m/s].
            rate: Angular velocity, field frame [rad/s].
        """
        self.read()  # what is left of the last step belongs to the old center
        self.distribution, self.vel, self.rate = mass, vel, rate
        self._engine.set_mass(self.row, mass.mass, mass.center, mass.inertia)
        self._world.robot_bodies[self.row].set_mass(mass.mass, mass.center, mass.inertia)
        self._engine.set_velocity(self.row, vel, rate)
        if self._drivetrain is not None and self._transfer is not None:
            self._drivetrain.set_mass_properties(mass.mass, mass.inertia[2], mass.center)
            self._transfer.set_robot(self._drivetrain.robot)

    # --- one sub-step -------------------------------------------------------------------------------------------

    def begin_step(self, h: float, *, may_rest: bool = True) -> list[float]:
        """Look at what the engine made of the last step, and begin the next one of h [s].

        Args:
            h: Length: of one step of the engine, or of some that are over before the driver is asked again.
            may_rest: Whether one part is enough for a robot in which nothing moves.

        Returns:
            Lengths of the parts in which the drivetrain moves, for `drive` [s]; none without a drivetrain.
        """
        self._take_in()
        self._h = h
        return [] if self._drivetrain is None else self._begin_drive(h, may_rest)

    def drive(self, h: float) -> None:
        """Let the drivetrain move in the next part of the step, h [s] long."""
        assert self._drivetrain is not None
        self._drivetrain.advance(h)

    def push(self, parts: int = 1) -> None:
        """Put on the body what the driver changes in the step that has begun.

        Args:
            parts: Steps of the engine in it; `go_on` must be called before each but the first.
        """
        if self._drivetrain is not None:
            change, mean, pull = self._drivetrain.change, self._drivetrain.mean_change, self._expected
        elif self._target is not None:
            change, mean, pull = self._follow(self._h)
        else:
            change = mean = pull = _ZERO
        self._push(self._h, parts, change, mean, pull)

    def step(self, h: float, parts: int = 1) -> None:
        """All of a step of h [s] before the engine's, for a chassis without mechanisms: `begin_step`, `drive`, `push`.

        Args:
            h: Length [s].
            parts: See `push`.
        """
        for part in self.begin_step(h):
            self.drive(part)
        self.push(parts)

    def go_on(self) -> None:
        """Continue the step before another one of the engine's."""
        if self._is_pushed and self._each != (_ZERO, _ZERO):
            (dx, dy, dz), (wx, wy, wz) = self._each
            (vx, vy, vz), (rx, ry, rz) = self._engine.velocity(self.row)
            self._set_velocity((vx + dx, vy + dy, vz + dz), (rx + wx, ry + wy, rz + wz))

    def read(self) -> None:
        """Take pose and velocity from the engine.

        Raises:
            EngineError: The engine lost the body (a value is not finite).
        """
        if self._take_in():
            self._body.tell()

    def _take_in(self) -> bool:
        """What `read` does, without telling the engine; whether the velocity is another than the engine's."""
        body, was_pushed, self._is_pushed = self._body, self._is_pushed, False
        is_free = self._force[2] == 0.0 and self._torque[:2] == (0.0, 0.0)
        if was_pushed:
            (gx, gy, gz), (px, py, pz) = self._given
            (rx, ry, rz), (qx, qy, qz) = self._rest
            if self._motion is not None:
                (dx, dy, turn), (ex, ey, turned) = self._motion.mean_change, self._motion.end_change
                gx, gy, pz = gx + dx, gy + dy, pz + turn
                rx, ry, qz = rx + ex - dx, ry + ey - dy, qz + turned - turn
            given, rest = ((gx, gy, gz), (px, py, pz)), ((rx, ry, rz), (qx, qy, qz))
            body.follow(self._h_before, given, rest, is_free=is_free)
        else:
            body.look(is_free=is_free)
        self.pos, self.quat, self.vel, self.rate = body.pos, body.quat, body.vel, body.rate
        return was_pushed

    # --- questions ----------------------------------------------------------------------------------------------

    @property
    def normal_loads(self) -> list[float]:
        """Load of each wheel in the last sub-step [N]; zeros without a drivetrain."""
        return [0.0] * len(self.touching) if self._drivetrain is None else self._drivetrain.normal_loads

    @property
    def pose(self) -> tuple[float, float, float]:
        """Position and heading, field frame [m, m, rad]."""
        return self.pos[0], self.pos[1], yaw_of(self.quat)

    @property
    def roll_pitch_yaw(self) -> Vector:
        """Attitude, WPILib's Rotation3d order [rad]."""
        return rpy(self.quat)

    @property
    def robot_rate(self) -> Vector:
        """Angular velocity, robot axes [rad/s]."""
        return rotate_back(self.quat, self.rate)

    @property
    def is_on_its_own(self) -> bool:
        """Whether nothing but the flat carpet, walls and robots had a hand in its last step."""
        return self._body.is_level and not self._body.is_touched

    @property
    def ground_velocity(self) -> tuple[float, float, float]:
        """Velocity of the point on the carpet under the center of mass, robot frame [m/s, m/s, rad/s]."""
        vx, vy, _ = rotate_back(self.quat, self.vel)
        wx, wy, wz = rotate_back(self.quat, self.rate)
        height = self.distribution.center[2]
        return vx - wy * height, vy + wx * height, wz

    @property
    def speed(self) -> float:
        """Speed of the fastest corner [m/s]."""
        return math.hypot(*self.vel) + abs(self.rate[2]) * self._half_diagonal

    def reach(self, dt: float) -> float:
        """How far from where its origin is now a corner of its bumpers can be within dt [s], from above [m]."""
        return self._half_diagonal + dt * self.speed

    @property
    def origin_velocity(self) -> Vector:
        """Velocity of the point at `pos`, field frame [m/s]."""
        cx, cy, cz = self.distribution.center
        ax, ay, az = rotate(self.quat, (-cx, -cy, -cz))
        (vx, vy, vz), (wx, wy, wz) = self.vel, self.rate
        return vx + wy * az - wz * ay, vy + wz * ax - wx * az, vz + wx * ay - wy * ax

    @property
    def footprint(self) -> tuple[float, float, float, float, float, float, Vector]:
        """What the pieces need to know.

        x, y, yaw, half length, half width [m, rad], speed of the box [m/s], and the plane of its underside: height at
        x, y [m] and slopes along the field's x and y.
        """
        x, y, yaw = self.pose
        (ax, ay, az), c = rotate(self.quat, (0.0, 0.0, 1.0)), self.config
        if az < _STANDING:
            plane = (-math.inf, 0.0, 0.0)
        else:  # through the point at the clearance over the origin
            plane = (self.pos[2] + c.clearance / az, -ax / az, -ay / az)
        return x, y, yaw, c.bumper_length / 2, c.bumper_width / 2, self.speed, plane

    def wheel_ground(self) -> tuple[FloatArray, FloatArray]:
        """What is under the wheels.

        Returns:
            Lowest point of each wheel, field frame [m], shape (n, 3), and the height of what carries robots straight
            under it [m], shape (n,); 5 m below the wheel's axle where there is nothing.
        """
        soles = self._contacts @ matrix(self.quat).T + self.pos
        if self._world.is_flat(self.pos[0], self.pos[1], self._sole_reach):
            return soles, np.zeros(len(soles))
        start = soles + np.array((0.0, 0.0, self.config.wheel_radius))
        hits = self._world.ground_rays(start, start - np.array((0.0, 0.0, 5.0)))
        return soles, start[:, 2] - 5.0 * hits.fraction

    def surroundings(self, dt: float) -> Surroundings:
        """What could be met within dt [s]."""
        c, (x, y, z) = self.config, self.pos
        grow = self.speed * dt + _BESIDE
        return self._world.surroundings(
            *(self.row, x, y, yaw_of(self.quat), 0.5 * c.bumper_length + grow, 0.5 * c.bumper_width + grow),
            *(z + 0.01, z + c.height),
        )

    # --- inside -------------------------------------------------------------------------------------------------

    def _begin_drive(self, h: float, may_rest: bool) -> list[float]:
        """Tell the drivetrain how the robot moves, what its wheels carry, and what the world is expected to do."""
        assert self._drivetrain is not None and self._transfer is not None
        self._find_ground()
        down = rotate_back(self.quat, (0.0, 0.0, -self._world.gravity))
        pull = self._expected_pull(down)
        felt = rotate_back(self.quat, self._body.pulled[0]) if self._h_before > 0.0 else _ZERO
        bump_x, bump_y, bump_turn, bump_height = self._bumped()
        ax, ay, alpha = self._lasting(pull[0] + bump_x, pull[1] + bump_y, pull[2] + bump_turn)
        over = 1.0 - bump_height / self.distribution.center[2]  # a push at the carpet's height shifts no load
        scale = 1.0 / self.distribution.mass
        fx, fy, fz = (f * scale for f in rotate_back(self.quat, self._force))
        turn = rotate_back(self.quat, self._torque)[2] / self.distribution.inertia[2]
        self._transfer.stand(
            self.touching, down, (felt[0] + over * bump_x + fx, felt[1] + over * bump_y + fy, felt[2] + fz)
        )
        vx, vy, omega = self.ground_velocity
        self._expected = pull
        return self._drivetrain.begin_step(
            *(h, vx, vy, omega, self._transfer, ax + fx, ay + fy, alpha + turn),
            may_rest=may_rest,
        )

    def _follow(self, h: float) -> tuple[Vector, Vector, Vector]:
        """Toward the target by no more than mu g h, and about the yaw axis by what the same grip can turn.

        The wheels that touch carry the whole weight between them, so grip is there in full until the last one lifts.
        What gravity does along a slope is made up for within that grip, so that a robot stands on it. What a wall does
        is not: pushed against a push that is as stiff as a wall's, a robot rattles. A target that is reached before the
        end of the sub-step is held from then on.

        Returns:
            Change of velocity, its mean over the step [m/s, m/s, rad/s], and what the world is expected to do
            [m/s^2, m/s^2, rad/s^2], in the robot's plane.
        """
        assert self._target is not None
        self._find_ground()
        if not any(self.touching):
            return _ZERO, _ZERO, _ZERO
        ax, ay, _ = rotate_back(self.quat, (0.0, 0.0, -self._world.gravity))
        grip = self.config.friction * self._world.gravity
        vx, vy, omega = self.ground_velocity
        gap_x, gap_y, gap_turn = self._target[0] - vx, self._target[1] - vy, self._target[2] - omega
        dvx, dvy = gap_x - ax * h, gap_y - ay * h
        size, spare = math.hypot(dvx, dvy), (grip - math.hypot(ax, ay)) * h
        if size > grip * h:
            dvx, dvy = dvx * grip * h / size, dvy * grip * h / size
            mean_x, mean_y = 0.5 * dvx, 0.5 * dvy
        else:
            late = min(1.0, math.hypot(gap_x, gap_y) / spare) if spare > 0.0 else 1.0
            mean_x = gap_x * (1.0 - 0.5 * late) - 0.5 * ax * h
            mean_y = gap_y * (1.0 - 0.5 * late) - 0.5 * ay * h
        spin = self._most_spin(self.config.friction) * h
        domega = max(-spin, min(spin, gap_turn))
        mean_turn = domega * (1.0 - 0.5 * abs(domega) / spin) if spin > 0.0 else 0.0
        return (dvx, dvy, domega), (mean_x, mean_y, mean_turn), (ax, ay, 0.0)

    def _expected_pull(self, down: Vector) -> Vector:
        """What the engine will add in the next sub-step, if it does as in the last one: a slope, pieces that hold.

        Args:
            down: Gravity, robot axes [m/s^2].

        Returns:
            Acceleration in the robot's plane [m/s^2, m/s^2, rad/s^2].
        """
        if self._h_before == 0.0:
            return down[0], down[1], 0.0
        ax, ay, _ = rotate_back(self.quat, self._body.pulled[0])
        return self._lasting(ax, ay, rotate_back(self.quat, self._body.pulled[1])[2])

    def _bumped(self) -> tuple[float, float, float, float]:
        """Acceleration by walls and robots in the last sub-step, robot's plane [m/s^2, m/s^2, rad/s^2], and where [m].

        The height is that above the carpet.
        """
        motion = self._motion
        if motion is None or self._h_before == 0.0 or motion.end_change == _ZERO:
            return 0.0, 0.0, 0.0, 0.0
        ax, ay, alpha = (change / self._h_before for change in motion.end_change)
        ax, ay, _ = rotate_back(self.quat, (ax, ay, 0.0))
        return ax, ay, alpha, motion.height

    def _lasting(self, ax: float, ay: float, alpha: float) -> Vector:
        """An acceleration in the robot's plane without what only a hit can give, which lasts for one sub-step."""
        size, most = math.hypot(ax, ay), _MOST_RESISTANCE * self._world.gravity
        if size > most:
            ax, ay = ax * most / size, ay * most / size
        spin = self._most_spin(_MOST_RESISTANCE)
        return ax, ay, max(-spin, min(spin, alpha))

    def _most_spin(self, friction: float) -> float:
        """Angular acceleration of a robot whose wheels all pull across their radius with this grip [rad/s^2]."""
        mass, _, (_, _, yaw_inertia) = self.distribution
        return friction * self._world.gravity * mass * self.config.traction_radius / yaw_inertia

    def _push(self, h: float, parts: int, change: Vector, mean: Vector, pull: Vector) -> None:
        """Give the body its mean velocity in the step by forces on the carpet, in the robot's plane, and by others.

        What carpet and gravity act against at once, up and down, in roll and pitch, is given in equal parts before each
        sub-step: all of it at once would lift wheels off the carpet.

        Args:
            h: Step [s].
            parts: Sub-steps in it.
            change: Of the velocity by the driver [m/s, m/s, rad/s].
            mean: Of that change over the sub-step [m/s, m/s, rad/s].
            pull: What the world is expected to do [m/s^2, m/s^2, rad/s^2].
        """
        mass, (_, _, height), (ix, iy, iz) = self.distribution
        lever = mass * height
        half = 0.5 * h
        ax, ay, alpha = (p * half for p in pull)
        now = rotate(self.quat, (mean[0] - ax, mean[1] - ay, 0.0))
        later = rotate(self.quat, (change[0] - mean[0] + ax, change[1] - mean[1] + ay, 0.0))
        # Grip acts below the center of mass.
        tilt_x, tilt_y, turn = lever * change[1] / ix, -lever * change[0] / iy, mean[2] - alpha
        lift = 0.0
        turn_later = rotate(self.quat, (0.0, 0.0, change[2] - mean[2] + alpha))
        (vx, vy, vz), (wx, wy, _) = self._body.put_velocity()
        linear = [vx + now[0], vy + now[1], vz + now[2]]
        if self._force != _ZERO or self._torque != _ZERO or self._outside != _ZERO:
            # Verlet: one kick by the present force, for half of the step before and half of the one to come. Up and
            # down, and in roll and pitch, the carpet or gravity acts against it, whole and at once: so does the force,
            # in each sub-step.
            tx, ty, tz = rotate_back(self.quat, self._torque)
            ax, ay, az = (f / mass for f in self._force)
            kick = half + 0.5 * self._h_before
            ox, oy, oz = self._outside
            linear = [linear[0] - ox + kick * ax, linear[1] - oy + kick * ay, linear[2]]
            lift = h * az
            tilt_x, tilt_y, turn = tilt_x + tx * h / ix, tilt_y + ty * h / iy, turn + kick * tz / iz - oz
            ox, oy, oz = self._outside = (half * ax, half * ay, half * tz / iz)
            later = (later[0] + ox, later[1] + oy, later[2])
            spin = rotate(self.quat, (0.0, 0.0, oz))
            turn_later = (turn_later[0] + spin[0], turn_later[1] + spin[1], turn_later[2] + spin[2])
        hold, held = 0.0, (0.0, 0.0)
        if self._body.is_level:
            hold = _STEADY * mass * self._world.gravity * self._half_base * h
            if math.hypot(tilt_x * ix, tilt_y * iy) < hold:
                held, tilt_x, tilt_y = (tilt_x * ix, tilt_y * iy), 0.0, 0.0
            hold = max(hold, math.sqrt(2.0 * min(ix, iy) * mass * self._world.gravity * _LIFTED))
            self._body.stay()
        share = 1.0 / parts
        now = rotate(self.quat, (0.0, 0.0, turn))
        x, y, z = wx + now[0], wy + now[1], self.rate[2] + now[2]
        wx, wy, wz = rotate(self.quat, (tilt_x, tilt_y, 0.0))
        self._given = (linear[0], linear[1], linear[2] + lift), (x + wx, y + wy, z + wz)
        self._each = (0.0, 0.0, share * lift), (share * wx, share * wy, share * wz)
        self._set_velocity(
            (linear[0], linear[1], linear[2] + share * lift), (x + share * wx, y + share * wy, z + share * wz)
        )
        self._rest = (later, turn_later)
        self._h_before = h
        self._is_pushed = True
        self._tell_bumpers(h, pull, hold, held)

    def _tell_bumpers(self, h: float, pull: Vector, hold: float, held: tuple[float, float]) -> None:
        """Say how the robot moves in the next step if it touches no wall and no robot; the engine does as expected.

        Args:
            h: Step [s].
            pull: What the engine is expected to do [m/s^2, m/s^2, rad/s^2].
            hold: Angular impulse that its weight takes in the step without a wheel coming off [N m s].
            held: Of it, what it takes of the tires, in roll and pitch, robot axes [N m s].
        """
        ax, ay, _ = rotate(self.quat, (h * pull[0], h * pull[1], 0.0))
        (gx, gy, _), (_, _, gz) = self._given
        (rx, ry, _), (_, _, rz) = self._rest
        mean = (gx + ax, gy + ay, gz + h * pull[2])
        x, y, z = rotate(self.quat, self.distribution.center)
        self._motion = RobotMotion(
            row=self.row,
            h=h,
            pos=self.pos,
            quat=self.quat,
            center=(self.pos[0] + x, self.pos[1] + y, self.pos[2] + z),
            mass=self.distribution.mass,
            inertia=self.distribution.inertia,
            start=(self.vel[0], self.vel[1], self.rate[2]),
            mean=mean,
            end=(mean[0] + rx, mean[1] + ry, mean[2] + rz),
            hold=hold,
            held=held,
        )
        self._world.bumpers.submit(self._motion)

    def _set_velocity(self, linear: Vector, angular: Vector) -> None:
        """Give the body a velocity for a sub-step, of which `_each` has the part that is new."""
        lift = self._each[0][2]
        if lift and self._engine.is_exact:  # it takes force and weight together, and moves by what is left of them
            linear = linear[0], linear[1], linear[2] - lift
            self._engine.apply_forces([self.row], np.array([[0.0, 0.0, self._force[2]]]))
        self._engine.set_velocity(self.row, linear, angular)

    def _find_ground(self) -> None:
        """Which wheels touch: all of them on the flat carpet, else those whose short ray down meets something.

        And those that touch what carries robots elsewhere: a wheel at the edge of a bar stands on it and pulls there.
        """
        x, y, _, _ = self.quat
        if abs(self.pos[2]) < LEVEL_HEIGHT and x * x + y * y < LEVEL_TILT**2:
            self.touching = self._all_touching
            return
        turn = matrix(self.quat).T
        start = self._hubs @ turn + self.pos
        end = self._soles @ turn + self.pos
        touching = self._world.ground_rays(start, end).row >= 0
        if not touching.all():
            places = self._world.ground_contacts(self.row)
            if len(places):
                away = np.linalg.norm(start[:, None] - places, axis=2).min(axis=1)
                touching |= away < self.config.wheel_radius + _CONTACT_GAP
        self.touching = touching.tolist()

    def _require_finite(self, what: str, values: Sequence[float]) -> None:
        if not all(map(math.isfinite, values)):
            raise NonFiniteError(f"{self.name}: {what} must be finite, got {tuple(values)}")
