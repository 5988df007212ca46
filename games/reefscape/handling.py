"""Scripts that handle coral, algae and cages, written for a blue robot."""

from __future__ import annotations

import math

from games.reefscape import dimensions as dim
from games.reefscape.human_players import station_faces
from games.reefscape.robot import ALGAE_REACH, CORAL_REACH, CORAL_TILT, FLOOR_PIVOT_HEIGHT, PIVOT, elevator_turns
from games.reefscape.staging import reef_algae_places
from simcore.match.scripted import ScriptedRobot, ScriptSettings, Steps
from simcore.units import degrees
from simcore.world.symmetry import Pose

__all__ = [
    "NET_X", "SETTINGS", "before_algae", "before_branch", "before_station", "hang", "lower_claw", "lower_wheel",
    "make_ready", "place_coral", "process", "put_in_net", "raise_to", "raise_to_net", "take_algae", "tuck",
]  # fmt: skip

SETTINGS = ScriptSettings(acceleration=5.5, roller_volts=6.0)  # at 7 m/s^2 the unloaded wheel slips

_ELEVATOR_TOLERANCE = 0.3  # [rad] of the drum, about 2 cm
_BEYOND = {4: 0.02, 3: -0.18, 2: -0.18}
"""Distance from the end of a branch to the near end of the released coral, by level [m]. On level 4 the coral drops
onto the branch. On the other levels most of the coral is already on the branch at the release."""
_TUCKED = degrees(85.0)  # arm angle while driving
_CARRY = elevator_turns(0.75)
_APPROACH, _NEAR_ENOUGH = 0.35, 0.05  # [m]; run-up along a branch, and position error at which a coral is released
_ALGAE_ARM = degrees(35.0)  # arm angle while the wheel takes algae off the reef
_ALGAE_OUT = dim.REEF_ALGAE_RADIUS + PIVOT[0] + ALGAE_REACH * math.cos(_ALGAE_ARM)  # [m] from the reef's center
_NET_ARM = degrees(40.0)  # arm angle while an algae falls into the net
_OVER_NET = elevator_turns(2.08)
NET_X = dim.FIELD_CENTER[0] - 0.02 - PIVOT[0] - ALGAE_REACH * math.cos(_NET_ARM)
"""x coordinate of the robot's center when the robot puts an algae into the net, blue field frame [m]."""
_AT_STATION = 0.46  # [m]; distance from a station's face to the robot's center
_ASIDE = {"left": -dim.BRANCH_OFFSET, "middle": 0.0, "right": dim.BRANCH_OFFSET}


def _reach(level: int, left: float = 0.0) -> tuple[float, float, float]:
    """Compute robot distance, drum angle and arm angle for a coral in line with a branch, nearly upright on level 1.

    Args:
        level: Level, 1 to 4.
        left: Remaining distance of the robot from the placing position [m]; the elevator is higher by the rise of the
            branch over this distance.

    Returns:
        Distance of the robot's center from the reef's center [m], drum angle [rad] and arm angle [rad].
    """
    if level == 1:
        return dim.REEF_APOTHEM + 0.44, elevator_turns(0.85), degrees(-27.0)
    slope = math.pi / 2 if level == 4 else dim.BRANCH_SLOPE
    arm = math.pi / 2 - slope - CORAL_TILT
    before = 0.5 * dim.CORAL_LENGTH + _BEYOND[level]
    out = dim.BRANCH_TIP_RADIUS + before * math.cos(slope) + PIVOT[0] + CORAL_REACH * math.cos(arm)
    height = dim.BRANCH_TIP_HEIGHTS[level - 2] + before * math.sin(slope) - CORAL_REACH * math.sin(arm)
    height += left * math.tan(slope) if level < 4 else 0.0
    return out, elevator_turns(height), arm


def _before_face(face: int, out: float, aside: float = 0.0) -> Pose:
    """Return the pose of a robot that faces a side of the reef, blue field frame [m, m, rad].

    Args:
        face: Number of the face.
        out: Distance of the robot's center from the reef's center, along the normal of the face [m].
        aside: Lateral offset, to the left as seen from the reef's center [m].
    """
    yaw = math.radians(dim.REEF_FACE_YAWS_DEG[face])
    (cx, cy), c, s = dim.REEF_CENTER, math.cos(yaw), math.sin(yaw)
    return cx + out * c - aside * s, cy + out * s + aside * c, yaw + math.pi


