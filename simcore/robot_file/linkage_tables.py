"""Where the mechanisms of `simcore.toml` are on the robot, what carries what, and the chains of joints that follow."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from simcore.geometry.linkage import Joint
from simcore.geometry.rotation import Vector
from simcore.quantities import DEGREES, MASS_OR_NONE, ROBOT_PLACE
from simcore.robot.mass_distribution import MovingMass
from simcore.robot.mechanisms import ArmConfig, ElevatorConfig, FlywheelConfig, RackConfig, RollerConfig
from simcore.robot.robot_config import MechanismConfig
from simcore.robot_file.robot_settings import MechanismSettings
from simcore.robot_file.toml_tables import Table
from simcore.units import plain_sum

__all__ = ["joints_to", "lengths", "moving_masses", "read_joint", "read_moving_mass", "require_chains"]


def read_joint(t: Table, name: str, kind: str, config: MechanismConfig) -> Joint | None:
    """The joint that a mechanism is, from its place and direction in the frame of what carries it.

    Args:
        t: The mechanism's table.
        name: Of the mechanism.
        kind: As the table says.
        config: Of the mechanism.

    Returns:
        None for what turns on the spot: flywheels and rollers.
    """
    if isinstance(config, FlywheelConfig | RollerConfig):
        return None
    origin = lengths(t, ("x", "y", "z"))
    if isinstance(config, ElevatorConfig):
        lean = math.radians(t.number("lean_deg", DEGREES, 0.0))
        axis = (math.sin(lean), 0.0, math.cos(lean))
        return Joint(mechanism=name, axis=axis, origin=origin, slides=True, ratio=config.drum_radius)
    if kind == "turret":
        return Joint(mechanism=name, axis=(0.0, 0.0, 1.0), origin=origin)
    yaw = math.radians(t.number("yaw_deg", DEGREES, 0.0))
    c, s = math.cos(yaw), math.sin(yaw)
    if isinstance(config, RackConfig):
        rise = math.radians(t.number("rise_deg", DEGREES, 0.0))
        axis = (math.cos(rise) * c, math.cos(rise) * s, math.sin(rise))
        return Joint(mechanism=name, axis=axis, origin=origin, slides=True, ratio=config.pinion_radius)
    assert isinstance(config, ArmConfig)
    # a positive angle lifts what points along the yaw
    return Joint(mechanism=name, axis=(s, -c, 0.0), origin=origin)


def read_moving_mass(t: Table, joint: Joint, config: MechanismConfig) -> tuple[float | None, Vector]:
    """How much of the robot's mass goes with a mechanism [kg], and its center in the frame after the joint [m].

    Returns:
        None for the mass where the file does not say: see `moving_masses`. The center of an arm's is then out on it.
    """
    out, (ax, ay, _) = config.center_of_mass if isinstance(config, ArmConfig) else 0.0, joint.axis
    middle = (0.0, 0.0, 0.0) if out == 0.0 else (-out * ay, out * ax, 0.0)  # an arm's axis is across its yaw
    x, y, z = t.numbers("mass_center", (ROBOT_PLACE,) * 3, middle)
    return t.number("moving_mass", MASS_OR_NONE, None), (x, y, z)


def moving_masses(mechanisms: Mapping[str, MechanismSettings]) -> tuple[MovingMass, ...]:
    """What of the robot's mass its mechanisms move; `require_chains` has looked at them.

    Where the file does not say, an elevator, a rack or an arm moves the mass that its motors do, of which what other
    mechanisms on it move is a part.
    """
    found = []
    for m in mechanisms.values():
        mass = _all_moved(m, mechanisms) - _carried(m, mechanisms)
        if mass > 0.0:
            joints = joints_to(m.name, mechanisms)
            found.append(MovingMass(name=m.name, mass=mass, joints=joints, center=m.mass_center))
    return tuple(found)


def _all_moved(m: MechanismSettings, mechanisms: Mapping[str, MechanismSettings]) -> float:
    """By a mechanism, with what is on it [kg]."""
    carried, config = _carried(m, mechanisms), m.config
    if m.moving_mass is not None:
        return m.moving_mass + carried
    if isinstance(config, ElevatorConfig):
        return max(config.carriage_mass, carried)
    return max(config.mass, carried) if isinstance(config, ArmConfig | RackConfig) else carried


def _carried(m: MechanismSettings, mechanisms: Mapping[str, MechanismSettings]) -> float:
    """By the mechanisms that are on one [kg]."""
    return plain_sum(_all_moved(one, mechanisms) for one in mechanisms.values() if one.on == m.name)


def require_chains(where: str, mechanisms: Mapping[str, MechanismSettings]) -> None:
    """Make sure that `on` names mechanisms that move something, and that none carries itself.

    Raises:
        ConfigError: One does not.
    """
    carriers = [m.name for m in mechanisms.values() if m.joint is not None]
    for m in mechanisms.values():
        table = Table({}, f"{where} [[mechanism]] {m.name!r}")
        seen = [m.name]
        on = m.on
        while on is not None:
            if on not in carriers:
                known = f"those of the file are {', '.join(carriers)}" if carriers else "there is none in the file"
                raise table.error("on", f"must name an arm, a turret, an elevator or a rack, got {on!r}; {known}")
            if on in seen:
                raise table.error("on", f"goes round in a circle: {' on '.join([*seen, on])}")
            seen.append(on)
            on = mechanisms[on].on


def joints_to(name: str | None, mechanisms: Mapping[str, MechanismSettings]) -> tuple[Joint, ...]:
    """The chain from the robot to the frame that a mechanism carries; empty for None, which is the robot itself."""
    chain: list[Joint] = []
    while name is not None:
        m = mechanisms[name]
        assert m.joint is not None
        chain.insert(0, m.joint)
        name = m.on
    return tuple(chain)


def lengths(t: Table, keys: Sequence[str]) -> Vector:
    """Three lengths on a robot, each 0 where it is not there [m]."""
    x, y, z = (t.number(key, ROBOT_PLACE, 0.0) for key in keys)
    return x, y, z
