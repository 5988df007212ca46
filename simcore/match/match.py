"""Match of any game with any robots, and the phases of a tick.

A tick runs the phases in `before`, then advances the motion of all bodies, then runs the phases in `after`. With
scripted robots, `Match` advances the motion of a tick in one part. For robot code with motor controllers that need more
frequent updates, the caller divides the motion into several parts.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from simcore.errors import ConfigError
from simcore.match.camera_rig import CameraRig
from simcore.match.clock import MatchTimer, Mode
from simcore.match.field_control import FieldControl
from simcore.match.game import Game, PieceSupply, RobotEntry, Rules
from simcore.match.motion import Motion, RobotContacts
from simcore.match.piece_flow import PieceFlow
from simcore.match.publish import Publisher
from simcore.match.run_record import PieceCount, RunRecord, TrajectoryDigest
from simcore.match.scatter import Scatter, ScatterDraws, built_robot, piece_variation, start_error
from simcore.match.scoring import Alliance, Score, ScoringTracker, ScoringZone
from simcore.match.starts import (
    BeliefCheck,
    free_place,
    missed_place,
    pose_text,
    require_free_place,
    require_free_starts,
    require_playable,
    require_settings,
)
from simcore.pieces.piece_manager import Footprint, GamePieceManager
from simcore.pieces.resting_places import RestingPlace
from simcore.quantities import POSE, Quantity, require, require_row, shown
from simcore.robot.robot import Controller, Robot
from simcore.robot.robot_config import RobotConfig
from simcore.telemetry.snapshot import Snapshot, TelemetrySink
from simcore.typing import FloatArray
from simcore.units import TICK
from simcore.vision.limelight import CameraNetwork
from simcore.world.engine import Engine
from simcore.world.field import FieldElement
from simcore.world.footprints import corners
from simcore.world.hanging import HangingBody
from simcore.world.symmetry import Pose
from simcore.world.world import PhysicsWorld

__all__ = ["Match"]

_log = logging.getLogger(__name__)

_LONGEST_PART = TICK * (1.0 + 1e-9)  # [s]
_MOST_PARTS = 100
_COUNT_PERIOD = 5  # ticks
_LONG = 3600.0  # [s]; a sink that would be due this long after the end receives the last snapshot


class Match:
    """One match of a game, used as a context manager or closed with `close`.

    Args:
        game: Game to play.
        robots: Robots of the match; by default one blue robot with the game's default config.
        seed: Seed of all random draws, a whole number >= 0.
        scatter: Sizes of the random differences in robots, pieces and shots; None for no differences.
        controllers: Controllers of the robots, in order of robot number; None for a robot without commands.
        options: Names of the game options to switch on.
        practice: Whether a scored piece counts at any time, regardless of the match clock.
        sinks: Receivers of telemetry.
        engine: Physics engine, which the match closes, or name of an engine; None for the default of `engine_choice`.
        network: Network on which cameras publish, e.g. `CameraTables`; None if frames are read only from `cameras`.
        field_mesh: OBJ file of the field; None for the game's field.
        tags: AprilTag layout, by official name or as a file in WPILib's JSON format; None for the game's layout.
        never_sleep: Whether pieces always stay awake, for measurements.

    Raises:
        ConfigError: If the robots, the seed or another setting is invalid.
        UnknownNameError: If the game does not have one of the options.
        StartError: If a start pose is outside the field or occupied.
        FieldMeshError: If the field mesh is missing or invalid.

    Example:
        >>> from simcore.match.registry import find_game
        >>> with Match(find_game(), seed=3) as match:
        ...     match.play(0.1)
        ...     match.score.total, match.count.is_conserved
        (0, True)
    """

    def __init__(
        self,
        game: Game,
        *,
        robots: Sequence[RobotEntry] = (),
        seed: int = 0,
        scatter: Scatter | None = None,
        controllers: Sequence[Controller | None] = (),
        options: Iterable[str] | None = None,
        practice: bool = False,
        sinks: Sequence[TelemetrySink] = (),
        engine: Engine | str | None = None,
        network: CameraNetwork | None = None,
        field_mesh: Path | None = None,
        tags: str | Path | None = None,
        never_sleep: bool = False,
    ) -> None:
        require_settings(practice=practice, sinks=sinks, engine=engine)
        self.game = game
        self.entries = tuple(robots) or (RobotEntry(),)
        self.options = frozenset(options or ())
        """Names of the game's options that are switched on."""
        self.practice = practice
        """Whether a scored piece counts at any time, regardless of the match clock."""
        if not isinstance(scatter, Scatter | None):
            raise ConfigError(f"scatter must be a Scatter or None, got {shown(scatter)}")
        self.scatter = scatter or Scatter.none()
        """Sizes of the random differences in robots, pieces and shots between runs."""
        require_playable(game, self.entries, options=self.options, controllers=len(controllers), seed=seed)
        if network is not None and not callable(getattr(network, "port", None)):
            raise ConfigError(f"network must be CameraTables(instance) or None, got {shown(network)}")
        self.network = network
        """Network on which cameras publish frames and read settings; None if frames are read only from `cameras`."""
        self._tags = tags or game.field.tags
        self._never_sleep = never_sleep
        self._controllers: list[Controller | None] = [None] * len(self.entries)
        for number, controller in enumerate(controllers):
            self.set_controller(number, controller)
        self.sinks = list(sinks)
        self.last_tick_ms: float | None = None
        """Wall time of the last tick [ms], which the caller sets for telemetry; None if not measured."""
        definition = game.field if game.arrange is None else game.arrange(game.field, self.options)
        self._rungs, self._hanging = definition.rungs, definition.hanging
        self.field = definition.load(field_mesh)  # before the engine starts, so that an invalid mesh fails early
        self.world = PhysicsWorld(engine=engine)
        self.control = FieldControl(self)
        """Queue of commands from web pages, dashboards and Python; `reset` keeps this object."""
        self.before: tuple[Callable[[], None], ...] = (
            self.control.before_tick,
            self._make_way,
            self._read,
            self._wake,
            self._take_in,
        )
        """Phases of a tick before the motion, in order.

        The phases run field commands, separate overlapping robots, run controllers and rules, wake pieces, and move
        pieces into robots.
        """
        self.after: tuple[Callable[[], None], ...] = (
            self._gather,
            self._see,
            self._settle,
            self._score,
            self._let_go,
            self._publish,
        )
        """Phases of a tick after the motion, in order.

        The phases read the state of pieces, expose camera frames, put slow pieces to sleep, update the score and apply
        the rules, release pieces from robots, and write telemetry.
        """
        try:
            self._begin(seed)
        except BaseException:
            self.world.close()
            raise

    @classmethod
    def bare(
        cls,
        robot: RobotConfig | None = None,
        *,
        start: Pose = (2.0, 2.0, 0.0),
        size: tuple[float, float] = (16.0, 8.0),
        elements: Sequence[FieldElement] = (),
        drivable: Sequence[str] = (),
        pieces: Sequence[PieceSupply] = (),
        zones: Sequence[ScoringZone] = (),
        places: Sequence[RestingPlace] = (),
        **settings: Any,
    ) -> Match:
        """Return a match with one robot on a bare carpet surrounded by a wall, for experiments and tests.

        Args:
            robot: Config of the robot; None for a 55 kg robot with four swerve modules and no mechanisms.
            start: Start pose of the robot, field frame [m, m, rad].
            size: Length and width of the field [m].
            elements: Elements on the field, in addition to the wall.
            drivable: Name patterns of the elements that robots drive over.
            pieces: Kinds of pieces; no piece is on the field until a call of `match.pieces.spawn`.
            zones: Zones in which pieces score.
            places: Resting places, where pieces stay and count as placed.
            settings: Further arguments of `Match`.

        Example:
            >>> with Match.bare() as match:
            ...     match.robots[0].drive.set_volts([6.0] * 4, [0.0] * 4)
            ...     match.play(1.0)
            ...     match.robots[0].chassis.pose[0] > 2.5
            True
        """
        game = Game.bare(
            size=size,
            elements=elements,
            drivable=drivable,
            pieces=pieces,
            zones=zones,
            places=places,
            robot=None if robot is None else lambda: robot,
        )
        return cls(game, robots=(RobotEntry(start=start),), **settings)

    # --- building -------------------------------------------------------------------------------------------------

    def _begin(self, seed: int) -> None:
        """Build all objects of a run in an empty physics world, check the start poses, and start the rules."""
        game = self.game
        self.seed = seed
        """Seed of all random draws."""
        self.draws = ScatterDraws(self.scatter, seed)
        """Random draws of this run, with the spreads in `scatter`."""
        self.rules_rng, robot_rng, staging_rng, camera_rng = np.random.default_rng(seed).spawn(4)
        """Random number generator for the rules of the game."""
        self.time = 0.0
        """Simulated time since the start of the run [s]."""
        self.ticks = 0
        """Number of ticks since the start of the run."""
        self.field_resets = 0
        """Number of calls of `reset_field` since the start of the run."""
        self.persons: dict[Alliance, dict[str, float]] = {}
        """End time of each requested action [s], by action name, for each alliance with a user as human player."""
        self.timer = MatchTimer(game.clock)
        """Timer with the match time, for scoring, rules and telemetry."""
        self.digest = TrajectoryDigest()
        """Hash of the states in all ticks so far, for comparison of runs."""
        self._started: Mode | None = None
        """Mode that a driver station enabled last; None if no mode has been enabled yet."""
        self._has_concluded = False
        self._unchecked: set[int] = set()  # robots that have changed alliance since the last tick
        self.alliances: list[Alliance] = [entry.alliance for entry in self.entries]
        """Current alliance of each robot."""
        self.world.add_field(self.field.elements, drivable=game.field.drivable_in(self.field))
        self.hanging = [HangingBody(self.world, config) for config in self._hanging]
        """Bodies that hang from the field and swing."""
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
        self.robots: list[Robot] = []
        for number, own_rng in enumerate(robot_rng.spawn(len(self.entries))):
            self._add_robot(number, own_rng)  # own stream, so that noise does not depend on the number of robots
        self.pieces.on_taken = [robot.forget_piece for robot in self.robots]
        require_free_starts(self.world, self.robots, game.field, self.alliances)
        for robot in self.robots:
            pose = self.start_pose(robot.number)
            missed = self._missed(robot.number, pose)
            if missed is not None:
                robot.reset(missed, believed=pose)
        self.record = RunRecord(self.pieces, self.robots, TICK)
        """Record of the run so far."""
        for robot in self.robots:
            robot.require_place = partial(self._require_place, robot.number)
            robot.on_put = partial(self._note_put, robot.number)
        self._make_room()
        self.contacts = RobotContacts(self.world, self.robots, self.pieces, self.hanging, self.field.elements)
        """Contacts of the robots in this tick."""
        self.motion = Motion(
            self.world,
            robots=self.robots,
            pieces=self.pieces,
            hanging=self.hanging,
            watchers=(self.contacts,),
        )
        """Time stepping of devices, robots, pieces and other bodies."""
        self.flow = PieceFlow(self.world, self.pieces, self.robots, self.record)
        """Transfer of pieces into and out of robots."""
        kinds = [game.pieces[kind].kind.name for kind in self.pieces.state.kind.tolist()]
        self.tracker = ScoringTracker(game.zones, worth=lambda zone: self.rules.worth(zone), kinds=kinds)
        self.beliefs = BeliefCheck(self.robots)
        """Check of the robots' pose estimates at the beginning of an auto."""
        self.cameras = CameraRig(
            *(self.world, self.pieces, self.robots, self.draws),
            field_size=game.field.size,
            tags=self._tags,
            rng=camera_rng,
            network=self.network,
        )
        self._begin_rules()
        self._publisher: Publisher | None = None

    def _update_digest(self) -> None:
        """Add the states of robots, awake hanging bodies and pieces to the digest, and every 0.1 s the score."""
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
        """Stage the game's pieces on and off the field; flip positions and attitudes if the first robot is red.

        A match with a red first robot is therefore the counterpart of the blue match under the field's symmetry.
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
        self.pieces.require_room()

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
        """Move pieces that overlap robots out of the way."""
        self.pieces.make_room([Footprint(*robot.chassis.footprint) for robot in self.robots])

    def _require_place(self, number: int, pose: Pose) -> None:
        """Raise an error unless a robot's pose is three finite numbers, inside the field and free."""
        require_row(f"robot {number}", "pose", pose, POSE)
        require_free_place(self.world, self.robots[number], pose, self.game.field.size, others=self.robots)

    def _note_put(self, number: int, reason: str) -> None:
        """Record a placement of a robot, and move pieces that overlap robots out of the way."""
        self.record.robots[number].put(self.time, reason)
        self._make_room()

    def _missed(self, number: int, pose: Pose) -> Pose | None:
        """Return the pose of a robot with a random placement error of the drive team; None if the error is zero."""
        ahead, left, turn = start_error(self.draws, number)
        if self.alliances[number] == "red" and not self.game.field.symmetry.keeps_hands:
            left, turn = -left, -turn
        error = (ahead, left, turn)
        return missed_place(self.world, self.robots[number], pose, error) if any(error) else None

    def _begin_rules(self) -> None:
        """Construct and start new `Rules`, and clear the cached breakdown of the score."""
        self._has_ended = self.timer.is_over
        self._counted: tuple[int, Score] | None = None
        """Index of the 0.1 s period, and score, at the last update of `score_counts`; None before the first update."""
        self._counts: Mapping[str, int] = {}
        self.rules: Rules = self.game.rules(self)
        self.rules.start()

    def __enter__(self) -> Match:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the run, and close all cameras and sinks and the engine, even if a close call fails.

        A second call of the method is harmless.
        """
        with ExitStack() as stack:
            stack.callback(self.world.close)
            self._end_run(stack)

    def _end_run(self, stack: ExitStack) -> None:
        """Log brownout totals, and write a last snapshot if there are new shortfalls, but only once per run.

        Args:
            stack: Stack that receives the calls that close cameras and sinks, and the calls that write the snapshot.
        """
        for end in (self.cameras.close, *(sink.close for sink in self.sinks)):
            stack.callback(end)
        if self._has_concluded:
            return
        self._has_concluded = True
        for robot in self.robots:
            robot.brownouts.log_total()
        if self.ticks and self.record.conclude():
            snapshot = self.snapshot()
            for sink in self.sinks:
                if sink.due(self.time + _LONG):
                    stack.callback(sink.write, snapshot)

    # --- the tick -------------------------------------------------------------------------------------------------

    def tick(self, parts: int = 1) -> None:
        """Advance by one tick of 20 ms, with the motion split into equal parts.

        Raises:
            ConfigError: If the number of parts is not a whole number from 1 to 100; nothing moves in this case.
        """
        if type(parts) is not int or not 1 <= parts <= _MOST_PARTS:
            raise ConfigError(f"Match.tick: parts must be a whole number from 1 to {_MOST_PARTS}, got {shown(parts)}")
        self.begin_tick()
        for _ in range(parts):
            self.run_part(TICK / parts)
        self.end_tick()

    def begin_tick(self) -> None:
        """Run the phases before the motion; then call `run_part` for 20 ms in total, and `end_tick`."""
        for phase in self.before:
            phase()

    def run_part(self, h: float) -> None:
        """Advance the motion by h [s], part of a tick.

        Raises:
            ConfigError: If h is not above 0 and at most 20 ms; nothing moves in this case.
        """
        if not 0.0 < h <= _LONGEST_PART:
            raise ConfigError(f"Match.run_part: h must be a part of 20 ms, above 0 s, got {shown(h)}")
        self.motion.advance(h)

    def end_tick(self) -> None:
        """Run the phases after the motion, from the state of the pieces to telemetry."""
        for phase in self.after:
            phase()

    def play(self, seconds: float, *, controllers: Sequence[Controller | None] | None = None) -> None:
        """Set new controllers, if there are any, and advance the match by a duration.

        Args:
            seconds: Simulated time to advance by, rounded to whole ticks [s].
            controllers: New controllers of the robots, in order of robot number; None to keep the current controllers.
        """
        require("Match.play", "seconds", seconds, Quantity("s", 0.0, 1e6))
        for number, controller in enumerate(controllers or ()):
            self.set_controller(number, controller)
        for _ in range(round(seconds / TICK)):
            self.tick()

    # --- before ---------------------------------------------------------------------------------------------------

    def _make_way(self) -> None:
        """Move a robot that has changed alliance to a free pose if the start pose is occupied, and log a warning."""
        while self._unchecked:
            robot = self.robots[self._unchecked.pop()]
            pose = robot.chassis.pose
            place = free_place(self.world, robot, pose, self.game.field.size, others=self.robots)
            if place is not None and place != pose:
                where = pose_text(place)
                _log.warning("robot %d: its start is occupied, so it stands next to it, at %s", robot.number, where)
                self._carry(robot.number, place, by_people=False)

    def _read(self) -> None:
        for robot, controller in zip(self.robots, self._controllers, strict=True):
            if controller is not None:
                controller(robot, self.time)
        self.cameras.listen(self.time)
        self.rules.before_tick()

    def _wake(self) -> None:
        """Begin the tick of the motion, which wakes sleeping pieces that a moving body can reach in this tick."""
        self.motion.begin_tick()

    def _take_in(self) -> None:
        """Move pieces within reach of intakes and placers into robots, and hand pieces over to placers.

        This phase precedes the motion. Otherwise, an intake could collect a piece that the robot has just shot.
        """
        self.flow.take_in()

    # --- after ----------------------------------------------------------------------------------------------------

    def _gather(self) -> None:
        """Advance clock and record, read the pieces' state, put back pieces off the field, and let bodies sleep."""
        self.ticks += 1
        self.time = self.ticks * TICK
        self.timer.advance(TICK)
        self.pieces.gather(TICK)
        self.record.after_tick(self.time)
        for body in self.hanging:
            body.after_tick(TICK)

    def _see(self) -> None:
        """Record robot poses for cameras, expose the frames that are due, and publish completed frames."""
        self.cameras.expose(self.time)

    def _settle(self) -> None:
        """Put all pieces that have been slow for some time to sleep."""
        self.pieces.settle(TICK)

    def _score(self) -> None:
        """Score and remove pieces that have entered a scoring zone, update the resting places, and apply the rules."""
        state, slots = self.pieces.state, self.pieces.awake
        events = self.tracker.update(self.time, slots, state.before.take(slots, axis=0), state.pos.take(slots, axis=0))
        if events:
            for event in events:
                self.record.note_scored(event)
            self.pieces.score(np.array([event.slot for event in events]))
            for event in events:
                self.rules.scored(event)
        if self.game.places:
            placed, removed = self.pieces.places.update()
            for stay in removed:
                self.rules.removed(stay)
            for stay in placed:
                self.rules.placed(stay)
        if self.timer.is_over and not self._has_ended:
            self._has_ended = True
            self.rules.end()
        self.rules.after_tick()

    def _let_go(self) -> None:
        """Advance hoppers, and release pieces from shooters and placers."""
        self.flow.let_go(self.time)

    def _publish(self) -> None:
        """Log brownouts, check pose estimates when an auto begins, update the digest, and write to due sinks."""
        for robot in self.robots:
            robot.brownouts.after_tick(self.time)
        self.beliefs.after_tick(self.time, self.timer)
        self._update_digest()
        due = [sink for sink in self.sinks if sink.due(self.time)]
        if due:
            snapshot = self.snapshot()
            for sink in due:
                sink.write(snapshot)

    # --- commands of robot code and drive team --------------------------------------------------------------------

    def set_controller(self, number: int, controller: Controller | None) -> None:
        """Set the controller of a robot from the next tick on; None removes the controller.

        Raises:
            ConfigError: If the robot does not exist or the controller is not callable.
        """
        self.require_robot(number)
        if not (controller is None or callable(controller)):
            raise ConfigError(f"robot {number}: a controller is called with robot and time, got {shown(controller)}")
        self._controllers[number] = controller

    def set_alliance(self, number: int, alliance: Alliance) -> None:
        """Change a robot's alliance, and place the robot at rest at the start pose for the new alliance.

        The scatter adds a placement error to the pose. The gyro keeps the reading. If another robot still occupies the
        start pose when the next tick begins, the match places the robot next to the other robot.

        Raises:
            ConfigError: If the robot or the alliance does not exist.
        """
        self.require_robot(number)
        if alliance not in ("blue", "red"):
            raise ConfigError(f"set_alliance: alliance must be 'blue' or 'red', got {shown(alliance)}")
        self.alliances[number] = alliance
        self._carry(number, self.start_pose(number), by_people=True)
        self._unchecked.add(number)

    def carry_to(self, number: int, pose: Pose, *, by_people: bool = False) -> None:
        """Place a robot at rest at a pose, and move pieces out of the way; the gyro keeps its reading.

        Args:
            number: Number of the robot.
            pose: New pose, field frame [m, m, rad].
            by_people: Whether the drive team places the robot for an auto. If True, the scatter adds a placement error
                to the pose, and headsets repeat the last pose reset. If False, the pose is exact.

        Raises:
            ConfigError: If the robot does not exist or the pose is not three finite numbers.
            StartError: If the pose is outside the field or occupied.
        """
        self.require_robot(number)
        self._require_place(number, pose)
        self._carry(number, pose, by_people=by_people)

    def _carry(self, number: int, pose: Pose, *, by_people: bool) -> None:
        missed = self._missed(number, pose) if by_people else None
        old_pos = self.robots[number].chassis.pos
        self.robots[number].put(missed or pose, believed=missed and pose)
        self.cameras.follow_carry(number, self.time, old_pos, to_start=by_people)

    def start_mode(self, mode: Mode) -> None:
        """Set the match clock to the start of a mode, `auto` or `teleop`, that a driver station has just enabled.

        At the start of `auto`, also clear the score and the record of pieces. The pieces stay in place.
        """
        self.timer.start(mode)
        if mode == "auto":
            self.tracker.reset()
            self.flow.clear()
            self.record.forget_pieces()
            self._has_ended = False
        self._started = mode
        self.rules.start_mode(mode)

    def reset_field(self) -> None:
        """Reset pieces, preloads, score, rules and piece records to the state at the start of the match.

        The robots stay in place, and staged pieces are moved out of the way of robots. The match clock keeps running.
        """
        self.field_resets += 1
        self.pieces.clear()
        self.rules_rng, _, staging_rng, _ = np.random.default_rng(self.seed).spawn(4)
        for robot in self.robots:
            robot.forget_pieces()
        self._stage(staging_rng)
        for robot in self.robots:
            self._preload(robot)
        self._make_room()
        self.flow.clear()
        self.record.forget_pieces()
        self.tracker.reset()
        self._begin_rules()
        if self._started is not None:
            self.rules.start_mode(self._started)

    def reset(self, seed: int | None = None, *, sinks: Sequence[TelemetrySink] = ()) -> None:
        """End the current run, and start a new run in the same engine, with new robots, pieces and rules.

        The match closes the sinks of the old run, which completes the log of the old run.

        Args:
            seed: Seed of the new run; None for the seed of the old run.
            sinks: Receivers of the new run's telemetry.
        """
        require_settings(sinks=sinks)
        if seed is not None:
            require_playable(self.game, self.entries, options=(), controllers=0, seed=seed)
        with ExitStack() as stack:
            self._end_run(stack)
        self.sinks = list(sinks)
        self.world.reset()
        self._begin(self.seed if seed is None else seed)

    # --- queries --------------------------------------------------------------------------------------------------

    @property
    def substeps(self) -> int:
        """Number of engine steps in the last tick."""
        return self.motion.substeps

    @property
    def score(self) -> Score:
        """Points of both alliances so far."""
        red, blue = self.tracker.totals["red"], self.tracker.totals["blue"]
        return Score(red=red, blue=blue, total=red + blue)

    @property
    def score_counts(self) -> Mapping[str, int]:
        """Result of `breakdown` for telemetry, updated every 0.1 s and when the score changes."""
        now = self.ticks // _COUNT_PERIOD, self.score
        if now != self._counted:
            self._counted, self._counts = now, self.breakdown()
        return self._counts

    def breakdown(self) -> dict[str, int]:
        """Return the breakdown of the score by name.

        The breakdown contains the number of scored pieces in each zone, the points of human players' throws, and the
        counts and points from `Rules.breakdown`.
        """
        people = self.record.human_points.items() if self.rules.human_actions() else ()
        thrown = {f"{alliance.capitalize()}/humanPlayerPoints": points for alliance, points in people}
        return {**self.tracker.pieces, **thrown, **self.rules.breakdown()}

    @property
    def count(self) -> PieceCount:
        """Number of pieces by status: on the field, in flight, in robots, scored, placed and off the field."""
        return PieceCount.of(self.pieces)

    def piece_positions(self) -> dict[str, FloatArray]:
        """Return the positions of the pieces on the field and in the air, field frame [m], shape (n, 3), by kind."""
        return {kind.name: self.pieces.state.pos[self.pieces.on_field(kind.name)] for kind in self.pieces.types}

    def start_pose(self, number: int) -> Pose:
        """Return the start pose of a robot for the robot's current alliance, field frame [m, m, rad].

        Raises:
            ConfigError: If the robot does not exist, or if the entry has no start and the game has too few starts.
        """
        self.require_robot(number)
        game, entry = self.game, self.entries[number]
        pose = entry.start
        if pose is None:
            before = [other.alliance for other in self.entries[:number]].count(entry.alliance)
            if before >= len(game.starts):
                raise ConfigError(
                    f"{game.name} has {len(game.starts)} starts per alliance; give the RobotEntry of robot {number} a "
                    "start"
                )
            pose = game.starts[before]
        return game.field.symmetry.flip_pose(*pose) if self.alliances[number] == "red" else pose

    def require_robot(self, number: int) -> None:
        """Raise a `ConfigError` if there is no robot with this number."""
        if type(number) is not int or number not in range(len(self.entries)):
            raise ConfigError(f"there are robots 0 to {len(self.entries) - 1}, got {shown(number)}")

    def outline(self, number: int) -> FloatArray:
        """Return the bumper corners of a robot seen from above; flip the corners of a red robot to the blue side.

        Returns:
            Corners, field frame [m], shape (4, 2).
        """
        body, pose = self.robots[number].chassis.config, self.robots[number].chassis.pose
        if self.alliances[number] == "red":
            pose = self.game.field.symmetry.flip_pose(*pose)
        return corners(*pose, body.bumper_length, body.bumper_width)

    def snapshot(self) -> Snapshot:
        """Return the telemetry of the last tick, from the current state of the match."""
        if self._publisher is None:
            self._publisher = Publisher(self)
        return self._publisher.snapshot()
