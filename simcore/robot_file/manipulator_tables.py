"""What the mechanisms of `simcore.toml` carry: storages, intakes, shooters, claws, climbers and parts to be drawn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

from simcore.geometry.linkage import Joint
from simcore.geometry.rotation import from_rpy
from simcore.pieces.hopper import FACES, HopperConfig
from simcore.pieces.intake import IntakeConfig, IntakeZone
from simcore.pieces.launch import LaunchParameters
from simcore.pieces.placer import PlacerConfig
from simcore.pieces.shooter import ShooterConfig
from simcore.pieces.storage import StorageConfig
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
from simcore.robot.mechanisms import FlywheelConfig, RollerConfig
from simcore.robot.robot_config import ComponentConfig
from simcore.robot_file.key_tables import REQUIRED, Key, KeyTable, Named, Names, Several, Table
from simcore.robot_file.mechanism_tables import joints_to
from simcore.robot_file.robot_settings import MechanismSettings

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
    """`x_min` to `z_max` with their defaults [m]; None: it is needed."""
    names = [f"{axis}_{end}" for axis in "xyz" for end in ("min", "max")]
    return tuple(
        Key(name, ROBOT_PLACE, REQUIRED if corner is None else corner, about if name == "x_min" else "", example)
        for name, corner, example in zip(names, corners, examples, strict=True)
    )


STORAGE = KeyTable("[[storage]]", "only if the robot has several, e.g. one a shooter; preloads are in the first", (
    Key("name", str, "", "by which intakes and shooters choose it", "front"),
    Key("capacity", Quantity("", 1, 500, is_whole=True), None, "left out: that of [robot]", 20),
    Key("order", ("fifo", "lifo"), _ROOM.order, "lifo is a stack"),
    *_box("room where held pieces are drawn", *(e for ends in zip(_ROOM.low, _ROOM.high, strict=True) for e in ends)),
    Key("outlet", tuple(FACES), None, "side with the opening to the shooter: pieces fall, roll and jam in the room one "
        "by one; left out: they are a list", "front", needs=("outlet_width", "<m>")),
    Key("outlet_width", ROBOT_LENGTH, None, "needed with an outlet; below two diameters two pieces can jam", 0.4,
        needs=_OUTLET),
    Key("outlet_height", ROBOT_LENGTH, None, "left out: as the width", 0.2, needs=_OUTLET),
    Key("outlet_place", (ROBOT_PLACE,) * 2, None, "its middle: y and z, of one in the left or right side x and z, in "
        "the bottom y and x; left out: in the middle of the side, at the floor", [0.0, 0.35],
        needs=_OUTLET),
    Key("inlet", tuple(FACES)[:-1], None, "wall at whose top pieces come in; left out: opposite the outlet", "back",
        needs=_OUTLET),
    Key("belt", _ONE, None, "a mechanism that moves what lies on the floor; left out: none does", "feeder",
        needs=_OUTLET),
    Key("belt_travel", RATIO, 0.025, "way of a piece per radian of it [m]: radius of its roller, half of it where "
        "pieces roll along a fixed ceiling; negative if it turns backward to feed", needs=_OUTLET),
    Key("funnel_deg", _LEAN, 0.0, "angle of the walls beside the opening; 0: its corners are dead", field="funnel",
        needs=_OUTLET),
    Key("slope_deg", _LEAN, 0.0, "of the floor, down to an outlet in a wall", field="slope", needs=_OUTLET),
    Key("friction", FRICTION, None, "of pieces on belt, edges and each other; left out: 0.4, of foam on a wall", 0.4,
        needs=_OUTLET),
))  # fmt: skip
INTAKE = KeyTable("[[intake]]", "pieces in this box are taken in while the roller turns forward; one table an intake", (
    *_box("x is forward, so this one is behind the bumpers: an intake at the back; in front of them both x are above "
        "zero, at the left side both y",
        None, None, None, None, -0.1, 0.2, examples=(-0.6, -0.35, -0.3, 0.3, None, None)),
    Key("roller", _ONE, about="a mechanism; it takes in above one turn a second", example="intake"),
    Key("takes_in", _DIRECTIONS, "forward", "or backward: how the roller turns then"),
    Key("deploy", _ONE, None, "a mechanism that must be out; left out: it always is", "pivot"),
    Key("out_at", ("upper", "lower"), "upper", "at which of its stops it is out", "lower", field="deployed_at",
        needs=("deploy", "<mechanism>")),
    Key("on", _CARRIER, None, "what carries the box; it is then from that joint, with all joints at 0", "pivot"),
    Key("storage", _STORAGE, "", "where pieces go; left out: the first", "front"),
    _KINDS,
))  # fmt: skip
SHOOTER = KeyTable("[[shooter]]", "one table a shooter; it throws while its wheels turn five times a second or more", (
    Key("wheels", _SOME, about='a flywheel, or two with speeds of their own: ["lower", "upper"]', example="shooter"),
    Key("side_by_side", bool, False, "whether two wheels are the left and the right one"),
    Key("feeder", _SOME, (), "what must turn forward, one or a list; left out: spinning wheels do", "feeder", "gate"),
    Key("feeder_backward", Several(str), (), "those of them that feed backward", "feeder", "gate_reversed"),
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
    Key("height", ROBOT_LENGTH, about="of the muzzle: the middle of a piece as it leaves", example=0.5),
    Key("forward", ROBOT_PLACE, 0.0, "of the muzzle, from the robot's center or the turret's axis", 0.15),
    Key("yaw_deg", DEGREES, 0.0, "where it shoots, with the turret at 0: 0 front, 90 left, 180 back", field="heading"),
    Key("barrels", Several(ROBOT_PLACE), (0.0,), "places across, to the left"),
    Key("shots_per_second", RATE, 8.0, "of each barrel", field="shot_rate"),
    Key("wheel_radius", Several(WHEEL_RADIUS), (0.05,), "of two wheels also [lower, upper]", 0.05),
    Key("compression", EFFICIENCY, 0.15, "share of its diameter by which a piece is squeezed"),
    Key("compression_loss", FACTOR, 0.0, "energy that a shot loses to the piece's foam [J]"),
    Key("exit_efficiency", EFFICIENCY, None, "piece's speed over the rim's; `simcore calibrate` fits it; left "
        "out: 0.49 (against a fixed hood), of two wheels 0.98", 0.49),
    _KINDS,
))  # fmt: skip
CLAW = KeyTable("[[claw]]", "holds one piece at the end of what carries it", (
    Key("on", _CARRIER, about='a mechanism; an arm on an elevator has on = "lift" itself', example="arm"),
    Key("x", ROBOT_PLACE, 0.0, "middle of the held piece from that joint, with all joints at 0", 0.35),
    *_PLACES,
    Key("size", (_EDGE,) * 3, (0.3, 0.3, 0.3), "of the box around it in which pieces are taken"),
    Key("roller", _ONE, about="a mechanism: forward takes, backward lets go", example="claw"),
    Key("passes_through", bool, False, "whether forward lets go, too, once the roller has stopped in between"),
    *(Key(f"{axis}_deg", DEGREES, 0.0, "of the held piece", field=axis) for axis in ("roll", "pitch", "yaw")),
    Key("from_storage", bool, False, "whether the storage hands pieces on to it", True),
    Key("storage", _STORAGE, "", "which; left out: the first", "front"),
    Key("handover", (ROBOT_PLACE,) * 3, None, "where: its box must be there; left out: anywhere", [0.1, 0.0, 0.5],
        needs=("from_storage", "true")),
    _KINDS,
))  # fmt: skip
CLIMBER = KeyTable("[[climber]]", "a hook that comes down on a rung of the field, and pulls the robot up", (
    Key("on", _CARRIER, about="the mechanism that pulls it", example="climb"),
    Key("x", ROBOT_PLACE, 0.0, "inside of the hook from that joint, with all joints at 0"),
    *_PLACES,
    Key("reach", WHEEL_RADIUS, 0.04, "half of the hook's mouth"),
))  # fmt: skip
COMPONENT = KeyTable("[[component]]", "a moving part with a model of its own in AdvantageScope, in the models' order", (
    Key("name", str, example="forearm"),
    Key("on", _CARRIER, None, "a mechanism; needed where no roller turns it", "arm"),
    Key("roller", _ONE, None, "a roller that turns it about y at that place", "claw"),
    Key("share", RATIO, 1.0, "of the motion: 0.33 for the first stage of an elevator with three"),
    Key("x", ROBOT_PLACE, 0.0, "origin of the model from that joint, with all joints at 0"),
    *_PLACES,
))  # fmt: skip
MANIPULATORS = (STORAGE, INTAKE, SHOOTER, CLAW, CLIMBER, COMPONENT)


def read_storage(t: Table, capacity: int | None, names: Names) -> StorageConfig:
    """Room for pieces.

    Args:
        t: The table.
        capacity: Of a storage that says nothing; None: it must say.
        names: Of its belt.
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
    """A box where pieces are taken in."""
    v = _read(INTAKE, t, names)
    (x_min, y_min, z_min), (x_max, y_max, z_max) = _corners(t, v)
    zone = IntakeZone(x_min=x_min, x_max=x_max, y_min=y_min, y_max=y_max, z_min=z_min, z_max=z_max)
    if v["deploy"] is not None and isinstance(mechanisms[v["deploy"]].config, FlywheelConfig | RollerConfig):
        raise t.error("deploy", f"must be an arm, elevator or rack, which has stops; got {v['deploy']!r}")
    joints, backward = joints_to(v.pop("on"), mechanisms), v.pop("takes_in") == "backward"
    return IntakeConfig(zone=zone, joints=joints, roller_reversed=backward, **v)


