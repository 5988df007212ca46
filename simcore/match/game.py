"""Definition of a year's game: a frozen config that `Match` plays, and hooks for the rules of the game."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeAlias, runtime_checkable

import numpy as np

from simcore.channel import Channel
from simcore.errors import ConfigError, UnknownNameError
from simcore.match.clock import MatchClock, Phase
from simcore.match.human_actions import HumanAction
from simcore.match.scoring import Alliance, ScoreEvent, ScoringZone
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.resting_places import PlaceEvent, RestingPlace
from simcore.quantities import (
    COUNT,
    FIELD_LENGTH,
    FIELD_PLACE,
    FORCE,
    START,
    Quantity,
    require_attitude,
    require_fields,
    require_points,
    shown,
)
from simcore.robot.climber import Rung
from simcore.robot.robot import Controller
from simcore.robot.robot_config import RobotConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.typing import FloatArray
from simcore.world.contact_law import TerrainSurface
from simcore.world.field import FieldBoundary, FieldElement, FieldGeometry
from simcore.world.hanging import HangingConfig
from simcore.world.obj import read_obj
from simcore.world.shapes import Box, Cylinder, Hull, Sphere
from simcore.world.symmetry import FieldSymmetry, Pose

if TYPE_CHECKING:
    from simcore.match.clock import MatchTimer
    from simcore.match.motion import RobotContacts
    from simcore.match.run_record import RunRecord
    from simcore.match.scatter import ScatterDraws
    from simcore.match.scoring import ScoringTracker
    from simcore.pieces.piece_manager import GamePieceManager
    from simcore.robot.robot import Robot
    from simcore.world.hanging import HangingBody
    from simcore.world.world import PhysicsWorld

__all__ = [
    "Auto",
    "Driving",
    "FieldDefinition",
    "Game",
    "GameOption",
    "PieceSupply",
    "PlayedMatch",
    "RobotEntry",
    "Rules",
    "StagedPieces",
    "for_both_alliances",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldDefinition:
    """Field of a game: geometry, materials, symmetry between blue and red, AprilTags, rungs and hanging bodies."""

    size: tuple[float, float]
    """Length and width of the field [m]."""
    symmetry: FieldSymmetry
    mesh: Path | None = None
    """OBJ file of the field; None if the field consists of `elements`."""
    elements: tuple[FieldElement, ...] = ()
    """Elements of the field if the field has no mesh."""
    materials: Mapping[str, TerrainSurface] = dataclasses.field(default_factory=dict)
    """Surfaces of mesh elements, by pattern (`*`, `?`) for element names; the last matching pattern applies."""
    drivable: tuple[str, ...] = ()
    """Name patterns of the elements that robots can drive over."""
    tags: str | Path = ""
    """AprilTag layout: an official name (`simcore.vision.tag_layout`) or a file in WPILib's JSON format.

    An empty name means no AprilTags. A match loads the layout only if a robot has a camera.
    """
    rungs: tuple[Rung, ...] = ()
    """Rungs on which climbers can hang."""
    hanging: tuple[HangingConfig, ...] = ()
    """Bodies that hang from the field and swing."""

    def __post_init__(self) -> None:
        require_fields(self, size=(FIELD_LENGTH, FIELD_LENGTH))
        if self.symmetry.size != self.size:
            raise ConfigError(f"FieldDefinition: symmetry is for a field of {self.symmetry.size} m, got {self.size} m")
        if (self.mesh is None) == (not self.elements):
            raise ConfigError("FieldDefinition: give either a mesh or elements")
        if unknown := {rung.mount for rung in self.rungs} - {body.name for body in self.hanging} - {""}:
            raise ConfigError(f"FieldDefinition: rungs mount on {sorted(unknown)}, but no hanging body has that name")

    def load(self, mesh: Path | None = None) -> FieldGeometry:
        """Return the field geometry from the mesh, with a surface for each group, or from `elements` without a mesh.

        Args:
            mesh: OBJ file that replaces the game's field; None for the game's field. The patterns in `materials` that
                match no group of this file are ignored.

        Raises:
            FieldMeshError: If the file is missing or invalid.
        """
        path = mesh or self.mesh
        if path is None:
            return FieldGeometry(self.elements)
        materials = self.materials
        if mesh is not None:
            names = [group.name for group in read_obj(mesh)]
            materials = {p: s for p, s in materials.items() if any(fnmatchcase(name, p) for name in names)}
        try:
            written = path.stat().st_mtime_ns
        except OSError:  # the reader reports the mistake
            written = 0
        return _read_field(path, written, tuple(materials.items()), self.symmetry)

    def drivable_in(self, geometry: FieldGeometry) -> list[str]:
        """Return the patterns in `drivable` that match at least one element name of a field geometry."""
        names = [element.name for element in geometry.elements]
        return [pattern for pattern in self.drivable if any(fnmatchcase(name, pattern) for name in names)]


@lru_cache(maxsize=4)
def _read_field(
    path: Path, written: int, materials: tuple[tuple[str, TerrainSurface], ...], symmetry: FieldSymmetry
) -> FieldGeometry:
    """Return the field geometry from a mesh; cache the result until the modification time `written` [ns] changes."""
    return FieldGeometry.load(path, surfaces=dict(materials), symmetry=symmetry)


def for_both_alliances(elements: Iterable[FieldElement], symmetry: FieldSymmetry) -> tuple[FieldElement, ...]:
    """Return each element of the blue half as `blue_<name>`, and the symmetric element of the red half as `red_<name>`.

    Args:
        elements: Elements of the blue half: axis-aligned boxes, upright cylinders, balls and hulls.
        symmetry: Symmetry of the field.

    Raises:
        ConfigError: If an element has any other shape.
    """
    both = []
    for element in elements:
        shape = element.shape
        if not isinstance(shape, Box | Cylinder | Sphere | Hull):
            kind = type(shape).__name__
            raise ConfigError(
                f"{element.name}: boxes, cylinders, balls and hulls can be put on both sides, got a {kind}"
            )
        other = Hull(symmetry.flip_vectors(shape.points)) if isinstance(shape, Hull) else shape
        place = symmetry.flip_points(element.position[None])[0]
        both.append(dataclasses.replace(element, name=f"blue_{element.name}"))
        both.append(dataclasses.replace(element, name=f"red_{element.name}", shape=other, position=place))
    return tuple(both)


@dataclass(frozen=True, slots=True)
class PieceSupply:
    """Kind of game piece, and the number of pieces in a match."""

    kind: GamePieceConfig
    count: int

    def __post_init__(self) -> None:
        require_fields(self, count=COUNT)


@dataclass(frozen=True, slots=True, kw_only=True)
class StagedPieces:
    """Pieces of one kind at the start of a match: poses on the field, and number of pieces off the field."""

    kind: str
    """Name of the kind of piece."""
    positions: FloatArray = dataclasses.field(default_factory=lambda: np.zeros((0, 3)))
    """Centers of the pieces on the field, field frame [m], shape (n, 3).

    The positions are for a match with a blue first robot; `Match` flips the positions if the first robot is red.
    """
    attitudes: FloatArray | None = None
    """Attitudes of the pieces on the field, unit quaternions x, y, z, w, shape (n, 4); None for upright pieces."""
    resting: bool = False
    """Whether pieces above the carpet start asleep, at rest on the field or on pieces staged earlier.

    If False, the pieces fall when the match begins.
    """
    lodged: float | None = None
    """Force that frees each wedged piece from the field [N]; None if the pieces are not wedged."""
    off_field: int = 0
    """Number of pieces that start off the field, e.g. with a human player."""

    def __post_init__(self) -> None:
        owner = f"StagedPieces of {self.kind}"
        if isinstance(self.off_field, int) and self.off_field < 0:
            raise ConfigError(
                f"{owner}: {-self.off_field} more stand on the field than there are (off_field is below 0)"
            )
        require_fields(self, owner, off_field=COUNT, lodged=FORCE)
        require_points(owner, "positions", self.positions, FIELD_PLACE)
        if self.attitudes is not None:
            if np.asarray(self.attitudes, dtype=object).shape != (len(self.positions), 4):
                raise ConfigError(
                    f"{owner}: attitudes must have shape ({len(self.positions)}, 4), one to each of positions, "
                    f"got {shown(self.attitudes)}"
                )
            for number, quat in enumerate(np.asarray(self.attitudes).tolist()):
                require_attitude(owner, f"attitudes[{number}]", quat)


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotEntry:
    """Robot of a match: alliance, start pose, preload and config."""

    alliance: Alliance = "blue"
    start: Pose | None = None
    """Start pose for the blue alliance, field frame [m, m, rad]; a red robot starts at the corresponding red pose.

    None for a start pose of the game: the n-th robot of an alliance gets the n-th start pose.
    """
    preload: int | None = None
    """Number of preloaded pieces of the game's first kind; None for the most that game and robot storage allow."""
    config: RobotConfig | None = None
    """Config of the robot; None for the game's default robot."""

    def __post_init__(self) -> None:
        require_fields(self, start=START, preload=COUNT)


