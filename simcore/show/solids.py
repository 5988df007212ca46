"""Triangle meshes for the 3D view of a page, read from GLB models or built from shapes and robot configs.

The functions merge meshes that have the same color and move together into one solid, because the drawing time of a
browser grows with the number of solids.
"""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from simcore.errors import ModelError
from simcore.pieces.launch import muzzle_offset
from simcore.robot.chassis_config import ChassisConfig
from simcore.robot.climber import ClimberConfig
from simcore.robot.intake import IntakeConfig, IntakeZone, is_deployed
from simcore.robot.mechanisms import PistonConfig
from simcore.robot.robot_config import RobotConfig, build_mechanism, telemetry_name
from simcore.robot.shooter import ShooterConfig
from simcore.robot.swerve_config import SwerveConfig
from simcore.show.palette import COLORS, screen_color
from simcore.show.robot_outlines import Posed, deployed, zone_corners
from simcore.show.scene import RobotLook, Scene
from simcore.show.view_models import Model, RobotModels
from simcore.telemetry.snapshot import Snapshot
from simcore.typing import FloatArray, IntArray
from simcore.world.footprints import box_corners
from simcore.world.linkage import Joint, part_pose
from simcore.world.rotation import Vector, from_rpy, matrix
from simcore.world.shapes import Box, Mesh, Shape, Sphere, bounding_box, outline_points, parts_of

__all__ = [
    "BUMPER", "RobotSolids", "Solid", "chassis_boxes", "described_solids", "element_solids", "extents", "model_solids",
    "robot_solids", "shape_solids",
]  # fmt: skip

BUMPER = "bumper"
"""Name of solids drawn in the color of the robot's alliance."""
_ROD = 0.015  # [m]; half the thickness of a drawn link
_RAIL = 0.12  # [m]; distance of an elevator's rails from its center
_SHOT_LENGTH, _CONE_LENGTH = 0.38, 0.55  # [m]; lengths of drawn shots and camera cones
_PLAIN = "#ffce14"
_BLUE, _WHITE, _BLACK, _STEEL, _DARK = "#1e54b7", "#ebecee", "#1c1e22", "#9ea5ae", "#3a3f47"
_GLASS = "#cddeee"
_FIELD_COLORS = {"blue": "#3f66ad", "red": "#b3403b", "": _STEEL}
_BOARD = 0.94  # [m]; height of the driver stations' boards below the glass
_HALF_TIRE = 0.019  # [m]; half the width of a drawn wheel
_MOST_VERTICES = 65_000  # per solid, because vertex indices are 16-bit numbers

PartPose = Callable[[Snapshot], "FloatArray | None"]
"""Function of a snapshot that returns a part's robot-frame pose `x, y, z, qw, qx, qy, qz`, or None to hide the part."""


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """Triangle mesh of one color."""

    name: str
    """Name of the solid: `BUMPER`, a name prefix of field elements, or empty."""
    color: str
    opacity: float
    vertices: FloatArray
    """Vertices in the frame of the object that the solid shows (field, robot, part or piece) [m], shape (n, 3)."""
    faces: IntArray
    """Indices into `vertices`, three per triangle, shape (m, 3)."""


@dataclass(frozen=True, slots=True, eq=False)
class RobotSolids:
    """Solids of a robot's body, and solids and pose function of each moving part."""

    body: Sequence[Solid]
    parts: Sequence[tuple[Sequence[Solid], PartPose]]


@functools.lru_cache(maxsize=128)
def model_solids(model: Model, names: tuple[str, ...] = ()) -> tuple[Solid, ...]:
    """Read the solids of a GLB file, or return the cached solids.

    The color of a textured mesh is the mean color of the texture.

    Args:
        model: File, and the transform to the frame of the field, robot, moving part or piece.
        names: Name prefixes of meshes to keep apart; the name of a solid is the prefix of the mesh. Bumpers have the
            name `BUMPER`. The names of all other solids are empty.

    Raises:
        ModelError: If the file cannot be read.
    """
    return tuple(_joined([_solid(name, mesh, whole, names) for name, mesh, whole in _placed_meshes(model)]))


