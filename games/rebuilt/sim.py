"""REBUILT in motion: one world, its robots, fuel and score, and the tick that moves them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from games.rebuilt.dimensions import FIELD_LENGTH, FIELD_WIDTH
from games.rebuilt.field import FIELD_SIZE, drivable, hub_exit, load_field, scoring_zones
from games.rebuilt.fuel import FUEL
from games.rebuilt.publish import build_snapshot
from games.rebuilt.robot import RebuiltRobot, RebuiltRobotConfig
from games.rebuilt.scene import scene_of
from games.rebuilt.scoring import MATCH, RebuiltScoring
from games.rebuilt.staging import Staging, depot_places, neutral_places
from games.rebuilt.vision import RebuiltVision, tag_layout
from simcore.errors import ConfigError
from simcore.geometry.rotation import rotate
from simcore.geometry.symmetry import turn_half, turn_half_pose
from simcore.match.digest import TrajectoryDigest
from simcore.match.report import FuelCount
from simcore.match.scoring import Alliance, ScoringTracker, ScoringZone
from simcore.physics.engine import Engine
from simcore.physics.substeps import Substepping, Surroundings
from simcore.physics.world import PhysicsWorld
from simcore.pieces.intake import field_to_robot
from simcore.pieces.launch import launch_state
from simcore.pieces.piece_manager import GamePieceManager
from simcore.pieces.pool import PieceStatus
from simcore.pieces.shooter import Launch
from simcore.pieces.wake_grid import Footprint, WakeSettings
from simcore.show.scene import Scene
from simcore.telemetry.snapshot import TelemetrySink
from simcore.typing import FloatArray
from simcore.units import GRAVITY
from simcore.vision.tag_layout import TagLayout

if TYPE_CHECKING:
    import ntcore

__all__ = ["RebuiltConfig", "RebuiltSim", "RobotCode", "RobotEntry", "ShotRecord"]

RobotCode = Callable[[RebuiltRobot, float], None]
"""What thinks for a robot: called once a tick with the robot and the simulated time [s]; it commands volts."""

DT = 0.02
"""Length of a tick [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotEntry:
    """One robot of a match."""

    alliance: Alliance = "blue"
    pose: tuple[float, float, float] = (2.5, 5.9, 0.0)
    """Start as a blue robot, field frame [m, m, rad]; a red one starts at the same place turned by 180 degrees."""
    preload: int = 8
    config: RebuiltRobotConfig = field(default_factory=RebuiltRobotConfig)


@dataclass(frozen=True, slots=True, kw_only=True)
class RebuiltConfig:
    """A match of REBUILT."""

    seed: int = 0
    """Of everything that is left to chance."""
    robots: tuple[RobotEntry, ...] = (RobotEntry(),)
    staging: Staging = field(default_factory=Staging)
    hub_exits: bool = False
    """Whether scored fuel comes out of the hub's exits into the neutral zone, as on the real field."""
    hubs_always_active: bool = False
    """For practice: every fuel counts, whatever the match clock says."""
    field_mesh: Path | None = None
    """An OBJ of the field; None: the one that comes with simcore."""
    tags: str | Path = "2026-welded"
    """AprilTag layout: a name, or a file in WPILib's JSON; read if a robot has cameras."""
    substepping: Substepping = field(default_factory=Substepping)
    proximity: WakeSettings = field(default_factory=WakeSettings)

    def __post_init__(self) -> None:
        if len(self.robots) > self.staging.robots:
            raise ConfigError(
                f"RebuiltConfig: {len(self.robots)} robots, but the staging counts preloads for {self.staging.robots}"
            )
        for entry in self.robots:
            if entry.alliance not in ("blue", "red"):
                raise ConfigError(f"RobotEntry: alliance must be 'blue' or 'red', got {entry.alliance!r}")
            if not 0 <= entry.preload <= self.staging.preload_per_robot:
                raise ConfigError(
                    f"RebuiltConfig: preload must be 0..{self.staging.preload_per_robot} fuel, got {entry.preload}"
                )


@dataclass(slots=True)
class ShotRecord:
    """One shot fuel, from the muzzle until it scored, or for 2 s and until it touched something."""

    time: float
    slot: int
    robot: int
    points: list[tuple[float, float, float]]
    """Its flight, a point a tick [m]."""
    scored: bool = False


class RebuiltSim:
    """A match of REBUILT. Use as a context manager, or call `close`.

    Args:
        config: Robots, fuel, seed.
        robot_code: What thinks for each robot, in their order; None: it stands.
        sinks: Who wants telemetry.
        engine: The physics engine; None makes one. It is closed with the simulation.
        network: NetworkTables on which cameras publish and listen; None: their frames are read from `vision` only.
    """

    def __init__(
        self,
        config: RebuiltConfig | None = None,
        *,
        robot_code: Sequence[RobotCode | None] = (),
        sinks: Sequence[TelemetrySink] = (),
        engine: Engine | None = None,
        network: ntcore.NetworkTableInstance | None = None,
    ) -> None:
        self.config = c = config or RebuiltConfig()
        if len(robot_code) > len(c.robots):
            raise ConfigError(f"RebuiltSim: {len(robot_code)} robot codes for {len(c.robots)} robots")
        rng = np.random.default_rng(c.seed)
        self.field = load_field(c.field_mesh)  # before the engine starts: a broken mesh ends the build
        self.world = PhysicsWorld(
            engine=engine,
            floor_size=(FIELD_LENGTH + 8.0, FIELD_WIDTH + 8.0),
            floor_center=(FIELD_LENGTH / 2, FIELD_WIDTH / 2),
            substepping=c.substepping,
        )
        try:
            self._build(c, rng)
            self.vision = RebuiltVision(self.world, self.pieces, self.robots, self._layout(), self._camera_rng, network)
        except BaseException:
            self.world.close()
            raise
        self._codes = list(robot_code) + [None] * (len(self.robots) - len(robot_code))
        self.alliances: list[Alliance] = [entry.alliance for entry in c.robots]
        """Of each robot, as last set."""
        self.sinks = list(sinks)
        self.time = 0.0
        """Simulated time since the start of auto [s]."""
        self._match_start = 0.0
        self.ticks = 0
        self.substeps = 0
        """Of the last tick."""
        self.last_tick_ms: float | None = None
        """Wall time of the last tick [ms], for telemetry, if whoever runs the simulation measures it."""
        self.digest = TrajectoryDigest()
        self.shots: list[ShotRecord] = []
        self.intakes: list[list[float]] = []
        """Where each fuel was taken in [m]."""
        self._flying: dict[int, ShotRecord] = {}
        self._movers: list[Footprint] = []
        self._piece_speed = 0.0
        self._near = Surroundings.OPEN
        self.phases: tuple[Callable[[], None], ...] = (
            self._read,
            self._power,
            self._wake,
            self._intake,
            self._move,
            self._gather,
            self._sense,
            self._see,
            self._settle,
            self._score,
            self._step_mechanisms,
            self._shoot,
            self._publish,
        )
        """One tick, read from top to bottom."""

    def __enter__(self) -> RebuiltSim:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close sinks and engine, each even if another fails; may be called twice."""
        with ExitStack() as stack:
            stack.callback(self.world.close)
            stack.callback(self.vision.close)
            for sink in self.sinks:
                stack.callback(sink.close)

    def set_alliance(self, number: int, alliance: Alliance) -> None:
        """Put a robot, at rest, where it starts as one of the alliance; its gyro does not notice being carried."""
        pose = self.config.robots[number].pose
        if alliance == "red":
            pose = turn_half_pose(*pose, FIELD_SIZE)
        self.alliances[number] = alliance
        robot = self.robots[number]
        robot.chassis.set_pose(*pose)
        robot.gyro.reset(yaw=robot.gyro.yaw, true_yaw=pose[2], time=self.time)
        robot.odometry.reset(pose, gyro_yaw=robot.gyro.yaw)

    def start_period(self, period: str) -> None:
        """Let the match clock follow a driver station that has just enabled `auto` or `teleop`."""
        self._match_start = self.time - MATCH.start("auto" if period == "auto" else "transition")
        if period == "auto":
            self.scoring.restart()

    @property
    def match_time(self) -> float:
        """Since the start of auto [s]: that of the simulation, or as the driver station has it."""
        return self.time - self._match_start

    @property
    def game_message(self) -> str:
        """What the field sends to robot code: `B` or `R`, whose hub is inactive first; empty before teleop."""
        return self.scoring.message(self.match_time)

    def set_robot_code(self, number: int, code: RobotCode | None) -> None:
        """Choose what thinks for a robot from the next tick on."""
        self._codes[number] = code

    def tick(self) -> None:
        """Advance by 20 ms."""
        for phase in self.phases:
            phase()

    # --- the same tick in parts -----------------------------------------------------------------------------------
    # Motor controllers close their loops a thousand times a second: volts that stand for 20 ms make a steer motor
    # overshoot by 18 %, for 5 ms by nothing. So that they can listen in between, phases 5, 7 and 10 can be cut.

    def begin_tick(self) -> None:
        """Phases 1 to 4. `move` follows, as often as it takes to fill the 20 ms, and `end_tick`."""
        self._read()
        self._power()
        self._wake()
        self._intake()
        self.substeps = 0
        self._near = self._surroundings(DT)

    def move(self, dt: float) -> None:
        """A part of the tick [s]: robots and fuel move, gyros see it, mechanisms turn."""
        self._power()
        self._advance(dt, max((robot.chassis.speed for robot in self.robots), default=0.0), self._near)
        for robot in self.robots:
            robot.chassis.read()
        self._sense(dt)
        self._step_mechanisms(dt)

    def end_tick(self) -> None:
        """What is left of phases 6 to 12."""
        self._count_tick()
        self._gather()
        self._see()
        self._settle()
        self._score()
        self._shoot()
        self._publish()

    def set_clock(self, now: float) -> None:
        """Tell cameras what NetworkTables' clock shows at the end of the present tick [s], so that stamps agree."""
        self.vision.clock.offset = now - (self.ticks + 1) * DT

    def piece_places(self) -> dict[str, FloatArray]:
        """Where the fuel on the field and in the air is, field frame [m], shape (n, 3): for a view of the field."""
        return {FUEL.name: self.pieces.state.pos[self.pieces.on_field()]}

    # --- questions ----------------------------------------------------------------------------------------------

    def scene(self) -> Scene:
        """What a picture shows beside telemetry, also after the end."""
        return scene_of(self)

    @property
    def fuel(self) -> FuelCount:
        """Where all fuel is."""
        count = self.pieces.count
        return FuelCount(
            staged=self._total_fuel,
            on_field=count(PieceStatus.ASLEEP) + count(PieceStatus.AWAKE),
            in_flight=count(PieceStatus.IN_FLIGHT),
            held=count(PieceStatus.HELD),
            scored=count(PieceStatus.SCORED),
            outside=count(PieceStatus.STAGED),
        )

    @property
    def flying(self) -> FloatArray:
        """Where the shots are that have not touched anything yet, oldest first, field frame [m], shape (n, 3)."""
        state = self.pieces.state
        slots = [slot for slot in self._flying if state.status[slot] == PieceStatus.IN_FLIGHT]
        return state.pos[slots]

    @property
    def hits(self) -> int:
        """Shots that scored."""
        return sum(shot.scored for shot in self.shots)

    # --- the phases of a tick -----------------------------------------------------------------------------------

    def _read(self) -> None:
        """1. Robot code looks at its robot and commands volts."""
        for robot, code in zip(self.robots, self._codes, strict=True):
            if code is not None:
                code(robot, self.time)
        self.vision.listen(self.time)

    def _power(self) -> None:
        """2. Batteries feel the mechanisms' currents; each is stepped with the drivetrain, and its brown-out acts."""
        for robot in self.robots:
            robot.drive.other_current = robot.mechanism_current

    def _wake(self) -> None:
        """3. Sleepers that can be reached within the tick wake."""
        self._movers = [Footprint(*robot.chassis.footprint) for robot in self.robots]
        self._piece_speed = self.pieces.wake_reachable(self._movers, DT)

    def _intake(self) -> None:
        """4. Active intakes take what is in their zone; before the step, so that a fresh shot is not eaten again."""
        for robot in self.robots:
            room = robot.config.hopper_capacity - len(self.pieces.held(robot.number))
            if room <= 0 or not robot.intake_active:
                continue
            slots = self.pieces.in_active_chunks  # sleepers too: a roller does not ask
            away = self.pieces.state.pos[slots] - robot.chassis.pos
            slots = slots[np.einsum("ij,ij->i", away, away) < robot.intake_reach**2]
            if not len(slots):
                continue
            pos_robot = field_to_robot(
                self.pieces.state.pos[slots], np.array(robot.chassis.pos), np.array(robot.chassis.quat)
            )
            inside = robot.intake_zone().contains(pos_robot)
            inside &= self.pieces.state.status[slots] != PieceStatus.IN_FLIGHT
            if inside.any():
                taken = slots[inside][:room]
                self.intakes += self.pieces.state.pos[taken].tolist()
                self.pieces.hold(taken, robot.number)

    def _move(self) -> None:
        """5. Sub-steps: tires push robots, air pushes fuel, the engine does the rest."""
        self.substeps = 0
        self._advance(DT, max((mover.speed for mover in self._movers), default=0.0), self._surroundings(DT))
        self._count_tick()

    def _surroundings(self, dt: float) -> Surroundings:
        """The most awkward that a robot could meet within dt [s]."""
        return max((robot.chassis.surroundings(dt) for robot in self.robots), default=Surroundings.OPEN)

    def _advance(self, dt: float, speed: float, near: Surroundings) -> None:
        substeps = self.world.substepping.count(dt, self._piece_speed, speed, near)
        self.world.step(dt, substeps=substeps, before_substep=self._before_substep)
        self.substeps += substeps

    def _count_tick(self) -> None:
        self.ticks += 1
        self.time = self.ticks * DT

    def _before_substep(self, h: float) -> None:
        for robot in self.robots:
            robot.chassis.before_substep(h)
        self.pieces.before_substep(h)

    def _gather(self) -> None:
        """6. Poses and velocities out of the engine, once; pieces outside the field come back."""
        for robot in self.robots:
            robot.chassis.read()
        self.pieces.gather(DT)
        for slot, shot in list(self._flying.items()):
            shot.points.append(tuple(self.pieces.state.pos[slot].tolist()))
            if self.pieces.state.status[slot] != PieceStatus.IN_FLIGHT and len(shot.points) > 100:
                del self._flying[slot]

    def _sense(self, dt: float = DT) -> None:
        """7. Gyros and odometry see the motion; encoders saw it in the sub-steps."""
        for robot in self.robots:
            robot.sense(dt)

    def _see(self) -> None:
        """7, with the fuel where it is now. Cameras expose the frames that are due and publish those that are ready."""
        self.vision.look(self.time)

    def _settle(self) -> None:
        """8. Fuel that has been slow for a while sleeps."""
        self.pieces.settle()

    def _score(self) -> None:
        """9. Fuel that went through a hub's throat scores."""
        state, slots = self.pieces.state, self.pieces.awake
        events = self.tracker.update(self.time, slots, state.before[slots], state.pos[slots])
        if not events:
            return
        for event in events:
            shot = self._flying.pop(event.slot, None)
            if shot is not None:
                shot.scored = True
        scored = np.array([event.slot for event in events])
        self.pieces.score(scored)
        if self.config.hub_exits:
            for event in events:
                slot = np.array([event.slot])
                pos, vel = hub_exit(event.alliance, self._exit_rng)
                self.pieces.release(slot, pos[None, :])
                self.pieces.push(slot, vel[None, :], flying=True)

    def _step_mechanisms(self, dt: float = DT) -> None:
        """10. Wheels, hood, feeder, spindexer, rack and roller turn."""
        for robot in self.robots:
            if robot.steps_own_mechanisms:
                robot.step_mechanisms(dt)

    def _shoot(self) -> None:
        """11. Fuel leaves the barrels of shooters whose gate is open."""
        for robot in self.robots:
            for launch in robot.shooter.update(DT, len(self.pieces.held(robot.number))):
                self._launch(robot, launch)

    def _launch(self, robot: RebuiltRobot, launch: Launch) -> None:
        chassis = robot.chassis
        pos, velocity = launch_state(
            robot.config.launch,
            elevation=launch.elevation,
            speed=launch.speed,
            robot_pos=np.array(chassis.pos),
            robot_rotation=np.array(chassis.quat),
            robot_velocity=np.array(chassis.origin_velocity),
            robot_spin=np.array(chassis.rate),
            barrel=launch.barrel,
        )
        flown = DT - launch.delay  # it left in the course of the tick
        pos = pos + velocity * flown - (0.0, 0.0, 0.5 * GRAVITY * flown * flown)
        velocity = velocity - (0.0, 0.0, GRAVITY * flown)
        # a fuel that rolls along the hood leaves with backspin: its rim speed there equals its own speed
        spin = rotate(chassis.quat, (0.0, -launch.speed / FUEL.bounding_radius, 0.0))
        slot = self.pieces.launch(robot.number, pos.tolist(), velocity.tolist(), spin)
        robot.after_shot(FUEL.mass, launch.speed)
        shot = ShotRecord(self.time, slot, robot.number, [tuple(pos.tolist())])
        self.shots.append(shot)
        self._flying[slot] = shot

    def _publish(self) -> None:
        """12. One snapshot for the sinks that are due, and the digest of the state."""
        state = self.pieces.state
        awake = self.pieces.awake
        for robot in self.robots:
            self.digest.update(np.array((*robot.chassis.pos, *robot.chassis.quat, *robot.chassis.vel)))
        self.digest.update(state.pos[awake], state.status.astype(np.int64))
        due = [sink for sink in self.sinks if sink.due(self.time)]
        if due:
            snapshot = build_snapshot(self)
            for sink in due:
                sink.write(snapshot)

    def _require_free_starts(self) -> None:
        """Refuse robots that start inside of each other or of a solid element."""
        for robot in self.robots:
            (x, y, _), c = robot.chassis.pose, robot.chassis.config
            half = 0.5 * min(c.bumper_length, c.bumper_width)
            for other in self.robots[: robot.number]:
                ox, oy, _ = other.chassis.pose
                reach = half + 0.5 * min(other.chassis.config.bumper_length, other.chassis.config.bumper_width)
                if np.hypot(ox - x, oy - y) < 0.99 * reach:
                    raise ConfigError(
                        f"robots {other.number} and {robot.number} start inside of each other, at ({ox:.2f}, {oy:.2f}) "
                        f"and ({x:.2f}, {y:.2f}) m; give their RobotEntry other poses"
                    )
        for robot in self.robots:
            (x, y, _), c = robot.chassis.pose, robot.chassis.config
            inner = 0.25 * min(c.bumper_length, c.bumper_width)
            low, high = (x - inner, y - inner, c.clearance), (x + inner, y + inner, c.bumper_top)
            if self.world.surroundings(robot.chassis.row, low, high) is Surroundings.WALL:
                raise ConfigError(
                    f"robot {robot.number} starts inside of a field element, at ({x:.2f}, {y:.2f}) m; "
                    "give its RobotEntry another pose"
                )

    def _worth(self, zone: ScoringZone, time: float) -> int:
        return self.scoring.worth(zone, time - self._match_start)

    # --- building -----------------------------------------------------------------------------------------------

    def _layout(self) -> TagLayout:
        """The tags; without cameras nobody needs them."""
        if any(robot.config.cameras for robot in self.robots):
            return tag_layout(self.config.tags)
        return TagLayout.of([], field_size=FIELD_SIZE)

    def _build(self, c: RebuiltConfig, rng: np.random.Generator) -> None:
        self.world.add_field(self.field.elements, drivable=drivable(self.field))
        self._total_fuel = c.staging.total
        self.pieces = GamePieceManager(
            self.world,
            [(FUEL, self._total_fuel)],
            field_size=FIELD_SIZE,
            wake=c.proximity,
        )
        self._exit_rng, robot_rng, fuel_rng, self._camera_rng = rng.spawn(4)
        preloaded = sum(entry.preload for entry in c.robots)
        missing = c.staging.preload_per_robot * len(c.robots) - preloaded  # preloads left out go to the neutral zone
        neutral = c.staging.in_neutral_zone(len(c.robots)) + missing
        # Placed as the first robot's alliance sees the field, so that a red match is a blue one turned by 180 degrees.
        places = [neutral_places(neutral, fuel_rng)]
        places += [depot_places(alliance, c.staging.depot, fuel_rng) for alliance in ("blue", "red")]
        is_turned = bool(c.robots) and c.robots[0].alliance == "red"
        for some in places:
            self.pieces.spawn(FUEL.name, turn_half(some, FIELD_SIZE) if is_turned else some)
        self.pieces.stage(FUEL.name, 2 * c.staging.chute)
        self.robots: list[RebuiltRobot] = []
        own_rngs = robot_rng.spawn(len(c.robots))  # one robot's noise does not depend on how many there are
        for number, (entry, own_rng) in enumerate(zip(c.robots, own_rngs, strict=True)):
            pose = entry.pose
            if entry.alliance == "red":
                pose = turn_half_pose(*pose, FIELD_SIZE)
            robot = entry.config.build(self.world, number=number, pose=pose, rng=own_rng)
            self.robots.append(robot)
            self.pieces.hold(self.pieces.stage(FUEL.name, entry.preload), number)
        self._require_free_starts()
        self.scoring = RebuiltScoring(rng, favorite="red" if is_turned else "blue", always_active=c.hubs_always_active)
        self.tracker = ScoringTracker(scoring_zones(), worth=self._worth)
        self.match = MATCH
