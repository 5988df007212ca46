"""A robot from its right side, as the page draws it: what its parts are made of, and where each was at each time.

Parts are those of the game's models where the run has their poses; else what mechanisms carry by the robot's config.
All are convex bodies in three dimensions: the page turns them and draws their outlines.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from simcore.errors import ModelError
from simcore.geometry.footprints import box_corners
from simcore.geometry.linkage import Joint, part_pose
from simcore.geometry.rotation import Vector, from_rpy, from_yaw, matrix, multiply, rotate_back, yaw_of
from simcore.pieces.intake import IntakeZone, is_deployed
from simcore.pieces.launch import muzzle_offset
from simcore.pieces.shooter import ShooterConfig
from simcore.robot.chassis_config import ChassisConfig
from simcore.robot.mechanisms import PistonConfig
from simcore.robot.robot_config import RobotConfig, build_mechanism, telemetry_name
from simcore.show.glb import Body, convex_bodies
from simcore.show.palette import color, tint
from simcore.show.robot_sketch import SHOT, Posed
from simcore.show.run_track import RunTrack
from simcore.show.scene import RobotLook
from simcore.show.svg import document, element, line, ticks, words
from simcore.show.view_models import load_models
from simcore.telemetry.recording import Recording, newest_rows
from simcore.typing import BoolArray, FloatArray

__all__ = ["robot_side"]

_ROD = 0.015  # [m]; half the thickness of a drawn link
_NEAR = -0.1  # [m]; what is farther to the right than this, all of it, is before the held pieces: drawn pale
_FARTHEST, _HIGHEST = 1.5, 3.0  # [m]; the drawing ends here, wherever the robot is thrown
_RING = np.array([(math.cos(a), 0.0, math.sin(a)) for a in np.arange(16) * math.pi / 8.0])
_STILL = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)

_Part = tuple[Sequence[Body], FloatArray, bool]
"""What moves as one; its poses `x, y, z, qw, qx, qy, qz` in the robot frame at each time, NaN while it is not there,
shape (m, 7); and whether it is a held piece."""


def robot_side(track: RunTrack, times: Sequence[float]) -> tuple[str, dict[str, Any]] | None:
    """The first robot of a run at some times [s]; None if it has no moving parts, holds nothing and stays level.

    Returns:
        The drawing without the robot, which the page's script puts in the group, and what it needs for that.
        `shapes`: corners [mm] one after the other. `solids`: part, shape, fill and opacity, the farthest first.
        `changes`: of each time the parts that moved. A number, then `x, y, z` [mm] if these changed, then a rotation
        vector [mrad] in the order y, x, z without the last two if they are 0; the number alone of a part that is gone.
        Part 0 is the body over the floor, the others are in its frame.
    """
    if not times or not track.scene.robots or not track.recording.has(track.scene.robots[0].pose_key):
        return None
    body, *others = _parts(track, track.scene.robots[0], np.array(times))
    parts = [body, *(part for part in others if _there(part[1]).any())]
    if not _there(body[1]).any():
        return None
    changes: list[list[list[int]]] = [[] for _ in times]
    shapes: dict[tuple[int, ...], int] = {}
    solids, places = [], [np.array([(0.5, 0.0, 0.0), (-0.5, 0.0, 0.0)])]
    for number, (bodies, poses, is_piece) in enumerate(parts):
        there = _there(poses)
        _note_changes(changes, number, poses)
        for _, fill, opacity, corners in bodies:
            seen = _moved(poses[there], corners[None])
            right, is_near = seen[0, :, 1].min(), bool(seen[0, :, 1].max() < _NEAR)
            shape = shapes.setdefault(tuple(np.rint(1000.0 * corners).astype(int).ravel().tolist()), len(shapes))
            solid = (number, shape, fill, round(opacity * (0.35 if is_near else 1.0), 2))
            solids.append((1 if is_piece else 2 * is_near, -right, solid))
            places.append((_moved(body[1][there], seen) if number else seen).reshape(-1, 3))
    if len(parts) == 1 and not any(changes[1:]):
        return None
    solids.sort(key=lambda entry: entry[:2])
    data = {"shapes": list(shapes), "solids": [solid for *_, solid in solids], "changes": changes}
    return _drawing(np.concatenate(places)), data


def _there(poses: FloatArray) -> BoolArray:
    """Where a part has a pose: neither NaN nor the zeros of a log that never set it."""
    found: BoolArray = np.linalg.norm(poses[:, 3:], axis=1) > 0.5
    return found


def _note_changes(changes: list[list[list[int]]], number: int, poses: FloatArray) -> None:
    rows, there = np.zeros((len(poses), 6)), _there(poses)
    rows[there, :3] = poses[there, :3]
    rows[there, 3:] = Rotation.from_quat(poses[there][:, [4, 5, 6, 3]]).as_rotvec()[:, [1, 0, 2]]
    before: list[int] = []
    for frame, is_there, row in zip(changes, there.tolist(), np.rint(1000.0 * rows).astype(int).tolist(), strict=True):
        now = row if is_there else []
        if now != before:
            place = [] if now[:3] == before[:3] else now[:3]
            frame.append([number, *place, *(now[3:] if any(now[4:]) else now[3:4])])
        before = now


def _moved(poses: FloatArray, points: FloatArray) -> FloatArray:
    """Points of a part, the same or others at each of its poses, shape (m, n, 3)."""
    found: FloatArray = np.einsum("ijm,mnj->mni", matrix(poses[:, [4, 5, 6, 3]].T), points) + poses[:, None, :3]
    return found


def _drawing(places: FloatArray) -> str:
    """As large as all places of all corners; in millimeters."""
    places = 1000.0 * np.clip(places, (-_FARTHEST, -_FARTHEST, 0.0), (_FARTHEST, _FARTHEST, _HIGHEST))
    left, right, top = places[:, 0].min() - 50.0, places[:, 0].max() + 50.0, places[:, 2].max() + 50.0
    size = 0.04 * max(top, 0.7 * (right - left))  # of letters
    levels = ticks(0.0, top, 5)
    parts = [line(left, -z, right, -z, stroke=color("grid" if z else "ink"), stroke_width=6) for z in levels]
    parts.append(element("g", element("desc", "robot")))
    parts += [words(left, -z - 10, f"{z / 1000:g} m", size) for z in levels[1:] if z + size < top]
    parts.append(words(right, 1.2 * size, "front \u2192", size, anchor="end"))
    return document((left, -top, right - left, top + 1.7 * size), *parts, role="img", aria_label="robot from its side")


# --- parts ------------------------------------------------------------------------------------------------------------


def _parts(track: RunTrack, look: RobotLook, times: FloatArray) -> Iterator[_Part]:
    """The body, whose pose is that of the robot over the floor and without its heading; then all that it carries."""
    recording = track.recording
    at, rows = recording.poses(look.pose_key)
    poses, key = rows[newest_rows(at, times)].tolist(), f"{look.prefix}/Robot/ComponentPoses"
    body, *models = _models(look, recording, key) or [[]]
    if abs(2.0 * max((corners[:, 0].max() for *_, corners in body), default=0.0) - look.bumpers[0]) > 0.02:
        body = _sketched_body(look)  # no models, or of a robot of another size
    edge = tint(look.alliance)[0]
    body = [(name, edge if "bumper" in name else fill, *rest) for name, fill, *rest in body]  # type: ignore[misc]
    yield body, np.array([_upright(pose) for pose in poses]), False
    moved = [recording.array_at(key, time) for time in times.tolist()] if models else []
    for number, model in enumerate(models):
        yield model, np.array([row[number] if number < len(row) else np.full(7, np.nan) for row in moved]), False
    if look.config is not None:
        yield from _carried(look.config, recording, f"{look.prefix}/Debug/", times, has_models=bool(models))
    held: dict[int, FloatArray] = {}
    for frame, (time, pose) in enumerate(zip(times.tolist(), poses, strict=True)):
        for row, place in track.held_by(0, time).items():
            held.setdefault(row, np.full((len(times), 7), np.nan))[frame] = _seen_from(pose, place.tolist())
    for row, inside in held.items():
        piece = track.scene.look(track.types[track.kinds[row]])
        corners = piece.reach * _RING
        if piece.size is not None:
            corners = box_corners([-0.5 * edge for edge in piece.size], [0.5 * edge for edge in piece.size])
        else:
            inside[np.isfinite(inside[:, 0]), 3:] = _STILL[3:]
        yield [("piece", piece.color, 0.9, corners)], inside, True


def _models(look: RobotLook, recording: Recording, key: str) -> list[list[Body]] | None:
    """Of the body and of each component, if there are as many as the run has poses."""
    try:
        robot = None if look.models is None else load_models(look.models).robot()
        if robot is not None and len(robot.parts) == recording.most_poses(key):
            return [convex_bodies(model) for model in (robot.body, *robot.parts)]
    except ModelError:  # the page can do without
        pass
    return None


def _upright(pose: Sequence[float]) -> tuple[float, ...]:
    _, _, height, w, x, y, z = pose
    x, y, z, w = multiply(from_yaw(-yaw_of((x, y, z, w))), (x, y, z, w))
    return 0.0, 0.0, height, w, x, y, z


def _seen_from(robot: Sequence[float], place: Sequence[float]) -> tuple[float, ...]:
    """A pose on the field in the frame of the robot."""
    (w, x, y, z), (d, a, b, c) = robot[3:], place[3:]
    inside = rotate_back((x, y, z, w), [there - here for there, here in zip(place[:3], robot[:3], strict=True)])
    a, b, c, d = multiply((-x, -y, -z, w), (a, b, c, d))
    return *inside, d, a, b, c


def _sketched_body(look: RobotLook) -> list[Body]:
    """Bumpers, frame and wheels of a robot without a model; one of which nothing is known has usual ones."""
    body = ChassisConfig() if look.config is None else look.config.body
    x, y, r = 0.5 * look.bumpers[0], 0.5 * look.bumpers[1], body.wheel_radius
    u, v = x - body.bumper_thickness, y - body.bumper_thickness
    return [
        *(("wheel", color("ink"), 1.0, r * _RING + (wheel_x, wheel_y, r)) for wheel_x, wheel_y in body.wheel_positions),
        ("bumper", "", 0.7, box_corners((-x, -y, body.clearance), (x, y, body.bumper_top))),
        ("frame", color("grid"), 0.5, box_corners((-u, -v, body.bumper_top), (u, v, body.height))),
    ]


def _carried(
    config: RobotConfig, recording: Recording, prefix: str, times: FloatArray, *, has_models: bool
) -> Iterator[_Part]:
    """What mechanisms carry, as far as there is no model of it: links, claws, hooks, intakes, and where shots leave."""
    posed: list[dict[str, Posed]] = [{} for _ in times]
    for name, mechanism in config.mechanisms.items():
        sim, key, unit = build_mechanism(mechanism), f"{prefix}{telemetry_name(name)}PositionRot", math.tau
        if isinstance(mechanism, PistonConfig):
            key, unit = f"{prefix}{telemetry_name(name)}ExtendedPct", 0.01 * mechanism.stroke
        at, values = recording.series(key) if recording.has(key) else (times, np.full(len(times), sim.position / unit))
        for now, value in zip(posed, (unit * values[newest_rows(at, times)]).tolist(), strict=True):
            now[name] = Posed(value, sim.stops)
    modelled = {component.joints for component in config.components} if has_models else set()
    hooks = [one for one in config.climbers if one.joints not in modelled]
    chains: list[tuple[str, tuple[Joint, ...], Vector, FloatArray]] = []
    chains += [("ghost", one.joints, one.offset, _cube(one.offset, one.reach)) for one in hooks]
    if not has_models:
        chains += [("path", one.joints, one.offset, _zone(one.zone)) for one in config.placers]
        chains += [("ink", one.joints, one.offset, _cube(one.offset, 2.0 * _ROD)) for one in config.components]
        for intake in config.intakes:
            joints, deploy = intake.joints, intake.deploy
            if any(joint.mechanism == deploy for joint in joints) or (joints and deploy is None):
                chains.append(("hit", joints, intake.zone.ball[0], _zone(intake.zone)))
                continue
            rows = _rows(joints or (() if intake.stretch is None else (intake.stretch,)), posed)
            if deploy is not None:
                out = [is_deployed(now[deploy].position, now[deploy].stops, intake.deployed_at) for now in posed]
                rows[np.logical_not(out)] = np.nan
            zone = intake.zone if joints else replace(intake.zone, z_min=max(0.0, intake.zone.z_min))
            yield [("", color("hit"), 0.5, _zone(zone))], rows, False
        for shooter in config.shooters:
            yield [("", color("miss"), 0.9, _SHOT)], np.array([_muzzle(shooter, now) for now in posed]), False
    bodies: dict[tuple[Joint, ...], dict[object, Body]] = {}
    for ink, joints, end, corners in chains:
        for number, joint in enumerate(joints):
            stops = [joint.ratio * stop for stop in posed[0][joint.mechanism].stops]
            if joint.slides and all(map(math.isfinite, stops)):  # its way, in what carries it
                low, high = (np.array(joint.origin) + stop * np.array(joint.axis) for stop in stops)
                bodies.setdefault(joints[:number], {})[joint] = ("", color("control"), 0.4, _rod(low, high))
            after = joints[number + 1].origin if number + 1 < len(joints) else end
            if any(after):
                rod = ("", color("muted"), 1.0, _rod((0.0, 0.0, 0.0), after))
                bodies.setdefault(joints[: number + 1], {})[after] = rod
        bodies.setdefault(joints, {})[ink, end] = ("", color(ink), 0.6, corners)
    for joints, solids in bodies.items():
        yield list(solids.values()), _rows(joints, posed), False


def _rows(joints: tuple[Joint, ...], posed: Sequence[Mapping[str, Posed]]) -> FloatArray:
    """Of what joints carry, at each time."""
    return np.array([(*pos, w, x, y, z) for pos, (x, y, z, w) in (part_pose(joints, now) for now in posed)])


def _muzzle(shooter: ShooterConfig, mechanisms: Mapping[str, Posed]) -> tuple[float, ...]:
    """Where its first barrel is, with x along the shot."""
    turned = 0.0 if shooter.turret is None else shooter.turret_ratio * mechanisms[shooter.turret].position
    raised = 0.0 if shooter.hood is None else shooter.elevation_per_hood * mechanisms[shooter.hood].position
    x, y, z, w = from_rpy(0.0, -(shooter.elevation + raised), shooter.launch.heading + turned)
    return *muzzle_offset(shooter.launch, 0, turned).tolist(), w, x, y, z


def _zone(zone: IntakeZone) -> FloatArray:
    return box_corners((zone.x_min, zone.y_min, zone.z_min), (zone.x_max, zone.y_max, zone.z_max))


def _cube(center: Sequence[float] | FloatArray, half: float) -> FloatArray:
    return box_corners(np.array(center) - half, np.array(center) + half)


def _rod(start: Sequence[float] | FloatArray, end: Sequence[float] | FloatArray) -> FloatArray:
    return np.concatenate((_cube(start, _ROD), _cube(end, _ROD)))


_SHOT = np.concatenate((_cube((0.0, 0.0, 0.0), _ROD), [(SHOT, 0.0, 0.0)]))
