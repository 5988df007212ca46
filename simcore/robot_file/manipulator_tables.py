"""What the mechanisms of `simcore.toml` carry: storages, intakes, shooters, claws, climbers and parts to be drawn."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from simcore.geometry.linkage import Joint
from simcore.geometry.rotation import Quaternion, from_rpy
from simcore.pieces.intake import IntakeConfig, IntakeZone
from simcore.pieces.launch import LaunchParameters
from simcore.pieces.placer import PlacerConfig
from simcore.pieces.shooter import ShooterConfig
from simcore.pieces.storage import StorageConfig
from simcore.quantities import DEGREES, EFFICIENCY, RATE, RATIO, ROBOT_LENGTH, ROBOT_PLACE, WHEEL_RADIUS, Quantity
from simcore.robot.climber import ClimberConfig
from simcore.robot.mechanisms import FlywheelConfig, RollerConfig
from simcore.robot.robot_config import ComponentConfig
from simcore.robot_file.linkage_tables import joints_to, lengths
from simcore.robot_file.robot_settings import MechanismSettings
from simcore.robot_file.toml_tables import Table

__all__ = ["read_claw", "read_climber", "read_component", "read_intake", "read_shooter", "read_storage"]

_Mechanisms = Mapping[str, MechanismSettings]
_DIRECTIONS = ("forward", "backward")


def read_storage(t: Table, capacity: int | None) -> StorageConfig:
    """Room for pieces.

    Args:
        t: The table.
        capacity: Of a storage that says nothing; None: it must say.
    """
    d = StorageConfig()
    low, high = (
        tuple(t.number(f"{axis}_{end}", ROBOT_PLACE, corner[k]) for k, axis in enumerate("xyz"))
        for end, corner in (("min", d.low), ("max", d.high))
    )
    for axis, below, above in zip("xyz", low, high, strict=True):
        _require_order(t, axis, below, above)
    storage = StorageConfig(
        name=t.text("name", ""),
        capacity=t.whole("capacity", most=500) if capacity is None else t.whole("capacity", capacity, most=500),
        order=t.choice("order", ("fifo", "lifo"), d.order),
        low=(low[0], low[1], low[2]),
        high=(high[0], high[1], high[2]),
    )
    t.finish()
    return storage


def read_intake(t: Table, mechanisms: _Mechanisms, storages: Sequence[str]) -> IntakeConfig:
    """A box where pieces are taken in."""
    zone = {key: t.number(key, ROBOT_PLACE) for key in ("x_min", "x_max", "y_min", "y_max")}
    zone["z_min"], zone["z_max"] = t.number("z_min", ROBOT_PLACE, -0.10), t.number("z_max", ROBOT_PLACE, 0.2)
    for axis in "xyz":
        _require_order(t, axis, zone[f"{axis}_min"], zone[f"{axis}_max"])
    intake = IntakeConfig(
        zone=IntakeZone(**zone),
        roller=_named(t, "roller", mechanisms),
        roller_reversed=t.choice("takes_in", _DIRECTIONS, "forward") == "backward",
        deploy=_maybe_named(t, "deploy", mechanisms),
        deployed_at=t.choice("out_at", ("upper", "lower"), "upper"),
        joints=_joints(t, mechanisms),
        storage=_storage(t, storages),
        kinds=t.texts("kinds"),
    )
    if intake.deploy is None:
        if "out_at" in t:
            raise t.error("out_at", "needs a deploy = <mechanism> beside it")
    elif isinstance(mechanisms[intake.deploy].config, FlywheelConfig | RollerConfig):
        raise t.error("deploy", f"must be an arm, elevator or rack, which has stops; got {intake.deploy!r}")
    t.finish()
    return intake


def read_shooter(t: Table, mechanisms: _Mechanisms, storages: Sequence[str]) -> ShooterConfig:
    """Wheels that throw pieces."""
    wheels = _names(t, "wheels", mechanisms)
    for name in wheels:
        if not isinstance(mechanisms[name].config, FlywheelConfig):
            raise t.error("wheels", f"must be a mechanism of kind flywheel, got {name!r}")
    if len(wheels) > 2 or len(set(wheels)) < len(wheels):
        raise t.error("wheels", f"must be one flywheel, or two: [lower, upper]; got {list(wheels)}")
    radii = _wheel_radii(t, len(wheels))
    feeders = _names(t, "feeder", mechanisms) if "feeder" in t else t.texts("feeder")
    backward = t.texts("feeder_backward")
    for name in backward:
        if name not in feeders:
            raise t.error("feeder_backward", f"must name feeders, which are {list(feeders)}; got {name!r}")
    hood, turret = _maybe_named(t, "hood", mechanisms), _maybe_named(t, "turret", mechanisms)
    joint = None if turret is None else mechanisms[turret].joint
    axis = (0.0, 0.0, 0.0) if joint is None else joint.origin
    shooter = ShooterConfig(
        wheels=wheels,
        wheel_places="left and right" if t.flag("side_by_side", False) else "lower and upper",
        gate=feeders,
        gate_reversed=backward,
        hood=hood,
        elevation=math.radians(t.number("elevation_deg", DEGREES)),
        elevation_per_hood=float(t.number("elevation_per_hood", RATIO, -1.0)),
        turret=turret,
        turret_ratio=float(t.number("turret_ratio", RATIO, 1.0)),
        wheel_radius=radii[0],
        second_wheel_radius=radii[1] if len(radii) > 1 else None,
        exit_efficiency=t.number("exit_efficiency", EFFICIENCY, 0.49 if len(wheels) == 1 else 0.98),
        launch=LaunchParameters(
            height=t.number("height", ROBOT_LENGTH),
            forward=t.number("forward", ROBOT_PLACE, 0.0),
            pivot_x=t.number("turret_x", ROBOT_PLACE, axis[0]),
            pivot_y=t.number("turret_y", ROBOT_PLACE, axis[1]),
            heading=math.radians(t.number("yaw_deg", DEGREES, 0.0)),
            barrels=t.numbers("barrels", [ROBOT_PLACE], (0.0,)),
        ),
        shot_rate=t.number("shots_per_second", RATE, 8.0),
        storage=_storage(t, storages),
        kinds=t.texts("kinds"),
    )
    for key, of, needs in (
        ("elevation_per_hood", hood, "hood"), ("turret_ratio", turret, "turret"),
        ("turret_x", turret, "turret"), ("turret_y", turret, "turret"),
    ):  # fmt: skip
        if key in t and of is None:
            raise t.error(key, f"needs a {needs} = <mechanism> beside it")
    if shooter.wheel_places == "left and right" and len(wheels) == 1:
        raise t.error("side_by_side", 'needs two wheels beside it: wheels = ["left", "right"]')
    t.finish()
    return shooter


def read_claw(t: Table, mechanisms: _Mechanisms, storages: Sequence[str]) -> PlacerConfig:
    """What holds one piece at the end of what carries it."""
    joints = _joints(t, mechanisms)
    if not joints:
        raise t.error("on", "is missing; it must be the mechanism that carries the claw: an arm, elevator or rack")
    offset = lengths(t, ("x", "y", "z"))
    size = t.numbers("size", (Quantity("m", 0.0, 2.0, is_open=True),) * 3, (0.3, 0.3, 0.3))
    (x, y, z), (dx, dy, dz) = offset, (0.5 * edge for edge in size)
    from_storage = t.flag("from_storage", False)
    if "handover" in t and not from_storage:
        raise t.error("handover", "is where the storage hands pieces on; it needs from_storage = true beside it")
    place = t.numbers("handover", (ROBOT_PLACE,) * 3, (0.0, 0.0, 0.0))
    claw = PlacerConfig(
        joints=joints,
        offset=offset,
        attitude=_attitude(t),
        roller=_named(t, "roller", mechanisms),
        give=t.number("give", ROBOT_LENGTH, 0.01),
        zone=IntakeZone(x_min=x - dx, x_max=x + dx, y_min=y - dy, y_max=y + dy, z_min=z - dz, z_max=z + dz),
        passes_through=t.flag("passes_through", False),
        from_storage=from_storage,
        handover=(place[0], place[1], place[2]) if "handover" in t else None,
        storage=_storage(t, storages),
        kinds=t.texts("kinds"),
    )
    t.finish()
    return claw


def read_climber(t: Table, mechanisms: _Mechanisms) -> ClimberConfig:
    """A hook at the end of what carries it."""
    joints = _joints(t, mechanisms)
    if not joints:
        raise t.error("on", "is missing; it must be the mechanism that pulls the hook: an elevator or an arm")
    climber = ClimberConfig(
        joints=joints, offset=lengths(t, ("x", "y", "z")), reach=t.number("reach", WHEEL_RADIUS, 0.04)
    )
    t.finish()
    return climber


def read_component(t: Table, mechanisms: _Mechanisms) -> ComponentConfig:
    """A part with a model of its own: what a chain carries, or what a roller turns there."""
    joints, place, share = _joints(t, mechanisms), lengths(t, ("x", "y", "z")), t.number("share", RATIO, 1.0)
    if "roller" not in t:
        if not joints:
            raise t.error("on", "is missing; it must be the mechanism that moves the part, e.g. an arm or an elevator")
        joints = (*joints[:-1], replace(joints[-1], ratio=share * joints[-1].ratio))
        component = ComponentConfig(name=t.text("name"), joints=joints, offset=place)
    else:
        rollers = {name: m for name, m in mechanisms.items() if m.joint is None}
        roller = Joint(mechanism=_named(t, "roller", rollers), axis=(0.0, 1.0, 0.0), origin=place, ratio=share)
        component = ComponentConfig(name=t.text("name"), joints=(*joints, roller))
    t.finish()
    return component


def _require_order(t: Table, axis: str, low: float, high: float) -> None:
    if not low < high:
        raise t.error(f"{axis}_min", f"must be below {axis}_max, got {low} and {high} m")


def _wheel_radii(t: Table, wheels: int) -> tuple[float, ...]:
    """One radius, or that of each of two wheels [m]."""
    if not t.is_list("wheel_radius"):
        return (t.number("wheel_radius", WHEEL_RADIUS, 0.05),)
    return t.numbers("wheel_radius", (WHEEL_RADIUS,) * wheels)


def _attitude(t: Table) -> Quaternion:
    """Of a held piece, against what carries it."""
    angles = [math.radians(t.number(f"{axis}_deg", DEGREES, 0.0)) for axis in ("roll", "pitch", "yaw")]
    return from_rpy(*angles)


def _joints(t: Table, mechanisms: _Mechanisms) -> tuple[Joint, ...]:
    """The chain that carries what a table describes; empty for the robot itself."""
    on = _maybe_named(t, "on", {name: m for name, m in mechanisms.items() if m.joint is not None})
    return joints_to(on, mechanisms)


def _storage(t: Table, storages: Sequence[str]) -> str:
    if "storage" in t and not storages:
        raise t.error("storage", "must name a storage, but there is no [[storage]] in the file")
    return str(t.choice("storage", storages, ""))


def _named(t: Table, key: str, mechanisms: _Mechanisms) -> str:
    """The mechanism that a key names."""
    _require_some(t, key, mechanisms)
    return str(t.choice(key, tuple(mechanisms)))


def _maybe_named(t: Table, key: str, mechanisms: _Mechanisms) -> str | None:
    """The mechanism that a key names, if it is there."""
    return _named(t, key, mechanisms) if key in t else t.text(key, None)


def _names(t: Table, key: str, mechanisms: _Mechanisms) -> tuple[str, ...]:
    """The mechanism or mechanisms that a key names."""
    _require_some(t, key, mechanisms)
    return t.choices(key, tuple(mechanisms))


def _require_some(t: Table, key: str, mechanisms: _Mechanisms) -> None:
    if not mechanisms:
        what = "[[mechanism]] of kind arm, turret, elevator or rack" if key == "on" else "[[mechanism]]"
        raise t.error(key, f"must name a mechanism, but there is no {what} in the file")