def _solid(name: str, mesh: Any, place: FloatArray | None = None, names: Iterable[str] = ()) -> Solid:
    """Convert a trimesh mesh to a solid of one color, named as in `model_solids`, after a transform `place`."""
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
    """Return the solids of a robot from GLB models, or build the solids from the config if no models fit the robot.

    Args:
        look: Look of the robot.
        models: Models of the robot; None for no models. The models are ignored unless the number of moving parts is
            `parts`. The model of the body is ignored if the length differs from the length over the bumpers.
        parts: Number of component poses in the robot's telemetry.
    """
    key = f"{look.prefix}/Robot/ComponentPoses"
    body: Sequence[Solid] = []
    moving: list[tuple[Sequence[Solid], PartPose]] = []
    try:
        if models is not None and len(models.parts) == parts:
            body = model_solids(models.body)
            moving = [(model_solids(part), _component(key, k)) for k, part in enumerate(models.parts)]
    except ModelError:  # draw boxes instead
        body, moving = [], []
    reach = max((float(one.vertices[:, 0].max()) for one in body), default=0.0)
    if abs(2.0 * reach - look.bumpers[0]) > 0.02:
        body = _sketched_body(look)
    if look.config is not None:
        posed = _posed(look.config, f"{look.prefix}/Debug/")
        moving += _carried(look.config, posed, has_models=bool(moving))
    return RobotSolids(body, moving)


def described_solids(config: RobotConfig) -> list[tuple[str, Solid]]:
    """Build the named solids of a robot from a config, in the robot frame.

    Intakes are deployed, and all other mechanisms are at the start position. The solids include the zones of intakes
    and claws, the directions of shots, the storages, and the view cones of cameras.
    """
    mechanisms = {name: build_mechanism(one) for name, one in config.mechanisms.items()}
    stands = {name: Posed(one.position, one.stops) for name, one in mechanisms.items()}
    for intake in config.intakes:
        stands |= deployed(intake, mechanisms)
    look = RobotLook(bumpers=(config.body.bumper_length, config.body.bumper_width), config=config)
    found = [("", solid) for solid in _sketched_body(look)]

    def put(name: str, solids: Sequence[Solid], pose: PartPose) -> None:
        at = pose(Snapshot(time=0.0, tick=0))
        if at is not None:
            turn = Rotation.from_quat(np.roll(at[3:], -1))
            found.extend((name, replace(one, vertices=at[:3] + turn.apply(one.vertices))) for one in solids)

    for solids, pose in _carried(config, lambda _: stands, has_models=False):
        put("", solids, pose)
    for intake in config.intakes:
        zone, pose = _intake_place(intake, lambda _: stands)
        put("intake, out", [_hull("", _ink("hit"), 0.35, zone_corners(zone))], pose)
    for placer in config.placers:
        put(
            "claw", [_hull("", _ink("path"), 0.35, zone_corners(placer.zone))], _linked(lambda _: stands, placer.joints)
        )
    for shooter in config.shooters:
        put("shot", [_hull("", _ink("miss"), 0.9, _SHOT)], _muzzle(lambda _: stands, shooter))
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


# --- shapes ---------------------------------------------------------------------------------------------------------


def shape_solids(shape: Shape, color: str, *, name: str = "", opacity: float = 1.0) -> list[Solid]:
    """Return the solids of a collision shape in the frame of the shape.

    The solid of a mesh has the same triangles. The solids of any other shape are the convex hulls of the parts.
    """
    if isinstance(shape, Mesh):
        return [Solid(name, color, opacity, shape.vertices, shape.faces)]
    found = []
    for part in parts_of(shape):
        points = _ball_points(part.shape.radius) if isinstance(part.shape, Sphere) else outline_points(part.shape)
        points = points @ matrix(part.quat).T + np.array(part.offset)
        found.append(_hull(name, color, opacity, points))
    return _joined(found)