@dataclass(frozen=True, slots=True, kw_only=True)
class GameOption:
    """Option of a game, which a user switches on with `Match(options=...)` or on the command line."""

    name: str
    help: str
    in_matches: bool = False
    """Whether the option is on by default in whole matches."""

    def __post_init__(self) -> None:
        require_fields(self)


class PlayedMatch(Protocol):
    """Match interface that a game's rules, autos, scripted players and scripts use."""

    game: Game
    entries: tuple[RobotEntry, ...]
    """Entries of the robots, by robot number."""
    options: frozenset[str]
    """Names of the game options that are switched on."""
    practice: bool
    """Whether a scored piece counts at any time, regardless of the match clock."""
    field: FieldGeometry
    world: PhysicsWorld
    hanging: list[HangingBody]
    robots: list[Robot]
    """All robots, by number."""
    alliances: list[Alliance]
    """Current alliance of each robot."""
    contacts: RobotContacts
    """Contacts of the robots in this tick."""
    pieces: GamePieceManager
    tracker: ScoringTracker
    """Tracker of points and of pieces that have scored."""
    timer: MatchTimer
    time: float
    """Simulated time since the start of the run [s]."""
    rules: Rules
    rules_rng: np.random.Generator
    """Random number generator for the rules of the game."""
    draws: ScatterDraws
    """Random draws of this run."""
    persons: dict[Alliance, dict[str, float]]
    """End time of each requested action [s], by action name, for each alliance with a user as human player."""
    record: RunRecord
    """Record of the run so far."""

    def outline(self, number: int) -> FloatArray:
        """Return a robot's bumper corners seen from above, field frame [m], shape (4, 2); flip a red robot to blue."""


