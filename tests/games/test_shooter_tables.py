"""Shooter tables: launches, claims against flights and real shots, files that robot code can use, refusals, tuning."""

from __future__ import annotations

import csv
import importlib.util
import json
import math
import re
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from games.rebuilt import REBUILT
from simcore.cli import main
from simcore.geometry.rotation import from_yaw
from simcore.match.match import Match
from simcore.match.scatter import Scatter
from simcore.loop.state import make_memory
from simcore.pieces.flight import FLIGHT_STEP
from simcore.pieces.launch import Aim, Launch
from simcore.shooting.practice_field import PracticeField
from simcore.shooting.shot_task import SPREADS, ShotDraws, ShotTask, Stand
from simcore.units import degrees

DOCS = Path(__file__).resolve().parents[2] / "docs"
SMALL = {
    "shots": ["--distances", "3", "--radial", "0", "--tangential", "0", "--check", "20", "--real-shots", "1"],
}


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_shots_leave_as_those_of_the_robots_shooter():
    """Place, velocity and spin are `Shooter.released`'s, of a robot that drives, from both barrels."""
    task = ShotTask(REBUILT)
    stand = Stand(3.0, 0.4, 1.2, -0.7)
    elevation, speed = np.array([1.1, 0.9]), np.array([7.0, 8.0])
    yaw = task.lead(stand, elevation, speed)
    rows = task.rows(stand, elevation, speed, yaw, np.array([0, 1]))
    with Match(REBUILT) as match:
        robot = match.robots[0]
        shooter = robot.shooters[0]
        x, y = stand.place(task.opening.middle)
        for row in range(2):
            motion = robot.motion_at(0.0)
            quat = from_yaw(float(yaw[row]))
            vel = tuple(stand.velocity.tolist())
            motion = type(motion)(pos=(x, y, 0.0), quat=quat, vel=vel, rate=(0.0, 0.0, 0.0))
            launch = Launch(barrel=row, delay=0.0, aim=Aim(float(elevation[row]), float(speed[row])))
            piece = shooter.released(launch, radius=float(rows.radius[row]), robot=motion)
            assert rows.pos[row] == pytest.approx(piece.pos, abs=1e-12)
            assert rows.vel[row] == pytest.approx(piece.vel, abs=1e-12)
            assert rows.spin[row] == pytest.approx(piece.rate, abs=1e-9)
    # without a barrel's offset it flies over the middle of the target: the lead takes the robot's way out of it
    way = task.opening.middle[:2] - task.muzzle(stand, yaw)[:, :2]
    across = way[:, 0] * rows.vel[:, 1] - way[:, 1] * rows.vel[:, 0]
    assert across == pytest.approx(0.0, abs=1e-3)


def test_draws_have_the_spreads_of_the_scatter():
    shares = (np.arange(4000)[:, None] + 0.5) / 4000 * np.ones(SPREADS)
    scatter = Scatter()
    draws = ShotDraws.of(scatter, shares)
    assert np.std(np.log(draws.exit_speed)) == pytest.approx(scatter.exit_speed, rel=0.01)
    assert np.std(draws.elevation) == pytest.approx(scatter.elevation, rel=0.01)
    assert np.ptp(draws.mass) == pytest.approx(2.0 * scatter.piece_mass, rel=0.01)
    none = ShotDraws.of(Scatter.none(), shares)
    assert (none.exit_speed == 1.0).all() and (none.azimuth == 0.0).all() and (none.drag == 1.0).all()


def test_a_table_holds_in_flights_and_real_shots_and_pastes_into_robot_code(here, capsys, whole):
    """Claims of each row in 1,000 flights, some in a match; rows that cannot be say why; the module interpolates."""
    distances = "1:8:0.5" if whole else "2.5,4,7"  # at 4 m straight on, the second barrel would hit the tower
    command = ["shots", "rebuilt", "--distances", distances, "--check", "1000", "--real-shots", "20" if whole else "4"]
    assert main(command) == 0
    text = capsys.readouterr().out
    out = here / "out" / "shots"
    with (out / "shots.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    told = json.loads((out / "shots.json").read_text(encoding="utf-8"))
    assert told["target"] == "BlueHub" and len(told["rows"]) == len(rows)
    good = [row for row in rows if row["feasible"] == "True"]
    assert len(good) >= 2 and "does NOT hold" not in text
    for row in good:
        assert row["check_shots"] == "1000" and row["check_holds"] == "True"
        assert float(row["check_lower"]) <= float(row["share"]) <= float(row["check_upper"])
        assert float(row["slowest_mps"]) < float(row["speed_mps"]) < float(row["fastest_mps"])
        shooter = REBUILT.robot().shooters[0]
        speed = shooter.exit_speed([float(row["wheel_rps"]) * 2.0 * np.pi])
        assert speed == pytest.approx(float(row["speed_mps"]), abs=1e-3)
        hood = float(row["hood_turns"]) * 360.0
        assert degrees(hood) == pytest.approx(shooter.elevation - degrees(float(row["elevation_deg"])), abs=1e-3)
    (far,) = [row for row in rows if row["distance_m"] == "7.0"]
    assert far["feasible"] == "False" and "no place" in far["problem"] and far["speed_mps"] == ""
    assert (out / "shots.png").stat().st_size > 5_000 and "<svg" in (out / "shots.svg").read_text(encoding="utf-8")
    module: dict = {}
    exec((out / "shot_table.py").read_text(encoding="utf-8"), module)
    shot_at = module["shot_at"]
    near, next_one = good[0], good[1]
    between = shot_at(0.5 * (float(near["distance_m"]) + float(next_one["distance_m"])))
    middle = 0.5 * (float(near["wheel_rps"]) + float(next_one["wheel_rps"]))
    assert between is None or between["wheel_rps"] == pytest.approx(middle)
    assert shot_at(float(near["distance_m"]))["elevation_deg"] == pytest.approx(float(near["elevation_deg"]))
    assert shot_at(0.1) is None and shot_at(7.0) is None and shot_at(2.6, radial=1.0) is None


def test_a_shot_of_the_table_goes_in_from_all_sides():
    """Without boards a row holds wherever the robot stands at that distance, as far as a hexagon is round; shots off
    the board, which `boards` counts, go in from one side.
    """
    draws = ShotDraws.of(Scatter(), np.random.default_rng(1).uniform(1e-9, 1.0 - 1e-9, (500, SPREADS)))
    for boards, elevation, speed, least, most in ((False, 69.0, 7.37, 0.9, 1.0), (True, 57.0, 7.6, 0.0, 0.5)):
        task = ShotTask(REBUILT, boards=boards)
        aim = np.array([degrees(elevation)]), np.array([speed])
        shares = [task.hits(Stand(3.0, degrees(b), 0.0, 0.0), *aim, draws).mean() for b in (0, 30, 60)]
        assert shares[0] > 0.9 and least <= min(shares[1:]) <= most, shares


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["shots", "reefscape"], "no shooter"),
        (["shots", "rebuilt", "--target", "BlueHubb"], "Did you mean 'BlueHub'"),
        (["shots", "rebuilt", "--shooter", "3"], "shooters 0 to 0, got 3"),
        (["shots", "rebuilt", "--robot", "gone.toml"], "no file 'gone.toml'"),
        (["shots", "rebuilt", "--set", "shooter.exit_eficiency=0.4"], "exit_efficiency"),
    ],
)
def test_what_cannot_be_is_said_in_a_sentence(here, capsys, words, sentence):
    assert main(words) == 1
    assert sentence in " ".join(capsys.readouterr().err.split())


