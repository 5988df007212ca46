"""Fits of measured shots agree with parabolas, and the command prints the fitted key."""

import math
from dataclasses import replace

import pytest
from each_case import each
from shooter_file import SHOOTING

from games.rebuilt import REBUILT
from simcore.calibrate.shot_fit import Shot, fit_shots, read_shots
from simcore.cli import main
from simcore.errors import ConfigError
from simcore.sweep.shot_task import ShotTask
from simcore.units import GRAVITY

ROBOT = REBUILT.robot()
SHOOTER = replace(ROBOT.shooters[0], hood=None, elevation=math.radians(65.0))
AIRLESS = replace(REBUILT, pieces=tuple(replace(s, kind=replace(s.kind, aerodynamics=None)) for s in REBUILT.pieces))
TASK = ShotTask(AIRLESS, replace(ROBOT, shooters=(SHOOTER,)))


def parabola(distance: float, efficiency: float) -> Shot:
    """Return a shot through the middle of the goal.

    v^2 = g d^2 / (2 cos^2 (d tan - h)), t = d / (v cos), w = v / (e R).
    """
    launch, angle = SHOOTER.launch, SHOOTER.elevation
    ahead = launch.pivot_x * math.cos(launch.heading) + launch.pivot_y * math.sin(launch.heading) + launch.forward
    far, up = distance - ahead, TASK.opening.middle[2] - launch.height
    speed = math.sqrt(GRAVITY * far**2 / (2.0 * math.cos(angle) ** 2 * (far * math.tan(angle) - up)))
    rps = speed / (efficiency * SHOOTER.wheel_radius * math.tau)
    return Shot(distance=distance, rps=rps, time=far / (speed * math.cos(angle)), result="hit")


def test_the_fit_recovers_the_exit_efficiency_of_shots_on_a_parabola():
    """Flights have points every 5 ms with straight lines between: heights are off by g (5 ms)^2 / 8."""
    found = fit_shots(TASK, [parabola(d, 0.42) for d in (2.0, 3.0, 4.0, 5.0)])
    assert found.estimates["exit_efficiency"].value == pytest.approx(0.42, rel=2e-3)
    assert all(abs(beyond) < 0.02 and abs(t - shot.time) < 0.01 for shot, beyond, t in found.rows)
    one = fit_shots(TASK, [parabola(3.0, 0.42)])
    assert one.estimates["exit_efficiency"].value == pytest.approx(0.42, rel=2e-3) and not one.rows
    assert any(line.startswith("spin") for line in found.unknown)


def test_shots_that_fall_short_give_an_upper_bound_of_the_efficiency():
    """At the wheel speed of a hit with 0.42, shots that all fall short bound the efficiency by 0.42."""
    short = [replace(parabola(d, 0.42), time=None, result="short") for d in (3.0, 4.0)]
    assert fit_shots(TASK, short).estimates["exit_efficiency"].value < 0.42 * 1.002


@each(
    ("text", "said"),
    [
        ("distance=2.8,speed=38", "no key 'speed'. Known: distance, rps"),
        ("distance=2.8", "rps is missing, e.g. distance=2.8,rps=38"),
        ("distance=-1,rps=3", "distance must be a number above 0"),
        ("distance=x,rps=3", "distance must be a number above 0"),
        ("2,8", "decimals take a point"),
        ("distance=2,rps=38,result=maybe", "result must be hit, miss, short or long, got 'maybe'"),
    ],
)
def test_an_invalid_shot_is_refused(text, said):
    with pytest.raises(ConfigError) as error:
        Shot.parse(text)
    assert said in str(error.value)


def test_shots_that_determine_no_efficiency_are_refused():
    with pytest.raises(ConfigError, match="a miss says nothing unless it is short or long"):
        fit_shots(TASK, [Shot(distance=3.0, rps=40.0, result="miss")])
    with pytest.raises(ConfigError, match=r"the shooter has a hood: add elevation_deg=<of the shot> or hood_deg="):
        fit_shots(ShotTask(REBUILT), [Shot(distance=3.0, rps=40.0)])
    with pytest.raises(ConfigError, match="no exit efficiency explains them"):
        fit_shots(TASK, [Shot(distance=3.0, rps=40.0, elevation_deg=5.0)])


def test_the_command_fits_shots_from_options_and_from_a_table_equally(tmp_path, capsys):
    (tmp_path / "simcore.toml").write_text(SHOOTING)
    args = ["calibrate", "--project", str(tmp_path), "--out", str(tmp_path / "page.html")]
    assert main([*args, "--shot", "distance=2.8,rps=38", "--shot", "distance=4,rps=43,time=1.2"]) == 0
    said = capsys.readouterr().out
    assert "[[shooter]]\nexit_efficiency = 0." in said and "held out, shot from 4 m" in said
    assert "above 0.5 is possible only where wheels drive both sides of a piece" in said
    table = tmp_path / "shots.csv"
    table.write_text("distance,rpm,hit,time\n2.8,2280,1,\n4,2580,,1.2\n")
    assert read_shots(table)[0].rps == pytest.approx(38.0)
    assert main([*args, str(table)]) == 0
    key = "exit_efficiency = "
    assert capsys.readouterr().out.split(key)[1].split()[0] == said.split(key)[1].split()[0]
    table.write_text("distance,rpm\n2.8,fast\n")
    assert main([*args, str(table)]) == 1
    assert "shots.csv, line 2: rpm must be a number" in capsys.readouterr().err
