"""Robots described in simcore.toml on the field of REBUILT: a claw on an arm, and a climber."""

from __future__ import annotations

import math

import pytest

from games.rebuilt import REBUILT
from simcore.errors import ConfigError
from simcore.match.match import Match
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot_file.reader import read_settings
from simcore.robot_file.robot_settings import practice_match

CLAW = """
[start]
x = 6.3
y = 1.0
preload = 1

[[mechanism]]
name = "lift"
kind = "elevator"
leader = 1
gearing = 9.0
mass = 5.0
drum_radius = 0.02
max_height = 1.0
z = 0.1

[[mechanism]]
name = "arm"
kind = "arm"
leader = 2
gearing = 60.0
inertia = 0.2
min_deg = -10
max_deg = 90
on = "lift"
x = 0.2

[[mechanism]]
name = "grip"
kind = "roller"
leader = 3
gearing = 5.0

[[claw]]
on = "arm"
x = 0.4
roller = "grip"
from_storage = true
"""

CLIMBER = """
[robot]
mass = 50

[start]
x = 1.06
y = 3.74

[[mechanism]]
name = "climb"
kind = "elevator"
leader = 1
followers = [2]
gearing = 60.0
mass = 2.0
drum_radius = 0.02
max_height = 0.55
start_height = 0.4
z = 0.34

[[climber]]
on = "climb"
"""


@pytest.fixture
def played(tmp_path):
    """Yield a function that returns a match with the robot of a file's text; close the matches afterwards."""
    matches = []

    def play(text: str) -> Match:
        path = tmp_path / "simcore.toml"
        path.write_text(text)
        settings = read_settings(path)
        drivetrain = SwerveConfig.square(0.42, SwerveModuleConfig(x=0, y=0), mass=settings.mass)
        matches.append(practice_match(REBUILT, settings, drivetrain))
        return matches[-1]

    yield play
    for match in matches:
        match.close()


def test_a_claw_on_an_arm_on_an_elevator_takes_lifts_and_releases_a_piece(played):
    match = played(CLAW)
    robot = match.robots[0]
    (slot,) = robot.held
    assert robot.placers[0].piece is None
    robot.mechanisms["grip"].set_volts(4.0)
    match.play(0.2)
    assert robot.held == [slot] and robot.placers[0].piece == slot
    robot.mechanisms["grip"].set_volts(0.0)
    robot.mechanisms["lift"].set_volts(6.0)
    robot.mechanisms["arm"].set_volts(3.0)
    match.play(1.0)
    lift, arm = robot.mechanisms["lift"].height, robot.mechanisms["arm"].position
    assert lift > 0.5 and arm > 0.5
    assert robot.held_poses(match.pieces.radius)[0, :3] == pytest.approx(
        (0.2 + 0.4 * math.cos(arm), 0.0, 0.1 + lift + 0.4 * math.sin(arm))
    )
    robot.mechanisms["grip"].set_volts(-6.0)
    match.play(0.3)
    assert robot.held == [] and match.count.is_conserved
    assert match.pieces.state.pos[slot, 2] < 1.5


def test_a_climber_lifts_the_robot_onto_a_rung_of_the_tower(played):
    """The hook starts 0.054 m above the low rung (0.6858 m), so the robot rises by its travel less that distance."""
    match = played(CLIMBER)
    robot = match.robots[0]
    (climber,) = robot.climbers
    assert not climber.rung
    robot.mechanisms["climb"].set_volts(-6.0)
    match.play(2.0)
    assert climber.rung is not None and climber.rung.name == "blue_tower_rung_low"
    lifted = 0.6858 - 0.34 - robot.mechanisms["climb"].height
    assert lifted > 0.1
    assert robot.chassis.pos[2] == pytest.approx(lifted, abs=0.01), "within the 8 mm that the hook gives"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[start]\nx = 80.0\ny = 40.0", r"^simcore.toml \[start\]: the robot starts outside of the field of 16.54"),
        ("[start]\nx = 4.62\ny = 4.03", r"^simcore.toml \[start\]: the robot starts inside of .*\) m is free$"),
        ("[autos.a]\nstart = [4.62, 4.03, 0]", r"^simcore.toml \[autos.'a'\]: the robot starts inside .* m is free$"),
        ("[autos.a]\nstart = [2.0, -1.0, 0]", r"^simcore.toml \[autos.'a'\]: the robot starts outside of the field"),
    ],
)
def test_the_error_for_an_invalid_start_names_the_table_and_the_key(played, text, said):
    with pytest.raises(ConfigError, match=said):
        played(text)


def test_a_storage_hands_over_a_piece_only_at_the_configured_arm_position(played):
    """The place is reached with the arm upright and the lift down; the arm starts 10 degrees below the horizontal."""
    match = played(CLAW + "handover = [0.2, 0.0, 0.5]")
    robot = match.robots[0]
    robot.mechanisms["grip"].set_volts(4.0)
    match.play(0.2)
    assert robot.placers[0].piece is None and len(robot.storage.pieces) == 1
    robot.mechanisms["arm"].set_volts(3.0)
    match.play(1.5)
    assert robot.placers[0].piece == robot.held[0] and not robot.storage.pieces