@runtime_checkable
class Driving(Protocol):
    """Controls with which a user drives a game's robot, e.g. `simcore.match.players.driven_robot.DriverControls`."""

    @property
    def actions(self) -> Collection[str]:
        """Names of the driver's actions, in the order of the buttons."""

    def controller(self, match: PlayedMatch, alliance: Alliance, driver: Callable[[], Any]) -> Controller:
        """Return a controller that reads the driver's inputs once per tick and commands the robot accordingly."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Auto:
    """Autonomous routine: controller, start pose and preload."""

    name: str
    summary: str
    controller: Callable[[PlayedMatch, Alliance], Controller]
    """Function of a match and an alliance that returns the robot's controller."""
    start: Pose
    """Start pose for the blue alliance, field frame [m, m, rad]."""
    preload: int | None = None
    """Number of preloaded pieces; None for the most that the game and the robot's storage allow."""

    def __post_init__(self) -> None:
        require_fields(self, f"Auto {self.name!r}", start=START, preload=COUNT)


@dataclass(frozen=True, slots=True, kw_only=True)
class Role:
    """Role of a scripted player in a whole match: controller and robot."""

    name: str
    summary: str
    controller: Callable[[PlayedMatch, Alliance, int], Controller]
    """Function of a match, an alliance and a skill level that returns the robot's controller."""
    config: Callable[[], RobotConfig] | None = None
    """Function that returns the robot's config; None for the game's default robot."""

    def __post_init__(self) -> None:
        require_fields(self)


