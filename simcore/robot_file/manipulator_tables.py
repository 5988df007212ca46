"""Tables of `simcore.toml` for manipulators: storages, intakes, shooters, claws, climbers and components."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

from simcore.pieces.launch import LaunchParameters
from simcore.quantities import (
    DEGREES,
    EFFICIENCY,
    FACTOR,
    FRICTION,
    RATE,
    RATIO,
    ROBOT_LENGTH,
    ROBOT_PLACE,
    WHEEL_RADIUS,
    Quantity,
)
from simcore.robot.climber import ClimberConfig
from simcore.robot.hopper import FACES, HopperConfig
from simcore.robot.intake import IntakeConfig, IntakeZone
from simcore.robot.mechanisms import FlywheelConfig, RollerConfig
from simcore.robot.placer import PlacerConfig
from simcore.robot.robot_config import ComponentConfig
from simcore.robot.shooter import ShooterConfig
from simcore.robot.storage import StorageConfig
from simcore.robot_file.key_tables import REQUIRED, Key, KeyTable, Named, Names, Several, Table
from simcore.robot_file.mechanism_tables import joints_to
from simcore.robot_file.robot_settings import MechanismSettings
from simcore.world.linkage import Joint
from simcore.world.rotation import from_rpy

__all__ = [
    "CLAW", "CLIMBER", "COMPONENT", "INTAKE", "MANIPULATORS", "SHOOTER", "STORAGE", "read_claw", "read_climber",
    "read_component", "read_intake", "read_shooter", "read_storage",
]  # fmt: skip

_Mechanisms = Mapping[str, MechanismSettings]
_ONE, _SOME = Named("mechanism", "[[mechanism]]"), Named("mechanism", "[[mechanism]]", many=True)
_CARRIER = Named("carrier", "[[mechanism]] of kind arm, turret, elevator or rack")
_STORAGE = Named("storage", "[[storage]]")
_DIRECTIONS = ("forward", "backward")
_EDGE = Quantity("m", 0.0, 2.0, is_open=True)
_KINDS = Key("kinds", Several(str), (), "kinds of pieces; left out: all", ["Name"])
_PLACES = tuple(Key(axis, ROBOT_PLACE, 0.0) for axis in "yz")
_OUTLET, _TURRET = ("outlet", "<side>"), ("turret", "<mechanism>")
_LEAN = Quantity("deg", 0.0, 68.0)
_ROOM = StorageConfig()


def _box(about: str, *corners: float | None, examples: tuple[float | None, ...] = (None,) * 6) -> tuple[Key, ...]:
    """Return the keys `x_min` to `z_max` of a box.

    Args:
        about: Meaning of the box, written at `x_min`.
        corners: Default of each key [m]; None for a required key.
        examples: Value of each key in the template [m]; None for the default.
    """
    names = [f"{axis}_{end}" for axis in "xyz" for end in ("min", "max")]
    return tuple(
        Key(name, ROBOT_PLACE, REQUIRED if corner is None else corner, about if name == "x_min" else "", example)
        for name, corner, example in zip(names, corners, examples, strict=True)
    )


STORAGE = KeyTable("[[storage]]", "only if the robot has several, e.g. one per shooter; preloads are in the first", (
    Key("name", str, "", "intakes and shooters refer to it by this", "front"),
    Key("capacity", Quantity("", 1, 500, is_whole=True), None, "left out: that of [robot]", 20),
    Key("order", ("fifo", "lifo"), _ROOM.order, "lifo is a stack"),
    *_box("box in which held pieces are drawn", *(e for ends in zip(_ROOM.low, _ROOM.high, strict=True) for e in ends)),
    Key("outlet", tuple(FACES), None, "side with the opening to the shooter: pieces fall, roll and jam in the box one "
        "by one; left out: they are a list", "front", needs=("outlet_width", "<m>")),
    Key("outlet_width", ROBOT_LENGTH, None, "needed with an outlet; below three diameters pieces can jam", 0.4,
        needs=_OUTLET),
    Key("outlet_height", ROBOT_LENGTH, None, "left out: equal to the width", 0.2, needs=_OUTLET),
    Key("outlet_place", (ROBOT_PLACE,) * 2, None, "its center: y and z, in the left or right side x and z, in "
        "the bottom y and x; left out: in the middle of the side, at the floor", [0.0, 0.35],
        needs=_OUTLET),
    Key("inlet", tuple(FACES)[:-1], None, "wall at whose top pieces enter; left out: opposite the outlet", "back",
        needs=_OUTLET),
    Key("belt", _ONE, None, "a mechanism that moves pieces on the floor; left out: none", "feeder",
        needs=_OUTLET),
    Key("belt_travel", RATIO, 0.025, "travel of a piece per radian of it [m]: radius of its roller, half of it where "
        "pieces roll along a fixed ceiling; negative if it turns backward to feed", needs=_OUTLET),
    Key("funnel_deg", _LEAN, 0.0, "angle of the walls next to the outlet; 0: its corners are dead", field="funnel",
        needs=_OUTLET),
    Key("slope_deg", _LEAN, 0.0, "of the floor, down to an outlet in a wall", field="slope", needs=_OUTLET),
    Key("friction", FRICTION, None, "of foam pieces on walls, floor and belt; left out: 0.4, foam on a wall", 0.4,
        needs=_OUTLET),
))  # fmt: skip
INTAKE = KeyTable("[[intake]]", "takes in pieces in this box while the roller turns forward; one table per intake", (
    *_box("x is forward, so this box is behind the bumpers: an intake at the back; at the front both x are positive, "
        "at the left side both y",
        None, None, None, None, -0.1, 0.2, examples=(-0.6, -0.35, -0.3, 0.3, None, None)),
    Key("roller", _ONE, about="a mechanism; takes in above one turn per second", example="intake"),
    Key("takes_in", _DIRECTIONS, "forward", "or backward: direction of the roller then"),
    Key("deploy", _ONE, None, "a mechanism that must be deployed; left out: none", "pivot"),
    Key("out_at", ("upper", "lower"), "upper", "stop at which it is deployed", "lower", field="deployed_at",
        needs=("deploy", "<mechanism>")),
    Key("on", _CARRIER, None, "carrier of the box, which is then from that joint, with all joints at 0", "pivot"),
    Key("storage", _STORAGE, "", "where pieces go; left out: the first", "front"),
    _KINDS,
))  # fmt: skip
SHOOTER = KeyTable("[[shooter]]", "one table per shooter; shoots while its wheels turn five times a second or more", (
    Key("wheels", _SOME, about='a flywheel, or two with their own speeds: ["lower", "upper"]', example="shooter"),
    Key("side_by_side", bool, False, "whether two wheels are left and right, not lower and upper"),
    Key("feeder", _SOME, (), "must turn forward, one or a list; left out: spinning wheels suffice", "feeder", "gate"),
    Key("feeder_backward", Several(str), (), "feeders that turn backward to feed", "feeder", "gate_reversed"),
    Key("storage", _STORAGE, "", "where pieces come from; left out: the first", "front"),
    Key("hood", _ONE, None, "a mechanism that tilts the shot; left out: it is fixed", "hood"),
    Key("elevation_deg", DEGREES, about="of the shot, with the hood at angle 0", example=65.0, field="elevation"),
    Key("elevation_per_hood", RATIO, -1.0, "-1 if the shot gets flatter as the hood goes up",
        needs=("hood", "<mechanism>")),
    Key("turret", _ONE, None, "a mechanism that turns the shot; left out: it is fixed", "turret"),
    Key("turret_ratio", RATIO, 1.0, "turns of the shot per turn of that mechanism", needs=_TURRET),
    Key("turret_x", ROBOT_PLACE, None, "where the turret's axis is; left out: at its joint", 0.0, "pivot_x",
        needs=_TURRET),
    Key("turret_y", ROBOT_PLACE, None, "", 0.0, "pivot_y", needs=_TURRET),
    Key("height", ROBOT_LENGTH, about="of the muzzle: the center of a piece as it leaves", example=0.5),
    Key("forward", ROBOT_PLACE, 0.0, "of the muzzle, from the robot's center or the turret's axis", 0.15),
    Key("yaw_deg", DEGREES, 0.0, "direction of shots, turret at 0: 0 front, 90 left, 180 back", field="heading"),
    Key("barrels", Several(ROBOT_PLACE), (0.0,), "positions across, to the left"),
    Key("shots_per_second", RATE, 8.0, "of each barrel", field="shot_rate"),
    Key("wheel_radius", Several(WHEEL_RADIUS), (0.05,), "for two wheels also [lower, upper]", 0.05),
    Key("compression", EFFICIENCY, 0.15, "compression of a piece as a fraction of its diameter"),
    Key("compression_loss", FACTOR, 0.0, "energy that a shot loses to the piece's foam [J]"),
    Key("exit_efficiency", EFFICIENCY, None, "piece's speed over the rim's; `simcore calibrate` fits it; left "
        "out: 0.49 (against a fixed hood), of two wheels 0.98", 0.49),
    _KINDS,
))  # fmt: skip
CLAW = KeyTable("[[claw]]", "holds one piece at the end of an arm or elevator", (
    Key("on", _CARRIER, about='a mechanism; an arm on an elevator has on = "lift" itself', example="arm"),
    Key("x", ROBOT_PLACE, 0.0, "center of the held piece from that joint, with all joints at 0", 0.35),
    *_PLACES,
    Key("size", (_EDGE,) * 3, (0.3, 0.3, 0.3), "of the box around it that takes pieces"),
    Key("roller", _ONE, about="a mechanism: forward takes, backward releases", example="claw"),
    Key("passes_through", bool, False, "whether forward also releases, once the roller has stopped in between"),
    *(Key(f"{axis}_deg", DEGREES, 0.0, "of the held piece", field=axis) for axis in ("roll", "pitch", "yaw")),
    Key("from_storage", bool, False, "whether it also takes pieces from the storage", True),
    Key("storage", _STORAGE, "", "which; left out: the first", "front"),
    Key("handover", (ROBOT_PLACE,) * 3, None, "point that the box must contain then; left out: any", [0.1, 0.0, 0.5],
        needs=("from_storage", "true")),
    _KINDS,
))  # fmt: skip
CLIMBER = KeyTable("[[climber]]", "a hook that moves down onto a rung of the field and pulls the robot up", (
    Key("on", _CARRIER, about="the mechanism that pulls it", example="climb"),
    Key("x", ROBOT_PLACE, 0.0, "inside of the hook from that joint, with all joints at 0"),
    *_PLACES,
    Key("reach", WHEEL_RADIUS, 0.04, "half of the hook's mouth"),
))  # fmt: skip
COMPONENT = KeyTable("[[component]]", "a moving part with its own AdvantageScope model, in the order of the models", (
    Key("name", str, example="forearm"),
    Key("on", _CARRIER, None, "a mechanism; needed without a roller", "arm"),
    Key("roller", _ONE, None, "a roller that turns it about y at that place", "claw"),
    Key("share", RATIO, 1.0, "of the motion: 0.33 for the first stage of an elevator with three"),
    Key("x", ROBOT_PLACE, 0.0, "origin of the model from that joint, with all joints at 0"),
    *_PLACES,
))  # fmt: skip
MANIPULATORS = (STORAGE, INTAKE, SHOOTER, CLAW, CLIMBER, COMPONENT)


def read_storage(t: Table, capacity: int | None, names: Names) -> StorageConfig:
    """Return the storage in a `[[storage]]` table; with an outlet, the storage is a hopper.

    Args:
        t: Table to read.
        capacity: Default number of pieces; None if the table must give the capacity.
        names: Names of the mechanisms in the file, for the belt.
    """
    v = _read(STORAGE, t, names)
    low, high = _corners(t, v)
    own = {key: v.pop(key) for key in [field.name for field in fields(HopperConfig)]}
    if own["outlet"] is not None:
        v["hopper"] = HopperConfig(**{key: value for key, value in own.items() if value is not None})
    room = capacity if v["capacity"] is None else v["capacity"]
    if room is None:
        raise t.error("capacity", "is missing; it must be a whole number from 0 to 500")
    return StorageConfig(**{**v, "capacity": room}, low=low, high=high)


def read_intake(t: Table, mechanisms: _Mechanisms, names: Names) -> IntakeConfig:
    """Return the intake in an `[[intake]]` table."""
    v = _read(INTAKE, t, names)
    (x_min, y_min, z_min), (x_max, y_max, z_max) = _corners(t, v)
    zone = IntakeZone(x_min=x_min, x_max=x_max, y_min=y_min, y_max=y_max, z_min=z_min, z_max=z_max)
    if v["deploy"] is not None and isinstance(mechanisms[v["deploy"]].config, FlywheelConfig | RollerConfig):
        raise t.error("deploy", f"must be an arm, elevator or rack, which has stops; got {v['deploy']!r}")
    joints, backward = joints_to(v.pop("on"), mechanisms), v.pop("takes_in") == "backward"
    return IntakeConfig(zone=zone, joints=joints, roller_reversed=backward, **v)


def read_shooter(t: Table, mechanisms: _Mechanisms, names: Names) -> ShooterConfig:
    """Return the shooter in a `[[shooter]]` table; the default turret axis is at the turret's joint."""
    v = _read(SHOOTER, t, names)
    wheels, feeders = v["wheels"], v["gate"]
    for name in wheels:
        if not isinstance(mechanisms[name].config, FlywheelConfig):
            raise t.error("wheels", f"must be a mechanism of kind flywheel, got {name!r}")
    if len(wheels) > 2 or len(set(wheels)) < len(wheels):
        raise t.error("wheels", f"must be one flywheel, or two: [lower, upper]; got {list(wheels)}")
    for name in v["gate_reversed"]:
        if name not in feeders:
            raise t.error("feeder_backward", f"must name feeders, which are {list(feeders)}; got {name!r}")
    if (side_by_side := v.pop("side_by_side")) and len(wheels) == 1:
        raise t.error("side_by_side", 'needs two wheels: wheels = ["left", "right"]')
    radii = v.pop("wheel_radius")
    if len(radii) > len(wheels):
        raise t.error("wheel_radius", f"must be one number, or one for each of {list(wheels)}; got {list(radii)}")
    joint = None if v["turret"] is None else mechanisms[v["turret"]].joint
    axis = (0.0, 0.0, 0.0) if joint is None else joint.origin
    pivot = [place if given is None else given for given, place in zip((v.pop("pivot_x"), v.pop("pivot_y")), axis)]  # noqa: B905
    place = {key: v.pop(key) for key in ("height", "forward", "heading", "barrels")}
    efficiency = v.pop("exit_efficiency") or (0.49 if len(wheels) == 1 else 0.98)
    return ShooterConfig(
        wheel_places="left and right" if side_by_side else "lower and upper",
        wheel_radius=radii[0],
        second_wheel_radius=radii[1] if len(radii) > 1 else None,
        exit_efficiency=efficiency,
        launch=LaunchParameters(**place, pivot_x=pivot[0], pivot_y=pivot[1]),
        **v,
    )


