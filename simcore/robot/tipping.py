"""How hard a robot may accelerate before wheels lift, with its mechanisms where that is worst and full of pieces."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from simcore.geometry.linkage import part_pose
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.storage import StorageConfig
from simcore.robot.chassis_config import MassDistribution, PointMass, moved_points, with_points
from simcore.robot.mechanisms import ShaftSim
from simcore.robot.robot_config import RobotConfig, build_drivetrain, build_mechanism
from simcore.units import GRAVITY

__all__ = ["TippingLimit", "stored_kind", "tipping_limit"]


@dataclass(frozen=True, slots=True)
class TippingLimit:
    """Of a robot with everything up and full."""

    mass: float
    """Then [kg]."""
    height: float
    """Of its center of mass above the floor [m]."""
    forward: float
    """Acceleration along x at which wheels lift, speeding up or braking, whichever is less [m/s^2]."""
    sideways: float
    """The same along y [m/s^2]."""
    drivetrain: float
    """What its drivetrain can do from rest, so loaded [m/s^2]."""


def tipping_limit(config: RobotConfig, kinds: Sequence[GamePieceConfig] = ()) -> TippingLimit:
    """Where the weight's moment about the outer wheels meets that of the acceleration: a h = g b.

    h is the height of the center of mass, b how far it is inside of the outermost wheels. Storages and placers are full
    of the heaviest kind that they can hold.

    Args:
        config: The robot.
        kinds: Of pieces that it may hold; none: it is empty.
    """
    worst = min(_standings(config, kinds), key=lambda one: min(_limits(config, one)))
    forward, sideways = _limits(config, worst)
    drive = build_drivetrain(config.drivetrain)
    drive.set_mass_properties(worst.mass, worst.inertia[2], worst.center)
    return TippingLimit(worst.mass, worst.center[2], forward, sideways, drive.max_accel)


def _limits(config: RobotConfig, standing: MassDistribution) -> tuple[float, float]:
    """Acceleration along x and along y at which wheels lift [m/s^2]."""
    x, y, height = standing.center
    xs, ys = zip(*config.body.wheel_positions, strict=True)
    per_meter = GRAVITY / max(height, 1e-3)
    along, across = min(max(xs) - x, x - min(xs)), min(max(ys) - y, y - min(ys))
    return per_meter * max(0.0, along), per_meter * max(0.0, across)


def _standings(config: RobotConfig, kinds: Sequence[GamePieceConfig]) -> Iterator[MassDistribution]:
    """The full robot with the mechanisms that move mass at all of their stops."""
    mechanisms: dict[str, ShaftSim] = {name: build_mechanism(one) for name, one in config.mechanisms.items()}
    body = with_points(config.bare_body, _stored(config, kinds))
    chains = [part.joints for part in config.moving_masses] + [placer.joints for placer in config.placers]
    carriers = dict.fromkeys(joint.mechanism for chain in chains for joint in chain)
    names = [name for name in carriers if all(map(math.isfinite, mechanisms[name].stops))]
    for positions in itertools.product(*(mechanisms[name].stops for name in names)):
        for name, position in zip(names, positions, strict=True):
            mechanisms[name].reset(position)
        points = moved_points(config.moving_masses, mechanisms)
        for placer in config.placers:
            heaviest = _heaviest(kinds, placer.kinds)
            if heaviest is not None:
                points.append((heaviest.mass, part_pose(placer.joints, mechanisms, placer.offset)[0]))
        yield with_points(body, points)


def stored_kind(
    config: RobotConfig, storage: StorageConfig, kinds: Sequence[GamePieceConfig]
) -> GamePieceConfig | None:
    """The heaviest kind that intakes bring into a storage; None if they bring none."""
    names = (storage.name, "") if storage is config.storage else (storage.name,)
    users = [intake for intake in config.intakes if intake.storage in names]
    allowed = [] if any(not one.kinds for one in users) else [kind for one in users for kind in one.kinds]
    return _heaviest(kinds, allowed)


def _stored(config: RobotConfig, kinds: Sequence[GamePieceConfig]) -> Iterator[PointMass]:
    """The pieces in full storages."""
    for storage in (config.storage, *config.more_storages):
        heaviest = stored_kind(config, storage, kinds)
        if heaviest is not None:
            for number in range(storage.capacity):
                yield heaviest.mass, storage.position(number, heaviest.bounding_radius)


def _heaviest(kinds: Sequence[GamePieceConfig], allowed: Sequence[str]) -> GamePieceConfig | None:
    """Of those that are allowed; all are if none is named."""
    return max((k for k in kinds if not allowed or k.name in allowed), key=lambda kind: kind.mass, default=None)