def element_solids(scene: Scene, names: Sequence[str]) -> list[Solid]:
    """Return the solids of the field elements in the colors of the alliances, for a field without a model.

    Perimeter walls are glass above a low board, because the inside of the field must stay visible.

    Args:
        scene: Scene with the field elements.
        names: Name prefixes of elements to keep apart; the name of a solid is the prefix of the element, or empty.
    """
    found: list[Solid] = []
    for element in scene.field_elements:
        side = next((side for side in ("blue", "red") if side in re.split(r"[^a-z]+", element.name.lower())), "")
        known = next((one for one in names if element.name.lower().startswith(one)), "")
        solids = [
            replace(one, vertices=one.vertices + element.position)
            for one in shape_solids(element.shape, _FIELD_COLORS[side], name=known)
        ]
        low, high = bounding_box(element.shape)
        is_outside = any(
            low[k] + element.position[k] >= size - 1e-6 or high[k] + element.position[k] <= 1e-6
            for k, size in enumerate(scene.field_size)
        )
        if is_outside and isinstance(element.shape, Box):
            corners = box_corners(low + element.position, high + element.position)
            board, glass, edge = corners.copy(), corners, _BOARD if side else 0.25 * _BOARD
            board[:, 2] = np.minimum(board[:, 2], edge)
            glass[:, 2] = np.maximum(glass[:, 2], edge)
            solids = [_hull("", _FIELD_COLORS[side], 1.0, board)]
            solids += [_hull("", _GLASS, 0.24, glass)] if np.ptp(glass[:, 2]) > 0.0 else []
        found += solids
    return _joined(found)


def _ball_points(radius: float) -> FloatArray:
    """Return points on the surface of a ball around the origin [m], shape (n, 3)."""
    turn, up = np.meshgrid(np.arange(16) * math.tau / 16, np.linspace(-0.5 * math.pi, 0.5 * math.pi, 9))
    points = np.stack((np.cos(up) * np.cos(turn), np.cos(up) * np.sin(turn), np.sin(up)), axis=-1)
    return radius * points.reshape(-1, 3)


# --- models -----------------------------------------------------------------------------------------------------------


def _placed_meshes(model: Model) -> Iterator[tuple[str, Any, FloatArray]]:
    """Yield each mesh of a GLB file: name, mesh, and homogeneous transform of file and node [m], shape (4, 4)."""
    scene = _load(model.path)
    for node in scene.graph.nodes_geometry:
        place, name = scene.graph[node]
        if len(getattr(scene.geometry[name], "faces", ())):
            yield name, scene.geometry[name], model.transform @ place


def extents(path: Path) -> list[float]:
    """Return the size of the content of a GLB file along the x, y and z axes of the file; zeros for an empty file.

    Raises:
        ModelError: If the file cannot be read.
    """
    size = _load(path).extents
    return [0.0] * 3 if size is None else np.asarray(size).tolist()


def _load(path: Path) -> Any:
    import trimesh

    try:
        return trimesh.load_scene(path)
    except Exception as error:  # trimesh lets any error of its parser through
        raise ModelError(f"{path.parent.name}/{path.name} is not a readable GLB: {error}") from error


def _joined(solids: Sequence[Solid]) -> list[Solid]:
    """Merge solids of equal name, color and opacity into solids of at most `_MOST_VERTICES` vertices."""
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
    """Yield parts of a solid with at most `_MOST_VERTICES` vertices each."""
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
    """Return the convex hull of points [m] as a solid with separate vertices for each triangle, for sharp edges."""
    import trimesh  # importing it takes half a second

    mesh = trimesh.convex.convex_hull(corners)
    vertices = np.asarray(mesh.vertices)[np.asarray(mesh.faces)].reshape(-1, 3)
    return Solid(name, color, opacity, vertices, np.arange(len(vertices)).reshape(-1, 3))


# --- a robot by its config --------------------------------------------------------------------------------------------


