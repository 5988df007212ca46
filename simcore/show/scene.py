"""What a drawing of a run needs beside its telemetry: the field, the looks of robots and pieces, the shots, colors."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from simcore.errors import ConfigError, require_positive
from simcore.physics.shapes import Cylinder, Sphere, bounding_box
from simcore.pieces.kinds import GamePieceConfig
from simcore.telemetry.snapshot import robot_prefix
from simcore.typing import FloatArray

if TYPE_CHECKING:
    from simcore.match.game import Game
    from simcore.match.match import Match

__all__ = [
    "CARPET", "GRID", "HIT", "INK", "MISS", "MUTED", "PATH", "PLAIN_PIECE",
    "PieceLook", "RobotLook", "Scene", "ShotTrace", "bare_scene", "piece_look", "rgb", "scene_of", "tint",
]  # fmt: skip

CARPET, INK, MUTED, GRID = "#d3d6da", "#20242b", "#5b6470", "#dfe2e6"
HIT, MISS = "#0e8a43", "#e0620d"
"""The same in pictures, pages and animations."""
PATH = "#6a3fb5"
"""A hue that neither shots nor alliances use."""

_TINTS = {"blue": ("#9db4dd", "#2f5fae"), "red": ("#e3a9a6", "#b3312b")}
_NEUTRAL = ("#b4b9c0", "#7d858f")


def tint(name: str) -> tuple[str, str]:
    """Fill and edge of what belongs to an alliance, by its name or by one that begins so.

    >>> tint("blue_tower")
    ('#9db4dd', '#2f5fae')
    """
    return next((colors for alliance, colors in _TINTS.items() if name.lower().startswith(alliance)), _NEUTRAL)


def rgb(color: str) -> tuple[int, int, int]:
    """As whole numbers of 0 to 255.

    >>> rgb("#0e8a43")
    (14, 138, 67)
    """
    return int(color[1:3], 16), int(color[3:5], 16), int(color[5:7], 16)


def _shade(color: str, part: float) -> str:
    return "#" + "".join(f"{round(part * value):02x}" for value in rgb(color))


@dataclass(frozen=True, slots=True, kw_only=True)
class PieceLook:
    """How pieces of one type are drawn from above: as a disk, or as a rectangle turned by the piece's attitude.

    >>> PieceLook(size=(0.3, 0.1, 0.1), color="#ffffff").rectangles(np.array([[1.0, 2.0, 0.05, 1.0, 0.0, 0.0, 0.0]]))
    array([[0.3, 0.1, 0. ]])
    """

    color: str
    """Of a piece on the floor, `#rrggbb`."""
    radius: float | None = None
    """Of a ball, or of a cylinder that stands [m]; None for a box."""
    size: tuple[float, float, float] | None = None
    """Of a box, and of a cylinder that may lie, along the x, y and z of the piece [m]; None for a disk."""
    air_color: str = ""
    """Of a piece in the air; empty: a darker `color`."""
    edge_color: str = ""
    """Of its outline; empty: half as bright as `color`."""

    def __post_init__(self) -> None:
        if (self.radius is None) == (self.size is None):
            raise ConfigError(f"PieceLook: give radius or size, one of them; got {self.radius} and {self.size}")
        for name, value in (("radius", self.radius), *(("size", value) for value in self.size or ())):
            if value is not None:
                require_positive("PieceLook", name, value, "m")
        object.__setattr__(self, "air_color", self.air_color or _shade(self.color, 0.75))
        object.__setattr__(self, "edge_color", self.edge_color or _shade(self.color, 0.5))

    @property
    def reach(self) -> float:
        """Of the outline from its middle at most [m]."""
        return self.radius if self.radius is not None else 0.5 * math.hypot(*(self.size or ()))

    def rectangles(self, rows: FloatArray) -> FloatArray:
        """The smallest rectangle along the longest edge, as seen from above, around each box.

        Args:
            rows: Poses `x, y, z, qw, qx, qy, qz`, shape (n, 7).

        Returns:
            Length and width [m] and the heading of the length [rad] in (-pi/2, pi/2], shape (n, 3). A disk has its
            diameter twice and heading 0.
        """
        if self.size is None:
            return np.tile([2.0 * self.reach, 2.0 * self.reach, 0.0], (len(rows), 1))
        w, x, y, z = (rows[:, column] for column in (3, 4, 5, 6))
        axes = np.array(  # x and y of the turned axes of the piece, shape (2, 3, n)
            [
                [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
                [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            ]
        )
        edges = np.moveaxis(axes, 2, 0) * np.array(self.size)  # from above [m], shape (n, 2, 3)
        longest = np.linalg.norm(edges, axis=1).argmax(axis=1)
        along = edges[np.arange(len(rows)), :, longest]
        heading = np.arctan2(along[:, 1], along[:, 0])
        cos, sin = np.cos(heading)[:, None], np.sin(heading)[:, None]
        length = np.abs(cos * edges[:, 0] + sin * edges[:, 1]).sum(axis=1)
        width = np.abs(cos * edges[:, 1] - sin * edges[:, 0]).sum(axis=1)
        return np.column_stack((length, width, np.pi / 2 - (np.pi / 2 - heading) % np.pi))

    def corners(self, rows: FloatArray) -> FloatArray:
        """Corners of `rectangles` where the pieces are, field frame [m], shape (n, 4, 2)."""
        length, width, heading = self.rectangles(rows).T
        cos, sin = np.cos(heading)[:, None], np.sin(heading)[:, None]
        x = 0.5 * length[:, None] * np.array([1.0, 1.0, -1.0, -1.0])
        y = 0.5 * width[:, None] * np.array([1.0, -1.0, -1.0, 1.0])
        return np.stack((rows[:, :1] + cos * x - sin * y, rows[:, 1:2] + sin * x + cos * y), axis=2)


PLAIN_PIECE = PieceLook(radius=0.1, color="#f2c511")
"""Of a type that the scene does not know."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotTrace:
    """The flight of one piece."""

    points: FloatArray
    """Centers from the muzzle to where it scored or first touched, field frame [m], shape (m, 3)."""
    scored: bool
    time: float = 0.0
    """When it left the muzzle, simulated [s]."""
    robot: int = 0
    """Number of the robot that shot it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotLook:
    """How one robot is drawn, and which telemetry is its own."""

    bumpers: tuple[float, float]
    """Length and width over the bumpers [m]."""
    alliance: str = "blue"
    prefix: str = "Sim"
    """Its keys begin so: `<prefix>/Robot/Pose3d`, `<prefix>/Debug/BatteryVoltage`."""

    def __post_init__(self) -> None:
        require_positive("RobotLook", "bumpers[0]", self.bumpers[0], "m")
        require_positive("RobotLook", "bumpers[1]", self.bumpers[1], "m")

    @property
    def pose_key(self) -> str:
        """Of its true pose."""
        return f"{self.prefix}/Robot/Pose3d"


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """Everything that is drawn and is in no telemetry key."""

    field_size: tuple[float, float]
    """Length and width of the field [m]."""
    field_outlines: Sequence[tuple[str, FloatArray]] = ()
    """Name and corners of each element from above [m], shape (n, 2); `blue...` and `red...` are tinted so."""
    robots: Sequence[RobotLook] = ()
    pieces: Mapping[str, PieceLook] = field(default_factory=dict)
    """By type name, as in `Sim/GamePieces/<Type>`."""
    shots: Sequence[ShotTrace] = ()
    """In the order in which they were shot."""
    intakes: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    """Where pieces were taken in, field frame [m], shape (n, 3)."""

    def __post_init__(self) -> None:
        require_positive("Scene", "field_size[0]", self.field_size[0], "m")
        require_positive("Scene", "field_size[1]", self.field_size[1], "m")
        if self.intakes.ndim != 2 or self.intakes.shape[1] != 3:
            raise ConfigError(f"Scene: intakes need shape (n, 3), got {self.intakes.shape}")

    @property
    def hits(self) -> int:
        """Shots that scored."""
        return sum(shot.scored for shot in self.shots)

    @property
    def piece_names(self) -> str:
        """What texts call the pieces.

        >>> Scene(field_size=(1.0, 1.0), pieces={"Ball": PLAIN_PIECE, "Crate": PLAIN_PIECE}).piece_names
        'ball, crate'
        """
        return ", ".join(name.lower() for name in self.pieces) or "pieces"

    def look(self, name: str) -> PieceLook:
        """Of a type of piece; a plain one for a type that the scene does not know."""
        return self.pieces.get(name, PLAIN_PIECE)


def piece_look(kind: GamePieceConfig) -> PieceLook:
    """How pieces of a kind are drawn."""
    shape = kind.shape
    if isinstance(shape, Sphere):
        return PieceLook(radius=shape.radius, color=kind.color)
    if isinstance(shape, Cylinder):
        return PieceLook(size=(2.0 * shape.radius, 2.0 * shape.radius, shape.height), color=kind.color)
    low, high = bounding_box(shape)
    length, width, height = (high - low).tolist()
    return PieceLook(size=(length, width, height), color=kind.color)


def bare_scene(game: Game) -> Scene:
    """The field alone, for a run of which only the log is left."""
    return Scene(
        field_size=game.field.size,
        field_outlines=game.field.load().outlines(),
        pieces={supply.kind.name: piece_look(supply.kind) for supply in game.pieces},
    )


def scene_of(match: Match) -> Scene:
    """The scene of a match as it is now, also after it was closed."""
    robots = []
    for robot in match.robots:
        c = robot.chassis.config
        look = RobotLook(
            alliance=match.alliances[robot.number],
            bumpers=(c.bumper_length, c.bumper_width),
            prefix=robot_prefix(robot.number),
        )
        robots.append(look)
    return Scene(
        field_size=match.game.field.size,
        field_outlines=match.field.outlines(),
        robots=robots,
        shots=[
            ShotTrace(points=np.array(shot.points), scored=shot.scored, time=shot.time, robot=shot.robot)
            for shot in match.flow.shots
        ],
        intakes=np.array(match.flow.intakes, dtype=np.float64).reshape(-1, 3),
        pieces={supply.kind.name: piece_look(supply.kind) for supply in match.game.pieces},
    )
