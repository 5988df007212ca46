"""What the player draws in three dimensions: models of fields and robots, or boxes of a robot's own, as triangles.

Meshes of one color that move together are one solid: what a browser draws is counted by solids.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from simcore.errors import ModelError
from simcore.pieces.launch import muzzle_offset
from simcore.robot.chassis_config import ChassisConfig
from simcore.robot.intake import is_deployed
from simcore.robot.mechanisms import PistonConfig
from simcore.robot.robot_config import RobotConfig, build_mechanism, telemetry_name
from simcore.robot.shooter import ShooterConfig
from simcore.show.palette import COLORS, screen_color
from simcore.show.robot_outlines import Posed, deployed, zone_corners
from simcore.show.scene import RobotLook
from simcore.show.view_models import Model, RobotModels
from simcore.telemetry.snapshot import Snapshot
from simcore.typing import FloatArray, IntArray
from simcore.world.footprints import box_corners
from simcore.world.linkage import Joint, part_pose
from simcore.world.rotation import Vector, from_rpy

__all__ = [
    "BUMPER", "RobotSolids", "Solid", "chassis_boxes", "described_solids", "extents", "model_solids", "robot_solids",
]  # fmt: skip

BUMPER = "bumper"
"""Name of a solid that is painted in the color of the robot's alliance."""
_ROD = 0.015  # [m]; half the thickness of a drawn link
_SHOT_LENGTH, _CONE_LENGTH = 0.38, 0.55  # [m]; of drawn shots and of what cameras see
_PLAIN = "#ffce14"
_BLUE, _WHITE, _BLACK, _STEEL, _DARK = "#1e54b7", "#ebecee", "#1c1e22", "#9ea5ae", "#3a3f47"
_HALF_TIRE = 0.019  # [m]; half the width of a drawn wheel
_MOST_VERTICES = 65_000  # of a solid: their numbers are 16-bit

_NAMES = {
    "hit": "intake, out", "miss": "shot", "path": "claw", "ghost": "hook", "ink": "part", "muted": "link",
    "control": "way of a slide",
}  # fmt: skip
"""Names of what mechanisms carry, by its color."""

PartPose = Callable[[Snapshot], "FloatArray | None"]
"""Pose of a part in the robot frame at a snapshot, `x, y, z, qw, qx, qy, qz`, shape (7,); None: it is not there."""


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """Triangles in one color."""

    name: str
    """`BUMPER`, a prefix that was asked for, or empty."""
    color: str
    opacity: float
    vertices: FloatArray
    """In the frame of its owner [m], shape (n, 3)."""
    faces: IntArray
    """Rows of `vertices`, shape (m, 3)."""


@dataclass(frozen=True, slots=True, eq=False)
class RobotSolids:
    """A robot: what does not move in it, and its parts."""

    body: Sequence[Solid]
    parts: Sequence[tuple[Sequence[Solid], PartPose]]


@functools.lru_cache(maxsize=128)
def model_solids(model: Model, names: tuple[str, ...] = ()) -> tuple[Solid, ...]:
    """The solids of a GLB file, read once for all robots that have it; a texture is seen as its mean color.

    Args:
        model: The file and its place.
        names: Meshes whose names begin so keep that name, those of bumpers theirs; all others have none.

    Raises:
        ModelError: The file cannot be read.
    """
    return tuple(_joined([_solid(name, mesh, whole, names) for name, mesh, whole in _placed_meshes(model)]))


def _solid(name: str, mesh: Any, place: FloatArray | None = None, names: Iterable[str] = ()) -> Solid:
    """A mesh of trimesh in one color; see `model_solids`."""
    known = BUMPER if BUMPER in name.lower() else next((one for one in names if name.startswith(one)), "")
    material = getattr(mesh.visual, "material", None)
    color, opacity = _PLAIN, 1.0
    if material is not None:
        *linear, alpha = (float(c) / 255.0 for c in material.main_color)
        color, opacity = screen_color(linear), round(alpha, 2)
    vertices = np.asarray(mesh.vertices)
    if place is not None:
        vertices = vertices @ place[:3, :3].T + place[:3, 3]
    return Solid(known, color, opacity, vertices, np.asarray(mesh.faces))


def robot_solids(look: RobotLook, models: RobotModels | None, parts: int) -> RobotSolids:
    """The solids of a robot: of its models if they are its own, else boxes by its config.

    Args:
        look: The robot.
        models: Of a robot with as many parts and as long as this one; of another one only its parts are taken.
        parts: How many component poses its telemetry has.
    """
    key = f"{look.prefix}/Robot/ComponentPoses"
    body: Sequence[Solid] = []
    moving: list[tuple[Sequence[Solid], PartPose]] = []
    try:
        if models is not None and len(models.parts) == parts:
            body = model_solids(models.body)
            moving = [(model_solids(part), _component(key, k)) for k, part in enumerate(models.parts)]
    except ModelError:  # boxes will do
        body, moving = [], []
    reach = max((float(one.vertices[:, 0].max()) for one in body), default=0.0)
    if abs(2.0 * reach - look.bumpers[0]) > 0.02:
        body = _sketched_body(look)
    if look.config is not None:
        posed = _posed(look.config, f"{look.prefix}/Debug/")
        moving += _carried(look.config, posed, has_models=bool(moving))
    return RobotSolids(body, moving)