def _component(key: str, number: int) -> PartPose:
    def pose(snapshot: Snapshot) -> FloatArray | None:
        rows = snapshot.pose_arrays.get(key, ())
        return rows[number] if number < len(rows) else None

    return pose


def chassis_boxes(body: ChassisConfig) -> dict[str, tuple[Vector, Vector, str]]:
    """Return the boxes of bumpers, belly pan and swerve modules by name: lower corner, upper corner [m] and color.

    The color of a bumper is empty, because the page draws bumpers in the color of the alliance.
    """
    length, width, thick = body.bumper_length / 2.0, body.bumper_width / 2.0, body.bumper_thickness
    low, high = body.clearance + 0.02, body.bumper_top
    frame_x, frame_y = length - thick, width - thick
    middle = 0.5 * (low + high)
    end, half = (body.bay[0] - length, 0.5 * body.bay[1]) if body.bay else (-frame_x, 0.0)  # of the intake bay
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
    """Build the body of a robot from the config in a look: bumpers, drivetrain, electronics and superstructure.

    Without a config, build the body of a typical robot. Scale the body to the bumper size of the look.
    """
    body = ChassisConfig() if look.config is None else look.config.body
    solids = []
    for name, (low, high, color) in chassis_boxes(body).items():
        solids.append(_hull(BUMPER if BUMPER in name else "", color or _BLUE, 1.0, box_corners(low, high)))
    is_swerve = look.config is None or isinstance(look.config.drivetrain, SwerveConfig)
    for x, y in body.wheel_positions:
        solids.append(_wheel((x, y, body.wheel_radius), body.wheel_radius, 2.0 * _HALF_TIRE, "y", _BLACK))
        solids.append(_wheel((x, y, body.wheel_radius), 0.5 * body.wheel_radius, 2.2 * _HALF_TIRE, "y", _STEEL))
        inside = np.array((x, y)) - 0.075 * np.sign((x, y))
        if is_swerve:  # drive and steer motors above each module
            for at in ((x, inside[1]), (inside[0], y)):
                solids.append(_wheel((*at, 0.2), 0.03, 0.11, "z", _BLACK))
        else:
            solids.append(_wheel((x, inside[1], body.wheel_radius + 0.03), 0.03, 0.11, "y", _DARK))
    floor = body.clearance + 0.02
    solids.append(_box((0.06, -0.09, floor), (0.24, 0.09, floor + 0.17), _BLACK))  # battery
    solids.append(_box((0.1, -0.03, floor + 0.17), (0.2, 0.03, floor + 0.18), "#c23a2b"))
    solids.append(_box((-0.12, -0.15, floor), (0.03, 0.0, floor + 0.04), "#d9dce1"))  # roboRIO
    solids.append(_box((-0.12, 0.03, floor), (0.03, 0.15, floor + 0.05), "#26a060"))  # power distribution
    solids += _superstructure(look.config, body)
    stretch = np.array((look.bumpers[0] / body.bumper_length, look.bumpers[1] / body.bumper_width, 1.0))
    return [replace(solid, vertices=stretch * solid.vertices) for solid in _joined(solids)]


