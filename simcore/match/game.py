"""Definition of a year's game: a frozen description that `Match` plays. A game implements hooks and has no loop."""

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
    """Static field: a mesh or a list of elements, its materials, and the symmetry between blue and red."""

    size: tuple[float, float]
    """Length and width [m]."""
    symmetry: FieldSymmetry
    mesh: Path | None = None
    """OBJ file; None: the field consists of `elements`."""
    elements: tuple[FieldElement, ...] = ()
    """Elements of a field without a mesh."""
    materials: Mapping[str, TerrainSurface] = dataclasses.field(default_factory=dict)
    """Surfaces by name pattern (`*`, `?`) of mesh elements; the last matching pattern wins."""
    drivable: tuple[str, ...] = ()
    """Name patterns of elements that robots drive over."""
    tags: str | Path = ""
    """AprilTag layout: a name (`simcore.vision.tag_layout`) or a file in WPILib's JSON, read if a robot has cameras;
    empty: no tags."""
    rungs: tuple[Rung, ...] = ()
    """Rungs that climbers can hang on."""
    hanging: tuple[HangingConfig, ...] = ()
    """Hanging bodies that swing."""

    def __post_init__(self) -> None:
        require_fields(self, size=(FIELD_LENGTH, FIELD_LENGTH))
        if self.symmetry.size != self.size:
            raise ConfigError(f"FieldDefinition: symmetry is of a field of {self.symmetry.size} m, got {self.size} m")
        if (self.mesh is None) == (not self.elements):
            raise ConfigError("FieldDefinition: give either a mesh or elements")
        if unknown := {rung.mount for rung in self.rungs} - {body.name for body in self.hanging} - {""}:
            raise ConfigError(
                f"FieldDefinition: no body hangs there of the name of the rungs' mounts {sorted(unknown)}"
            )

    def load(self, mesh: Path | None = None) -> FieldGeometry:
        """Load the field as shapes with surfaces.

        Args:
            mesh: OBJ file to use instead of the game's. Groups are matched by name to the game's materials; any other
                group gets the material of `*`.

        Raises:
            FieldMeshError: If the file is missing or broken.
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
        """Return the `drivable` patterns that match an element of a field."""
        names = [element.name for element in geometry.elements]
        return [pattern for pattern in self.drivable if any(fnmatchcase(name, pattern) for name in names)]


@lru_cache(maxsize=4)
def _read_field(
    path: Path, written: int, materials: tuple[tuple[str, TerrainSurface], ...], symmetry: FieldSymmetry
) -> FieldGeometry:
    """Read the shapes of a mesh; cached for all matches until the file's modification time [ns] changes."""
    return FieldGeometry.load(path, surfaces=dict(materials), symmetry=symmetry)


def for_both_alliances(elements: Iterable[FieldElement], symmetry: FieldSymmetry) -> tuple[FieldElement, ...]:
    """Return the elements of the blue half, renamed `blue_...`, and their counterparts on the red half, `red_...`.

    Args:
        elements: Axis-aligned boxes, upright cylinders and balls, which are their own mirror images, and hulls.
        symmetry: Symmetry of the field.

    Raises:
        ConfigError: If an element has another shape.
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
    """One kind of piece, and how many a match has."""

    kind: GamePieceConfig
    count: int

    def __post_init__(self) -> None:
        require_fields(self, count=COUNT)


@dataclass(frozen=True, slots=True, kw_only=True)
class StagedPieces:
    """Pieces of one kind at the start of a match."""

    kind: str
    """Name of their kind."""
    positions: FloatArray = dataclasses.field(default_factory=lambda: np.zeros((0, 3)))
    """Centers of the pieces on the field, in blue's field frame [m], shape (n, 3)."""
    attitudes: FloatArray | None = None
    """Attitudes of these pieces in the same frame, unit quaternions x, y, z, w, shape (n, 4); None: upright."""
    resting: bool = False
    """Whether pieces above the carpet start asleep, at rest on the field or on pieces staged before them; otherwise
    they fall when the match begins."""
    lodged: float | None = None
    """Force that frees wedged pieces [N]; None: the pieces are not wedged."""
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
    """One robot of a match."""

    alliance: Alliance = "blue"
    start: Pose | None = None
    """Start pose as a blue robot, field frame [m, m, rad]; a red robot starts at the corresponding pose. None: the
    game's start pose for the robot's position in the list."""
    preload: int | None = None
    """Preloaded pieces of the game's first kind; None: as many as the game allows."""
    config: RobotConfig | None = None
    """Config of the robot; None: the game's robot."""

    def __post_init__(self) -> None:
        require_fields(self, start=START, preload=COUNT)