class Rules:
    """Rules of a game in one match: methods that `Match` calls, and that a game overrides.

    By default, a piece scores the points of the zone, and all other hooks do nothing. Hooks use the public attributes
    of the match: `match.pieces`, `match.tracker`, `match.timer`, `match.robots`.

    Args:
        match: Match being played, with all pieces staged.
    """

    channels: ClassVar[Sequence[Channel]] = ()
    """Telemetry channels of the game; each channel has the full key, and a function of the `Rules` object."""

    def __init__(self, match: PlayedMatch) -> None:
        self.match = match

    def start(self) -> None:
        """Initialize the rules at the start of the match and after a reset of the field; all pieces are staged."""

    def start_mode(self, mode: str) -> None:
        """Handle the start of `auto` or `teleop` by a driver station, and a reset of the field in this mode."""

    def before_tick(self) -> None:
        """Apply the rules in each tick after the robots' controllers have run, before all motion."""

    def worth(self, zone: ScoringZone) -> int:
        """Return the points for a piece that would score in a zone at the current time.

        Web pages and dashboards may call this method, `game_data`, `breakdown` and the functions of `channels` at any
        time. These functions must not change any state; the hook `scored` implements the effects of a scored piece.
        """
        return zone.points

    def scored(self, event: ScoreEvent) -> None:
        """Handle a piece that has just scored and been removed from the field."""

    def placed(self, event: PlaceEvent) -> None:
        """Handle a piece that has just come to rest in one of the game's `places`."""

    def removed(self, event: PlaceEvent) -> None:
        """Handle a placed piece that has just fallen from a resting place or that a robot has removed."""

    def after_tick(self) -> None:
        """Apply the rules in each tick after motion and scoring, before telemetry."""

    def end(self) -> None:
        """Apply the rules at the end of the last phase; called once, before `after_tick`."""

    def human_actions(self) -> Sequence[HumanAction]:
        """Return the actions of the human players; empty if this run has no human players.

        The names of the actions must not change during a run.
        """
        return ()

    def game_data(self) -> str:
        """Return the game-specific message that the robots currently receive; empty for no message."""
        return ""

    def breakdown(self) -> Mapping[str, int]:
        """Return further counts and points of the score by name, in addition to the number of pieces in each zone."""
        return {}