def _superstructure(config: RobotConfig | None, body: ChassisConfig) -> list[Solid]:
    """Build the tubes around the storages, or around the frame without storages, and the mounts of the shooters."""
    edge_x, edge_y = (0.5 * size - body.bumper_thickness - 0.03 for size in (body.bumper_length, body.bumper_width))
    rooms = [] if config is None or not (config.intakes or config.shooters) else [config.storage, *config.more_storages]
    spans = [(np.array(room.low), np.array(room.high)) for room in rooms]
    if not spans and body.height > body.bumper_top + 0.05:
        spans = [(np.array((-edge_x, -edge_y, body.bumper_top)), np.array((edge_x, edge_y, body.height)))]
    solids = []
    for low, high in spans:
        corners = [(x, y) for x in (low[0], high[0]) for y in (low[1], high[1])]
        for level in (low[2], high[2]):
            a, b, d, c = ((x, y, level) for x, y in corners)
            solids += [_bar(*ends, _ROD) for ends in ((a, b), (b, c), (c, d), (d, a))]
        solids += [_bar((x, y, body.clearance), (x, y, high[2]), _ROD) for x, y in corners]
        if rooms:
            solids.append(_box(low - (0, 0, 0.006), (*high[:2], low[2]), "#8f959d"))
    for shooter in () if config is None else config.shooters:
        launch = shooter.launch
        x, y, _ = muzzle_offset(launch) if shooter.turret is None else (launch.pivot_x, launch.pivot_y, 0.0)
        for side in (-0.11, 0.11):
            solids.append(_bar((x, y + side, body.clearance), (x, y + side, launch.height - 0.1), 0.02, _STEEL))
        if shooter.turret is not None:
            solids.append(_wheel((x, y, launch.height - 0.1), 0.15, 0.03, "z", _BLACK))
    return solids


def _intake_place(
    intake: IntakeConfig, posed: Callable[[Snapshot], Mapping[str, Posed]]
) -> tuple[IntakeZone, PartPose]:
    """Return the zone of an intake, and a function for the pose of the part that carries the zone.

    The function returns None while the intake is retracted, unless the zone moves with the deploy mechanism.
    """
    joints, deploy = intake.joints, intake.deploy
    moves = joints or (() if intake.stretch is None else (intake.stretch,))
    zone = intake.zone if joints else replace(intake.zone, z_min=max(0.0, intake.zone.z_min))
    is_carried = any(joint.mechanism == deploy for joint in joints)
    return zone, _linked(posed, moves, None if deploy is None or is_carried else (deploy, intake.deployed_at))


def _carried(
    config: RobotConfig, posed: Callable[[Snapshot], Mapping[str, Posed]], *, has_models: bool
) -> Iterator[tuple[list[Solid], PartPose]]:
    """Yield the solids and the pose function of each moving part without a model.

    The parts are links, rails, claws, hooks, rollers and shooters.
    """
    modelled = {component.joints for component in config.components} if has_models else set()
    ends: list[tuple[tuple[Joint, ...], Vector, list[Solid]]] = []
    ends += [(one.joints, one.offset, _hook(one)) for one in config.climbers if one.joints not in modelled]
    if not has_models:
        ends += [(one.joints, one.offset, _gripper(one.zone)) for one in config.placers]
        ends += [(one.joints, one.offset, []) for one in config.components]
        for intake in config.intakes:
            zone, pose = _intake_place(intake, posed)
            yield _joined(_rollers(zone)), pose
            if intake.joints:
                ends.append((intake.joints, zone.ball[0], []))
        for shooter in config.shooters:
            yield _joined(_launcher(shooter)), _muzzle(posed, shooter)
    start = posed(Snapshot(time=0.0, tick=0))
    bodies: dict[tuple[Joint, ...], dict[object, list[Solid]]] = {}
    for joints, end, solids in ends:
        for number, joint in enumerate(joints):
            stops = [joint.ratio * stop for stop in start[joint.mechanism].stops]
            if joint.slides and all(map(math.isfinite, stops)):  # two rails, fixed to the carrier of the joint
                low, high = (np.array(joint.origin) + stop * np.array(joint.axis) for stop in stops)
                beside = _RAIL * np.array((1.0, 0, 0) if abs(joint.axis[1]) > 0.9 else (0, 1.0, 0))
                rails = [_bar(low + side, high + side, _ROD, _STEEL) for side in (beside, -beside)]
                bodies.setdefault(joints[:number], {})[joint] = [
                    *rails,
                    _bar(high - beside, high + beside, _ROD, _STEEL),
                ]
            after = joints[number + 1].origin if number + 1 < len(joints) else end
            if any(after):
                bodies.setdefault(joints[: number + 1], {})[after] = [_bar((0.0, 0.0, 0.0), after, 0.022, _STEEL)]
        bodies.setdefault(joints, {})[id(solids)] = solids
    for joints, groups in bodies.items():
        if found := _joined([solid for solids in groups.values() for solid in solids]):
            yield found, _linked(posed, joints)