@dataclass(frozen=True, slots=True, kw_only=True)
class GameOption:
    """Option of a game that `Match(options=...)` or the command line can switch on."""

    name: str
    help: str
    in_matches: bool = False
    """Whether the option is on by default in whole matches."""

    def __post_init__(self) -> None:
        require_fields(self)


class PlayedMatch(Protocol):
    """Match as its game sees it: the parts that rules, autos, players and scripts use."""

    game: Game
    entries: tuple[RobotEntry, ...]
    """Robots as requested when the match was created."""
    options: frozenset[str]
    """Names of the game options that are on."""
    practice: bool
    """Whether every piece counts, regardless of the clock."""
    field: FieldGeometry
    world: PhysicsWorld
    hanging: list[HangingBody]
    robots: list[Robot]
    """Robots by number."""
    alliances: list[Alliance]
    """Current alliance of each robot."""
    contacts: RobotContacts
    """Contacts of this tick."""
    pieces: GamePieceManager
    tracker: ScoringTracker
    """Tracker of points and of pieces that have scored."""
    timer: MatchTimer
    time: float
    """Simulated time since the start [s]."""
    rules: Rules
    rules_rng: np.random.Generator
    """Random generator for the rules."""
    draws: ScatterDraws
    """Scatter draws of this run."""
    persons: dict[Alliance, dict[str, float]]
    """Requested actions, with the time at which each ends [s], of every human player that a user controls."""
    record: RunRecord
    """Record of the run so far."""

    def outline(self, number: int) -> FloatArray:
        """Return the corners of a robot's bumpers [m], shape (4, 2); a red robot is flipped to the blue side."""


@runtime_checkable
class Driving(Protocol):
    """Driver controls of a game's robot; see `simcore.match.players.driven_robot.DriverControls`."""

    @property
    def actions(self) -> Collection[str]:
        """Names of the actions, in the order of the buttons."""

    def controller(self, match: PlayedMatch, alliance: Alliance, driver: Callable[[], Any]) -> Controller:
        """Make the controller that follows a driver, whose inputs it reads once per tick."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Auto:
    """Autonomous routine of a robot, with its start pose."""

    name: str
    summary: str
    controller: Callable[[PlayedMatch, Alliance], Controller]
    """Function of a match and an alliance that makes the robot's controller."""
    start: Pose
    """Start pose as a blue robot, field frame [m, m, rad]."""
    preload: int | None = None
    """Preloaded pieces, as in `RobotEntry`."""

    def __post_init__(self) -> None:
        require_fields(self, f"Auto {self.name!r}", start=START, preload=COUNT)


@dataclass(frozen=True, slots=True, kw_only=True)
class Role:
    """Role of a scripted player in a whole match."""

    name: str
    summary: str
    controller: Callable[[PlayedMatch, Alliance, int], Controller]
    """Function of a match, an alliance and a skill level that makes the robot's controller."""
    config: Callable[[], RobotConfig] | None = None
    """Config of its robot; None: the game's robot."""

    def __post_init__(self) -> None:
        require_fields(self)


