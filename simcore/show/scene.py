"""Scene of a run: the parts of a drawing that telemetry does not contain, e.g. field, goals and looks of robots.

The motion comes from telemetry. `simcore.show.run_track` reads the motion from a recording.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from simcore.errors import ConfigError
from simcore.match.runner import split_level
from simcore.pieces.kinds import GamePieceConfig
from simcore.quantities import FIELD_LENGTH, ROBOT_LENGTH, require_fields
from simcore.show.palette import shade
from simcore.telemetry.snapshot import robot_prefix
from simcore.typing import FloatArray
from simcore.world.shapes import Compound, Shape, Sphere, bounding_box, outline_points, support
from simcore.world.zones import BoxZone, CapsuleZone, CylinderZone, Zone

if TYPE_CHECKING:
    from simcore.match.game import Game
    from simcore.match.match import Match
    from simcore.match.scoring import ScoringZone
    from simcore.pieces.resting_places import RestingPlace
    from simcore.robot.robot_config import RobotConfig
    from simcore.world.field import FieldElement, FieldGeometry

__all__ = [
    "PLAIN_PIECE",
    "Goal",
    "LevelLook",
    "PieceLook",
    "RobotLook",
    "Scene",
    "bare_scene",
    "piece_look",
    "scene_of",
    "shape_look",
]


_STEEL, _HANGING = "#9ea5ae", {"blue": "#4a6db0", "red": "#b0564f"}


@dataclass(frozen=True, slots=True, kw_only=True)
class PieceLook:
    """Look of one kind of piece: a disk or a box seen from above, colors, and a shape for the 3D view."""

    color: str
    """Color of a piece on the carpet, `#rrggbb`."""
    radius: float | None = None
    """Radius of a ball, or of a cylinder with a vertical axis [m]; None if `size` is given."""
    size: tuple[float, float, float] | None = None
    """Size of the bounding box along the piece's x, y and z axes [m]; None for a piece that is drawn as a disk."""
    air_color: str = ""
    """Color of a piece in the air; empty for a darker shade of `color`."""
    edge_color: str = ""
    """Color of the piece's outline; empty for half the brightness of `color`."""
    shape: Shape | None = None
    """Shape of the piece in three dimensions; None for a ball of `radius` or a box of `size`."""

    def __post_init__(self) -> None:
        require_fields(self, radius=FIELD_LENGTH, size=(FIELD_LENGTH,) * 3)
        if (self.radius is None) == (self.size is None):
            raise ConfigError(f"PieceLook: give radius or size, one of them; got {self.radius} and {self.size}")
        object.__setattr__(self, "air_color", self.air_color or shade(self.color, 0.75))
        object.__setattr__(self, "edge_color", self.edge_color or shade(self.color, 0.5))

    @property
    def reach(self) -> float:
        """Largest distance from the center to the outline [m]."""
        return self.radius if self.radius is not None else 0.5 * math.hypot(*(self.size or ()))

    @property
    def hole(self) -> float | None:
        """Radius of the hole along the z axis of a body of revolution [m]; 0 without a hole.

        None if the body is not a body of revolution about the z axis, or if no shape is given.
        """
        if self.shape is None:
            return None
        turn = np.arange(24) * math.tau / 24
        reach = support(self.shape, np.column_stack((np.cos(turn), np.sin(turn), np.zeros(24))))
        if np.ptp(reach) > _ROUND * reach.max():
            return None
        return float(np.hypot(*outline_points(self.shape)[:, :2].T).min()) if isinstance(self.shape, Compound) else 0.0


_ROUND = 0.05  # relative variation of the radius allowed for a round body, because rings consist of segments

