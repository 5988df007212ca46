"""Scripted autos, written for a blue robot."""

from __future__ import annotations

import math
from collections.abc import Callable

from games.reefscape import dimensions as dim
from games.reefscape.human_players import station_faces
from games.reefscape.robot import ALGAE_REACH, CORAL_REACH, CORAL_TILT, PIVOT, elevator_turns
from games.reefscape.staging import reef_algae_places
from simcore.geometry.symmetry import Pose
from simcore.match.game import Auto
from simcore.match.scripted import DriverControls, ScriptedRobot, ScriptSettings, Steps
from simcore.units import degrees

__all__ = ["AUTOS", "DRIVING"]

_SETTINGS = ScriptSettings(acceleration=5.5, roller_volts=6.0)  # at 7 m/s^2 the wheel that is unloaded slides

_BEYOND = {4: 0.02, 3: -0.18, 2: -0.18}
"""By level, from the end of a branch to the near end of the coral that is let go [m]: over level 4 it falls on by
itself, on the others most of it is on the branch already."""
_PAST_LEFT_MARK = ((2.3, 6.7),)
_PAST_RIGHT_MARK = ((2.3, dim.FIELD_WIDTH - 6.7),)
"""Between a station and the reef, so that the algae on the mark in between stays there [m]."""
_TUCKED = degrees(85.0)  # of the arm while driving
_CARRY = elevator_turns(0.75)
_APPROACH = 0.35  # [m], of the robot along a branch


def _reach(level: int, left: float = 0.0) -> tuple[float, float, float]:
    """How to place on a level: distance of the robot's center from the reef's [m], drum and arm angle [rad].

    The coral is let go in line with the branch. The drum is for a robot that has so far left to go along it [m].
    """
    slope = math.pi / 2 if level == 4 else dim.BRANCH_SLOPE
    arm = math.pi / 2 - slope - CORAL_TILT
    before = 0.5 * dim.CORAL_LENGTH + _BEYOND[level]
    out = dim.BRANCH_TIP_RADIUS + before * math.cos(slope) + PIVOT[0] + CORAL_REACH * math.cos(arm)
    height = dim.BRANCH_TIP_HEIGHTS[level - 2] + before * math.sin(slope) - CORAL_REACH * math.sin(arm)
    height += left * math.tan(slope) if level < 4 else 0.0
    return out, elevator_turns(height), arm


def _before_face(face: int, out: float, aside: float = 0.0) -> Pose:
    """Where a robot stands in front of a face, so far from the reef's center, and aside (left seen from there)."""
    yaw = math.radians(dim.REEF_FACE_YAWS_DEG[face])
    (cx, cy), c, s = dim.REEF_CENTER, math.cos(yaw), math.sin(yaw)
    return cx + out * c - aside * s, cy + out * s + aside * c, yaw + math.pi


def _place(robot: ScriptedRobot, face: int, side: str, level: int, way: tuple[tuple[float, float], ...] = ()) -> Steps:
    """Drive to a face, put the coral on a branch (left or right as seen from there), and back off."""
    out, drum, arm = _reach(level, _APPROACH)
    aside = -dim.BRANCH_OFFSET if side == "left" else dim.BRANCH_OFFSET
    robot.set_position("elevator", drum)
    x, y, yaw = _before_face(face, out + _APPROACH, aside)
    yield from robot.drive_through([*way, (x, y)], yaw, speed=3.5, tolerance=0.10)
    robot.set_position("arm", arm)
    x, y, yaw = _before_face(face, out, aside)
    for _ in robot.drive_to(x, y, yaw, speed=1.5 if level == 4 else 0.8, tolerance=0.012, timeout=1.2):
        robot.set_position("elevator", _reach(level, math.dist(robot.pose[:2], (x, y)))[1])
        yield
    yield from robot.wait(0.16)
    robot.set_volts("claw", -8.0)
    yield from robot.wait(0.16)
    robot.set_position("arm", _TUCKED)
    yield from robot.drive_to(*_before_face(face, out + 0.30, aside), speed=2.0, tolerance=0.12)
    robot.set_volts("claw", 8.0)
    robot.set_position("elevator", _CARRY)


