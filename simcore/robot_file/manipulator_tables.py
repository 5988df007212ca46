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
_KINDS = Key("kinds", Several(str), (), "names of the kinds of pieces; left out: all kinds", ["Name"])
_PLACES = tuple(Key(axis, ROBOT_PLACE, 0.0, f"{axis} coordinate, from the joint of the carrier [m]") for axis in "yz")
_OUTLET, _TURRET = ("outlet", "<side>"), ("turret", "<mechanism>")
_LEAN = Quantity("deg", 0.0, 68.0)
_ROOM = StorageConfig()


def _box(about: str, *corners: float | None, examples: tuple[float | None, ...] = (None,) * 6) -> tuple[Key, ...]:
    """Return the keys `x_min` to `z_max` of a box.

    Args:
        about: Description of the box, for the key `x_min`.
        corners: Default of each key [m]; None for a required key.
        examples: Value of each key in the template [m]; None for the default.
    """
    names = [f"{axis}_{end}" for axis in "xyz" for end in ("min", "max")]
    return tuple(
        Key(name, ROBOT_PLACE, REQUIRED if corner is None else corner, about if name == "x_min" else "", example)
        for name, corner, example in zip(names, corners, examples, strict=True)
    )


STORAGE = KeyTable("[[storage]]", "a storage for pieces; without a table, the robot has one storage; preloads are in "
    "the first storage", (
    Key("name", str, "", "name that intakes and shooters use for the storage", "front"),
    Key("capacity", Quantity("", 1, 500, is_whole=True), None, "maximum number of pieces; left out: that of [robot]",
        20),
    Key("order", ("fifo", "lifo"), _ROOM.order, "order in which pieces leave: first in, first out, or last in, first "
        "out"),
    *_box("box for the pieces, robot frame [m]: lower and upper limits in x, y and z",
        *(e for ends in zip(_ROOM.low, _ROOM.high, strict=True) for e in ends)),
    Key("outlet", tuple(FACES), None, "side with the opening to the shooter; with an outlet, pieces fall, roll and jam "
        "in the box; left out: pieces form a queue without motion", "front", needs=("outlet_width", "<m>")),
    Key("outlet_width", ROBOT_LENGTH, None, "width of the outlet [m], needed with outlet; pieces can jam if the width "
        "is below three diameters", 0.4, needs=_OUTLET),
    Key("outlet_height", ROBOT_LENGTH, None, "height of the outlet (bottom: length along x) [m]; left out: equal to "
        "the width", 0.2, needs=_OUTLET),
    Key("outlet_place", (ROBOT_PLACE,) * 2, None, "center of the outlet, robot frame [m]: y and z (left or right side: "
        "x and z; bottom: y and x); left out: middle of the side, at the floor", [0.0, 0.35], needs=_OUTLET),
    Key("inlet", tuple(FACES)[:-1], None, "wall where pieces enter, at the top; left out: opposite the outlet (bottom: "
        "back)", "back", needs=_OUTLET),
    Key("belt", _ONE, None, "mechanism that moves pieces on the floor; left out: no belt", "feeder", needs=_OUTLET),
    Key("belt_travel", RATIO, 0.025, "travel of a piece per radian of the belt mechanism [m]: the roller radius, or "
        "half of the radius if pieces roll along a fixed ceiling; negative if the mechanism turns backward to feed",
        needs=_OUTLET),
    Key("funnel_deg", _LEAN, 0.0, "tilt of the walls next to the outlet, toward the outlet [deg]; at 0, pieces stay in "
        "the corners", field="funnel", needs=_OUTLET),
    Key("slope_deg", _LEAN, 0.0, "slope of the floor, down to an outlet in a wall [deg]", field="slope", needs=_OUTLET),
    Key("friction", FRICTION, None, "coefficient of friction of foam pieces on walls, floor and belt; left out: 0.4, "
        "for foam on a wall", 0.4, needs=_OUTLET),
))  # fmt: skip
INTAKE = KeyTable("[[intake]]", "an intake, which takes in pieces inside a box while the roller turns; one table "
    "per intake", (
    *_box("box in which pieces are taken in, robot frame [m]; for an intake at the back, both x are negative; at the "
        "front, both x are positive; at the left side, both y are positive",
        None, None, None, None, -0.1, 0.2, examples=(-0.6, -0.35, -0.3, 0.3, None, None)),
    Key("roller", _ONE, about="mechanism of the roller, which takes in pieces above one turn per second",
        example="intake"),
    Key("takes_in", _DIRECTIONS, "forward", "direction in which the roller takes in pieces"),
    Key("deploy", _ONE, None, "mechanism that deploys the intake; left out: always deployed", "pivot"),
    Key("out_at", ("upper", "lower"), "upper", "stop of the deploy mechanism at which the intake is deployed", "lower",
        field="deployed_at", needs=("deploy", "<mechanism>")),
    Key("on", _CARRIER, None, "carrier of the box; the box is then relative to the joint of the carrier, with all "
        "joints at 0; left out: the robot", "pivot"),
    Key("storage", _STORAGE, "", "storage that the intake fills; left out: the first", "front"),
    _KINDS,
))  # fmt: skip
SHOOTER = KeyTable("[[shooter]]", "a shooter, which launches pieces while the wheels turn at five turns per second "
    "or more; one table per shooter", (
    Key("wheels", _SOME, about='flywheel, or two flywheels with separate speeds: ["lower", "upper"]',
        example="shooter"),
    Key("side_by_side", bool, False, "whether two wheels are left and right instead of lower and upper"),
    Key("feeder", _SOME, (), "mechanism or mechanisms that must turn forward to feed pieces; left out: no feeder",
        "feeder", "gate"),
    Key("feeder_backward", Several(str), (), "feeders that must turn backward instead; left out: none", "feeder",
        "gate_reversed"),
    Key("storage", _STORAGE, "", "storage that feeds the shooter; left out: the first", "front"),
    Key("hood", _ONE, None, "mechanism of the hood; left out: a fixed hood", "hood"),
    Key("elevation_deg", DEGREES, about="elevation of the shot at hood angle 0 [deg]", example=65.0, field="elevation"),
    Key("elevation_per_hood", RATIO, -1.0, "change of the elevation per change of the hood angle; -1 if the shot gets "
        "flatter as the angle increases", needs=("hood", "<mechanism>")),
    Key("turret", _ONE, None, "mechanism of the turret; left out: no turret", "turret"),
    Key("turret_ratio", RATIO, 1.0, "turns of the shot direction per turn of the turret mechanism", needs=_TURRET),
    Key("turret_x", ROBOT_PLACE, None, "x coordinate of the turret axis [m]; left out: that of the turret's joint", 0.0,
        "pivot_x", needs=_TURRET),
    Key("turret_y", ROBOT_PLACE, None, "y coordinate of the turret axis [m]; left out: that of the turret's joint", 0.0,
        "pivot_y", needs=_TURRET),
    Key("height", ROBOT_LENGTH, about="height of a piece's center at launch above the floor [m]", example=0.5),
    Key("forward", ROBOT_PLACE, 0.0, "distance of the muzzle from the robot's center or the turret axis, along the "
        "shot [m]", 0.15),
    Key("yaw_deg", DEGREES, 0.0, "direction of the shot at turret angle 0, counter-clockwise [deg]: 0 front, 90 left, "
        "180 back", field="heading"),
    Key("barrels", Several(ROBOT_PLACE), (0.0,), "sideways offset of each barrel, positive to the left [m]"),
    Key("shots_per_second", RATE, 8.0, "shots per second from each barrel [1/s]", field="shot_rate"),
    Key("wheel_radius", Several(WHEEL_RADIUS), (0.05,), "radius of the wheels [m]; [lower, upper] for two different "
        "radii", 0.05),
    Key("compression", EFFICIENCY, 0.15, "compression of a piece as a fraction of the diameter"),
    Key("compression_loss", FACTOR, 0.0, "energy that the wheels lose to the piece's foam at each shot [J]"),
    Key("exit_efficiency", EFFICIENCY, None, "exit speed of a piece over the rim speed of the wheels; `simcore "
        "calibrate` fits the ratio; left out: 0.49 for one wheel against a fixed hood, 0.98 for two wheels", 0.49),
    _KINDS,
))  # fmt: skip
CLAW = KeyTable("[[claw]]", "a gripper that holds one piece at the end of an arm or elevator", (
    Key("on", _CARRIER, about='carrier of the claw, e.g. an arm; an arm on an elevator has its own on = "lift"',
        example="arm"),
    Key("x", ROBOT_PLACE, 0.0, "x coordinate of the held piece's center, from the joint of the carrier, with all "
        "joints at 0 [m]", 0.35),
    *_PLACES,
    Key("size", (_EDGE,) * 3, (0.3, 0.3, 0.3), "size along x, y and z of the box, centered on the held piece, in which "
        "the claw takes pieces [m]"),
    Key("roller", _ONE, about="mechanism that takes a piece by turning forward and releases the piece by turning "
        "backward", example="claw"),
    Key("passes_through", bool, False, "whether the roller, after a stop, also releases the piece by turning forward"),
    *(Key(f"{axis}_deg", DEGREES, 0.0, f"{axis} of the held piece [deg]", field=axis)
        for axis in ("roll", "pitch", "yaw")),
    Key("from_storage", bool, False, "whether the claw also takes pieces from the storage", True),
    Key("storage", _STORAGE, "", "storage that supplies the claw; left out: the first", "front"),
    Key("handover", (ROBOT_PLACE,) * 3, None, "point, robot frame [m], that the box must contain while the claw takes "
        "a piece from the storage; left out: any position of the box", [0.1, 0.0, 0.5], needs=("from_storage", "true")),
    _KINDS,
))  # fmt: skip
CLIMBER = KeyTable("[[climber]]", "a hook that moves down onto a rung of the field and pulls the robot up", (
    Key("on", _CARRIER, about="carrier of the hook, which pulls the robot up", example="climb"),
    Key("x", ROBOT_PLACE, 0.0, "x coordinate of the inside of the hook, from the joint of the carrier, with all joints "
        "at 0 [m]"),
    *_PLACES,
    Key("reach", WHEEL_RADIUS, 0.04, "half of the hook's opening [m]"),
))  # fmt: skip
COMPONENT = KeyTable("[[component]]", "a moving part with its own AdvantageScope model; the tables are in the order of "
    "the models", (
    Key("name", str, about="name of the part", example="forearm"),
    Key("on", _CARRIER, None, "carrier of the part; needed without a roller", "arm"),
    Key("roller", _ONE, None, "roller that turns the part about the y axis through the point x, y, z", "claw"),
    Key("share", RATIO, 1.0, "fraction of the carrier's motion: 0.33 for the first of three elevator stages"),
    Key("x", ROBOT_PLACE, 0.0, "x coordinate of the model's origin, from the joint of the carrier, with all joints at "
        "0 [m]"),
    *_PLACES,
))  # fmt: skip
MANIPULATORS = (STORAGE, INTAKE, SHOOTER, CLAW, CLIMBER, COMPONENT)