PLAIN_PIECE = PieceLook(radius=0.1, color="#f2c511")
"""Look of a piece of an unknown kind."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotLook:
    """Look of one robot, and the prefix of the robot's telemetry keys."""

    bumpers: tuple[float, float]
    """Length and width over the bumpers [m]."""
    alliance: str = "blue"
    prefix: str = "Sim"
    """Beginning of the robot's telemetry keys, e.g. `<prefix>/Robot/Pose3d`."""
    intakes: Sequence[FloatArray] = ()
    """Outline of the zone of each deployed intake, seen from above, robot frame [m], shape (n, 2) each."""
    config: RobotConfig | None = None
    """Config of the robot; None if only telemetry is available."""
    models: Path | None = None
    """Folder whose first robot model shows the body and components; None to draw the robot from simple shapes."""
    name: str = ""
    """Name of the robot on the page; empty to use the robot's number."""
    team: str = ""
    """Team number on the bumpers; empty for the robot's number in the match."""
    role: str = ""
    """Role and level of the scripted player of the robot in a match, e.g. `collector:3`; empty without a match."""
    ink: str = ""
    """Name, in `COLORS`, of the color of the robot's path and curves; empty for the color of the alliance."""
    score_key: str = ""
    """Telemetry key of the score of the robot's run on a page of two runs; empty on other pages."""

    def __post_init__(self) -> None:
        require_fields(self, bumpers=(ROBOT_LENGTH, ROBOT_LENGTH))

    @property
    def pose_key(self) -> str:
        """Telemetry key of the robot's true pose."""
        return f"{self.prefix}/Robot/Pose3d"


@dataclass(frozen=True, slots=True, kw_only=True)
class Goal:
    """Target of an alliance's shots."""

    alliance: str
    center: tuple[float, float, float]
    """Center of the goal's opening, field frame [m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LevelLook:
    """Group of scoring places with a common count of pieces, e.g. one level of a scoring structure."""

    name: str
    """Name of the level, as in `Sim/Places/<name>`."""
    alliance: str = ""
    """Alliance that owns the level; empty for a neutral level."""
    label: str
    """Name of the level without the alliance."""
    places: tuple[str, ...] = ()
    """Name of each place without the alliance and the label."""
    is_single: bool = False
    """Whether at most one piece counts in each place."""
    middle: tuple[float, float] | None = None
    """Mean center of the places' zones, field frame [m]; None if no zone has a known center."""

    @property
    def key(self) -> str:
        """Telemetry key of the number of pieces in each place."""
        return f"Sim/Places/{self.name}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """Parts of a drawing of a run that telemetry does not contain: field, looks of robots and pieces, and goals."""

    field_size: tuple[float, float]
    """Length and width of the field [m]."""
    field_outlines: Sequence[tuple[str, FloatArray]] = ()
    """Name and outline of each field element, seen from above [m], shape (n, 2). The color is that of the alliance if
    the name begins with `blue` or `red`."""
    field_elements: Sequence[FieldElement] = ()
    """Field elements in three dimensions; the page draws the elements if the field has no model."""
    hanging: Sequence[PieceLook] = ()
    """Looks of the bodies that hang from the field, in the order of `Sim/Hanging`."""
    robots: Sequence[RobotLook] = ()
    pieces: Mapping[str, PieceLook] = field(default_factory=dict)
    """Looks of pieces by name of the kind, as in `Sim/GamePieces/<Type>`."""
    goals: Sequence[Goal] = ()
    """Goals at which robots shoot."""
    levels: Sequence[LevelLook] = ()
    """Levels of scoring places, in the game's order."""
    models: Path | None = None
    """Folder with the model of the field; None to draw the field's elements."""
    tags: str | Path = ""
    """Layout of the AprilTags, as in `FieldDefinition.tags`; empty for no tags."""

    def __post_init__(self) -> None:
        require_fields(self, field_size=(FIELD_LENGTH, FIELD_LENGTH))
        for name, corners in self.field_outlines:
            if np.ndim(corners) != 2 or np.shape(corners)[1] != 2:
                raise ConfigError(f"Scene: the outline {name!r} needs shape (n, 2), got {np.shape(corners)}")

    @property
    def piece_names(self) -> str:
        """Names of all kinds of pieces in lower case, separated by commas; `pieces` without kinds.

        >>> Scene(field_size=(1.0, 1.0), pieces={"Ball": PLAIN_PIECE, "Crate": PLAIN_PIECE}).piece_names
        'ball, crate'
        """
        return ", ".join(name.lower() for name in self.pieces) or "pieces"

    def label(self, number: int) -> str:
        """Return the label of a robot in texts: the name, or the team number, or `robot <number>` without both."""
        robot = self.robots[number] if number < len(self.robots) else None
        return (robot.name or robot.team if robot is not None else "") or f"robot {number}"

    def with_models(self, folder: Path) -> Scene:
        """Return a copy that uses the models in a folder.

        The copy keeps the robots' models if the folder has no robot model, and the field's models if the folder has no
        field model.
        """
        models = list(folder.glob("Robot_*")) and folder
        robots = [replace(look, models=models or look.models) for look in self.robots]
        return replace(self, robots=robots, models=folder if any(folder.glob("Field3d_*")) else self.models)

    def look(self, name: str) -> PieceLook:
        """Return the look of the kind of piece `name`, or `PLAIN_PIECE` for an unknown kind."""
        return self.pieces.get(name, PLAIN_PIECE)