def _rollers(zone: IntakeZone) -> list[Solid]:
    """Build an intake around a zone: two plates, and two rollers along the longer side, with a lower outer roller."""
    corners = zone_corners(zone)
    low, high = corners.min(axis=0), corners.max(axis=0)
    size = high - low
    along = 1 if size[1] >= size[0] else 0
    out = 1 - along
    is_ahead = low[out] + high[out] >= 0.0
    radius = min(0.032, 0.2 * size[2], 0.3 * size[out])
    tip, root = (high[out] - radius, low[out] + radius) if is_ahead else (low[out] + radius, high[out] - radius)
    middle = 0.5 * (low + high)
    solids = []
    for across, level, color in ((tip, low[2] + 0.55 * size[2], "#1f7a6a"), (root, high[2] - radius, "#2f3640")):
        place = middle.copy()
        place[out], place[2] = across, level
        solids.append(_wheel(place, radius, size[along], "xy"[along], color))
    for side in (low[along], high[along]):
        plate = np.array([middle] * 4)
        plate[:, along] = side
        plate[:, out] = (tip, tip, root, root)
        plate[:, 2] = low[2] + np.array((0.42, 0.72, 0.7, 1.0)) * size[2]
        thick = np.zeros(3)
        thick[along] = 0.004
        solids.append(_hull("", _STEEL, 1.0, np.vstack((plate - thick, plate + thick))))
    return solids


def _launcher(shooter: ShooterConfig) -> list[Solid]:
    """Build the wheels and hood of a shooter in the frame of the first muzzle, with x along the shot."""
    first, radius, gap = shooter.launch.barrels[0], shooter.wheel_radius, 0.07
    sides = [barrel - first for barrel in shooter.launch.barrels]
    middle, wide = 0.5 * (min(sides) + max(sides)), max(sides) - min(sides) + 0.14
    second = shooter.second_wheel_radius or radius
    if shooter.wheel_places == "left and right":
        return [
            _wheel((0.0, middle - sign * (0.5 * wide + size), 0.0), size, 0.09, "z", "#2b7a8c")
            for sign, size in ((1.0, radius), (-1.0, second))
        ]
    solids = [_wheel((-0.03, middle, -(radius + gap)), radius, wide, "y", "#2b7a8c")]
    if len(shooter.wheels) == 2:
        solids.append(_wheel((-0.03, middle, second + gap), second, wide, "y", "#2b7a8c"))
    else:  # hood around the back of the wheel
        turns = np.radians(np.linspace(85.0, 200.0, 7))
        arc = np.column_stack((np.cos(turns), np.zeros(7), np.sin(turns)))
        inner, outer = ((radius + 2.0 * gap + thick) * arc + (-0.03, middle, -(radius + gap)) for thick in (0.0, 0.008))
        half = np.array((0.0, 0.5 * wide, 0.0))
        for k in range(6):
            edge = np.vstack((inner[k : k + 2], outer[k : k + 2]))
            solids.append(_hull("", "#d3d7dc", 1.0, np.vstack((edge - half, edge + half))))
    for side in (-1.0, 1.0):
        at = np.array((-0.03, middle + side * (0.5 * wide + 0.008), 0.0))
        plate = np.array([(-0.06, 0, -radius - gap), (0.06, 0, -radius - gap), (0.03, 0, gap), (-0.09, 0, gap)]) + at
        half = np.array((0.0, 0.004, 0.0))
        solids.append(_hull("", _STEEL, 1.0, np.vstack((plate - half, plate + half))))
    return solids


