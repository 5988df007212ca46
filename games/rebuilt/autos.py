"""Scripted autos of REBUILT, written for a blue robot."""

from __future__ import annotations

import math

from games.rebuilt.dimensions import (
    BUMP_LEFT_Y,
    DEPOT_DEPTH,
    DEPOT_WIDTH,
    DEPOT_Y,
    FIELD_LENGTH,
    HUB_CENTER,
    TRENCH_LEFT_Y,
)
from games.rebuilt.field import HUB_TARGET
from simcore.match.game import Auto
from simcore.match.players.driven_robot import DriverControls
from simcore.match.scripted import ScriptedRobot, ScriptSettings, Steps
from simcore.units import degrees

__all__ = ["AUTOS", "DRIVING", "SETTINGS"]

_HUB_X = HUB_CENTER[0]

SETTINGS = ScriptSettings(
    shot_elevation=degrees(68.0),  # steep enough to fall into the funnel
    feed_volts={"feeder": 9.0, "spindexer": 6.0},
    roller_volts=9.0,
    intake_x=-0.62,  # center of the intake zone, with the rack extended
)


def depot(robot: ScriptedRobot) -> Steps:
    """Shoot the preload, back into the depot with the intake deployed, return, and shoot the collected fuel."""
    x, y = DEPOT_DEPTH / 2, DEPOT_Y
    yield from robot.shoot_until_empty(HUB_TARGET, timeout=3.0)
    robot.intake(True)
    yield from robot.drive_to(x + 1.3, y, 0.0, speed=3.0, tolerance=0.1)
    yield from robot.drive_to(x + 0.5, y, 0.0, speed=1.5, timeout=1.8)
    low, high = (0.0, y - DEPOT_WIDTH / 2), (1.0, y + DEPOT_WIDTH / 2)
    yield from robot.collect_in(low, high, aside=0.14, timeout=5.0)
    yield from robot.collect_in((0.0, y - 1.2), (1.5, y + 1.5), aside=1.3, timeout=4.0)  # fuel that left the depot
    robot.spin_up(HUB_TARGET)
    yield from robot.drive_to(2.4, 5.2, -0.4, speed=3.0)
    robot.intake(False)
    yield from robot.shoot_until_empty(HUB_TARGET, timeout=6.0)


def neutral(robot: ScriptedRobot) -> Steps:
    """Shoot the preload, cross the bump intake first, collect in the neutral zone, return over the bump and shoot."""
    y = BUMP_LEFT_Y
    yield from robot.shoot_until_empty(HUB_TARGET, timeout=3.0)
    robot.intake(True)
    yield from robot.drive_to(_HUB_X - 1.4, y, math.pi, speed=3.0, tolerance=0.15)
    yield from robot.drive_to(_HUB_X + 1.6, y, math.pi, speed=2.5, tolerance=0.2)
    yield from robot.drive_to(FIELD_LENGTH / 2 - 0.6, y, math.pi, speed=2.0, tolerance=0.2)
    yield from robot.drive_to(FIELD_LENGTH / 2 - 0.3, y - 1.2, math.pi * 0.75, speed=1.5, tolerance=0.2)
    yield from robot.drive_to(_HUB_X + 1.7, y, math.pi, speed=3.0, tolerance=0.2)
    robot.spin_up(HUB_TARGET)
    # At 2.5 m/s, one robot in ten would get stuck with the wheels in the air, on fuel pushed over the bump.
    yield from robot.drive_to(_HUB_X - 1.6, y, math.pi, speed=1.4, tolerance=0.15)
    yield from robot.drive_to(2.4, 5.2, -0.4, speed=3.0)
    robot.intake(False)
    yield from robot.shoot_until_empty(HUB_TARGET, timeout=6.0)


def tour(robot: ScriptedRobot) -> Steps:
    """Drive over the bump into the neutral zone and back through the trench, without shooting."""
    y, trench = BUMP_LEFT_Y, TRENCH_LEFT_Y
    yield from robot.drive_to(_HUB_X - 1.5, y, 0.0, tolerance=0.15)
    yield from robot.drive_to(_HUB_X + 1.6, y, 0.0, speed=2.5, tolerance=0.2)
    yield from robot.drive_through([(_HUB_X + 1.6, trench), (_HUB_X - 1.8, trench)], 0.0, speed=3.0)
    yield from robot.drive_to(2.5, y, 0.0)


def _shoot(robot: ScriptedRobot) -> Steps:
    """Aim at the hub and shoot all fuel, again and again while the driver holds the button."""
    while True:
        yield from robot.shoot_until_empty(HUB_TARGET, timeout=10.0)


DRIVING = DriverControls(settings=SETTINGS, actions={"shoot": _shoot})
"""Driver controls of the default robot: settings of the scripts, and the action `shoot`."""

AUTOS: dict[str, Auto] = {
    auto.name: auto
    for auto in (
        Auto(
            name="depot",
            summary="shoot the preload, collect the depot, shoot again",
            controller=SETTINGS.controller(depot),
            start=(2.6, 5.3, -0.5),
        ),
        Auto(
            name="neutral",
            summary="shoot the preload, cross the bump, collect in the neutral zone, come back, shoot",
            controller=SETTINGS.controller(neutral),
            start=(2.9, 5.3, -0.5),
        ),
        Auto(
            name="tour",
            summary="drive only: over a bump and back through a trench",
            controller=SETTINGS.controller(tour),
            start=(2.5, 5.6, 0.0),
            preload=0,
        ),
    )
}
"""Autos by name; the first auto is the default."""
