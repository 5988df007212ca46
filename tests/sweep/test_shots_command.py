"""`simcore shots`, its table (shot_table.py) and its files (shot_files.py), tested on a single run."""

import csv
import math
import re
import shlex
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from page_reader import report_blocks
from real_shots import RealShots

from games.rebuilt import REBUILT
from simcore.cli import main
from simcore.match.scatter import Scatter
from simcore.sweep.shot_files import table_csv, table_page, table_python
from simcore.sweep.shot_table import _margin, _middle, make_table
from simcore.sweep.shot_task import ShotDraws, ShotTask

DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.fixture(scope="module")
def made():
    """Return a table of three distances: 4 m is partly blocked by the tower, and the robot does not fit at 7 m."""
    task = ShotTask(REBUILT)
    return SimpleNamespace(task=task, table=make_table(task, (2.5, 4.0, 7.0)))


def test_a_row_has_the_best_margin_and_a_shot_that_the_shooter_can_make(made) -> None:
    shooter = REBUILT.robot().shooters[0]
    for row in made.table.feasible:
        usable = row.band.inside & made.task.can_tilt(row.band.elevations)[:, None]
        usable &= row.band.speeds <= made.task.max_speed
        best = max(
            _margin(row.band, number, _middle(usable[number]), made.table.scatter)
            for number in np.nonzero(usable.any(axis=1))[0]
        )
        assert best >= row.shot["margin_sd"] >= 0.97 * best > 1.0
        assert row.shot["slowest_mps"] < row.speed < row.shot["fastest_mps"]
        assert shooter.exit_speed([row.shot["wheel_rps"] * math.tau]) == pytest.approx(row.speed)
        assert shooter.elevation - row.shot["hood_turns"] * math.tau == pytest.approx(row.elevation)
    far = made.table.rows[-1]
    assert "does not fit" in far.problem and far.share is None and far.shot["speed_mps"] is None


def test_the_shares_hold_for_other_draws_and_the_intended_shot_scores_in_a_match(made) -> None:
    """Shares of 1,024 and of 4,000 draws differ by less than 4 standard errors of their difference."""
    draws = ShotDraws.of(Scatter(), np.random.default_rng(99), 4000)
    for row in made.table.feasible:
        share = made.task.share(row.stand, row.elevation, row.speed, draws)
        pooled = (4000 * share + 1024 * row.share) / 5024
        assert abs(share - row.share) < 4.0 * math.sqrt(pooled * (1.0 - pooled) * (1 / 1024 + 1 / 4000)) + 1e-3
    for barrel in range(len(made.task.barrels)):
        with RealShots(made.task, barrel=barrel) as real:
            assert all(real.shoot(row.stand, row.elevation, row.speed) for row in made.table.feasible)


def test_the_csv_has_each_row_and_the_module_interpolates_between_rows(made) -> None:
    rows = list(csv.DictReader(table_csv(made.table).splitlines()))
    assert [row["feasible"] for row in rows] == ["True", "True", "False"] and rows[2]["speed_mps"] == ""
    module: dict = {}
    exec(table_python(made.table), module)
    shot_at = module["shot_at"]
    near, far, *_ = (float(row["wheel_rps"] or "nan") for row in rows)
    assert shot_at(2.5)["wheel_rps"] == near and shot_at(2.5)["elevation_deg"] == float(rows[0]["elevation_deg"])
    between = shot_at(3.25)
    assert between["wheel_rps"] == pytest.approx(0.5 * (near + far))
    assert shot_at(4.0)["wheel_rps"] == far
    assert shot_at(0.1) is None and shot_at(5.0) is None and shot_at(7.0) is None and shot_at(7.1) is None


def test_the_page_has_the_best_shot_and_curves_over_distance(made) -> None:
    blocks = report_blocks(table_page(made.table))
    best = max(made.table.feasible, key=lambda row: row.shot["margin_sd"])
    assert blocks[0]["text"] == f"{best.shot['wheel_rps']:.0f} turns/s from {best.stand.distance:g} m"
    table = next(block for block in blocks if block["kind"] == "table")
    assert [row[0] for row in table["rows"]] == ["2.5 m", "4 m", "7 m"] and "does not fit" in table["rows"][2][1]
    (speed,) = (block for block in blocks if block.get("title") == "Speed of the shot and what still goes in")
    assert speed["series"][0]["y"] == [row.shot["speed_mps"] for row in made.table.feasible]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["shots", "reefscape"], "no shooter"),
        (["shots", "rebuilt", "--target", "BlueHubb"], "Did you mean 'BlueHub'"),
        (["shots", "rebuilt", "--shooter", "3"], "no shooter number 3, counted from 0. Known: 0"),
        (["shots", "rebuilt", "--robot", "gone.toml"], "no file 'gone.toml'"),
        (["shots", "rebuilt", "--set", "robot.shooters.*.exit_eficiency=0.4"], "exit_efficiency"),
    ],
)
def test_invalid_options_give_an_error_in_a_single_sentence(tmp_path, monkeypatch, capsys, words, sentence) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(words) == 1
    assert sentence in " ".join(capsys.readouterr().err.split())


def test_documented_commands_write_their_files(tmp_path, monkeypatch, capsys, whole) -> None:
    """Run the documented command as written, but for a single distance without `--whole`."""
    monkeypatch.chdir(tmp_path)
    lines = re.findall(r"^simcore shots .*$", (DOCS / "shots.md").read_text(encoding="utf-8"), re.MULTILINE)
    (line,) = lines
    assert main([*shlex.split(line)[1:], *([] if whole else ["--distances", "3"])]) == 0
    assert "turns/s" in capsys.readouterr().out
    written = {path.name for path in (tmp_path / "out" / "shots").iterdir()}
    assert written == {"shots.csv", "shot_table.py", "shots.html"}
