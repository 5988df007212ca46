"""What a drawing of a robot shows, in the robot frame: boxes, wheels, shots, view cones, and the ways of what moves."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from simcore.geometry.footprints import box_corners
from simcore.geometry.linkage import Joint, MechanismMotion, part_pose
from simcore.geometry.rotation import Vector, rotate
from simcore.physics.shapes import outline
from simcore.pieces.intake import Intake, IntakeConfig, IntakeZone
from simcore.pieces.launch import launch_direction, muzzle_offset
from simcore.pieces.shooter import ShooterConfig
from simcore.robot.chassis_config import ChassisConfig
from simcore.robot.mechanisms import ShaftSim
from simcore.robot.robot_config import RobotConfig, build_mechanism
from simcore.typing import FloatArray
from simcore.vision.camera import CameraConfig

__all__ = [
    "SHOT",
    "Posed",
    "RobotSketch",
    "SketchArrow",
    "SketchNote",
    "SketchVolume",
    "SketchWay",
    "intake_outlines",
    "sketch_robot",
    "zone_corners",
]

SHOT, CONE = 0.38, 0.55  # [m]; lengths of drawn arrows and cones
_STEPS = 24  # of the way of a mechanism


@dataclass(frozen=True, slots=True)
class SketchVolume:
    """A convex body by its corners, robot frame [m], shape (n, 3)."""

    role: str
    corners: FloatArray
    tag: str = ""
    is_outline: bool = False
    """Where it is at other times, e.g. while an intake is stowed."""


@dataclass(frozen=True, slots=True)
class SketchArrow:
    """A shot from its muzzle, robot frame [m]."""

    start: FloatArray
    end: FloatArray
    tag: str = ""
    is_faint: bool = False
    """Where a hood or turret can also point."""


@dataclass(frozen=True, slots=True)
class SketchWay:
    """Where a mechanism takes the end of what it carries, robot frame [m]."""

    name: str
    axis: FloatArray
    """Of its joint, shape (3,)."""
    link: FloatArray
    """From its joint to the end of what it carries, as the robot starts, shape (n, 3)."""
    way: FloatArray
    """Of that end, from one stop to the other, shape (n, 3); empty without stops."""
    has_place: bool = True
    """Whether it is said where the joint is."""


@dataclass(frozen=True, slots=True)
class SketchNote:
    """A line of the legend."""

    tag: str
    role: str
    text: str


@dataclass(slots=True)
class RobotSketch:
    """All of a robot that is drawn."""

    body: ChassisConfig
    wheel_radius: float
    wheels: list[tuple[str, float, float]]
    """Name and place of each [m]."""
    volumes: list[SketchVolume] = field(default_factory=list)
    arrows: list[SketchArrow] = field(default_factory=list)
    ways: list[SketchWay] = field(default_factory=list)
    notes: list[SketchNote] = field(default_factory=list)

    def points(self) -> FloatArray:
        """Everything that must be on the drawing, robot frame [m], shape (n, 3)."""
        x, y = 0.5 * self.body.bumper_length, 0.5 * self.body.bumper_width
        rows = [np.array([(x, y, self.body.height), (-x, -y, 0.0)])]
        rows += [volume.corners for volume in self.volumes]
        rows += [np.stack((arrow.start, arrow.end)) for arrow in self.arrows]
        rows += [way.link for way in self.ways] + [way.way for way in self.ways]
        return np.concatenate(rows)


class Posed:
    """A mechanism that stands somewhere."""

    velocity = 0.0

    def __init__(self, position: float, stops: tuple[float, float]) -> None:
        self.position = position
        self.stops = stops


def sketch_robot(config: RobotConfig, *, chains: Sequence[Sequence[Joint]] = ()) -> RobotSketch:
    """The sketch of a robot as it starts.

    Args:
        config: The robot.
        chains: Joints that carry nothing of the config, but are to be drawn as well.
    """
    drivetrain = config.drivetrain
    modules = getattr(drivetrain, "modules", ())
    names = [module.name for module in modules] or [f"wheel {k}" for k in range(len(drivetrain.wheel_positions))]
    sketch = RobotSketch(
        body=config.body,
        wheel_radius=drivetrain.wheel_radius,
        wheels=[(name, x, y) for name, (x, y) in zip(names, drivetrain.wheel_positions, strict=True)],
    )
    mechanisms = {name: build_mechanism(one) for name, one in config.mechanisms.items()}
    _add_storages(sketch, config)
    for number, intake in enumerate(config.intakes, 1):
        _add_intake(sketch, f"I{number}", intake, mechanisms)
    for number, shooter in enumerate(config.shooters, 1):
        _add_shooter(sketch, f"S{number}", shooter, mechanisms)
    for number, placer in enumerate(config.placers, 1):
        pos, quat = part_pose(placer.joints, mechanisms)
        corners = np.array([np.add(pos, rotate(quat, corner)) for corner in zone_corners(placer.zone)])
        sketch.volumes.append(SketchVolume("claw", corners, f"G{number}"))
        text = f"claw: {placer.roller!r} forward takes, backward lets go"
        sketch.notes.append(SketchNote(f"G{number}", "claw", text))
    for number, climber in enumerate(config.climbers, 1):
        pos, _ = part_pose(climber.joints, mechanisms, climber.offset)
        reach = climber.reach
        box = box_corners((-reach,) * 3, (reach,) * 3) + np.array(pos)
        sketch.volumes.append(SketchVolume("hook", box, f"H{number}"))
        sketch.notes.append(SketchNote(f"H{number}", "hook", f"hook of {climber.joints[-1].mechanism!r}"))
    for number, camera in enumerate(config.cameras, 1):
        _add_camera(sketch, f"C{number}", camera)
    _add_ways(sketch, config, mechanisms, chains)
    return sketch


def intake_outlines(config: RobotConfig) -> list[FloatArray]:
    """Corners from above of the zone of each intake while it is out, robot frame [m], shape (n, 2)."""
    mechanisms = {name: build_mechanism(one) for name, one in config.mechanisms.items()}
    zones = []
    for intake in config.intakes:
        posed: dict[str, ShaftSim | Posed] = {**mechanisms, **_deployed(intake, mechanisms)}
        zones.append(outline(_intake_corners(intake, posed)[:, :2]))
    return zones


def _add_storages(sketch: RobotSketch, config: RobotConfig) -> None:
    if not (config.intakes or config.shooters):
        return
    for number, storage in enumerate((config.storage, *config.more_storages), 1):
        corners = box_corners(storage.low, storage.high)
        sketch.volumes.append(SketchVolume("storage", corners, f"R{number}"))
        name = f"storage {storage.name!r}" if storage.name else "storage"
        way = "last in, first out" if storage.order == "lifo" else "first in, first out"
        sketch.notes.append(SketchNote(f"R{number}", "storage", f"{name}: room for {storage.capacity}, {way}"))


def _add_intake(sketch: RobotSketch, tag: str, intake: IntakeConfig, mechanisms: Mapping[str, ShaftSim]) -> None:
    for name in dict.fromkeys(joint.mechanism for joint in intake.joints if joint.mechanism != intake.deploy):
        stops = mechanisms[name].stops
        for stop in stops if all(map(math.isfinite, stops)) else ():
            there = _intake_corners(intake, {**mechanisms, name: Posed(stop, stops)})
            sketch.volumes.append(SketchVolume("intake", there, is_outline=True))
    stowed = _intake_corners(intake, mechanisms)
    out = dict(mechanisms) | _deployed(intake, mechanisms)
    corners = _intake_corners(intake, out)
    sketch.volumes.append(SketchVolume("intake", corners, tag))
    if not np.allclose(stowed, corners):
        sketch.volumes.append(SketchVolume("intake", stowed, is_outline=True))
    turns = (
        "" if intake.roller is None else f", {intake.roller!r} {'backward' if intake.roller_reversed else 'forward'}"
    )
    deploy = "" if intake.deploy is None else f", {intake.deploy!r} at its {intake.deployed_at} stop"
    low, high = corners.min(axis=0), corners.max(axis=0)
    into = f", into {intake.storage!r}" if intake.storage else ""
    text = f"intake at x {low[0]:.2f} to {high[0]:.2f}, y {low[1]:.2f} to {high[1]:.2f} m{turns}{deploy}{into}"
    sketch.notes.append(SketchNote(tag, "intake", text))


def _deployed(intake: IntakeConfig, mechanisms: Mapping[str, ShaftSim]) -> dict[str, Posed]:
    """The mechanism that puts an intake out, where it is out."""
    if intake.deploy is None:
        return {}
    stops = mechanisms[intake.deploy].stops
    return {intake.deploy: Posed(stops[1] if intake.deployed_at == "upper" else stops[0], stops)}


def zone_corners(zone: IntakeZone) -> FloatArray:
    """Of a zone in the frame of what carries it [m], shape (8, 3)."""
    return box_corners((zone.x_min, zone.y_min, zone.z_min), (zone.x_max, zone.y_max, zone.z_max))


def _intake_corners(intake: IntakeConfig, mechanisms: Mapping[str, ShaftSim | Posed]) -> FloatArray:
    zone = Intake(intake, mechanisms).zone
    pos, quat = part_pose(intake.joints, mechanisms)
    shown = zone if intake.joints else replace(zone, z_min=max(0.0, zone.z_min))
    return np.array([np.add(pos, rotate(quat, corner)) for corner in zone_corners(shown)])


def _add_shooter(sketch: RobotSketch, tag: str, shooter: ShooterConfig, mechanisms: Mapping[str, ShaftSim]) -> None:
    hood = None if shooter.hood is None else mechanisms[shooter.hood]
    turret = None if shooter.turret is None else mechanisms[shooter.turret]
    start = 0.0 if turret is None else shooter.turret_ratio * turret.position
    tilt = shooter.elevation if hood is None else shooter.elevation + shooter.elevation_per_hood * hood.position
    others = [] if hood is None else [shooter.elevation + shooter.elevation_per_hood * stop for stop in hood.stops]
    for barrel in range(len(shooter.launch.barrels)):
        muzzle = muzzle_offset(shooter.launch, barrel, start)
        heading = shooter.launch.heading + start
        sketch.arrows.append(
            SketchArrow(muzzle, muzzle + SHOT * launch_direction(heading, tilt), "" if barrel else tag)
        )
        for other in others:
            if math.isfinite(other) and abs(other - tilt) > 0.01:
                sketch.arrows.append(
                    SketchArrow(muzzle, muzzle + SHOT * launch_direction(heading, other), is_faint=True)
                )
    where = f"{math.degrees(shooter.launch.heading + start):.0f} deg" if shooter.launch.heading + start else "the front"
    text = f"shooter {' and '.join(map(repr, shooter.wheels))} to {where}, up {math.degrees(tilt):.0f} deg"
    if others:
        low, high = sorted(math.degrees(other) for other in others)
        text += f" (hood: {low:.0f} to {high:.0f})"
    if turret is not None and all(map(math.isfinite, turret.stops)):
        low, high = (shooter.turret_ratio * stop for stop in turret.stops)
        angles = np.linspace(low, high, 3 * _STEPS)
        way = np.array([muzzle_offset(shooter.launch, 0, angle) for angle in angles])
        pivot = np.array([(shooter.launch.pivot_x, shooter.launch.pivot_y, shooter.launch.height)])
        assert shooter.turret is not None
        link = np.concatenate((pivot, muzzle_offset(shooter.launch, 0, start)[None]))
        sketch.ways.append(SketchWay(shooter.turret, np.array([0.0, 0.0, 1.0]), link, way))
        text += f", turret {math.degrees(low):.0f} to {math.degrees(high):.0f} deg"
    text += f", from {shooter.storage!r}" if shooter.storage else ""
    sketch.notes.append(SketchNote(tag, "shooter", text))


def _add_camera(sketch: RobotSketch, tag: str, camera: CameraConfig) -> None:
    mount, kind = camera.mount, camera.type
    right, down = (math.tan(math.radians(0.5 * fov)) for fov in (kind.horizontal_fov_deg, kind.vertical_fov_deg))
    rays = [(1.0, a * right, b * down) for a, b in itertools.product((-1.0, 1.0), repeat=2)]
    apex = np.array(mount.position)
    ends = [apex + np.array(rotate(mount.rotation, ray)) * CONE / math.hypot(*ray) for ray in rays]
    sketch.volumes.append(SketchVolume("camera", np.stack((apex, *ends)), tag))
    up = -mount.pitch_deg
    text = f"camera {camera.name!r} ({kind.name}): looks to {mount.yaw_deg:.0f} deg, {abs(up):.0f} deg "
    sketch.notes.append(SketchNote(tag, "camera", text + ("up" if up >= 0.0 else "down")))


def _add_ways(
    sketch: RobotSketch, config: RobotConfig, mechanisms: Mapping[str, ShaftSim], chains: Sequence[Sequence[Joint]]
) -> None:
    """How each mechanism moves the longest chain that it is a part of; a mechanism is drawn once."""
    drawn = {way.name for way in sketch.ways}
    for joints, offset in _parts(config, chains):
        for number, joint in enumerate(joints):
            if joint.mechanism in drawn:
                continue
            drawn.add(joint.mechanism)
            low, high = mechanisms[joint.mechanism].stops
            places: list[Vector] = []
            if math.isfinite(low) and math.isfinite(high):
                for position in np.linspace(low, high, _STEPS).tolist():
                    posed: dict[str, MechanismMotion] = dict(mechanisms)
                    posed[joint.mechanism] = Posed(position, (low, high))
                    places.append(part_pose(joints, posed, offset)[0])
            link = [part_pose(joints[:k], mechanisms, joints[k].origin)[0] for k in range(number, len(joints))]
            link.append(part_pose(joints, mechanisms, offset)[0])
            axis = np.array(rotate(part_pose(joints[:number], mechanisms)[1], joint.axis))
            way = np.array(places) if places else np.empty((0, 3))
            has_place = any(joint.origin) or number > 0
            if has_place or (joint.slides and len(way)):
                sketch.ways.append(SketchWay(joint.mechanism, axis, np.array(link), way, has_place))


def _parts(config: RobotConfig, chains: Sequence[Sequence[Joint]]) -> Iterator[tuple[Sequence[Joint], Vector]]:
    """Chains and the end that each carries, those of claws and hooks first."""
    for placer in config.placers:
        yield placer.joints, placer.offset
    for climber in config.climbers:
        yield climber.joints, climber.offset
    for intake in config.intakes:
        zone = intake.zone
        middle = (0.5 * (zone.x_min + zone.x_max), 0.5 * (zone.y_min + zone.y_max), 0.5 * (zone.z_min + zone.z_max))
        if intake.joints:
            yield intake.joints, middle
    for chain in chains:
        yield chain, (0.0, 0.0, 0.0)
    for component in config.components:
        yield component.joints, component.offset