def described_solids(config: RobotConfig) -> list[tuple[str, Solid]]:
    """Return names and solids of a robot by its config, robot frame: intakes out, all else as it starts."""
    mechanisms = {name: build_mechanism(one) for name, one in config.mechanisms.items()}
    stands = {name: Posed(one.position, one.stops) for name, one in mechanisms.items()}
    for intake in config.intakes:
        stands |= deployed(intake, mechanisms)
    look = RobotLook(bumpers=(config.body.bumper_length, config.body.bumper_width), config=config)
    found = [("", solid) for solid in _sketched_body(look)]
    names = {_ink(ink): name for ink, name in _NAMES.items()}
    for solids, pose in _carried(config, lambda _: stands, has_models=False):
        at = pose(Snapshot(time=0.0, tick=0))
        if at is not None:
            turn = Rotation.from_quat(np.roll(at[3:], -1))
            found += [(names[one.color], replace(one, vertices=at[:3] + turn.apply(one.vertices))) for one in solids]
    for storage in (config.storage, *config.more_storages) if config.intakes or config.shooters else ():
        found.append(("storage", _hull("", "#8a6a00", 0.12, box_corners(storage.low, storage.high))))
    for camera in config.cameras:
        fovs = camera.type.horizontal_fov_deg, camera.type.vertical_fov_deg
        across, up = (math.tan(math.radians(0.5 * fov)) for fov in fovs)
        rays = np.array([(1.0, a * across, b * up) for a in (-1.0, 1.0) for b in (-1.0, 1.0)])
        rays *= _CONE_LENGTH / math.hypot(1.0, across, up)
        ends = Rotation.from_quat(camera.mount.rotation).apply(rays)
        apex = np.array(camera.mount.position)
        found.append(("camera", _hull("", "#0b6675", 0.25, np.vstack((apex, apex + ends)))))
    return found


# --- models -----------------------------------------------------------------------------------------------------------


def _placed_meshes(model: Model) -> Iterator[tuple[str, Any, FloatArray]]:
    """Each mesh of a file by its name, and where it is in the frame of the model's owner [m], shape (4, 4)."""
    scene = _load(model.path)
    for node in scene.graph.nodes_geometry:
        place, name = scene.graph[node]
        if len(getattr(scene.geometry[name], "faces", ())):
            yield name, scene.geometry[name], model.transform @ place


def extents(path: Path) -> list[float]:
    """Length, width and height of all that is in a GLB file, as exported; zeros of an empty one.

    Raises:
        ModelError: The file cannot be read.
    """
    size = _load(path).extents
    return [0.0] * 3 if size is None else np.asarray(size).tolist()


def _load(path: Path) -> Any:
    import trimesh

    try:
        return trimesh.load_scene(path)
    except Exception as error:  # trimesh passes on whatever its parser stumbles over
        raise ModelError(f"{path.parent.name}/{path.name} is no readable GLB: {error}") from error


def _joined(solids: Sequence[Solid]) -> list[Solid]:
    """Those of one name, color and opacity as one, as long as their vertices can be numbered."""
    groups: dict[tuple[str, str, float], list[Solid]] = {}
    found = []
    for solid in solids:
        for part in _split(solid):
            mine = groups.setdefault((part.name, part.color, part.opacity), [])
            if sum(len(one.vertices) for one in mine) + len(part.vertices) > _MOST_VERTICES:
                found.append(_concatenated(mine))
                mine.clear()
            mine.append(part)
    return found + [_concatenated(mine) for mine in groups.values()]


def _split(solid: Solid) -> Iterator[Solid]:
    """A solid with too many vertices as several."""
    step = _MOST_VERTICES // 3
    if len(solid.vertices) <= _MOST_VERTICES:
        yield solid
        return
    for first in range(0, len(solid.faces), step):
        rows, faces = np.unique(solid.faces[first : first + step], return_inverse=True)
        yield replace(solid, vertices=solid.vertices[rows], faces=faces.reshape(-1, 3))


def _concatenated(solids: Sequence[Solid]) -> Solid:
    starts = np.cumsum([0, *(len(one.vertices) for one in solids[:-1])])
    faces = np.concatenate([one.faces + start for one, start in zip(solids, starts, strict=True)])
    return replace(solids[0], vertices=np.concatenate([one.vertices for one in solids]), faces=faces)