class Rules:
    """Hooks through which a game applies its rules to one match; the defaults do nothing.

    Hooks use the public parts of the match: `match.pieces`, `match.tracker`, `match.timer`, `match.robots`.

    Args:
        match: Match being played, complete except for the pieces, which are staged when `start` is called.
    """

    channels: ClassVar[Sequence[Channel]] = ()
    """Channels that the game adds to telemetry: each has its full key and a function of the rules."""

    def __init__(self, match: PlayedMatch) -> None:
        self.match = match

    def start(self) -> None:
        """Act as the match begins: pieces are staged and robots are at their start poses."""

    def start_mode(self, mode: str) -> None:
        """Act after a driver station has enabled `auto` or `teleop`."""

    def before_tick(self) -> None:
        """Act after robot code has given its commands, before anything moves."""

    def worth(self, zone: ScoringZone) -> int:
        """Return the points of a piece that would score in a zone now.

        This method must not change anything, and neither may `game_data`, `breakdown` or `channels`: pages and
        dashboards call them at any time. Effects of a scoring piece belong in `scored`.
        """
        return zone.points

    def scored(self, event: ScoreEvent) -> None:
        """Act after a piece has scored; it is off the field."""

    def placed(self, event: PlaceEvent) -> None:
        """Act after a piece has come to rest in a place where it counts."""

    def removed(self, event: PlaceEvent) -> None:
        """Act after a placed piece has left its place: it fell, or a robot took it."""

    def after_tick(self) -> None:
        """Act after everything has moved and scored; telemetry comes next."""

    def end(self) -> None:
        """Act after the last phase; called once."""

    def human_actions(self) -> Sequence[HumanAction]:
        """Return the actions of human players; empty if the game has none. All runs of a match have the same names."""
        return ()

    def game_data(self) -> str:
        """Return the game-specific message that robots receive now; empty for none."""
        return ""

    def breakdown(self) -> Mapping[str, int]:
        """Return the parts of the score by name, in addition to the pieces of each zone."""
        return {}


Staging: TypeAlias = Callable[[np.random.Generator, Sequence[RobotEntry]], Sequence[StagedPieces]]
"""Function that returns the pieces staged for these robots, in blue's field frame, without preloads."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Game:
    """Definition of a year's game. Make variants with `dataclasses.replace`."""

    name: str
    """Name for `--game` and telemetry: letters, digits and `_`."""
    year: int
    title: str = ""
    """Title for people; empty: the name in capitals."""
    field: FieldDefinition
    pieces: tuple[PieceSupply, ...]
    clock: MatchClock
    assessment: float = 0.0
    """Time between the end of the clock and the final score of a whole match [s]."""
    staging: Staging
    zones: tuple[ScoringZone, ...] = ()
    places: tuple[RestingPlace, ...] = ()
    """Places where pieces stay and count as placed."""
    rules: Callable[[PlayedMatch], Rules] = Rules
    robot: Callable[[], RobotConfig]
    """Function that makes the default robot's config."""
    starts: tuple[Pose, ...]
    """Start poses of an alliance's robots, as blue robots [m, m, rad]."""
    preload: int = 0
    """Maximum number of pieces that a robot may hold at the start."""
    robots: int = 6
    """Maximum number of robots in a match."""
    autos: Mapping[str, Auto] = dataclasses.field(default_factory=dict)
    """Autos by name; the first is the default."""
    roles: Mapping[str, Role] = dataclasses.field(default_factory=dict)
    """Roles of scripted players, by name."""
    driving: Driving | None = None
    """Controls for a user who drives the game's robot; None: driving and the intake only."""
    practice_matches: Mapping[str, tuple[str, str]] = dataclasses.field(default_factory=dict)
    """Whole matches to run a team's robot code in, by name: roles of its partners and of its opponents."""
    options: tuple[GameOption, ...] = ()
    arrange: Callable[[FieldDefinition, frozenset[str]], FieldDefinition] | None = None
    """Function that changes the field for the options that are on; None: options leave the field unchanged."""
    models: Path | None = None
    """Folder of models for AdvantageScope and the browser view."""

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
        """Title for people."""
        return self.title or self.name.upper()

    def auto(self, name: str | None = None) -> Auto:
        """Return the auto of a name; None: the first.

        Raises:
            UnknownNameError: If there is no such auto; the error lists the nearest names.
            ConfigError: If the game has no auto at all.
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
        """Make an empty game: a carpet with a wall around it, for experiments and tests.

        Args:
            size: Length and width of the field [m].
            elements: Elements on the field, in addition to the wall.
            drivable: Name patterns of the elements that robots drive on.
            pieces: Kinds of pieces; none are on the field until `match.pieces.spawn` puts them there.
            robot: The default robot; None: 55 kg on four swerve modules, without mechanisms.
            zones: Zones where pieces score.
            places: Places where pieces stay and count.
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
