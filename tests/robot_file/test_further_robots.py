"""Tables `[[partner]]` and `[[opponent]]` and the empty field: robots, places, and messages about mistakes."""

import math

import pytest
from each_case import each

from games.rebuilt import REBUILT
from simcore.errors import ConfigError, UnknownNameError
from simcore.match.registry import find_game, practice_field
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot_file.robot_settings import practice_match

DRIVETRAIN = SwerveConfig.square(0.5334, SwerveModuleConfig(x=0.0, y=0.0))
EMPTY = 'game = "none"\nfield_size = [12.0, 6.0]\n'
OPPONENT = '[[opponent]]\nname = "other"\nstart = [2.0, 4.5, 90.0]\n'
SCRIPTS = """
def forward(robot, time):
    robot.drive.set_chassis_speeds(1.0, 0.0, 0.0)


def ahead(robot):
    x, y, yaw = robot.pose
    yield from robot.drive_to(x + 1.0, y, yaw)


NUMBER = 3
"""


@pytest.fixture
def play(read, tmp_path):
    """Return a function that builds the practice match of a robot file and plays it for some seconds."""
    matches = []

    def play(text, seconds=0.0):
        (tmp_path / "field_scripts.py").write_text(SCRIPTS)
        settings = read(text)
        game = find_game(settings.game) if settings.game else REBUILT
        matches.append(practice_match(game, settings, DRIVETRAIN))
        if seconds:
            matches[-1].play(seconds)
        return matches[-1]

    yield play
    for match in matches:
        match.close()


def test_an_empty_field_has_the_configured_size_and_no_elements(play):
    match = play(EMPTY, 0.1)
    assert match.game.field.size == (12.0, 6.0) and match.game.field.tags == ""
    assert match.piece_positions() == {} and match.score.total == 0
    assert play('game = "none"').game.field.size == practice_field().field.size


def test_partners_and_opponents_stand_at_the_poses_in_the_file(play):
    """Places are written as for a blue robot: its opponent is at the other end, rotated by half a turn."""
    match = play(EMPTY + OPPONENT + '[[partner]]\nname = "friend"\nstart = [3.0, 4.5, 0.0]\n')
    assert match.alliances == ["blue", "blue", "red"]
    assert match.robots[1].chassis.pose[:2] == pytest.approx((3.0, 4.5))
    x, y, yaw = match.robots[2].chassis.pose
    assert (x, y) == pytest.approx((10.0, 1.5)) and math.cos(yaw - 1.5 * math.pi) == pytest.approx(1.0)


def test_further_robots_change_sides_with_the_teams_robot(play):
    match = play(EMPTY + OPPONENT)
    match.set_alliance(0, "red")
    match.tick()
    assert match.alliances == ["red", "blue"]
    assert match.robots[1].chassis.pose[:2] == pytest.approx((2.0, 4.5), abs=0.01)


@pytest.mark.parametrize("script", ["forward", "ahead"])
def test_a_script_as_a_function_or_in_steps_drives_while_robots_are_enabled(play, script):
    match = play(EMPTY + f'[[partner]]\nname = "a"\nstart = [3.0, 4.5, 0.0]\nscript = "field_scripts:{script}"\n')
    match.timer.follow_driver_station()
    match.play(0.4)
    assert match.robots[1].chassis.pose[0] == pytest.approx(3.0, abs=0.01)
    match.timer.set_enabled(True)
    match.play(1.5)
    assert 3.9 < match.robots[1].chassis.pose[0] < 4.6


def test_a_robot_with_an_auto_of_the_game_has_its_start_pose_and_preload(play):
    match = play('[[opponent]]\nname = "a"\nauto = "depot"\n', 0.1)
    auto = REBUILT.auto("depot")
    assert match.entries[1].start == auto.start and match.entries[1].preload == auto.preload
    assert match.robots[1].drive is not None and match.alliances[1] == "red"


def test_a_robot_without_a_controller_stands_still(play):
    match = play(EMPTY + OPPONENT)
    before = match.robots[1].chassis.pose
    match.play(0.5)
    assert match.robots[1].chassis.pose == pytest.approx(before, abs=1e-3)


@each(
    ("text", "said"),
    [
        ("field_size = [9, 9]", 'field_size is for the empty field: it needs game = "none" as well'),
        (EMPTY + OPPONENT + "speed = 1", "[[opponent]] 'other': no key 'speed'"),
        (
            EMPTY + OPPONENT.replace("2.0, 4.5, 90.0", "2.0, 1.2, 0.0").replace("opponent", "partner"),
            "inside of robot 0",
        ),
        (EMPTY + OPPONENT.replace("2.0", "20.0"), "[[opponent]] 'other': the robot starts outside of the field"),
        (OPPONENT + 'auto = "depott"', "[[opponent]] 'other': no auto named 'depott'. Did you mean 'depot'?"),
        (EMPTY + OPPONENT + 'auto = "depot"', "[[opponent]] 'other': no auto"),
        (EMPTY + OPPONENT + 'script = "a"', 'script must be "module:function", e.g. "defense:defend"; got \'a\''),
        (EMPTY + OPPONENT + 'script = "nowhere_to_be:f"', "'nowhere_to_be:f' is not there: No module named"),
        (EMPTY + OPPONENT + 'script = "field_scripts:f"', "is not there: module 'field_scripts' has no attribute 'f'"),
        (EMPTY + OPPONENT + 'script = "field_scripts:NUMBER"', "script must name a function, got 3"),
        (
            EMPTY + OPPONENT + 'auto = "a"\nscript = "b:c"',
            "script and auto exclude each other: one of them drives the robot",
        ),
        (EMPTY + "[[opponent]]\nauto = 'a'", "[[opponent]] 1: name is missing"),
        (EMPTY + OPPONENT + OPPONENT, "[[opponent]] 'other': name is used twice"),
    ],
)
def test_the_error_names_each_mistake_in_a_further_robot(play, text, said):
    with pytest.raises(ConfigError) as error:
        play(text)
    assert said in str(error.value)


def test_a_match_in_the_file_has_the_listed_players_and_rules(play):
    match = play('game = "rebuilt"\nmatch = "practice-2v2"\n', seconds=0.1)
    assert match.alliances == ["blue", "blue", "red", "red"] and not match.practice
    assert match.options == {option.name for option in REBUILT.options if option.in_matches}
    assert [len(robot.held) for robot in match.robots[1:]] == [8, 8, 8]


@each(
    ("text", "words"),
    [
        ("practice-9v9", r"no match of rebuilt \(or PARTNERS/OPPONENTS\) named 'practice-9v9'.*'practice-2v2'"),
        ("goalkeeper/idle", r"no role of rebuilt named 'goalkeeper'"),
        ("idle,idle,idle/idle", r"an alliance of rebuilt has at most 3 robots, got 4"),
    ],
)
def test_an_invalid_match_is_refused(play, text, words):
    with pytest.raises((ConfigError, UnknownNameError), match=words):
        play(f'game = "rebuilt"\nmatch = "{text}"\n')