def before_station(side: str, aside: float = 0.0) -> Pose:
    """Return the pose of a robot with the rear at a station, blue field frame [m, m, rad].

    Args:
        side: Station, `left` or `right`.
        aside: Lateral offset, to the left as seen from the station [m].
    """
    x, y, yaw = station_faces("blue")[side]
    c, s = math.cos(yaw), math.sin(yaw)
    return x + _AT_STATION * c - aside * s, y + _AT_STATION * s + aside * c, yaw


def raise_to(robot: ScriptedRobot, level: int) -> None:
    """Command the elevator to the height for approaching a reef level with a coral, without waiting."""
    robot.set_position("elevator", _reach(level, _APPROACH)[1])


def raised_to(robot: ScriptedRobot, level: int) -> Steps:
    """Move the elevator to the height for approaching a reef level with a coral, and wait up to 1.5 s."""
    raise_to(robot, level)
    yield from _wait_for_elevator(robot, _reach(level, _APPROACH)[1])


def _wait_for_elevator(robot: ScriptedRobot, goal: float) -> Steps:
    """Wait at most 1.5 s until the elevator's drum is within 0.3 rad of a goal [rad]."""
    for _ in range(75):
        if abs(robot.robot.mechanisms["elevator"].position - goal) < _ELEVATOR_TOLERANCE:
            break
        yield


def before_branch(face: int, side: str, level: int) -> Pose:
    """Return the robot's starting pose for placing a coral on a branch, blue field frame [m, m, rad].

    Args:
        face: Number of the face.
        side: Side of the face as seen from the reef's center: `left`, `right` or, for the trough, `middle`.
        level: Level, 1 to 4.
    """
    return _before_face(face, _reach(level)[0] + _APPROACH, _ASIDE[side])


def place_coral(
    robot: ScriptedRobot,
    face: int,
    side: str,
    level: int,
    way: tuple[tuple[float, float], ...] = (),
    *,
    error: float = 0.0,
) -> Steps:
    """Drive to a face of the reef, place the coral on a branch or in the trough, and back off.

    The robot keeps the coral if an obstacle stops the robot more than 5 cm from the placing position.

    Args:
        robot: Robot with the coral.
        face: Number of the face.
        side: Side of the face as seen from the reef's center, `left` or `right`; `middle` for the trough.
        level: Level, 1 to 4.
        way: Waypoints before the face, blue field frame [m].
        error: Lateral error of the placement, to the left of the branch [m].
    """
    out, _, arm = _reach(level)
    raise_to(robot, level)
    x, y, yaw = before_branch(face, side, level)
    yield from robot.drive_through([*way, (x, y)], yaw, speed=3.5, tolerance=0.10)
    robot.set_position("arm", arm)
    yield from _wait_for_elevator(robot, _reach(level, _APPROACH)[1])
    x, y, yaw = _before_face(face, out, _ASIDE[side] + error)
    for _ in robot.drive_to(x, y, yaw, speed=1.5 if level == 4 else 0.8, tolerance=0.012, timeout=1.2):
        robot.set_position("elevator", _reach(level, math.dist(robot.pose[:2], (x, y)))[1])
        yield
    yield from robot.wait(0.16)
    if math.dist(robot.pose[:2], (x, y)) < _NEAR_ENOUGH:
        robot.set_volts("claw", -8.0)
    yield from robot.wait(0.16)
    robot.set_position("arm", _TUCKED)
    yield from robot.drive_to(*_before_face(face, out + 0.30, _ASIDE[side]), speed=2.0, tolerance=0.12)
    robot.set_volts("claw", 8.0)
    robot.set_position("elevator", _CARRY)


def make_ready(robot: ScriptedRobot) -> None:
    """Run the claw to take the preload, and move the arm to the driving position."""
    robot.set_volts("claw", 8.0)
    robot.set_position("arm", _TUCKED)


def before_algae(face: int) -> Pose:
    """Return the robot's starting pose for taking the algae from a face, blue field frame [m, m, rad]."""
    return _before_face(face, _ALGAE_OUT + 0.45)