def read_claw(t: Table, mechanisms: _Mechanisms, names: Names) -> PlacerConfig:
    """Return the gripper in a `[[claw]]` table, at the end of a chain of mechanisms."""
    v = _read(CLAW, t, names)
    joints = joints_to(v.pop("on"), mechanisms)
    offset, (dx, dy, dz) = _offset(v), (0.5 * edge for edge in v.pop("size"))
    x, y, z = offset
    attitude = from_rpy(v.pop("roll"), v.pop("pitch"), v.pop("yaw"))
    zone = IntakeZone(x_min=x - dx, x_max=x + dx, y_min=y - dy, y_max=y + dy, z_min=z - dz, z_max=z + dz)
    return PlacerConfig(joints=joints, offset=offset, attitude=attitude, zone=zone, **v)


def read_climber(t: Table, mechanisms: _Mechanisms, names: Names) -> ClimberConfig:
    """Return the hook in a `[[climber]]` table, at the end of a chain of mechanisms."""
    v = _read(CLIMBER, t, names)
    return ClimberConfig(joints=joints_to(v["on"], mechanisms), offset=_offset(v), reach=v["reach"])


def read_component(t: Table, mechanisms: _Mechanisms, names: Names) -> ComponentConfig:
    """Return the moving part in a `[[component]]` table, on a chain of mechanisms or on a roller."""
    turning = tuple(name for name, m in mechanisms.items() if m.joint is None)
    v = COMPONENT.read(t, {**names, "mechanism": turning})
    t.finish()
    joints, place, share = joints_to(v["on"], mechanisms), _offset(v), v["share"]
    if v["roller"] is not None:
        roller = Joint(mechanism=v["roller"], axis=(0.0, 1.0, 0.0), origin=place, ratio=share)
        return ComponentConfig(name=v["name"], joints=(*joints, roller))
    if not joints:
        raise t.error("on", "is missing; it must be the mechanism that moves the part, e.g. an arm or an elevator")
    joints = (*joints[:-1], replace(joints[-1], ratio=share * joints[-1].ratio))
    return ComponentConfig(name=v["name"], joints=joints, offset=place)


def _read(keys: KeyTable, t: Table, names: Names) -> dict[str, Any]:
    """Return the values of a table by config field, after checking that the table has no unknown keys."""
    values = keys.read(t, names)
    t.finish()
    return values


def _offset(v: dict[str, Any]) -> tuple[float, float, float]:
    return v.pop("x"), v.pop("y"), v.pop("z")


def _corners(t: Table, v: dict[str, Any]) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Remove the keys of a box from the values; return the box's lowest and highest corner [m]."""
    low, high = ([v.pop(f"{axis}_{end}") for axis in "xyz"] for end in ("min", "max"))
    for axis, below, above in zip("xyz", low, high, strict=True):
        if not below < above:
            raise t.error(f"{axis}_min", f"must be below {axis}_max, got {below} and {above} m")
    return (low[0], low[1], low[2]), (high[0], high[1], high[2])