def read_shooter(t: Table, mechanisms: _Mechanisms, names: Names) -> ShooterConfig:
    """Wheels that throw pieces."""
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
    if (beside := v.pop("side_by_side")) and len(wheels) == 1:
        raise t.error("side_by_side", 'needs two wheels beside it: wheels = ["left", "right"]')
    radii = v.pop("wheel_radius")
    if len(radii) > len(wheels):
        raise t.error("wheel_radius", f"must be one number, or one for each of {list(wheels)}; got {list(radii)}")
    joint = None if v["turret"] is None else mechanisms[v["turret"]].joint
    axis = (0.0, 0.0, 0.0) if joint is None else joint.origin
    pivot = [place if given is None else given for given, place in zip((v.pop("pivot_x"), v.pop("pivot_y")), axis)]  # noqa: B905
    place = {key: v.pop(key) for key in ("height", "forward", "heading", "barrels")}
    efficiency = v.pop("exit_efficiency") or (0.49 if len(wheels) == 1 else 0.98)
    return ShooterConfig(
        wheel_places="left and right" if beside else "lower and upper",
        wheel_radius=radii[0],
        second_wheel_radius=radii[1] if len(radii) > 1 else None,
        exit_efficiency=efficiency,
        launch=LaunchParameters(**place, pivot_x=pivot[0], pivot_y=pivot[1]),
        **v,
    )


