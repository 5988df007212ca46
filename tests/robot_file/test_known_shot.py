"""Exit efficiency: figures of `simcore check` for a shooter's goal, and the fit to one known shot."""

import math
from dataclasses import replace

import pytest
from each_case import each

from games.rebuilt import REBUILT
from games.reefscape import REEFSCAPE
from simcore.cli import main
from simcore.errors import ConfigError
from simcore.robot_file.known_shot import KnownShot, exit_efficiency, goal_of, needed_speeds
from simcore.units import GRAVITY

ROBOT = REBUILT.robot()
(SHOOTER,) = ROBOT.shooters
FIXED = replace(SHOOTER, hood=None, elevation=math.radians(65.0))


def test_the_efficiency_of_a_known_shot_is_that_of_the_parabola_without_air():
    """At 65 degrees v^2 = g d^2 / (2 cos^2 (d tan - h)); e = v / (w R)."""
    supplies = tuple(replace(one, kind=replace(one.kind, aerodynamics=None)) for one in REBUILT.pieces)
    airless = replace(REBUILT, pieces=supplies)
    launch, angle = FIXED.launch, FIXED.elevation
    ahead = launch.pivot_x * math.cos(launch.heading) + launch.pivot_y * math.sin(launch.heading) + launch.forward
    far, up = 3.0 - ahead, goal_of(FIXED, airless).opening.middle[2] - launch.height
    want = math.sqrt(GRAVITY * far**2 / (2.0 * math.cos(angle) ** 2 * (far * math.tan(angle) - up)))
    found = exit_efficiency(KnownShot(distance=3.0, rps=40.0), FIXED, ROBOT, airless)
    assert found * 40.0 * math.tau * FIXED.wheel_radius == pytest.approx(want, rel=1e-6)


def test_with_the_fitted_efficiency_the_goal_needs_the_known_wheel_speed():
    shot = KnownShot(distance=3.0, rps=35.0)
    fitted = replace(FIXED, exit_efficiency=exit_efficiency(shot, FIXED, ROBOT, REBUILT))
    (need,) = [need for need in needed_speeds(fitted, ROBOT, REBUILT) if need.distance == 3.0]
    assert need.wheel_rps == pytest.approx(35.0)
    speeds = [need.speed for need in needed_speeds(FIXED, ROBOT, REBUILT)]
    assert speeds == sorted(speeds) and len(speeds) == 4
    hooded = needed_speeds(SHOOTER, ROBOT, REBUILT)  # whose hood goes to straight up
    assert all(45.0 <= math.degrees(need.elevation) < 80.0 for need in hooded)
    assert all(need.speed <= speed + 1e-9 for need, speed in zip(hooded, speeds, strict=True))


def test_a_hood_needs_an_angle():
    shot = KnownShot(distance=3.0, rps=35.0)
    with pytest.raises(ConfigError, match=r"shooter 1 has a hood: add elevation_deg=<of the shot> or hood_deg="):
        exit_efficiency(shot, SHOOTER, ROBOT, REBUILT)
    by_elevation = exit_efficiency(replace(shot, elevation_deg=60.0), SHOOTER, ROBOT, REBUILT)
    hood = math.degrees((math.radians(60.0) - SHOOTER.elevation) / SHOOTER.elevation_per_hood)
    assert exit_efficiency(replace(shot, hood_deg=hood), SHOOTER, ROBOT, REBUILT) == pytest.approx(by_elevation)
    with pytest.raises(ConfigError, match="nothing goes in from 3 m at 5 deg, at any speed"):
        exit_efficiency(replace(shot, elevation_deg=5.0), SHOOTER, ROBOT, REBUILT)


@each(
    ("text", "said"),
    [
        ("distance=2.8,rpm=38", "no key 'rpm'. Known: distance, rps"),
        ("distance=2.8", "rps is missing, e.g. distance=2.8,rps=38"),
        ("distance=-1,rps=3", "distance must be a number above 0"),
        ("distance=x,rps=3", "distance must be a number above 0"),
    ],
)
def test_an_invalid_known_shot_is_refused(text, said):
    with pytest.raises(ConfigError) as error:
        KnownShot.parse(text)
    assert said in str(error.value)


SHOOTING = """
game = "rebuilt"
[[mechanism]]
name = "wheels"
kind = "flywheel"
leader = 20
gearing = 1.0
inertia = 0.004

[[shooter]]
wheels = "wheels"
height = 0.5
elevation_deg = 65
"""


def test_check_states_what_the_goal_needs_and_fits_a_known_shot(tmp_path, capsys):
    (tmp_path / "simcore.toml").write_text(SHOOTING)
    out = str(tmp_path / "robot.html")
    assert main(["check", str(tmp_path), "--out", out, "--known-shot", "distance=2.8,rps=38"]) == 0
    said = capsys.readouterr().out
    assert "for BlueHub at exit_efficiency 0.49 its wheels need 41 turns/s from 2 m (at 65 deg), 47 from 3 m" in said
    assert "for BlueHub from 2.8 m with 38 turns/s you need an exit efficiency of 0.59 (now 0.49)" in said
    key = said.split("write under [[shooter]]: ")[1].split("\n")[0]
    assert "more than 0.5 is right only where wheels drive both sides of a piece" in said
    assert "no [[intake]] is described: pieces are pushed, not taken in" in said
    (tmp_path / "simcore.toml").write_text(SHOOTING + key)
    main(["check", str(tmp_path), "--out", out, "--known-shot", "distance=2.8,rps=38"])
    assert f"(now {float(key.split(' = ')[1]):g})" in capsys.readouterr().out


def test_check_refuses_a_known_shot_without_a_goal(tmp_path, capsys):
    (tmp_path / "simcore.toml").write_text(SHOOTING.replace("rebuilt", REEFSCAPE.name))
    out = str(tmp_path / "robot.html")
    assert main(["check", str(tmp_path), "--out", out, "--known-shot", "distance=2.8,rps=38"]) == 1
    assert "the game has no goal that this shooter's pieces fall into" in capsys.readouterr().err
    assert main(["check", str(tmp_path), "--out", out, "--known-shot", "distance=2.8,rps=38,shooter=2"]) == 1
    assert "there are 1 shooters, got shooter=2" in capsys.readouterr().err


def test_an_arm_in_radians_is_noted(tmp_path, capsys):
    arm = '[[mechanism]]\nname = "pivot"\nkind = "arm"\nleader = 3\ngearing = 50\ninertia = 0.2\n'
    (tmp_path / "simcore.toml").write_text(f"{arm}min_deg = -1.57\nmax_deg = 1.57\n")
    assert main(["check", str(tmp_path), "--out", str(tmp_path / "robot.html")]) == 0
    said = capsys.readouterr().out
    assert (
        "note: pivot moves only 3.1 deg: min_deg and max_deg are degrees; from radians they would be min_deg = -90"
        in said
    )