def test_documented_commands_run(here, whole):
    """As written, but on few shots; without `--whole` the first command of the page is the sample."""
    lines = re.findall(r"^simcore shots .*$", (DOCS / "shots.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert lines
    for line in lines if whole else lines[:1]:
        words = shlex.split(line)[1:]
        assert main([*words, *SMALL[words[0]]]) == 0


def test_shares_hold_in_matches_at_all_bearings_standing_and_moving(whole):
    """With `--whole` all cells of `scripts/shot_cells.py`, 200 real shots each; otherwise one, 40 shots."""
    spec = importlib.util.spec_from_file_location("shot_cells", DOCS.parent / "scripts" / "shot_cells.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    if whole:
        found = script.cells((2.0, 3.0, 4.0, 5.0, 6.0), 200)
        assert len(found) >= 20
    else:
        found = script.cells((3.0,), 40, bearings=1, motions=script.MOTIONS[1:])
        assert len(found) == 1
    misses = [str(cell) for cell in found if not cell.holds]
    assert 20 * len(misses) <= len(found), misses


@pytest.fixture
def low_shooter():
    """A muzzle .35 m high at 62 deg, without a hood: shots rise steeply past the rim."""
    own = REBUILT.robot()
    launch = replace(own.shooters[0].launch, height=0.35)
    shooter = replace(own.shooters[0], hood=None, elevation=math.radians(62.0), launch=launch)
    return replace(own, shooters=(shooter,))


def test_shares_hold_of_a_low_fixed_shooter_that_stands_near(monkeypatch, low_shooter):
    """40 shots from 3 m."""
    spec = importlib.util.spec_from_file_location("shot_cells", DOCS.parent / "scripts" / "shot_cells.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    monkeypatch.setattr(script, "REBUILT", replace(REBUILT, robot=lambda: low_shooter))
    (cell,) = script.cells((3.0,), 40, bearings=1, motions=script.MOTIONS[:1])
    assert cell.holds, str(cell)


def test_scattered_shots_of_a_fixed_shooter_fly_in_a_match_as_foreseen(low_shooter):
    """Speed and elevation differ as a scatter has them: the same verdict, the same way within 1 mm until it ends."""
    task, stand = ShotTask(REBUILT, low_shooter), Stand(3.0, 0.0)
    verdicts = []
    with PracticeField(task, seed=1) as practice:
        for elevation_deg, speed in ((62.0, 7.07), (60.0, 7.3), (64.5, 6.95), (58.0, 6.6), (66.0, 6.2)):
            aim = np.array([degrees(elevation_deg)]), np.array([speed])
            yaw = task.lead(stand, *aim)
            foreseen = bool(task.fly(task.rows(stand, *aim, yaw)).goes_in[0])
            ball, memory = task.rows(stand, *aim, yaw), make_memory(1)
            way = [ball.pos[0].copy()]
            while not ball.is_touched[0]:
                task.field.fly(ball, memory, FLIGHT_STEP)
                way.append(ball.pos[0].copy())
            scored = practice.shoot(stand, degrees(elevation_deg), speed)
            x, *across = np.array(way).T
            flown = np.array(practice._match.record.shots[-1].points)
            flown = flown[np.maximum.accumulate(flown[:, 0]) < x[-2]]
            foreseen_there = np.column_stack([np.interp(flown[:, 0], x, one) for one in across])
            assert len(flown) > 20 and np.abs(flown[:, 1:] - foreseen_there).max() < 1e-3
            assert scored == foreseen, f"{elevation_deg} deg, {speed} m/s"
            verdicts.append(scored)
    assert verdicts == [True, True, True, False, False]
