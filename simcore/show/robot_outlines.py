"""Outlines of the zones of deployed intakes, for drawings of robots."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from simcore.robot.intake import Intake, IntakeConfig, IntakeZone
from simcore.robot.mechanisms import ShaftSim
from simcore.robot.robot_config import RobotConfig, build_mechanism
from simcore.typing import FloatArray
from simcore.world.footprints import box_corners
from simcore.world.linkage import part_pose
from simcore.world.rotation import rotate
from simcore.world.shapes import outline

__all__ = ["Posed", "deployed", "intake_outlines", "zone_corners"]


class Posed:
    """Stand-in for a mechanism at a fixed position, for drawings."""

    velocity = 0.0

    def __init__(self, position: float, stops: tuple[float, float]) -> None:
        self.position = position
        self.stops = stops


def deployed(intake: IntakeConfig, mechanisms: Mapping[str, ShaftSim | Posed]) -> dict[str, Posed]:
    """Return the mechanism that deploys an intake, at the deployed position, by name; empty without this mechanism."""
    if intake.deploy is None:
        return {}
    stops = mechanisms[intake.deploy].stops
    return {intake.deploy: Posed(stops[1] if intake.deployed_at == "upper" else stops[0], stops)}


def zone_corners(zone: IntakeZone) -> FloatArray:
    """Return the corners of a zone in the frame of the part that carries the zone [m], shape (8, 3)."""
    return box_corners((zone.x_min, zone.y_min, zone.z_min), (zone.x_max, zone.y_max, zone.z_max))


def intake_outlines(config: RobotConfig) -> list[FloatArray]:
    """Return the outline of the zone of each deployed intake, seen from above, robot frame [m], shape (n, 2) each."""
    mechanisms = {name: build_mechanism(one) for name, one in config.mechanisms.items()}
    zones = []
    for intake in config.intakes:
        posed: dict[str, ShaftSim | Posed] = {**mechanisms, **deployed(intake, mechanisms)}
        zone = Intake(intake, posed).zone
        pos, quat = part_pose(intake.joints, posed)
        shown = zone if intake.joints else replace(zone, z_min=max(0.0, zone.z_min))
        corners = np.array([np.add(pos, rotate(quat, corner)) for corner in zone_corners(shown)])
        zones.append(outline(corners[:, :2]))
    return zones