def _load(robot: ScriptedRobot, side: str, way: tuple[tuple[float, float], ...] = ()) -> Steps:
    """Drive backward to a station and wait for a coral there."""
    robot.intake(True)
    _begin(robot)
    x, y, yaw = station_faces("blue")[side]
    before = (x + 0.46 * math.cos(yaw), y + 0.46 * math.sin(yaw))
    yield from robot.drive_through([*way, before], yaw, speed=4.0, tolerance=0.08)
    for _ in range(75):
        if robot.held:
            break
        yield
    robot.intake(False)


def _begin(robot: ScriptedRobot) -> None:
    robot.set_volts("claw", 8.0)
    robot.set_position("arm", _TUCKED)


def three_l4(robot: ScriptedRobot) -> Steps:
    """The preload and two coral of the left station on level 4."""
    _begin(robot)
    yield from _place(robot, 2, "right", 4)
    yield from _load(robot, "left", ((4.6, 5.9),))
    yield from _place(robot, 1, "right", 4, _PAST_LEFT_MARK)
    yield from _load(robot, "left", _PAST_LEFT_MARK)
    yield from _place(robot, 1, "left", 4, _PAST_LEFT_MARK)


def station_cycle(robot: ScriptedRobot) -> Steps:
    """The preload on level 4, then coral of the right station on levels 3 and 2."""
    _begin(robot)
    yield from _place(robot, 4, "left", 4)
    yield from _load(robot, "right", ((4.6, 2.15),))
    yield from _place(robot, 5, "left", 3, _PAST_RIGHT_MARK)
    yield from _load(robot, "right", _PAST_RIGHT_MARK)
    yield from _place(robot, 5, "right", 2, _PAST_RIGHT_MARK)


def _take_algae(robot: ScriptedRobot, face: int) -> Steps:
    """Take the algae of a face off the reef."""
    arm = degrees(35.0)
    place = reef_algae_places()[face]
    out = dim.REEF_ALGAE_RADIUS + PIVOT[0] + ALGAE_REACH * math.cos(arm)
    robot.set_position("elevator", elevator_turns(place[2] - ALGAE_REACH * math.sin(arm)))
    robot.set_volts("algae_wheel", 8.0)
    yield from robot.drive_to(*_before_face(face, out + 0.45), speed=3.5, tolerance=0.10)
    robot.set_position("arm", arm)
    yield from robot.drive_to(*_before_face(face, out), speed=1.5, tolerance=0.03, timeout=1.2)
    for _ in range(20):
        if robot.held:
            break
        yield
    robot.set_volts("algae_wheel", 0.0)
    yield from robot.drive_to(*_before_face(face, out + 0.35), speed=2.0, tolerance=0.12)
    robot.set_position("arm", _TUCKED)


def _let_algae_go(robot: ScriptedRobot) -> Steps:
    robot.set_volts("algae_wheel", -8.0)
    yield from robot.wait(0.3)
    robot.set_volts("algae_wheel", 0.0)
    robot.set_position("arm", _TUCKED)


def _process(robot: ScriptedRobot) -> Steps:
    """Bring the algae straight to the processor."""
    robot.set_position("elevator", 0.0)
    x, y = dim.PROCESSOR_X, 0.46
    yield from robot.drive_to(x, y + 0.8, -math.pi / 2, speed=3.5, tolerance=0.10)
    robot.set_position("arm", 0.0)
    yield from robot.wait(0.5)
    yield from robot.drive_to(x, y, -math.pi / 2, speed=1.5, tolerance=0.03, timeout=1.2)
    yield from robot.wait(0.2)
    yield from _let_algae_go(robot)