def read_storage(t: Table, capacity: int | None, names: Names) -> StorageConfig:
    """Return the storage that a `[[storage]]` table describes; a table with an outlet describes a hopper.

    Args:
        t: Table to read.
        capacity: Default capacity; None if the table must give the capacity.
        names: Names of the mechanisms in the file, for the belt.
    """
    v = _read(STORAGE, t, names)
    low, high = _corners(t, v)
    own = {key: v.pop(key) for key in [field.name for field in fields(HopperConfig)]}
    if own["outlet"] is not None:
        v["hopper"] = HopperConfig(**{key: value for key, value in own.items() if value is not None})
    room = capacity if v["capacity"] is None else v["capacity"]
    if room is None:
        raise t.error("capacity", "is missing; it must be a whole number from 1 to 500")
    return StorageConfig(**{**v, "capacity": room}, low=low, high=high)


def read_intake(t: Table, mechanisms: _Mechanisms, names: Names) -> IntakeConfig:
    """Return the intake that an `[[intake]]` table describes."""
    v = _read(INTAKE, t, names)
    (x_min, y_min, z_min), (x_max, y_max, z_max) = _corners(t, v)
    zone = IntakeZone(x_min=x_min, x_max=x_max, y_min=y_min, y_max=y_max, z_min=z_min, z_max=z_max)
    if v["deploy"] is not None and isinstance(mechanisms[v["deploy"]].config, FlywheelConfig | RollerConfig):
        raise t.error("deploy", f"must be an arm, elevator or rack, which has stops; got {v['deploy']!r}")
    joints, backward = joints_to(v.pop("on"), mechanisms), v.pop("takes_in") == "backward"
    return IntakeConfig(zone=zone, joints=joints, roller_reversed=backward, **v)