def _gripper(zone: IntakeZone) -> list[Solid]:
    """Build a claw around a zone: two fingers, and a roller between the fingers at the back."""
    corners = zone_corners(zone)
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle, size = 0.5 * (low + high), high - low
    fingers = [
        _box((low[0], y - 0.006, middle[2] - 0.3 * size[2]), (high[0], y + 0.006, middle[2] + 0.3 * size[2]), "#e08a2c")
        for y in (low[1], high[1])
    ]
    return [*fingers, _wheel((low[0], middle[1], middle[2]), min(0.03, 0.3 * size[2]), size[1], "y", "#1f7a6a")]


def _hook(climber: ClimberConfig) -> list[Solid]:
    """Build the hook of a climber, open at the bottom, around the point at which the hook catches a rung."""
    x, y, z = climber.offset
    reach = climber.reach
    top, color = z + reach, "#c9ccd1"
    parts = [((-reach, z - 2.5 * reach), (-reach, top)), ((-reach, top), (reach, top)), ((reach, top), (reach, z))]
    return [_bar((x + a, y, b), (x + c, y, d), 0.3 * reach, color) for (a, b), (c, d) in parts]


def _posed(config: RobotConfig, prefix: str) -> Callable[[Snapshot], Mapping[str, Posed]]:
    """Return a function that reads the positions of a robot's mechanisms from a snapshot."""
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
    """Return a function for the pose of the last part in a chain of joints, robot frame.

    If `deploy` is given (mechanism and deployed stop), the function returns None while the mechanism is not deployed.
    """

    def pose(snapshot: Snapshot) -> FloatArray | None:
        now = posed(snapshot)
        if deploy is not None and not is_deployed(now[deploy[0]].position, now[deploy[0]].stops, deploy[1]):
            return None
        pos, (x, y, z, w) = part_pose(joints, now)
        return np.array((*pos, w, x, y, z))

    return pose


def _muzzle(posed: Callable[[Snapshot], Mapping[str, Posed]], shooter: ShooterConfig) -> PartPose:
    """Return a function for the pose of a shooter's first barrel, with x along the shot."""

    def pose(snapshot: Snapshot) -> FloatArray:
        now = posed(snapshot)
        turned = 0.0 if shooter.turret is None else shooter.turret_ratio * now[shooter.turret].position
        raised = 0.0 if shooter.hood is None else shooter.elevation_per_hood * now[shooter.hood].position
        x, y, z, w = from_rpy(0.0, -(shooter.elevation + raised), shooter.launch.heading + turned)
        return np.array((*muzzle_offset(shooter.launch, 0, turned).tolist(), w, x, y, z))

    return pose


def _ink(name: str) -> str:
    return COLORS[name][0]


def _box(low: Sequence[float] | FloatArray, high: Sequence[float] | FloatArray, color: str) -> Solid:
    return _hull("", color, 1.0, box_corners(low, high))


def _cube(center: Sequence[float] | FloatArray, half: float) -> FloatArray:
    return box_corners(np.array(center) - half, np.array(center) + half)


def _bar(start: Sequence[float] | FloatArray, end: Sequence[float] | FloatArray, half: float, color: str = "") -> Solid:
    """Build a square tube between two points [m], with a thickness of twice `half` [m]."""
    return _hull("", color or "#70767f", 1.0, np.concatenate((_cube(start, half), _cube(end, half))))


def _wheel(center: Sequence[float] | FloatArray, radius: float, width: float, axis: str, color: str) -> Solid:
    """Build a wheel or roller: a cylinder along `axis`."""
    turns = np.linspace(0.0, math.tau, 20, endpoint=False)
    rim = radius * np.column_stack((np.cos(turns), np.sin(turns), np.zeros(20)))
    rim = np.roll(rim, "zxy".index(axis), axis=1)
    side = 0.5 * width * np.eye(3)["xyz".index(axis)]
    return _hull("", color, 1.0, np.concatenate((rim - side, rim + side)) + np.asarray(center))


_SHOT = np.concatenate((_cube((0.0, 0.0, 0.0), _ROD), [(_SHOT_LENGTH, 0.0, 0.0)]))
