"""The state of a match: what is played, what a run builds and changes, and the questions that it answers.

Rules, autos, telemetry and views see a match as this. `Match` adds the tick and what people do.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path

import numpy as np

from simcore.errors import ConfigError
from simcore.geometry.footprints import corners
from simcore.geometry.symmetry import Pose
from simcore.match.camera_rig import CameraRig, tag_layout
from simcore.match.clock import MatchTimer, Mode
from simcore.match.digest import TrajectoryDigest
from simcore.match.game import Game, RobotEntry, Rules
from simcore.match.motion import Motion
from simcore.match.piece_flow import PieceFlow
from simcore.match.report import PieceCount, Score
from simcore.match.robot_contacts import RobotContacts, StructureRecoil
from simcore.match.run_record import RunRecord
from simcore.match.scatter import Scatter, ScatterDraws, piece_variation
from simcore.match.scattered_robot import built_robot, start_error
from simcore.match.scoring import Alliance, ScoringTracker
from simcore.match.starts import BeliefCheck, missed_place, require_free_place, require_free_starts
from simcore.physics.field import FieldGeometry
from simcore.physics.hanging import HangingBody, HangingConfig
from simcore.physics.world import PhysicsWorld
from simcore.pieces.piece_manager import Footprint, GamePieceManager
from simcore.quantities import POSE, require_row, shown
from simcore.robot.climber import Rung
from simcore.robot.robot import Robot
from simcore.season import NetworkTables
from simcore.typing import FloatArray
from simcore.units import TICK

__all__ = ["MatchState"]

_COUNT_PERIOD = 5  # ticks


class MatchState:
    """All state of a match, whose runs are built one after the other in the same world."""

    # --- of all runs ----------------------------------------------------------------------------------------------

    game: Game
    entries: tuple[RobotEntry, ...]
    options: frozenset[str]
    """Names of the game's options that are on."""
    practice: bool
    """Every piece counts, whatever the clock says."""
    scatter: Scatter
    """By how much things differ from run to run."""
    last_tick_ms: float | None
    """Wall time of the last tick [ms], for telemetry, if whoever runs the match measures it."""
    world: PhysicsWorld
    field: FieldGeometry
    _rungs: tuple[Rung, ...]
    _hanging: tuple[HangingConfig, ...]
    _network: NetworkTables | None
    _tags: str | Path
    _never_sleep: bool

    # --- of one run -----------------------------------------------------------------------------------------------

    time: float
    """Simulated time since the start [s]."""
    ticks: int
    """Ticks since the start."""
    seed: int
    """Of everything that is left to chance."""
    draws: ScatterDraws
    """What the scatter of this run comes to."""
    persons: dict[Alliance, dict[str, float]]
    """Alliances whose human player a person plays, and what they have asked for, with until when [s]."""
    field_resets: int
    """How often `reset_field` was called since the start."""
    timer: MatchTimer
    """The time of the match, for scores and rules."""
    pieces: GamePieceManager
    hanging: list[HangingBody]
    """What hangs from the field and swings."""
    contacts: RobotContacts
    """Who touched whom in this tick."""
    recoil: StructureRecoil
    """What hits on the field do to the pieces on it."""
    motion: Motion
    """Devices, mechanisms, drivetrains, flights, engine and sensors: everything that moves, and its loop."""
    flow: PieceFlow
    """Pieces into robots and out of them."""
    record: RunRecord
    """What has happened so far."""
    robots: list[Robot]
    alliances: list[Alliance]
    """Of each robot, as last set."""
    tracker: ScoringTracker
    rules: Rules
    rules_rng: np.random.Generator
    """For what the rules leave to chance."""
    cameras: CameraRig
    beliefs: BeliefCheck
    """Compares where robots are with where they believe to be, as an auto begins."""
    digest: TrajectoryDigest
    """Of the state of every tick so far."""
    _counted: tuple[int, Score] | None
    """When `score_counts` was worked out, and at which points; None: not since the start."""
    _counts: Mapping[str, int]
    _has_ended: bool
    _has_told: bool
    _started: Mode | None
    """Which mode a driver station has enabled last; None: there is none."""

    # --- questions ------------------------------------------------------------------------------------------------

    @property
    def substeps(self) -> int:
        """Steps of the engine in the last tick."""
        return self.motion.substeps

    @property
    def score(self) -> Score:
        """Points so far."""
        red, blue = self.tracker.totals["red"], self.tracker.totals["blue"]
        return Score(red=red, blue=blue, total=red + blue)

    @property
    def score_counts(self) -> Mapping[str, int]:
        """Pieces that scored, by zone, and the rules' breakdown, as telemetry shows them.

        They are counted every 0.1 s, and when points change: in most ticks nothing has.
        """
        now = self.ticks // _COUNT_PERIOD, self.score
        if now != self._counted:
            self._counted, self._counts = now, {**self.tracker.pieces, **self.rules.breakdown()}
        return self._counts

    @property
    def count(self) -> PieceCount:
        """Where all pieces are."""
        return PieceCount.of(self.pieces)

    def piece_positions(self) -> dict[str, FloatArray]:
        """Where the pieces on the field and in the air are, by kind, field frame [m], shape (n, 3)."""
        return {kind.name: self.pieces.state.pos[self.pieces.on_field(kind.name)] for kind in self.pieces.types}

    def start_pose(self, number: int) -> Pose:
        """Where a robot should start as one of its present alliance, field frame [m, m, rad].

        Raises:
            ConfigError: Its entry names no start, and the game has none left.
        """
        self.require_robot(number)
        game, entry = self.game, self.entries[number]
        pose = entry.start
        if pose is None:
            before = [other.alliance for other in self.entries[:number]].count(entry.alliance)
            if before >= len(game.starts):
                raise ConfigError(
                    f"{game.name} has {len(game.starts)} starts an alliance; "
                    f"give the RobotEntry of robot {number} a start"
                )
            pose = game.starts[before]
        return game.field.symmetry.flip_pose(*pose) if self.alliances[number] == "red" else pose

    def require_robot(self, number: int) -> None:
        """Refuse the number of a robot that there is not."""
        if type(number) is not int or number not in range(len(self.entries)):
            raise ConfigError(f"there are robots 0 to {len(self.entries) - 1}, got {shown(number)}")

    def outline(self, number: int) -> FloatArray:
        """Corners of a robot's bumpers, as those of a blue robot if its alliance is red [m], shape (4, 2)."""
        body, pose = self.robots[number].chassis.config, self.robots[number].chassis.pose
        if self.alliances[number] == "red":
            pose = self.game.field.symmetry.flip_pose(*pose)
        return corners(*pose, body.bumper_length, body.bumper_width)

    # --- building -------------------------------------------------------------------------------------------------

    def _begin(self, seed: int) -> None:
        """Build everything that a run changes, in an empty world."""
        game, self.seed = self.game, seed
        self.draws = ScatterDraws(self.scatter, seed)
        self.rules_rng, robot_rng, staging_rng, camera_rng = np.random.default_rng(seed).spawn(4)
        self.time, self.ticks, self.field_resets = 0.0, 0, 0
        self.persons = {}
        self.timer = MatchTimer(game.clock)
        self.digest = TrajectoryDigest()
        self._started = None
        self._has_told = False
        self.alliances = [entry.alliance for entry in self.entries]
        self.world.add_field(self.field.elements, drivable=game.field.drivable_in(self.field))
        self.hanging = [HangingBody(self.world, config) for config in self._hanging]
        supplies = [(supply.kind, supply.count) for supply in game.pieces]
        self.pieces = GamePieceManager(
            self.world,
            supplies,
            field_size=game.field.size,
            never_sleep=self._never_sleep,
            places=game.places,
            variation=piece_variation(self.draws, [count for _, count in supplies]) if self._is_scattered else None,
        )
        self._stage(staging_rng)
        self.robots = []
        for number, own_rng in enumerate(robot_rng.spawn(len(self.entries))):
            self._add_robot(number, own_rng)  # whose noise does not depend on how many there are
        self.pieces.on_taken = [robot.forget_piece for robot in self.robots]
        require_free_starts(self.world, self.robots, game.field, self.alliances)
        for robot in self.robots:
            pose = self.start_pose(robot.number)
            missed = self._missed(robot.number, pose)
            if missed is not None:
                robot.reset(missed, believed=pose)
        self.record = RunRecord(self.pieces, self.robots, TICK)
        for robot in self.robots:
            robot.require_place = partial(self._require_place, robot.number)
            robot.on_put = partial(self._note_put, robot.number)
        self._make_room()
        self.contacts = RobotContacts(self.world, self.robots, self.pieces, self.hanging, self.field.elements)
        self.recoil = StructureRecoil(self.world, self.field.elements, game.field.structures, self.pieces, self.robots)
        self.motion = Motion(
            self.world,
            robots=self.robots,
            pieces=self.pieces,
            hanging=self.hanging,
            watchers=(self.contacts, self.recoil),
        )
        self.flow = PieceFlow(self.world, self.pieces, self.robots, self.record)
        kinds = [game.pieces[kind].kind.name for kind in self.pieces.state.kind.tolist()]
        self.tracker = ScoringTracker(game.zones, worth=lambda zone: self.rules.worth(zone), kinds=kinds)
        self.beliefs = BeliefCheck(self.robots)
        self.cameras = CameraRig(
            self.world,
            self.pieces,
            self.robots,
            partial(tag_layout, self._tags, game.field.size),
            game.field.size,
            camera_rng,
            self.draws,
            self._network,
        )
        self._begin_rules()

    def _update_digest(self) -> None:
        """Feed the digest with all that moves, and every 0.1 s with the points."""
        for robot in self.robots:
            self.digest.update(np.array((*robot.chassis.pos, *robot.chassis.quat, *robot.chassis.vel)))
        for body in self.hanging:
            if body.is_awake:
                self.digest.update(np.array((*body.pos, *body.rate)))
        state, awake = self.pieces.state, self.pieces.awake
        self.digest.update(state.pos.take(awake, axis=0), state.status)
        if self.ticks % _COUNT_PERIOD == 0:
            self.digest.update(np.array([*self.tracker.totals.values(), *self.rules.breakdown().values()]))

    @property
    def _is_scattered(self) -> bool:
        return self.scatter != Scatter.none()

    def _add_robot(self, number: int, rng: np.random.Generator) -> None:
        config = self.entries[number].config or self.game.robot()
        robot = Robot(
            self.world,
            config,
            number=number,
            pose=self.start_pose(number),
            rng=rng,
            rungs=self._rungs,
            mounts={body.config.name: body for body in self.hanging},
            built=built_robot(config, self.draws, number) if self._is_scattered else None,
        )
        self.robots.append(robot)
        self._preload(robot)

    def _stage(self, rng: np.random.Generator) -> None:
        """Put pieces where they start, as the first robot's alliance sees the field.

        So a red match is a blue one under the field's symmetry.
        """
        symmetry = self.game.field.symmetry if self.entries[0].alliance == "red" else None
        for some in self.game.staging(rng, self.entries):
            positions = np.asarray(some.positions, dtype=np.float64).reshape(-1, 3)
            attitudes = some.attitudes
            if symmetry is not None:
                positions = symmetry.flip_points(positions)
                attitudes = None if attitudes is None else symmetry.flip_attitudes(attitudes)
            if len(positions):
                self.pieces.spawn(some.kind, positions, attitudes, resting=some.resting, lodged=some.lodged)
            self.pieces.stage(some.kind, some.off_field)

    def _preload(self, robot: Robot) -> None:
        count = self.entries[robot.number].preload
        if count is None:
            count = min(self.game.preload, robot.storage.room)
        if count:
            if count > robot.storage.room:
                raise ConfigError(f"robot {robot.number} holds {robot.storage.room} pieces, got a preload of {count}")
            slots = self.pieces.stage(self.game.pieces[0].kind.name, count)
            self.pieces.hold(slots, robot.number)
            robot.storage.add(slots.tolist())

    def _make_room(self) -> None:
        """Pieces that are where robots are move aside."""
        self.pieces.make_room([Footprint(*robot.chassis.footprint) for robot in self.robots])

    def _require_place(self, number: int, pose: Pose) -> None:
        """Refuse a place where a robot cannot stand."""
        require_row(f"robot {number}", "pose", pose, POSE)
        require_free_place(self.world, self.robots[number], pose, self.game.field.size, others=self.robots)

    def _note_put(self, number: int, reason: str) -> None:
        """A robot was put somewhere."""
        self.record.robots[number].put(self.time, reason)
        self._make_room()

    def _missed(self, number: int, pose: Pose) -> Pose | None:
        """Where people put a robot who want it somewhere; None: there."""
        ahead, left, turn = start_error(self.draws, number)
        if self.alliances[number] == "red" and not self.game.field.symmetry.keeps_hands:
            left, turn = -left, -turn
        error = (ahead, left, turn)
        return missed_place(self.world, self.robots[number], pose, error) if any(error) else None

    def _begin_rules(self) -> None:
        """The rules begin anew, with nothing scored."""
        self._has_ended = self.timer.is_over
        self._counted = None
        self.rules = self.game.rules(self)
        self.rules.start()
