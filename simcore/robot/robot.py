"""Robot in a world: body, drivetrain, battery, sensors, mechanisms and held pieces."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol, TypeAlias

import numpy as np

from simcore.channel import Channel
from simcore.errors import UnknownNameError
from simcore.quantities import ANGLE, require, require_row
from simcore.robot.battery import Battery, BrownoutLog
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.chassis_config import MassDistribution, MovingMass, PointMass, moved_points, with_points
from simcore.robot.climber import Climber, Rung
from simcore.robot.gyro import Gyro
from simcore.robot.intake import Intake, IntakeConfig
from simcore.robot.mechanisms import ShaftSim
from simcore.robot.placer import Placer, PlacerConfig
from simcore.robot.robot_config import BuiltRobot, RobotConfig, build_drivetrain, build_mechanism
from simcore.robot.shooter import Shooter, ShooterConfig
from simcore.robot.storage import Storage
from simcore.typing import FloatArray, IntArray
from simcore.units import TICK, plain_sum
from simcore.world.hanging import HangingBody
from simcore.world.linkage import MechanismMotion, PartState
from simcore.world.rotation import Quaternion, Vector, interpolate, multiply, rotate, rotate_back, wrap_angle
from simcore.world.symmetry import Pose
from simcore.world.world import PhysicsWorld

__all__ = [
    "Controller",
    "Robot",
    "RobotDevices",
]


class SwerveOdometry:
    """Pose estimate from wheel travel and gyro yaw, as in WPILib's SwerveDriveOdometry.

    Between two samples, module i travels a distance d_i in the direction of the steer angle. The chassis moves along an
    arc by the twist (dx, dy, dyaw): dyaw comes from the gyro, and dx and dy are the least-squares fit to all d_i. Tank
    and mecanum drives have wheels instead of modules.

    Args:
        positions: Positions of the modules, relative to the point whose pose is estimated, robot axes [m].
        pose: Initial pose, field frame [m, m, rad].
    """

    def __init__(
        self, positions: Sequence[tuple[float, float]], pose: tuple[float, float, float] = (0.0, 0.0, 0.0)
    ) -> None:
        self._positions = [(float(x), float(y)) for x, y in positions]
        self.reset(pose)

    def reset(
        self,
        pose: tuple[float, float, float],
        distances: Sequence[float] | FloatArray | None = None,
        gyro_yaw: float | None = None,
    ) -> None:
        """Set the pose estimate.

        Args:
            pose: New pose, field frame [m, m, rad].
            distances: Current readings of the drive encoders [m], shape (n,); None for zeros.
            gyro_yaw: Current yaw reading of the gyro [rad]; None for a reading equal to the heading of `pose`.

        Raises:
            ConfigError: If an argument is invalid or the number of distances is not the number of modules; the estimate
                is left unchanged.
        """
        require_row("odometry", "pose", pose, (ANGLE,) * 3)
        distances = [0.0] * len(self._positions) if distances is None else distances
        require_row("odometry", "distances", distances, (ANGLE,) * len(self._positions))
        require("odometry", "gyro_yaw", pose[2] if gyro_yaw is None else gyro_yaw, ANGLE)
        self.pose = pose
        """Pose estimate, field frame [m, m, rad]; the heading is continuous over turns."""
        self._distances = [float(d) for d in distances]
        self._offset = pose[2] - (pose[2] if gyro_yaw is None else gyro_yaw)

    def update(
        self, distances: Sequence[float], angles: Sequence[float], gyro_yaw: float
    ) -> tuple[float, float, float]:
        """Add the travel since the last call to the pose estimate.

        Args:
            distances: Readings of the drive encoders [m], shape (n,).
            angles: Steer angles [rad], shape (n,).
            gyro_yaw: Yaw reading of the gyro, continuous [rad].

        Returns:
            New pose estimate, field frame [m, m, rad].
        """
        x, y, before = self.pose
        yaw = gyro_yaw + self._offset
        turn = yaw - before
        # Each module moves by the translation plus turn x position, so the least-squares translation is the mean travel
        # without turn x position. Plain floats take 4 us for four modules; numpy takes 15.
        dx = dy = 0.0
        rows = zip(distances, self._distances, angles, self._positions, strict=True)
        for distance, last, angle, (px, py) in rows:
            travel = distance - last
            dx += travel * math.cos(angle) + turn * py
            dy += travel * math.sin(angle) - turn * px
        n = len(self._positions)
        dx, dy = dx / n, dy / n
        self._distances = list(distances)
        if abs(turn) > 1e-9:  # along the arc: WPILib's Pose2d.exp
            s, c = math.sin(turn) / turn, (1.0 - math.cos(turn)) / turn
        else:
            s, c = 1.0, 0.5 * turn
        along, across = s * dx - c * dy, c * dx + s * dy
        cos, sin = math.cos(before), math.sin(before)
        self.pose = (x + cos * along - sin * across, y + sin * along + cos * across, yaw)
        return self.pose


_MASS_BIT = 1e-6  # [kg]


class MassBalance:
    """Mass and momentum balance of a robot with pieces and moving mechanisms.

    Once per tick, before the motion, `update` passes a changed mass distribution to the chassis. The pose of the robot
    does not change. The new velocity follows from conservation laws:

    - An incoming piece adds momentum to the robot; a launched or released piece removes momentum. Linear momentum and
      angular momentum about the common center of mass are conserved: an intake is an inelastic impact, and a launch
      causes recoil.
    - Mass that moves within the robot changes neither linear nor angular momentum: an arm that extends slows a turn.
      The model ignores the reaction on the body while the arm accelerates and decelerates.
    - Pieces that the drive team puts in or takes out have the velocity of the robot.

    Args:
        body: Mass distribution of the robot without moving masses; see `RobotConfig.bare_body`.
        parts: Moving masses.
        mechanisms: Mechanisms of the robot, by name.
        storages: Storages of the robot.
        placers: Placers of the robot.
        chassis: Chassis to update.
    """

    def __init__(
        self,
        body: MassDistribution,
        parts: Sequence[MovingMass],
        mechanisms: Mapping[str, MechanismMotion],
        storages: Sequence[Storage],
        placers: Sequence[Placer],
        chassis: ChassisSimulation,
    ) -> None:
        self._body = body
        self._parts = parts
        self._mechanisms = mechanisms
        self._storages = storages
        self._placers = placers
        self._chassis = chassis
        self._stored: list[list[int]] = [[] for _ in storages]
        self._has_hopper = any(storage.hopper is not None for storage in storages)  # pieces in a hopper move
        self._laden = body  # body including the pieces in storages
        self._exchanged: list[tuple[float, Vector, Vector]] = []

    def exchange(self, mass: float, pos: Vector, vel: Vector) -> None:
        """Record a piece that entered or left the robot since the last `update`.

        Args:
            mass: Mass of the piece [kg]; negative for a piece that left.
            pos: Position of the piece at the time of entry or exit, field frame [m].
            vel: Velocity of the piece at the time of entry or exit, field frame [m/s].
        """
        self._exchanged.append((mass, pos, vel))

    def now(self, masses: FloatArray, radii: FloatArray) -> MassDistribution:
        """Compute the current mass distribution, with held pieces and moving masses at their current positions.

        Args:
            masses: Masses of all pieces, by slot [kg].
            radii: Bounding radii of all pieces, by slot [m].
        """
        stored = [storage.pieces for storage in self._storages]
        if stored != self._stored or self._has_hopper:
            self._stored = [slots[:] for slots in stored]
            self._laden = with_points(
                self._body,
                [
                    (float(masses[slot]), (x, y, z))
                    for storage in self._storages
                    for slot, (x, y, z) in zip(storage.pieces, storage.places(radii).tolist(), strict=True)
                ],
            )
        points: list[PointMass] = moved_points(self._parts, self._mechanisms)
        points += [(float(masses[p.piece]), p.held_state().pos) for p in self._placers if p.piece is not None]
        return with_points(self._laden, points) if points else self._laden

    def update(self, masses: FloatArray, radii: FloatArray) -> None:
        """Pass a changed mass distribution and the new velocity to the chassis; the arguments are those of `now`.

        Call this method between two steps of the loop.
        """
        old, new = self._chassis.distribution, self.now(masses, radii)
        exchanged = self._exchanged
        if new == old and not exchanged:
            return
        self._exchanged = []
        self._chassis.set_mass(new, *self._velocity(old, new, exchanged))

    def _velocity(
        self, old: MassDistribution, new: MassDistribution, exchanged: Sequence[tuple[float, Vector, Vector]]
    ) -> tuple[Vector, Vector]:
        """Compute the velocities of the robot with the new mass distribution from the conservation laws.

        Args:
            old: Mass distribution before the change.
            new: Mass distribution after the change.
            exchanged: Mass [kg], position [m] and velocity [m/s] of each piece that entered or left, field frame.

        Returns:
            Velocity of the new center of mass [m/s], and angular velocity [rad/s], field frame.
        """
        c = self._chassis
        ox, oy, oz = rotate(c.quat, old.center)
        (vx, vy, vz), (wx, wy, wz) = c.vel, c.rate
        known = old.mass + plain_sum(mass for mass, _, _ in exchanged)
        if abs(new.mass - known) > _MASS_BIT:  # the drive team put a piece in or took one out
            px, py, pz = rotate(c.quat, new.center)
            px, py, pz = px - ox, py - oy, pz - oz
            return (vx + wy * pz - wz * py, vy + wz * px - wx * pz, vz + wx * py - wy * px), c.rate
        rows = [(m, (x - c.pos[0], y - c.pos[1], z - c.pos[2]), v) for m, (x, y, z), v in exchanged]
        if not rows:
            mx, my, mz = ox, oy, oz
            linear = c.vel
        else:
            rows.append((old.mass, (ox, oy, oz), c.vel))
            mx, my, mz = (plain_sum(m * place[axis] for m, place, _ in rows) / new.mass for axis in range(3))
            ux, uy, uz = (plain_sum(m * v[axis] for m, _, v in rows) / new.mass for axis in range(3))
            linear = (ux, uy, uz)
        ix, iy, iz = old.inertia
        wx, wy, wz = rotate_back(c.quat, c.rate)
        sx, sy, sz = rotate(c.quat, (ix * wx, iy * wy, iz * wz))
        for m, (px, py, pz), (vx, vy, vz) in rows:
            px, py, pz = m * (px - mx), m * (py - my), m * (pz - mz)
            sx, sy, sz = sx + py * vz - pz * vy, sy + pz * vx - px * vz, sz + px * vy - py * vx
        ix, iy, iz = new.inertia
        sx, sy, sz = rotate_back(c.quat, (sx, sy, sz))
        return linear, rotate(c.quat, (sx / ix, sy / iy, sz / iz))


class NamedMechanisms(dict[str, ShaftSim]):
    """Mechanisms by name; an unknown name raises an error that lists the known names."""

    def __missing__(self, name: str) -> ShaftSim:
        raise UnknownNameError("mechanism", name, self)


class RobotDevices(Protocol):
    """Motor controllers and sensors that robot code uses on a robot."""

    def step(self, h: float, yaw_rate: float) -> None:
        """Apply the outputs of the motor controllers to mechanisms and drivetrain, before a motion of the robot.

        The devices also read the battery voltage.

        Args:
            h: Duration of the motion, at most 5 ms [s].
            yaw_rate: Yaw rate of the robot after the last step of the loop [rad/s].
        """
        ...

    def write(self) -> None:
        """Update the sensor readings in robot code after a motion of the robot."""
        ...


class Robot:
    """Robot in a world, with all parts and devices.

    Args:
        world: World to which the constructor adds the robot; several robots can share a world.
        config: Config of the robot.
        rng: Random generator for the errors of the gyro.
        number: Index in the list of robots.
        pose: Start pose, field frame [m, m, rad].
        rungs: Rungs on which climbers can hang.
        mounts: Hanging bodies with rungs, by name.
        built: Robot as actually built; None for a robot exactly as in the config.
    """

    def __init__(
        self,
        world: PhysicsWorld,
        config: RobotConfig,
        *,
        rng: np.random.Generator,
        number: int = 0,
        pose: Pose = (0.0, 0.0, 0.0),
        rungs: Sequence[Rung] = (),
        mounts: Mapping[str, HangingBody] | None = None,
        built: BuiltRobot | None = None,
    ) -> None:
        built = built or BuiltRobot.exactly(config)
        self.config = config
        """Config of the robot: nominal values, as assumed by robot code."""
        self.number = number
        self.battery = Battery(built.battery)
        drivetrain = config.drivetrain
        self.drive = build_drivetrain(drivetrain, battery=self.battery, built=built.drivetrain)
        self.mechanisms = NamedMechanisms({name: build_mechanism(c) for name, c in built.mechanisms.items()})
        """Mechanisms by name, in the order of `RobotConfig.mechanisms`."""
        self.chassis = ChassisSimulation(
            *(world, config.body),
            pose=pose,
            drivetrain=self.drive,
            mechanisms=tuple(self.mechanisms.values()),
            name=f"robot {number}",
            mass=config.whole,
        )
        self.gyro = Gyro(built.gyro, rng)
        self.odometry = SwerveOdometry(drivetrain.wheel_positions)
        self.intakes = [Intake(c, self.mechanisms) for c in config.intakes]
        self.storage = Storage(config.storage, lambda: world.balls.balls)
        """First storage of the robot, for preloads and for parts that name no storage."""
        self._storages = {"": self.storage, config.storage.name: self.storage}
        self._storages |= {c.name: Storage(c, lambda: world.balls.balls) for c in config.more_storages}
        self.storages = list(dict.fromkeys(self._storages.values()))
        """All storages: first `storage`, then the storages of `RobotConfig.more_storages`."""
        self._hoppers = [storage for storage in self.storages if storage.hopper is not None]
        self.shooters = [
            Shooter(c, self.mechanisms, errors) for c, errors in zip(config.shooters, built.shot_errors, strict=True)
        ]
        self.placers = [Placer(c, self.mechanisms) for c in config.placers]
        self.climbers = [Climber(c, self.mechanisms, self.chassis, rungs, mounts or {}) for c in config.climbers]
        self.balance = MassBalance(
            *(config.bare_body, config.moving_masses, self.mechanisms, self.storages, self.placers, self.chassis)
        )
        """Mass and momentum balance, which updates the chassis for held pieces and moving masses."""
        self.devices: RobotDevices | None = None
        """Motor controllers and sensors of robot code; None without robot code."""
        self.channels: list[Channel] = []
        """Telemetry channels of robot code; a published key is the key of the robot plus the key of the channel."""
        self.sensor_states: dict[str, bool] = {}
        """Whether each switch and beam break of robot code is triggered, by name; for telemetry."""
        self.light_colors: dict[str, IntArray] = {}
        """LED colors of each light of robot code, 0xRRGGBB, shape (n,), by name of the light; for telemetry."""
        self.light_requests: dict[str, str] = {}
        """Text of the current request to each light of robot code, by name of the light; for telemetry."""
        self.brownouts = BrownoutLog(number, self.battery, self._consumers)
        """Log of brownouts and roboRIO resets."""
        self.setpoints: dict[str, float] = {}
        """Setpoints of closed loops, by telemetry name: mechanism, quantity and unit, for example `HoodPositionRot`."""
        self.module_setpoints: FloatArray | None = None
        """Setpoints of robot code for the modules: rows of wheel speed [m/s] and steer angle [rad], shape (n, 2).

        None if robot code publishes no setpoints.
        """
        self.estimated_pose: tuple[float, float, float] | None = None
        """Pose estimate of robot code's drivetrain, field frame [m, m, rad]; None to use `odometry` instead."""
        self.require_place: Callable[[Pose], object] | None = None
        """Function that raises an error for a pose where the robot cannot stand; None for no check.

        `reset` and `carry_to` call this function before the placement.
        """
        self.on_put: Callable[[str], object] | None = None
        """Callback after each placement; None for no callback. The argument is the reason, `carried` or `reset`."""
        self._estimated: list[ShaftSim] = []
        self._is_carried = False  # whether any climber was near a rung in the last sub-step
        self._before: PartState
        self._start: tuple[Pose, Pose] | None = None  # actual and intended pose of the last placement
        self.reset(pose)

    # --- sensors and drivetrain ---------------------------------------------------------------------------------

    def reset(self, pose: Pose, *, believed: Pose | None = None) -> None:
        """Place the robot at rest, reset drivetrain and battery, and set gyro and odometry to the new pose.

        To change only the pose estimate, call `odometry.reset`.

        Args:
            pose: New pose, field frame [m, m, rad].
            believed: Pose for gyro and odometry, where the drive team intended to place the robot; None for `pose`.

        Raises:
            NonFiniteError: If the pose is not finite; the robot is left unchanged.
            StartError: If the robot cannot stand at this pose; the robot is left unchanged.
        """
        if self.require_place is not None:
            self.require_place(pose)
        self.chassis.set_pose(*pose)
        self.drive.reset()
        self._note_put(pose, believed, (pose if believed is None else believed)[2], "reset")

    def carry_to(self, pose: Pose, *, believed: Pose | None = None) -> None:
        """Place the robot at rest with an unchanged gyro reading, as if the drive team carried the robot to a new pose.

        Args:
            pose: New pose, field frame [m, m, rad].
            believed: Pose for odometry, where the drive team intended to place the robot; None for `pose`.

        Raises:
            NonFiniteError: If the pose is not finite; the robot is left unchanged.
            StartError: If the robot cannot stand at this pose; the robot is left unchanged.
        """
        if self.require_place is not None:
            self.require_place(pose)
        self.put(pose, believed=believed)

    def put(self, pose: Pose, *, believed: Pose | None) -> None:
        """Place the robot like `carry_to`, but without a check of the pose by `require_place`."""
        self.chassis.set_pose(*pose)
        self._note_put(pose, believed, self.gyro.yaw, "carried")

    def _note_put(self, pose: Pose, believed: Pose | None, yaw: float, reason: str) -> None:
        """Reset gyro and odometry after a placement, and call `on_put`.

        Args:
            pose: True pose after the placement, field frame [m, m, rad].
            believed: Pose for odometry [m, m, rad]; None for `pose`.
            yaw: New reading of the gyro [rad].
            reason: Argument of `on_put`.
        """
        self.gyro.reset(yaw=yaw, true_yaw=pose[2])
        self.odometry.reset(pose if believed is None else believed, gyro_yaw=yaw)
        self._start = None if believed is None else (pose, believed)
        self._before = self._motion
        if self.on_put is not None:
            self.on_put(reason)

    @property
    def believed_pose(self) -> Pose:
        """Pose estimate of robot code, or of `odometry` if robot code has none, field frame [m, m, rad]."""
        return self.estimated_pose or self.odometry.pose

    @property
    def reckoned_pose(self) -> Pose:
        """Pose that odometry without any error would estimate, field frame [m, m, rad].

        The result is the true pose, unless the last placement was not at the intended pose.
        """
        pose = self.chassis.pose
        if self._start is None:
            return pose
        (tx, ty, t_yaw), (bx, by, b_yaw) = self._start
        turn = b_yaw - t_yaw
        c, s, dx, dy = math.cos(turn), math.sin(turn), pose[0] - tx, pose[1] - ty
        return bx + c * dx - s * dy, by + s * dx + c * dy, wrap_angle(pose[2] + turn)

    def sense(self, dt: float) -> None:
        """Update the chassis state, gyro, odometry and sensor readings of the devices after a motion of `dt` [s]."""
        self.chassis.read()
        roll, pitch, yaw = self.chassis.roll_pitch_yaw
        self.gyro.step(dt, yaw, pitch, roll, self.chassis.robot_rate)
        self.odometry.update(self.drive.wheel_distances(), self.drive.wheel_angles(), self.gyro.yaw)
        if self.devices is not None:
            self.devices.write()

    def connect(self, devices: RobotDevices) -> None:
        """Connect the devices of robot code, which command the robot from the next call of `step_devices` on."""
        self.devices = devices

    def step_devices(self, h: float) -> None:
        """Apply climber forces, step the devices, and advance the estimated mechanisms, before a motion of `h` [s].

        Estimated mechanisms coast while the robot is disabled or browned out.
        """
        if self.climbers:
            self._let_climbers_push(h)
        if self.devices is not None:
            self.devices.step(h, self.drive.yaw_rate)
        for mechanism in self._estimated:
            if self.battery.browned_out or not self.drive.enabled:
                mechanism.coast()
            mechanism.step(h, self.battery.voltage)

    def _let_climbers_push(self, h: float) -> None:
        near = [climber for climber in self.climbers if climber.is_near]
        if near or self._is_carried:
            self.chassis.read()  # the force of a stiff hook needs the current pose
            force, torque = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
            for climber in near:
                (fx, fy, fz), (tx, ty, tz) = climber.push(h)
                force = (force[0] + fx, force[1] + fy, force[2] + fz)
                torque = (torque[0] + tx, torque[1] + ty, torque[2] + tz)
            self.chassis.apply_forces(force, torque)
        self._is_carried = bool(near)

    # --- mechanisms -----------------------------------------------------------------------------------------------

    def add_estimated_mechanism(self, mechanism: ShaftSim) -> None:
        """Add a mechanism with estimated parameters, which draws no current from the battery of the robot.

        `step_devices` advances the mechanism.
        """
        self._estimated.append(mechanism)

    def remove_estimated_mechanism(self, mechanism: ShaftSim) -> None:
        """Remove a mechanism added by `add_estimated_mechanism`."""
        self._estimated.remove(mechanism)

    def _consumers(self) -> dict[str, float]:
        """Return the supply currents at the start of the last brownout or reset, by mechanism name or `drive` [A]."""
        drawn = {name: float(mechanism.record["noted_supply"][0]) for name, mechanism in self.mechanisms.items()}
        return drawn | {"drive": float(self.drive.shafts["noted_supply"].sum())}

    # --- pieces ---------------------------------------------------------------------------------------------------

    @property
    def held(self) -> list[int]:
        """Slots of held pieces: first the pieces in storages, in the order of arrival, then the pieces in placers."""
        stored = [slot for storage in self.storages for slot in storage.pieces]
        return stored + [placer.piece for placer in self.placers if placer.piece is not None]

    def storage_of(self, part: IntakeConfig | ShooterConfig | PlacerConfig) -> Storage:
        """Return the storage that an intake, shooter or placer uses."""
        return self._storages[part.storage]

    def forget_pieces(self) -> None:
        """Remove all held pieces from the robot, as at a field reset."""
        for storage in self.storages:
            storage.clear()
        for placer in self.placers:
            placer.piece = None

    def forget_piece(self, slot: int) -> None:
        """Remove a held piece from the storage or placer that holds the piece, as if taken out by hand."""
        for storage in self.storages:
            if slot in storage.pieces:
                storage.pieces.remove(slot)
        for placer in self.placers:
            if placer.piece == slot:
                placer.piece = None

    @property
    def is_shifting(self) -> bool:
        """Whether held pieces may move within the robot, in a hopper or a placer."""
        return bool(self._hoppers or self.placers)

    def held_poses(self, radii: FloatArray) -> FloatArray:
        """Return pose rows `x, y, z, qw, qx, qy, qz` of the held pieces, in the order of `held`, robot frame.

        The array has the shape (n, 7).

        Args:
            radii: Bounding radii of all pieces, by slot [m].
        """
        rows, first = np.empty((len(self.held), 7)), 0
        for storage in self.storages:
            if storage.pieces:
                last = first + len(storage.pieces)
                x, y, z, w = storage.config.attitude
                rows[first:last, :3], rows[first:last, 3:] = storage.places(radii), (w, x, y, z)
                first = last
        for placer in self.placers:
            if placer.piece is not None:
                pos, (x, y, z, w), *_ = placer.held_state()
                rows[first] = *pos, w, x, y, z
                first += 1
        return rows

    def follow_hoppers(self, radii: FloatArray) -> None:
        """Update the balls in the hoppers after a change of the storages' contents.

        Args:
            radii: Radii of all pieces, by slot [m].
        """
        for storage in self._hoppers:
            storage.follow([float(radii[slot]) for slot in storage.pieces])

    def advance_hoppers(self, gravity: float) -> list[str]:
        """Advance the balls in hoppers by the last tick, and return the names of the storages that jammed in this tick.

        Args:
            gravity: Gravitational acceleration, downward [m/s^2].
        """
        jammed: list[str] = []
        if not self._hoppers:
            return jammed
        before, now = self._before, self._motion
        ax, ay, az = ((v - u) / TICK for u, v in zip(before.vel, now.vel, strict=True))
        pull = rotate_back(now.quat, (-ax, -ay, -gravity - az))
        was, spin = rotate_back(before.quat, before.rate), rotate_back(now.quat, now.rate)
        turn = ((spin[0] - was[0]) / TICK, (spin[1] - was[1]) / TICK, (spin[2] - was[2]) / TICK)
        for storage in self._hoppers:
            assert storage.hopper is not None
            belt = storage.hopper.config.belt
            speed = 0.0 if belt is None else storage.hopper.config.belt_travel * self.mechanisms[belt].velocity
            if storage.hopper.advance(pull, spin, turn, speed):
                jammed.append(storage.config.name)
        return jammed

    def begin_tick(self) -> None:
        """Start a tick: record the robot's motion and the shooters' aims, and update the battery and the placers."""
        self._before = self._motion
        self.battery.begin_tick()
        for shooter in self.shooters:
            shooter.begin_tick()
        for placer in self.placers:
            placer.note_roller()

    @property
    def pose_before(self) -> tuple[Vector, Quaternion]:
        """Position [m] and attitude of the robot at the start of the last tick, field frame."""
        return self._before.pos, self._before.quat

    def motion_at(self, share: float) -> PartState:
        """Interpolate the motion of the robot's origin within the last tick, field frame.

        The position error of the linear interpolation is at most 0.5 mm at an acceleration of 10 m/s^2, or in a turn at
        2 m/s and 4 rad/s.

        Args:
            share: Fraction of the tick: 0 at the start, 1 at the end.
        """
        before, now = self._before, self._motion
        return PartState(
            _between(before.pos, now.pos, share),
            interpolate(before.quat, now.quat, share),
            _between(before.vel, now.vel, share),
            _between(before.rate, now.rate, share),
        )

    @property
    def _motion(self) -> PartState:
        c = self.chassis
        return PartState(c.pos, c.quat, c.origin_velocity, c.rate)

    def part_in_field(self, part: PartState) -> PartState:
        """Transform the pose and motion of a part from the robot frame to the field frame."""
        c = self.chassis
        lever = rotate(c.quat, part.pos)
        (lx, ly, lz), (wx, wy, wz) = lever, c.rate
        vx, vy, vz = rotate(c.quat, part.vel)
        ox, oy, oz = c.origin_velocity
        px, py, pz = rotate(c.quat, part.rate)
        return PartState(
            (c.pos[0] + lx, c.pos[1] + ly, c.pos[2] + lz),
            multiply(c.quat, part.quat),
            (ox + wy * lz - wz * ly + vx, oy + wz * lx - wx * lz + vy, oz + wx * ly - wy * lx + vz),
            (wx + px, wy + py, wz + pz),
        )


def _between(a: Vector, b: Vector, share: float) -> Vector:
    back = 1.0 - share
    return back * a[0] + share * b[0], back * a[1] + share * b[1], back * a[2] + share * b[2]


Controller: TypeAlias = Callable[[Robot, float], None]
"""Function that commands a robot, called once per tick with the robot and the simulated time [s]."""