def read_claw(t: Table, mechanisms: _Mechanisms, names: Names) -> PlacerConfig:
    """What holds one piece at the end of what carries it."""
    v = _read(CLAW, t, names)
    joints = joints_to(v.pop("on"), mechanisms)
    offset, (dx, dy, dz) = _offset(v), (0.5 * edge for edge in v.pop("size"))
    x, y, z = offset
    attitude = from_rpy(v.pop("roll"), v.pop("pitch"), v.pop("yaw"))
    zone = IntakeZone(x_min=x - dx, x_max=x + dx, y_min=y - dy, y_max=y + dy, z_min=z - dz, z_max=z + dz)
    return PlacerConfig(joints=joints, offset=offset, attitude=attitude, zone=zone, **v)


def read_climber(t: Table, mechanisms: _Mechanisms, names: Names) -> ClimberConfig:
    """A hook at the end of what carries it."""
    v = _read(CLIMBER, t, names)
    return ClimberConfig(joints=joints_to(v["on"], mechanisms), offset=_offset(v), reach=v["reach"])


def read_component(t: Table, mechanisms: _Mechanisms, names: Names) -> ComponentConfig:
    """A part with a model of its own: what a chain carries, or what a roller turns there."""
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
    """All of a table."""
    values = keys.read(t, names)
    t.finish()
    return values


def _offset(v: dict[str, Any]) -> tuple[float, float, float]:
    return v.pop("x"), v.pop("y"), v.pop("z")


def _corners(t: Table, v: dict[str, Any]) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Smallest and largest corner of a box [m]."""
    low, high = ([v.pop(f"{axis}_{end}") for axis in "xyz"] for end in ("min", "max"))
    for axis, below, above in zip("xyz", low, high, strict=True):
        if not below < above:
            raise t.error(f"{axis}_min", f"must be below {axis}_max, got {below} and {above} m")
    return (low[0], low[1], low[2]), (high[0], high[1], high[2])
