"""Wheel speeds for the goal of a shooter, as `simcore check` reports them."""

import math
from dataclasses import replace

import pytest
from shooter_file import SHOOTING

from games.rebuilt import REBUILT
from simcore.cli import main
from simcore.robot_file.needed_speeds import goal_of, needed_speeds
from simcore.units import GRAVITY

ROBOT = REBUILT.robot()
(SHOOTER,) = ROBOT.shooters
FIXED = replace(SHOOTER, hood=None, elevation=math.radians(65.0))


def test_the_needed_speed_without_air_is_that_of_the_parabola():
    """At 65 degrees, v^2 = g d^2 / (2 cos^2 (d tan - h))."""
    supplies = tuple(replace(one, kind=replace(one.kind, aerodynamics=None)) for one in REBUILT.pieces)
    airless = replace(REBUILT, pieces=supplies)
    launch, angle = FIXED.launch, FIXED.elevation
    ahead = launch.pivot_x * math.cos(launch.heading) + launch.pivot_y * math.sin(launch.heading) + launch.forward
    far, up = 3.0 - ahead, goal_of(FIXED, airless).opening.middle[2] - launch.height
    want = math.sqrt(GRAVITY * far**2 / (2.0 * math.cos(angle) ** 2 * (far * math.tan(angle) - up)))
    (need,) = [need for need in needed_speeds(FIXED, ROBOT, airless) if need.distance == 3.0]
    assert need.speed == pytest.approx(want, rel=1e-6)
    assert need.wheel_rps * math.tau * FIXED.wheel_radius * FIXED.exit_efficiency == pytest.approx(want, rel=1e-6)


def test_farther_goals_need_more_speed_and_a_hood_needs_less():
    speeds = [need.speed for need in needed_speeds(FIXED, ROBOT, REBUILT)]
    assert speeds == sorted(speeds) and len(speeds) == 4
    hooded = needed_speeds(SHOOTER, ROBOT, REBUILT)  # its hood goes up to the vertical
    assert all(45.0 <= math.degrees(need.elevation) < 80.0 for need in hooded)
    assert all(need.speed <= speed + 1e-9 for need, speed in zip(hooded, speeds, strict=True))


def test_check_reports_the_wheel_speeds_that_the_goal_needs(tmp_path, capsys):
    (tmp_path / "simcore.toml").write_text(SHOOTING)
    assert main(["check", str(tmp_path), "--out", str(tmp_path / "robot.html")]) == 0
    said = capsys.readouterr().out
    assert "for BlueHub at exit_efficiency 0.49 its wheels need 41 turns/s from 2 m (at 65 deg), 47 from 3 m" in said
    assert "no [[intake]] is described: pieces are pushed, not taken in" in said


def test_check_notes_an_arm_with_limits_in_radians(tmp_path, capsys):
    arm = '[[mechanism]]\nname = "pivot"\nkind = "arm"\nleader = 3\ngearing = 50\ninertia = 0.2\n'
    (tmp_path / "simcore.toml").write_text(f"{arm}min_deg = -1.57\nmax_deg = 1.57\n")
    assert main(["check", str(tmp_path), "--out", str(tmp_path / "robot.html")]) == 0
    said = capsys.readouterr().out
    assert (
        "note: pivot moves only 3.1 deg: min_deg and max_deg are degrees; from radians they would be min_deg = -90"
        in said
    )