def read_shooter(t: Table, mechanisms: _Mechanisms, names: Names) -> ShooterConfig:
    """Return the shooter that a `[[shooter]]` table describes; the default turret axis is at the turret's joint."""
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
    """Return the gripper that a `[[claw]]` table describes, on a chain of mechanisms."""
    v = _read(CLAW, t, names)
    joints = joints_to(v.pop("on"), mechanisms)
    offset, (dx, dy, dz) = _offset(v), (0.5 * edge for edge in v.pop("size"))
    x, y, z = offset
    attitude = from_rpy(v.pop("roll"), v.pop("pitch"), v.pop("yaw"))
    zone = IntakeZone(x_min=x - dx, x_max=x + dx, y_min=y - dy, y_max=y + dy, z_min=z - dz, z_max=z + dz)
    return PlacerConfig(joints=joints, offset=offset, attitude=attitude, zone=zone, **v)


def read_climber(t: Table, mechanisms: _Mechanisms, names: Names) -> ClimberConfig:
    """Return the hook that a `[[climber]]` table describes, on a chain of mechanisms."""
    v = _read(CLIMBER, t, names)
    return ClimberConfig(joints=joints_to(v["on"], mechanisms), offset=_offset(v), reach=v["reach"])


def read_component(t: Table, mechanisms: _Mechanisms, names: Names) -> ComponentConfig:
    """Return the part that a `[[component]]` table describes, on a chain of mechanisms, a roller, or both."""
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
    """Remove the keys of a box from the values, check the limits, and return the lowest and highest corner [m]."""
    low, high = ([v.pop(f"{axis}_{end}") for axis in "xyz"] for end in ("min", "max"))
    for axis, below, above in zip("xyz", low, high, strict=True):
        if not below < above:
            raise t.error(f"{axis}_min", f"must be below {axis}_max, got {below} and {above} m")
    return (low[0], low[1], low[2]), (high[0], high[1], high[2])