def algae(robot: ScriptedRobot) -> Steps:
    """The preload on level 4, one algae of the reef through the processor and one into the net."""
    _begin(robot)
    yield from _place(robot, 3, "left", 4)
    yield from _take_algae(robot, 3)
    yield from _process(robot)
    yield from _take_algae(robot, 4)
    arm = degrees(40.0)
    robot.set_position("elevator", elevator_turns(2.08))
    x, y = dim.FIELD_CENTER[0] - 0.02 - PIVOT[0] - ALGAE_REACH * math.cos(arm), 5.0
    yield from robot.drive_through([(6.3, 3.2), (x - 0.5, y)], 0.0, speed=4.0, tolerance=0.10)
    robot.set_position("arm", degrees(60.0))
    yield from robot.drive_to(x, y, 0.0, speed=1.5, tolerance=0.04, timeout=1.5)
    robot.set_position("arm", arm)
    yield from robot.wait(0.3)
    yield from _let_algae_go(robot)
    robot.set_position("elevator", _CARRY)


def climb(robot: ScriptedRobot) -> Steps:
    """Take the middle cage into the bay, with the hook over it, and pull it down; then hang without power."""
    _begin(robot)
    robot.set_volts("climber", 12.0)
    x, y = dim.CAGE_X, dim.CAGE_YS[1]
    yield from robot.drive_to(x - 0.9, y, math.pi, speed=2.0, tolerance=0.02)
    yield from robot.wait(1.5)
    yield from robot.drive_to(x, y, math.pi, speed=0.6, tolerance=0.02, timeout=4.0)
    robot.set_volts("climber", -12.0)
    yield from robot.wait(3.0)
    robot.set_volts("climber", 0.0)


def _nearest(robot: ScriptedRobot, places: dict[tuple[int, str], Pose]) -> tuple[int, str]:
    return min(places, key=lambda key: math.dist(robot.pose[:2], places[key][:2]))


def _place_near(level: int) -> Callable[[ScriptedRobot], Steps]:
    """Puts the coral on the nearest branch of a level."""
    offsets = {"left": -dim.BRANCH_OFFSET, "right": dim.BRANCH_OFFSET}
    branches = {(face, side): _before_face(face, 1.6, aside) for face in range(6) for side, aside in offsets.items()}

    def script(robot: ScriptedRobot) -> Steps:
        drum = _reach(level, _APPROACH)[1]
        robot.set_position("elevator", drum)
        while abs(robot.robot.mechanisms["elevator"].position - drum) > 1.5:  # [rad]; 0.1 m
            yield  # else a robot that stands there already brings its coral down on branches below
        yield from _place(robot, *_nearest(robot, branches), level)

    return script


def _algae_near(robot: ScriptedRobot) -> Steps:
    """Take the algae of the nearest face; with one, bring it to the processor."""
    if robot.robot.placers[1].piece is not None:
        yield from _process(robot)
    else:
        yield from _take_algae(robot, _nearest(robot, {(face, ""): _before_face(face, 1.6) for face in range(6)})[0])


def _rest(robot: ScriptedRobot) -> None:
    _begin(robot)
    robot.set_volts("algae_wheel", 0.0)
    robot.set_position("elevator", _CARRY)


DRIVING = DriverControls(
    settings=_SETTINGS,
    actions={**{f"level {level}": _place_near(level) for level in (4, 3, 2)}, "algae": _algae_near},
    rest=_rest,
)
"""What the buttons of a person do who drives the robot."""

AUTOS: dict[str, Auto] = {
    auto.name: auto
    for auto in (
        Auto(
            name="three_l4",
            summary="the preload and two coral of the left station on level 4",
            controller=_SETTINGS.controller(three_l4),
            start=(7.2, 5.9, degrees(-120.0)),
        ),
        Auto(
            name="station_cycle",
            summary="the preload on level 4, coral of the right station on levels 3 and 2",
            controller=_SETTINGS.controller(station_cycle),
            start=(7.2, 2.15, degrees(120.0)),
        ),
        Auto(
            name="algae",
            summary="the preload on level 4, algae of the reef through the processor and into the net",
            controller=_SETTINGS.controller(algae),
            start=(7.2, 4.0259, math.pi),
        ),
        Auto(
            name="climb",
            summary="up the middle cage, which counts if it still hangs there when the match is over",
            controller=_SETTINGS.controller(climb),
            start=(7.2, 5.9, math.pi),
        ),
    )
}
"""By name; the first is played if none is named."""
