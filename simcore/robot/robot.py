"""A robot in the world: body, drivetrain, battery, sensors, mechanisms, and what it does with pieces."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol, TypeAlias

import numpy as np

from simcore.errors import UnknownNameError
from simcore.geometry.linkage import PartState, part_pose
from simcore.geometry.rotation import Quaternion, Vector, interpolate, multiply, rotate, rotate_back, wrap_angle
from simcore.geometry.symmetry import Pose
from simcore.physics.hanging import HangingBody
from simcore.physics.world import PhysicsWorld
from simcore.pieces.intake import Intake, IntakeConfig
from simcore.pieces.placer import Placer, PlacerConfig
from simcore.pieces.shooter import Shooter, ShooterConfig
from simcore.pieces.storage import Storage
from simcore.robot.battery import Battery, BrownoutLog
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.climber import Climber, Rung
from simcore.robot.gyro import Gyro
from simcore.robot.mass_balance import MassBalance
from simcore.robot.odometry import SwerveOdometry
from simcore.robot.robot_config import BuiltRobot, RobotConfig, build_drivetrain, build_mechanism
from simcore.robot.shaft import ShaftSim
from simcore.typing import FloatArray, IntArray
from simcore.units import TICK

__all__ = ["Controller", "Robot", "RobotDevices"]


class NamedMechanisms(dict[str, ShaftSim]):
    """Mechanisms by name, which say what names there are where one is asked for that is not."""

    def __missing__(self, name: str) -> ShaftSim:
        raise UnknownNameError("mechanism", name, self)


class RobotDevices(Protocol):
    """Motor controllers and sensors of robot code that drives a robot."""

    def step(self, h: float, yaw_rate: float) -> None:
        """Before mechanisms and drivetrain move for h [s]: supply voltage to the controllers, their answer to both.

        Args:
            h: Time to come, at most 5 ms [s].
            yaw_rate: Of the robot as its tires leave it [rad/s].
        """
        ...

    def write(self) -> None:
        """After a part of a tick: what the sensors show."""
        ...


class Robot:
    """One robot; several in one world share nothing but the world.

    Args:
        world: Where it stands.
        config: What it is built of.
        rng: For the noise of its sensors.
        number: Its place in the list of robots; also the holder of its pieces.
        pose: Start, field frame [m, m, rad].
        rungs: What its climbers can hang on.
        mounts: Hanging bodies that rungs are parts of, by name.
        built: What it really is, where that is not what the config says; None: it is.
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
        """What it was designed to be, and robot code believes."""
        self.number = number
        self.battery = Battery(built.battery)
        drivetrain = config.drivetrain
        self.drive = build_drivetrain(drivetrain, battery=self.battery, built=built.drivetrain)
        self.mechanisms = NamedMechanisms({name: build_mechanism(c) for name, c in built.mechanisms.items()})
        """By name, in the order in which they are stepped."""
        self.chassis = ChassisSimulation(
            *(world, config.body),
            pose=pose,
            drivetrain=self.drive,
            mechanisms=tuple(self.mechanisms.values()),
            name=f"robot {number}",
            mass=config.whole,
        )
        self.gyro = Gyro(built.gyro, rng)
        self.odometry = SwerveOdometry(drivetrain.positions)
        self.intakes = [Intake(c, self.mechanisms) for c in config.intakes]
        self.storage = Storage(config.storage)
        """The first of its storages."""
        self._storages = {"": self.storage, config.storage.name: self.storage}
        self._storages |= {c.name: Storage(c) for c in config.more_storages}
        self._hoppers = [storage for storage in self.storages if storage.hopper is not None]
        self.shooters = [
            Shooter(c, self.mechanisms, errors) for c, errors in zip(config.shooters, built.shot_errors, strict=True)
        ]
        self.placers = [Placer(c, self.mechanisms) for c in config.placers]
        self.climbers = [Climber(c, self.mechanisms, self.chassis, rungs, mounts or {}) for c in config.climbers]
        self.balance = MassBalance(
            *(config.bare_body, config.moving_masses, self.mechanisms, self.storages, self.placers, self.chassis)
        )
        """What it weighs with what it holds and as its mechanisms stand."""
        self.devices: RobotDevices | None = None
        self.sensor_states: dict[str, bool] = {}
        """Whether each switch and beam break of robot code sees something, by name; for telemetry."""
        self.light_colors: dict[str, IntArray] = {}
        """What robot code's lights show, by their name: 0xRRGGBB of each LED, shape (n,); for telemetry."""
        self.light_requests: dict[str, str] = {}
        """The same in words, of those that have them."""
        self.brownouts = BrownoutLog(number, self.battery, self._consumers)
        """Tells of brown-outs."""
        self.setpoints: dict[str, float] = {}
        """What a closed loop wants of a mechanism, by its telemetry name and quantity, e.g. `HoodPositionRot`."""
        self.estimated_pose: tuple[float, float, float] | None = None
        """Where robot code's drivetrain believes to be, field frame [m, m, rad]; None: `odometry` stands for it."""
        self.require_place: Callable[[Pose], object] | None = None
        """Called before it is put somewhere; raises where it cannot stand. Its match sets it."""
        self.on_put: Callable[[str], object] | None = None
        """Called after it was put somewhere, with `carried` or `reset`."""
        self._estimated: list[ShaftSim] = []
        self._is_carried = False  # whether a climber was near a rung in the last sub-step
        self._before: PartState
        self._start: tuple[Pose, Pose] | None = None  # where it was put and where it was meant to be
        self.reset(pose)

    # --- sensors and drivetrain ---------------------------------------------------------------------------------

    def reset(self, pose: Pose, *, believed: Pose | None = None) -> None:
        """Put the robot somewhere at rest; truth, gyro and odometry agree again.

        Robot code that only wants to believe something else calls `odometry.reset`; the robot then stays where it is.

        Args:
            pose: Where, field frame [m, m, rad].
            believed: Where people meant to put it, and gyro and odometry therefore believe it to be; None: there.

        Raises:
            NonFiniteError: The pose is not finite; nothing has changed.
            StartError: It cannot stand there; nothing has changed.
        """
        if self.require_place is not None:
            self.require_place(pose)
        self.chassis.set_pose(*pose)
        self.drive.reset()
        self._note_put(pose, believed, (pose if believed is None else believed)[2], "reset")

    def carry_to(self, pose: Pose, *, believed: Pose | None = None) -> None:
        """Put the robot somewhere at rest while its gyro keeps its reading, as when a team carries it.

        Args:
            pose: Where, field frame [m, m, rad].
            believed: Where people meant to put it, and odometry therefore believes it to be; None: there.

        Raises:
            StartError: It cannot stand there; nothing has changed.
        """
        if self.require_place is not None:
            self.require_place(pose)
        self.put(pose, believed=believed)

    def put(self, pose: Pose, *, believed: Pose | None) -> None:
        """As `carry_to`, to a place that is known to be free."""
        self.chassis.set_pose(*pose)
        self._note_put(pose, believed, self.gyro.yaw, "carried")

    def _note_put(self, pose: Pose, believed: Pose | None, yaw: float, reason: str) -> None:
        """Let sensors follow, with a gyro that reads `yaw` [rad]."""
        self.gyro.reset(yaw=yaw, true_yaw=pose[2])
        self.odometry.reset(pose if believed is None else believed, gyro_yaw=yaw)
        self._start = None if believed is None else (pose, believed)
        self._before = self._motion
        if self.on_put is not None:
            self.on_put(reason)

    @property
    def believed_pose(self) -> Pose:
        """Where its program believes to be, or its own odometry if that is not known, field frame [m, m, rad]."""
        return self.estimated_pose or self.odometry.pose

    @property
    def reckoned_pose(self) -> Pose:
        """Where a program that measures its way without an error believes it to be, field frame [m, m, rad].

        That is where it is, unless people have put it elsewhere than they meant.
        """
        pose = self.chassis.pose
        if self._start is None:
            return pose
        (tx, ty, t_yaw), (bx, by, b_yaw) = self._start
        turn = b_yaw - t_yaw
        c, s, dx, dy = math.cos(turn), math.sin(turn), pose[0] - tx, pose[1] - ty
        return bx + c * dx - s * dy, by + s * dx + c * dy, wrap_angle(pose[2] + turn)

    def sense(self, dt: float) -> None:
        """Let gyro and odometry follow what happened in the last dt [s], and devices show it."""
        self.chassis.read()
        roll, pitch, yaw = self.chassis.roll_pitch_yaw
        self.gyro.step(dt, yaw, pitch, roll, self.chassis.robot_rate)
        self.odometry.update(self.drive.wheel_distances(), self.drive.wheel_angles(), self.gyro.yaw)
        if self.devices is not None:
            self.devices.write()

    def connect(self, devices: RobotDevices) -> None:
        """Let robot code's devices drive this robot from the next part of a tick on."""
        self.devices = devices

    def before_step(self, h: float) -> None:
        """Before a step of h [s]: climbers that hang carry it, and the controllers of robot code look and answer."""
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
            self.chassis.read()  # a stiff hook must not push against where the robot was a step ago
            force, torque = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
            for climber in near:
                (fx, fy, fz), (tx, ty, tz) = climber.push(h)
                force = (force[0] + fx, force[1] + fy, force[2] + fz)
                torque = (torque[0] + tx, torque[1] + ty, torque[2] + tz)
            self.chassis.apply_forces(force, torque)
        self._is_carried = bool(near)

    # --- mechanisms -----------------------------------------------------------------------------------------------

    def add_estimated_mechanism(self, mechanism: ShaftSim) -> None:
        """Step one more with the others. Its figures are estimates, so it takes no current from the battery."""
        self._estimated.append(mechanism)

    def remove_estimated_mechanism(self, mechanism: ShaftSim) -> None:
        """Step a mechanism no more that `add_estimated_mechanism` added."""
        self._estimated.remove(mechanism)

    def _consumers(self) -> dict[str, float]:
        """What each mechanism and the drive took from the battery as the last brown-out began [A]."""
        drawn = {name: float(mechanism.record["noted_supply"][0]) for name, mechanism in self.mechanisms.items()}
        return drawn | {"drive": float(self.drive.shafts["noted_supply"].sum())}

    # --- pieces ---------------------------------------------------------------------------------------------------

    @property
    def held(self) -> list[int]:
        """Slots of the pieces in it: of each storage in the order in which they came, then those of placers."""
        stored = [slot for storage in self.storages for slot in storage.pieces]
        return stored + [placer.piece for placer in self.placers if placer.piece is not None]

    @property
    def storages(self) -> list[Storage]:
        """All of them, the first one first."""
        return list(dict.fromkeys(self._storages.values()))

    def storage_of(self, part: IntakeConfig | ShooterConfig | PlacerConfig) -> Storage:
        """The storage that an intake, shooter or placer works with."""
        return self._storages[part.storage]

    def forget_pieces(self) -> None:
        """Hold none any more, as when the field is reset."""
        for storage in self.storages:
            storage.clear()
        for placer in self.placers:
            placer.piece = None

    def forget_piece(self, slot: int) -> None:
        """Hold a piece no more that was taken out by hand."""
        for storage in self.storages:
            if slot in storage.pieces:
                storage.pieces.remove(slot)
        for placer in self.placers:
            if placer.piece == slot:
                placer.piece = None

    def held_pose(self, slot: int, radius: float) -> tuple[Vector, Quaternion]:
        """Where a piece that it holds is, robot frame [m].

        Args:
            slot: Of the piece.
            radius: Bounding radius of the piece [m].
        """
        for placer in self.placers:
            if placer.piece == slot:
                state = placer.held_state()
                return state.pos, state.quat
        storage = next(storage for storage in self.storages if slot in storage.pieces)
        return storage.place(storage.pieces.index(slot), radius), storage.config.attitude

    def follow_hoppers(self, radii: FloatArray) -> None:
        """Let hoppers hold what has been put into them; `radii` are of all pieces, by slot [m]."""
        for storage in self._hoppers:
            storage.follow([float(radii[slot]) for slot in storage.pieces])

    def advance_hoppers(self, gravity: float) -> list[str]:
        """Let the pieces in hoppers move as the robot did in the tick that ends now; whose outlets have just jammed.

        Args:
            gravity: Downward [m/s^2].
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
        """Note how the robot moves and aims as a tick begins; intakes have looked at the last tick."""
        self._before = self._motion
        self.battery.begin_tick()
        for shooter in self.shooters:
            shooter.begin_tick()
        for placer in self.placers:
            placer.note_roller()

    @property
    def pose_before(self) -> tuple[Vector, Quaternion]:
        """Pose of the robot as the last tick began, field frame."""
        return self._before.pos, self._before.quat

    def motion_at(self, share: float) -> PartState:
        """Pose and velocity of its origin at an instant of the last tick, field frame.

        Linear between the tick's ends: within 0.5 mm at 10 m/s^2, or at 2 m/s and 4 rad/s.

        Args:
            share: 0 as the tick began, 1 at its end.
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
        """Pose and motion of a part in the field frame, from those in the robot frame."""
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

    # --- questions ------------------------------------------------------------------------------------------------

    def component_poses(self) -> FloatArray:
        """Pose rows `x, y, z, qw, qx, qy, qz` of its components in the robot frame, shape (n, 7)."""
        rows = np.empty((len(self.config.components), 7))
        for number, component in enumerate(self.config.components):
            pos, (x, y, z, w) = part_pose(component.joints, self.mechanisms, component.offset)
            rows[number] = (*pos, w, x, y, z)
        rows.setflags(write=False)
        return rows


def _between(a: Vector, b: Vector, share: float) -> Vector:
    back = 1.0 - share
    return back * a[0] + share * b[0], back * a[1] + share * b[1], back * a[2] + share * b[2]


Controller: TypeAlias = Callable[[Robot, float], None]
"""Commands a robot: called once a tick with the robot and the simulated time [s]; sets volts."""
