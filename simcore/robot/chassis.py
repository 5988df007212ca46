"""The robot in the world: what it is driven by, and what the world makes of it.

Each sub-step the driver (a velocity to follow, forces, or a drivetrain model) asks for a change of velocity, no larger
than tires can give; the engine adds gravity, contacts and hits; what really came of it is what the driver sees next.
Poses are never forced. `DrivenBody` says how the body moves by both; the drivetrain is told what the world did and what
the bumpers met, so that a robot that leans on a wall stalls its motors.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from simcore.errors import ConfigError, NonFiniteError
from simcore.geometry.rotation import Quaternion, Vector, from_yaw, rotate, rotate_back, rpy, yaw_of
from simcore.physics.substeps import Surroundings
from simcore.physics.world import PhysicsWorld
from simcore.quantities import POSE, require_row
from simcore.robot.chassis_config import ChassisConfig
from simcore.robot.driven_body import DrivenBody
from simcore.robot.mass_distribution import MassDistribution
from simcore.robot.wheel_ground import WheelGround
from simcore.robot.wheel_loads import LoadTransfer
from simcore.robot.wheeled_drive import WheeledDrive
from simcore.typing import FloatArray

__all__ = ["ChassisSimulation"]

_BESIDE = 0.03  # [m]; what is farther from the bumpers than this and the way of a tick is not met in it
_MOST_RESISTANCE = 1.5  # [g]; more than any tire can push against for longer than a hit
_ZERO: Vector = (0.0, 0.0, 0.0)


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
        drivetrain: WheeledDrive[Any] | None = None,
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
            pos=(pose[0], pose[1], 0.0),
            quat=from_yaw(pose[2]),
        )
        self._target: tuple[float, float, float] | None = None
        self._ground = WheelGround(world, self.row, config)
        world.set_pose(self.row, *self._ground.standing(*pose))
        self._body = DrivenBody(world, self.row, self._ground.reach, config.wheel_positions, name)
        self._body.set_mass(self.distribution)
        self._half_diagonal = 0.5 * math.hypot(config.bumper_length, config.bumper_width)
        if drivetrain is not None:
            drivetrain.set_mass_properties(
                self.distribution.mass, self.distribution.inertia[2], self.distribution.center
            )
        self._transfer = None if drivetrain is None else LoadTransfer(drivetrain.robot)
        self._h = 0.0  # of the present step [s]
        self._expected = _ZERO  # what the world is expected to do in it, in the robot's plane [m/s^2, m/s^2, rad/s^2]
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
        self._target, self._body.force, self._body.torque = None, _ZERO, _ZERO

    def apply_forces(self, force: Vector, torque: Vector = _ZERO) -> None:
        """Push at the center of mass, field frame [N, N m], until the next command.

        Raises:
            NonFiniteError: A value is not finite; the last forces stay.
        """
        self._require_finite("force", (*force, *torque))
        self._body.force, self._body.torque = force, torque

    def set_pose(self, x: float, y: float, yaw: float) -> None:
        """Put the robot somewhere at rest, on the carpet or on what robots drive over [m, m, rad].

        Raises:
            NonFiniteError: A value is not finite; the robot stays.
            ConfigError: One is on no field; the robot stays.
        """
        self._require_finite("pose", (x, y, yaw))
        require_row(self.name, "pose", (x, y, yaw), POSE)
        self._world.set_pose(self.row, *self._ground.standing(x, y, yaw))
        self._body.forget()
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
        self._body.set_mass(mass)
        self._engine.set_mass(self.row, mass.mass, mass.center, mass.inertia)
        self._world.balls.set_mass(self.row, mass.mass, mass.center, mass.inertia)
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
        self._body.push(self._h, parts, change, mean, pull)

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
        self._body.go_on()

    def read(self) -> None:
        """Take pose and velocity from the engine.

        Raises:
            EngineError: The engine lost the body (a value is not finite).
        """
        if self._take_in():
            self._body.level.tell()

    def _take_in(self) -> bool:
        """What `read` does, without telling the engine; whether the velocity is another than the engine's."""
        was_pushed, level = self._body.read(), self._body.level
        self.pos, self.quat, self.vel, self.rate = level.pos, level.quat, level.vel, level.rate
        return was_pushed

    # --- questions ----------------------------------------------------------------------------------------------

    @property
    def normal_loads(self) -> list[float]:
        """Load of each wheel in the last sub-step [N]; zeros without a drivetrain."""
        return [0.0] * len(self._ground.touching) if self._drivetrain is None else self._drivetrain.normal_loads

    @property
    def touching(self) -> list[bool]:
        """Which wheels are on the ground."""
        return self._ground.touching

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
        return self._body.level.is_level and not self._body.level.is_touched

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
        return math.hypot(*self.origin_velocity) + abs(self.rate[2]) * self._half_diagonal

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
    def footprint(self) -> tuple[float, float, float, float, float, float]:
        """What the pieces need to know: x, y, yaw, half length, half width [m, rad] and speed of the box [m/s]."""
        x, y, yaw = self.pose
        return x, y, yaw, self.config.bumper_length / 2, self.config.bumper_width / 2, self.speed

    def standing(self, pose: Vector) -> tuple[Vector, Quaternion]:
        """Place of its origin, field frame [m], and attitude as it would stand at a pose [m, m, rad]."""
        return self._ground.standing(*pose)

    def wheel_ground(self) -> tuple[FloatArray, FloatArray]:
        """What is under the wheels.

        Returns:
            Lowest point of each wheel, field frame [m], shape (n, 3), and the height of what carries robots straight
            under it [m], shape (n,); 5 m below the wheel's axle where there is nothing.
        """
        return self._ground.under(self.pos, self.quat)

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
        self._ground.find(self.pos, self.quat)
        down = rotate_back(self.quat, (0.0, 0.0, -self._world.gravity))
        pull = self._expected_pull(down)
        felt = rotate_back(self.quat, self._body.level.pulled[0]) if self._body.h_before > 0.0 else _ZERO
        bump_x, bump_y, bump_turn, bump_height = self._body.bumped()
        ax, ay, alpha = self._lasting(pull[0] + bump_x, pull[1] + bump_y, pull[2] + bump_turn)
        over = 1.0 - bump_height / self.distribution.center[2]  # a push at the carpet's height shifts no load
        scale = 1.0 / self.distribution.mass
        fx, fy, fz = (f * scale for f in rotate_back(self.quat, self._body.force))
        turn = rotate_back(self.quat, self._body.torque)[2] / self.distribution.inertia[2]
        self._transfer.stand(
            self._ground.touching, down, (felt[0] + over * bump_x + fx, felt[1] + over * bump_y + fy, felt[2] + fz)
        )
        self._expected = pull
        return self._drivetrain.begin_step(
            h, self.ground_velocity, self._transfer, (ax + fx, ay + fy, alpha + turn), may_rest=may_rest
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
        self._ground.find(self.pos, self.quat)
        if not any(self._ground.touching):
            return _ZERO, _ZERO, _ZERO
        ax, ay, _ = rotate_back(self.quat, (0.0, 0.0, -self._world.gravity))
        grip = self.config.friction * self._world.gravity
        vx, vy, omega = self.ground_velocity
        cx, cy, _ = self.distribution.center
        wanted_x, wanted_y, wanted_turn = self._target  # of the origin; the center of mass turns about it
        gap_x, gap_y, gap_turn = wanted_x - wanted_turn * cy - vx, wanted_y + wanted_turn * cx - vy, wanted_turn - omega
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
        if self._body.h_before == 0.0:
            return down[0], down[1], 0.0
        ax, ay, _ = rotate_back(self.quat, self._body.level.pulled[0])
        return self._lasting(ax, ay, rotate_back(self.quat, self._body.level.pulled[1])[2])

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

    def _require_finite(self, what: str, values: Sequence[float]) -> None:
        if not all(map(math.isfinite, values)):
            raise NonFiniteError(f"{self.name}: {what} must be finite, got {tuple(values)}")