def take_algae(robot: ScriptedRobot, face: int) -> Steps:
    """Drive to a face of the reef, take the algae off this face, and back off."""
    height = reef_algae_places()[face][2]
    robot.set_position("elevator", elevator_turns(height - ALGAE_REACH * math.sin(_ALGAE_ARM)))
    robot.set_volts("algae_wheel", 8.0)
    yield from robot.drive_to(*before_algae(face), speed=3.5, tolerance=0.10)
    robot.set_position("arm", _ALGAE_ARM)
    yield from robot.drive_to(*_before_face(face, _ALGAE_OUT), speed=1.5, tolerance=0.03, timeout=1.2)
    for _ in range(20):
        if robot.held:
            break
        yield
    robot.set_volts("algae_wheel", 0.0)
    yield from robot.drive_to(*_before_face(face, _ALGAE_OUT + 0.35), speed=2.0, tolerance=0.12)
    robot.set_position("arm", _TUCKED)


def _let_algae_go(robot: ScriptedRobot) -> Steps:
    robot.set_volts("algae_wheel", -8.0)
    yield from robot.wait(0.3)
    robot.set_volts("algae_wheel", 0.0)
    robot.set_position("arm", _TUCKED)


def lower_claw(robot: ScriptedRobot) -> None:
    """Lower the claw in front of the front bumper, and run the claw to take coral off the carpet."""
    robot.set_volts("claw", 8.0)
    robot.set_position("elevator", elevator_turns(FLOOR_PIVOT_HEIGHT))
    robot.set_position("arm", degrees(-60.0))


def lower_wheel(robot: ScriptedRobot, height: float) -> None:
    """Lower the algae wheel to the height of a loose algae's center [m], and run the wheel to take the algae."""
    robot.set_volts("algae_wheel", 8.0)
    robot.set_position("elevator", 0.0)
    robot.set_position("arm", math.asin((height - PIVOT[2]) / ALGAE_REACH))


def tuck(robot: ScriptedRobot) -> None:
    """Move the arm and the elevator to the driving positions, and stop the algae wheel."""
    robot.set_volts("algae_wheel", 0.0)
    robot.set_position("elevator", _CARRY)
    robot.set_position("arm", _TUCKED)


def process(robot: ScriptedRobot) -> Steps:
    """Drive to the processor, and release the algae into the processor."""
    robot.set_position("elevator", 0.0)
    x, y = dim.PROCESSOR_X, 0.46
    yield from robot.drive_to(x, y + 0.8, -math.pi / 2, speed=3.5, tolerance=0.10)
    robot.set_position("arm", 0.0)
    yield from robot.wait(0.5)
    yield from robot.drive_to(x, y, -math.pi / 2, speed=1.5, tolerance=0.03, timeout=1.2)
    yield from robot.wait(0.2)
    yield from _let_algae_go(robot)


def raise_to_net(robot: ScriptedRobot) -> None:
    """Start to move the elevator to the height at which an algae clears the rim of the net."""
    robot.set_position("elevator", _OVER_NET)


def put_in_net(robot: ScriptedRobot, y: float, way: tuple[tuple[float, float], ...] = ()) -> Steps:
    """Drive to the net, put the algae into the net, and lower the elevator.

    Args:
        robot: Robot with the algae.
        y: Position along the net, blue field frame [m].
        way: Waypoints before the net, blue field frame [m].
    """
    raise_to_net(robot)
    yield from robot.drive_through([*way, (NET_X - 0.5, y)], 0.0, speed=4.0, tolerance=0.10)
    yield from _wait_for_elevator(robot, _OVER_NET)
    robot.set_position("arm", degrees(60.0))
    yield from robot.drive_to(NET_X, y, 0.0, speed=1.5, tolerance=0.04, timeout=1.5)
    robot.set_position("arm", _NET_ARM)
    yield from robot.wait(0.3)
    yield from _let_algae_go(robot)
    robot.set_position("elevator", _CARRY)


def hang(robot: ScriptedRobot, y: float) -> Steps:
    """Drive until a cage is in the robot's bay under the hook, pull the hook down to climb, and hang without power.

    Args:
        robot: Robot that climbs.
        y: y coordinate of the cage, blue field frame [m].
    """
    robot.set_volts("climber", 12.0)
    yield from robot.drive_to(dim.CAGE_X - 0.9, y, math.pi, speed=2.0, tolerance=0.02)
    yield from robot.wait(1.5)
    yield from robot.drive_to(dim.CAGE_X, y, math.pi, speed=0.6, tolerance=0.02, timeout=4.0)
    robot.set_volts("climber", -12.0)
    yield from robot.wait(3.0)
    robot.set_volts("climber", 0.0)
