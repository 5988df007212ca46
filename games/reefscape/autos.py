"""Scripted autos of REEFSCAPE, written for a blue robot."""

from __future__ import annotations

import math

from games.reefscape import dimensions as dim
from games.reefscape.handling import (
    SETTINGS,
    before_station,
    hang,
    make_ready,
    place_coral,
    process,
    put_in_net,
    take_algae,
)
from simcore.match.game import Auto
from simcore.match.scripted import ScriptedRobot, Steps
from simcore.units import degrees

__all__ = ["AUTOS"]

_PAST_LEFT_MARK = ((2.3, 6.7),)
_PAST_RIGHT_MARK = ((2.3, dim.FIELD_WIDTH - 6.7),)
"""Waypoint from the right station to the reef, next to the algae on the mark, blue field frame [m]."""


def _load(robot: ScriptedRobot, side: str, way: tuple[tuple[float, float], ...] = ()) -> Steps:
    """Drive to a station rear first, and wait up to 1.5 s for a coral with the intake on."""
    robot.intake(True)
    make_ready(robot)
    x, y, yaw = before_station(side)
    yield from robot.drive_through([*way, (x, y)], yaw, speed=4.0, tolerance=0.08)
    for _ in range(75):
        if robot.held:
            break
        yield
    robot.intake(False)


def three_l4(robot: ScriptedRobot) -> Steps:
    """Place the preload, and then two coral from the left station, on level 4."""
    make_ready(robot)
    yield from place_coral(robot, 2, "right", 4)
    yield from _load(robot, "left", ((4.6, 5.9),))
    yield from place_coral(robot, 1, "right", 4, _PAST_LEFT_MARK)
    yield from _load(robot, "left", _PAST_LEFT_MARK)
    yield from place_coral(robot, 1, "left", 4, _PAST_LEFT_MARK)


def station_cycle(robot: ScriptedRobot) -> Steps:
    """Place the preload on level 4, then coral from the right station on levels 3 and 2."""
    make_ready(robot)
    yield from place_coral(robot, 4, "left", 4)
    yield from _load(robot, "right", ((4.6, 2.15),))
    yield from place_coral(robot, 5, "left", 3, _PAST_RIGHT_MARK)
    yield from _load(robot, "right", _PAST_RIGHT_MARK)
    yield from place_coral(robot, 5, "right", 2, _PAST_RIGHT_MARK)


def algae(robot: ScriptedRobot) -> Steps:
    """Place the preload on level 4, then bring one algae from the reef to the processor and one to the net."""
    make_ready(robot)
    yield from place_coral(robot, 3, "left", 4)
    yield from take_algae(robot, 3)
    yield from process(robot)
    yield from take_algae(robot, 4)
    yield from put_in_net(robot, 5.0, ((6.3, 3.2),))


def climb(robot: ScriptedRobot) -> Steps:
    """Hang on the middle cage without power."""
    make_ready(robot)
    yield from hang(robot, dim.CAGE_YS[1])


AUTOS: dict[str, Auto] = {
    auto.name: auto
    for auto in (
        Auto(
            name="three_l4",
            summary="the preload and two coral from the left station to level 4",
            controller=SETTINGS.controller(three_l4),
            start=(7.2, 5.9, degrees(-120.0)),
        ),
        Auto(
            name="station_cycle",
            summary="the preload to level 4, coral from the right station to levels 3 and 2",
            controller=SETTINGS.controller(station_cycle),
            start=(7.2, 2.15, degrees(120.0)),
        ),
        Auto(
            name="algae",
            summary="the preload to level 4, algae from the reef through the processor and into the net",
            controller=SETTINGS.controller(algae),
            start=(7.2, 4.0259, math.pi),
        ),
        Auto(
            name="climb",
            summary="climb the middle cage, which counts if the robot still hangs there when the match is over",
            controller=SETTINGS.controller(climb),
            start=(7.2, 5.9, math.pi),
        ),
    )
}
"""Autos by name; the first auto is the default."""