def _hull(name: str, color: str, opacity: float, corners: FloatArray) -> Solid:
    """The convex hull of some corners, every face with vertices of its own so that edges are sharp."""
    import trimesh  # takes half a second

    mesh = trimesh.convex.convex_hull(corners)
    vertices = np.asarray(mesh.vertices)[np.asarray(mesh.faces)].reshape(-1, 3)
    return Solid(name, color, opacity, vertices, np.arange(len(vertices)).reshape(-1, 3))


# --- a robot of boxes -------------------------------------------------------------------------------------------------


def _component(key: str, number: int) -> PartPose:
    def pose(snapshot: Snapshot) -> FloatArray | None:
        rows = snapshot.pose_arrays.get(key, ())
        return rows[number] if number < len(rows) else None

    return pose


def chassis_boxes(body: ChassisConfig) -> dict[str, tuple[Vector, Vector, str]]:
    """Return bumpers, belly pan and modules of a robot by name: lower and upper corner [m], and color.

    Bumpers have no color: it is that of the alliance.
    """
    length, width, thick = body.bumper_length / 2.0, body.bumper_width / 2.0, body.bumper_thickness
    low, high = body.clearance + 0.02, body.bumper_top
    frame_x, frame_y = length - thick, width - thick
    middle = 0.5 * (low + high)
    end, half = (body.bay[0] - length, 0.5 * body.bay[1]) if body.bay else (-frame_x, 0.0)  # of what is cut out
    boxes: dict[str, tuple[Vector, Vector, str]] = {
        "bumper_front": ((frame_x, -width, low), (length, width, high), ""),
        "bumper_left": ((-frame_x, frame_y, low), (frame_x, width, high), ""),
        "bumper_right": ((-frame_x, -width, low), (frame_x, -frame_y, high), ""),
        "front_mark": ((length, -0.11, middle - 0.04), (length + 0.004, 0.11, middle + 0.04), _WHITE),
        "belly_pan": ((end, -frame_y, body.clearance), (frame_x, frame_y, low), _DARK),
    }
    for side, sign in (("left", 1), ("right", -1)):
        inner, outer = sorted((sign * half, sign * width))
        boxes[f"bumper_back_{side}"] = ((-length, inner, low), (-frame_x, outer, high), "")
        inner, outer = sorted((sign * half, sign * frame_y))
        if end > -frame_x:
            boxes[f"belly_pan_{side}"] = ((-frame_x, inner, body.clearance), (end, outer, low), _DARK)
    for i, (x, y) in enumerate(body.wheel_positions):
        boxes[f"swerve_module_{i}"] = ((x - 0.04, y - 0.04, 0.105), (x + 0.04, y + 0.04, 0.155), _STEEL)
    return boxes


def _sketched_body(look: RobotLook) -> list[Solid]:
    """Bumpers, frame and wheels; a robot of which nothing is known has usual ones."""
    body = ChassisConfig() if look.config is None else look.config.body
    solids = []
    for name, (low, high, color) in chassis_boxes(body).items():
        solids.append(_hull(BUMPER if BUMPER in name else "", color or _BLUE, 1.0, box_corners(low, high)))
    angles = np.linspace(0.0, math.tau, 20, endpoint=False)
    rim = body.wheel_radius * np.column_stack((np.cos(angles), np.zeros(20), 1.0 + np.sin(angles)))
    for x, y in body.wheel_positions:
        sides = [rim + np.array((x, y + side, 0.0)) for side in (-_HALF_TIRE, _HALF_TIRE)]
        solids.append(_hull("", _BLACK, 1.0, np.concatenate(sides)))
    if body.height > body.bumper_top + 0.01:
        x, y = 0.5 * body.bumper_length - body.bumper_thickness, 0.5 * body.bumper_width - body.bumper_thickness
        solids.append(_hull("", _STEEL, 0.25, box_corners((-x, -y, body.bumper_top), (x, y, body.height))))
    stretch = np.array((look.bumpers[0] / body.bumper_length, look.bumpers[1] / body.bumper_width, 1.0))
    return [replace(solid, vertices=stretch * solid.vertices) for solid in _joined(solids)]


