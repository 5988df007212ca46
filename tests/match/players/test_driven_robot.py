"""A person's sticks and buttons drive a robot in the frame of its driver station."""

import math
from dataclasses import replace

import pytest
from each_case import each

from simcore.errors import ConfigError
from simcore.match.clock import MatchClock, Phase
from simcore.match.game import Game, RobotEntry
from simcore.match.match import Match
from simcore.match.players.driven_robot import DrivenRobot, DriverControls, DriverInput, HandedOver
from simcore.world.symmetry import FieldSymmetry

AHEAD = DriverInput(ahead=0.5)


class Person:
    wants: DriverInput | None = None

    def __call__(self):
        return self.wants


def driven(alliance="blue", symmetry="rotate", controls=None, game=None):
    """Return a match with a robot that a person drives, and the person."""
    game = game or Game.bare()
    game = replace(game, field=replace(game.field, symmetry=FieldSymmetry(symmetry, game.field.size)))
    match, person = Match(game, robots=(RobotEntry(alliance=alliance, start=(4.0, 4.0, 0.7)),)), Person()
    match.set_controller(0, DrivenRobot(controls or DriverControls(), match, alliance, person))
    return match, person


@each(
    ("alliance", "symmetry", "ahead", "left"),
    [("blue", "rotate", 1, 1), ("red", "rotate", -1, -1), ("red", "mirror", -1, -1), ("blue", "mirror", 1, 1)],
)
def test_sticks_are_relative_to_the_driver_station(alliance, symmetry, ahead, left):
    """Translation ignores the robot's heading, and positive turns are counter-clockwise on both sides."""
    match, person = driven(alliance, symmetry)
    with match:
        chassis = match.robots[0].chassis
        x, y, yaw = chassis.pose
        person.wants = AHEAD
        match.play(0.5)
        assert (chassis.pose[0] - x) * ahead > 0.3 and abs(chassis.pose[1] - y) < 0.05
        person.wants = DriverInput(left=0.5)
        match.play(0.8)
        assert (chassis.pose[1] - y) * left > 0.3
        person.wants = DriverInput(turn=0.2)
        match.play(0.3)
        assert 0.1 < math.remainder(chassis.pose[2] - yaw, math.tau) < 0.2 * math.tau * 0.3 + 0.1


def test_a_robot_stops_when_no_person_drives():
    match, person = driven()
    with match:
        person.wants = AHEAD
        match.play(1.0)
        assert match.robots[0].chassis.vel[0] > 1.5
        person.wants = None
        match.play(0.6)
        assert math.hypot(*match.robots[0].chassis.vel[:2]) < 0.05


def test_a_robot_accelerates_from_rest_after_it_was_disabled():
    """The sticks are pushed when the robot is enabled again; acceleration stays within the configured limit."""
    match, person = driven()
    with match:
        person.wants = DriverInput(ahead=1.0)
        match.play(1.0)
        controller, robot = match._controllers[0], match.robots[0]
        match.set_controller(0, None)
        robot.drive.stop()
        match.play(1.0)
        assert robot.chassis.speed < 0.05
        match.set_controller(0, controller)
        match.play(0.1)
        assert 0.1 < robot.chassis.speed < 0.1 * controller.settings.acceleration + 0.05


def test_an_action_runs_while_held_and_overrides_the_sticks_only_if_it_steers():
    seen = []

    def count(robot):
        for _ in range(3):
            seen.append("count")
            yield

    def hold_still(robot):
        try:
            robot._feed = True
            while True:
                robot.accelerate_to(0.0, 0.0)
                yield
        finally:
            seen.append("let go")

    controls = DriverControls(actions={"count": count, "still": hold_still}, rest=lambda robot: seen.append("rest"))
    match, person = driven(controls=controls)
    with match:
        person.wants = replace(AHEAD, action=0)
        match.play(1.0)
        assert seen == ["rest", "count", "count", "count", "rest"] and match.robots[0].chassis.vel[0] > 1.5
        person.wants = replace(AHEAD, action=1)
        match.play(1.0)
        assert abs(match.robots[0].chassis.vel[0]) < 0.05 and len(seen) == 5 and match._controllers[0].is_feeding
        person.wants = replace(AHEAD, action=3)  # the game has no such action
        match.play(0.5)
        assert seen[5:] == ["let go", "rest"] and match.robots[0].chassis.vel[0] > 1.0
        assert not match._controllers[0].is_feeding


def test_a_person_takes_over_once_robots_may_move_and_keeps_control():
    clock = MatchClock([Phase("auto", 0.4, "auto"), Phase("pause", 0.4, "disabled"), Phase("teleop", 2.0)])
    game = replace(Game.bare(), clock=clock)
    played = []

    def auto(robot, time):
        played.append(time)
        robot.drive.set_chassis_speeds(0.0, 0.0, 0.0)

    for from_teleop in (False, True):
        match, person = driven(game=game)
        with match:
            taken = HandedOver(match, "blue", auto, person, from_teleop=from_teleop)
            match.set_controller(0, taken)
            match.play(0.2)
            assert len(played) == 10 and not taken.is_taken
            person.wants = replace(AHEAD, ahead=1.0)
            match.play(0.2)
            assert taken.is_taken != from_teleop and (match.robots[0].chassis.vel[0] > 0.5) != from_teleop
            match.play(0.38)
            assert abs(match.robots[0].chassis.vel[0]) < 0.1, "disabled"
            person.wants = None
            match.play(0.1)
            person.wants = replace(AHEAD, ahead=1.0)
            match.play(0.5)
            assert taken.is_taken and match.robots[0].chassis.vel[0] > 1.5
            person.wants, count = None, len(played)
            match.play(0.8)
            assert len(played) == count, "the auto does not come back"
            assert abs(match.robots[0].chassis.vel[0]) < 0.05
        played.clear()


def test_invalid_driver_controls_and_inputs_are_refused():
    with pytest.raises(ConfigError, match=r"DriverInput: ahead must be .* got nan"):
        DriverInput(ahead=math.nan)
    with pytest.raises(ConfigError, match="at most 4 scripts by name"):
        DriverControls(actions={str(number): lambda robot: iter(()) for number in range(5)})