Staging: TypeAlias = Callable[[np.random.Generator, Sequence[RobotEntry]], Sequence[StagedPieces]]
"""Function of a random generator and the robot entries that returns the staged pieces without preloads.

The positions are for a match with a blue first robot.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Game:
    """Definition of a year's game. To make a variant of a game, use `dataclasses.replace`."""

    name: str
    """Name of the game for `--game` and telemetry, with only letters, digits and `_`."""
    year: int
    title: str = ""
    """Title of the game on pages and in reports; empty to use the name in capitals."""
    field: FieldDefinition
    pieces: tuple[PieceSupply, ...]
    clock: MatchClock
    assessment: float = 0.0
    """Time between the end of the match clock and the final assessment of the score [s]."""
    staging: Staging
    zones: tuple[ScoringZone, ...] = ()
    places: tuple[RestingPlace, ...] = ()
    """Resting places, where pieces stay and count as placed."""
    rules: Callable[[PlayedMatch], Rules] = Rules
    robot: Callable[[], RobotConfig]
    """Function that returns the config of the game's default robot."""
    starts: tuple[Pose, ...]
    """Start poses of blue robots, field frame [m, m, rad]; red robots start at the corresponding red poses."""
    preload: int = 0
    """Maximum number of preloaded pieces per robot."""
    robots: int = 6
    """Maximum number of robots in a match."""
    autos: Mapping[str, Auto] = dataclasses.field(default_factory=dict)
    """Autos by name; the first auto is the default."""
    roles: Mapping[str, Role] = dataclasses.field(default_factory=dict)
    """Roles of scripted players, by name."""
    driving: Driving | None = None
    """Controls for a user who drives the game's robot; None if a user can only drive and use the intake."""
    practice_matches: Mapping[str, tuple[str, str]] = dataclasses.field(default_factory=dict)
    """Practice matches for a team's robot code, by name: roles of the robot's partners, and roles of the opponents."""
    options: tuple[GameOption, ...] = ()
    arrange: Callable[[FieldDefinition, frozenset[str]], FieldDefinition] | None = None
    """Function of the field and the enabled options that returns the changed field; None to keep the field."""
    models: Path | None = None
    """Folder with 3D models for AdvantageScope and the browser view; None if the game has no models."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            f"Game {self.name}",
            assessment=Quantity("s", 0.0, 60.0),
            year=COUNT,
            preload=COUNT,
            robots=COUNT,
            starts=[START],
        )
        if not self.name.replace("_", "").isalnum():
            raise ConfigError(f"Game: name must be of letters, digits and '_', got {self.name!r}")
        names = [supply.kind.name for supply in self.pieces]
        if len(set(names)) < len(names):
            raise ConfigError(f"Game {self.name}: kinds of pieces must differ, got {names}")
        if not len(self.starts):
            raise ConfigError(f"Game {self.name}: starts must have at least one place, got none")

    @property
    def heading(self) -> str:
        """Title of the game on pages and in reports: `title`, or the name in capitals without a title."""
        return self.title or self.name.upper()

    def auto(self, name: str | None = None) -> Auto:
        """Return the auto named `name`, or the game's first auto if `name` is None.

        Raises:
            UnknownNameError: If no auto has this name; the message suggests similar names.
            ConfigError: If the game has no autos.
        """
        if name is None:
            if not self.autos:
                raise ConfigError(f"game {self.name} has no auto")
            return next(iter(self.autos.values()))
        if not isinstance(name, str) or name not in self.autos:
            raise UnknownNameError("auto", name, self.autos)
        return self.autos[name]

    @classmethod
    def bare(
        cls,
        *,
        size: tuple[float, float] = (16.0, 8.0),
        elements: Sequence[FieldElement] = (),
        drivable: Sequence[str] = (),
        pieces: Sequence[PieceSupply] = (),
        robot: Callable[[], RobotConfig] | None = None,
        zones: Sequence[ScoringZone] = (),
        places: Sequence[RestingPlace] = (),
    ) -> Game:
        """Return a game on a bare carpet surrounded by a wall, for experiments and tests.

        The clock has an auto phase of 15 s and a teleop phase of 1e6 s.

        Args:
            size: Length and width of the field [m].
            elements: Elements on the field, in addition to the wall.
            drivable: Name patterns of the elements that robots drive over.
            pieces: Kinds of pieces; no piece is on the field until a call of `match.pieces.spawn`.
            robot: Function that returns the default robot's config; None for a 55 kg robot with four swerve modules and
                no mechanisms.
            zones: Zones in which pieces score.
            places: Resting places, where pieces stay and count as placed.
        """
        module = SwerveModuleConfig(
            x=0.0,
            y=0.0,
            drive_stator_limit=60.0,
            drive_supply_limit=40.0,
            steer_stator_limit=40.0,
            steer_supply_limit=20.0,
        )
        drivetrain = SwerveConfig.square(0.53, module)
        wall = FieldBoundary(length=size[0], width=size[1], side_height=0.5, end_height=2.0)
        return cls(
            name="bare",
            year=0,
            field=FieldDefinition(
                size=size,
                symmetry=FieldSymmetry("rotate", size),
                elements=(*wall.elements(), *elements),
                drivable=tuple(drivable),
            ),
            pieces=tuple(pieces),
            clock=MatchClock([Phase("auto", 15.0, "auto"), Phase("teleop", 1e6)]),
            staging=lambda rng, entries: (),
            zones=tuple(zones),
            places=tuple(places),
            robot=robot or (lambda: RobotConfig(drivetrain=drivetrain)),
            starts=((0.25 * size[0], 0.5 * size[1], 0.0),),
        )