def _carried(
    config: RobotConfig, posed: Callable[[Snapshot], Mapping[str, Posed]], *, has_models: bool
) -> Iterator[tuple[list[Solid], PartPose]]:
    """What mechanisms carry, as far as there is no model of it: links, claws, hooks, intakes, and where shots leave."""
    modelled = {component.joints for component in config.components} if has_models else set()
    hooks = [one for one in config.climbers if one.joints not in modelled]
    start = posed(Snapshot(time=0.0, tick=0))
    chains: list[tuple[str, tuple[Joint, ...], Vector, FloatArray]] = []
    chains += [("ghost", one.joints, one.offset, _cube(one.offset, one.reach)) for one in hooks]
    if not has_models:
        chains += [("path", one.joints, one.offset, zone_corners(one.zone)) for one in config.placers]
        chains += [("ink", one.joints, one.offset, _cube(one.offset, 2.0 * _ROD)) for one in config.components]
        for intake in config.intakes:
            joints, deploy = intake.joints, intake.deploy
            if any(joint.mechanism == deploy for joint in joints) or (joints and deploy is None):
                chains.append(("hit", joints, intake.zone.ball[0], zone_corners(intake.zone)))
                continue
            moves = joints or (() if intake.stretch is None else (intake.stretch,))
            zone = intake.zone if joints else replace(intake.zone, z_min=max(0.0, intake.zone.z_min))
            pose = _linked(posed, moves, None if deploy is None else (deploy, intake.deployed_at))
            yield [_hull("", _ink("hit"), 0.5, zone_corners(zone))], pose
        for shooter in config.shooters:
            yield [_hull("", _ink("miss"), 0.9, _SHOT)], _muzzle(posed, shooter)
    bodies: dict[tuple[Joint, ...], dict[object, Solid]] = {}
    for ink, joints, end, corners in chains:
        for number, joint in enumerate(joints):
            stops = [joint.ratio * stop for stop in start[joint.mechanism].stops]
            if joint.slides and all(map(math.isfinite, stops)):  # its way, in what carries it
                low, high = (np.array(joint.origin) + stop * np.array(joint.axis) for stop in stops)
                bodies.setdefault(joints[:number], {})[joint] = _hull("", _ink("control"), 0.4, _rod(low, high))
            after = joints[number + 1].origin if number + 1 < len(joints) else end
            if any(after):
                rod = _hull("", _ink("muted"), 1.0, _rod((0.0, 0.0, 0.0), after))
                bodies.setdefault(joints[: number + 1], {})[after] = rod
        bodies.setdefault(joints, {})[ink, end] = _hull("", _ink(ink), 0.6, corners)
    for joints, solids in bodies.items():
        yield _joined(list(solids.values())), _linked(posed, joints)


def _posed(config: RobotConfig, prefix: str) -> Callable[[Snapshot], Mapping[str, Posed]]:
    """Where the mechanisms of a robot stand at a snapshot."""
    known = []
    for name, mechanism in config.mechanisms.items():
        sim, key, unit = build_mechanism(mechanism), f"{prefix}{telemetry_name(name)}PositionRot", math.tau
        if isinstance(mechanism, PistonConfig):
            key, unit = f"{prefix}{telemetry_name(name)}ExtendedPct", 0.01 * mechanism.stroke
        known.append((name, key, unit, sim.position, sim.stops))

    def posed(snapshot: Snapshot) -> Mapping[str, Posed]:
        values = snapshot.doubles
        return {
            name: Posed(unit * values[key] if key in values else position, stops)
            for name, key, unit, position, stops in known
        }

    return posed


def _linked(
    posed: Callable[[Snapshot], Mapping[str, Posed]], joints: Sequence[Joint], deploy: tuple[str, Any] | None = None
) -> PartPose:
    """Of what joints carry; with `deploy` a mechanism and its stop, without which it is not there."""

    def pose(snapshot: Snapshot) -> FloatArray | None:
        now = posed(snapshot)
        if deploy is not None and not is_deployed(now[deploy[0]].position, now[deploy[0]].stops, deploy[1]):
            return None
        pos, (x, y, z, w) = part_pose(joints, now)
        return np.array((*pos, w, x, y, z))

    return pose


def _muzzle(posed: Callable[[Snapshot], Mapping[str, Posed]], shooter: ShooterConfig) -> PartPose:
    """Of its first barrel, with x along the shot."""

    def pose(snapshot: Snapshot) -> FloatArray:
        now = posed(snapshot)
        turned = 0.0 if shooter.turret is None else shooter.turret_ratio * now[shooter.turret].position
        raised = 0.0 if shooter.hood is None else shooter.elevation_per_hood * now[shooter.hood].position
        x, y, z, w = from_rpy(0.0, -(shooter.elevation + raised), shooter.launch.heading + turned)
        return np.array((*muzzle_offset(shooter.launch, 0, turned).tolist(), w, x, y, z))

    return pose


def _ink(name: str) -> str:
    return COLORS[name][0]


def _cube(center: Sequence[float] | FloatArray, half: float) -> FloatArray:
    return box_corners(np.array(center) - half, np.array(center) + half)


def _rod(start: Sequence[float] | FloatArray, end: Sequence[float] | FloatArray) -> FloatArray:
    return np.concatenate((_cube(start, _ROD), _cube(end, _ROD)))


_SHOT = np.concatenate((_cube((0.0, 0.0, 0.0), _ROD), [(_SHOT_LENGTH, 0.0, 0.0)]))