def piece_look(kind: GamePieceConfig) -> PieceLook:
    """Return the look of a kind of piece, from the shape and color in the config."""
    return shape_look(kind.shape, kind.color)


def shape_look(shape: Shape, color: str) -> PieceLook:
    """Return the look of a body with a shape and a color: a disk for a sphere, a box for any other shape."""
    if isinstance(shape, Sphere):
        return PieceLook(radius=shape.radius, color=color)
    low, high = bounding_box(shape)
    length, width, height = (high - low).tolist()
    return PieceLook(size=(length, width, height), color=color, shape=shape)


def bare_scene(game: Game) -> Scene:
    """Return a scene with the field of a game and without robots."""
    return _scene(game, game.field.load(), ())


def scene_of(match: Match) -> Scene:
    """Return the scene of a match that is in progress or closed."""
    from simcore.show.robot_outlines import intake_outlines  # not needed for logs: imports all robot modules

    robots, parts = [], [component.name for component in match.game.robot().components]
    for robot in match.robots:
        body = robot.chassis.config
        look = RobotLook(
            alliance=match.alliances[robot.number],
            bumpers=(body.bumper_length, body.bumper_width),
            prefix=robot_prefix(robot.number),
            intakes=intake_outlines(robot.config),
            config=robot.config,
            role=match.record.robots[robot.number].player,
            models=robot.config.models
            or (match.game.models if [part.name for part in robot.config.components] == parts else None),
            team="" if robot.config.team is None else str(robot.config.team),
        )
        robots.append(look)
    return _scene(match.game, match.field, robots)


def _scene(game: Game, geometry: FieldGeometry, robots: Sequence[RobotLook]) -> Scene:
    return Scene(
        field_size=game.field.size,
        field_outlines=geometry.outlines(),
        field_elements=geometry.elements,
        hanging=[shape_look(body.shape, _HANGING.get(body.alliance or "", _STEEL)) for body in game.field.hanging],
        robots=robots,
        goals=[goal for zone in game.zones for goal in _goals(zone)],
        pieces={supply.kind.name: piece_look(supply.kind) for supply in game.pieces},
        levels=_levels(game.places),
        models=game.models,
        tags=game.field.tags,
    )


def _levels(places: Sequence[RestingPlace]) -> list[LevelLook]:
    levels: dict[str, list[RestingPlace]] = {}
    for place in places:
        if place.level:
            levels.setdefault(place.level, []).append(place)
    return [_level(name, found) for name, found in levels.items()]


def _level(name: str, places: Sequence[RestingPlace]) -> LevelLook:
    alliance, label = split_level(name)
    known = {alliance, label.lower(), name.lower()}
    middles = [middle for place in places if (middle := _middle(place.zone)) is not None]
    return LevelLook(
        name=name,
        alliance=alliance,
        label=label,
        places=tuple(" ".join(w for w in place.name.split() if w.lower() not in known) for place in places),
        is_single=all(place.capacity == 1 for place in places),
        middle=(float(np.mean([x for x, _ in middles])), float(np.mean([y for _, y in middles]))) if middles else None,
    )


def _middle(zone: Zone) -> tuple[float, float] | None:
    """Return x and y of the center of a box, cylinder or capsule zone [m]; None for any other zone."""
    if isinstance(zone, CylinderZone):
        return zone.center
    if isinstance(zone, BoxZone):
        return 0.5 * (zone.low[0] + zone.high[0]), 0.5 * (zone.low[1] + zone.high[1])
    if isinstance(zone, CapsuleZone):
        return 0.5 * (zone.start[0] + zone.end[0]), 0.5 * (zone.start[1] + zone.end[1])
    return None


def _goals(scoring: ScoringZone) -> list[Goal]:
    """Return a list with a goal at the top center of a scoring zone; empty unless the zone is a box or a cylinder."""
    zone, middle = scoring.zone, _middle(scoring.zone)
    if middle is None or not isinstance(zone, BoxZone | CylinderZone):
        return []
    top = zone.high[2] if isinstance(zone, BoxZone) else zone.top
    return [Goal(alliance=scoring.alliance, center=(*middle, top))]
