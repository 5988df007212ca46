"""`simcore check` on whole robot programs: printed text, errors found, and the page."""

from __future__ import annotations

import re
from importlib.util import find_spec
from pathlib import Path

import pytest
from page_reader import report_blocks

from simcore.cli import main

pytestmark = pytest.mark.skipif(
    any(find_spec(m) is None for m in ("phoenix6", "wpilib", "commands2")), reason="needs .[phoenix6,robotpy]"
)

ROBOTS = Path(__file__).parent / "robots"


CHANGES = (
    ("opposed = [32]", "opposed = []"),
    ("leader = 33", "leader = 43"),
    ("x = 2.0\ny = 1.2", "x = 4.6\ny = 4.0"),
    ("forward = 0.2", "forward = 0.7"),
    ("gearing = 3.0", "gearing = 4.0\nreversed = true"),
)
"""A missing `opposed`, an unknown id, a start in the hub, a muzzle outside the robot, and a wrong gearing."""


def test_check_reports_differences_between_program_and_file(project_of):
    """Matching settings are reported too: the pivot starts at its upper stop and reads 0.25 turns there."""
    run = project_of(ROBOTS / "described")
    folder = run.folder
    text = (folder / "simcore.toml").read_text()
    for before, after in CHANGES:
        assert before in text
        text = text.replace(before, after, 1)
    (folder / "simcore.toml").write_text(text)
    code, said = run("", command=("-m", "simcore.cli", "check"))
    assert code == 1, said
    wrong = re.findall("^wrong: (.*)$", said, re.MULTILINE)
    assert wrong[:-1] == [
        "wheels: TalonFX 32 opposes its leader in the program, but not in the file: look at opposed",
        "feeder: besides its drivetrain the program builds no TalonFX 43; it builds [31, 32, 33, 34, 35]",
        wrong[2],
    ], said
    assert wrong[2].startswith("simcore.toml [start]: the robot starts inside of a field element, at (4.60, 4.00) m; (")
    assert wrong[3] == "shooter 1: its muzzle is 260 mm outside of the robot, at (0.70, 0.00) m"
    notes = re.findall("^note: (.*)$", said, re.MULTILINE)
    assert notes[0] == "swerve drive: SwerveDrivetrain with 4 modules, Pigeon2 9, loops on the controller"
    assert notes[1].startswith("roller: gearing = 4 in the file, but the program divides the rotor's turns by 3")
    assert said.rstrip().endswith("4 wrong; the page is out/robot.html") and len(said.splitlines()) < 25
    assert said.startswith("robot: 48.5 kg, bumpers 0.88 x 0.76 m, 4 swerve modules, 5.1 m/s free speed")
    assert "as the program builds it and simcore.toml says" in said
    assert re.search(r"wheels +forward, .*: throws \(shooter 1\) +0\.00 to \d+\.\d\d turns, inverted", said)
    assert re.search(r"roller +backward, .*: pushes out \(intake 1\)", said)
    assert re.search(r"pivot +up: at its stop, 90 deg; - output: down, .* +0\.25 to -?0\.00 turns, inverted", said)
    blocks = report_blocks((folder / "out" / "robot.html").read_text(encoding="utf-8"))
    assert blocks[0]["text"] == "4 wrong" and [row[0] for row in blocks[1]["rows"]].count("wrong") == 4


def test_check_reports_a_missing_program_and_an_invalid_file(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = (ROBOTS / "described" / "simcore.toml").read_text()
    Path("simcore.toml").write_text(text)
    assert main(["check", "--game", "rebuilt"]) == 0
    said = capsys.readouterr().out
    assert "robot program not read (there is no robot.py); as simcore.toml says" in said
    assert "note: the drivetrain is a guess: four modules" in said and Path("out/robot.html").exists()
    Path("simcore.toml").write_text(text.replace("mass = 48.5", "mass = 107"))
    assert main(["check"]) == 1
    assert capsys.readouterr().err == (
        "\nsimcore check: simcore.toml [robot]: mass must be a number from 20 to 75 kg, got 107. As pounds that is "
        "48.5 kg\n"
    )


def test_check_describes_a_games_own_robot_and_refuses_a_folder_without_a_robot(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["check"]) == 1
    assert "no robot.py and no simcore.toml in" in capsys.readouterr().err
    assert main(["check", "--game", "rebuilt", "--out", "here.html"]) == 0
    assert "REBUILT: the game's own robot: 55 kg" in capsys.readouterr().out
    assert (tmp_path / "here.html").exists()
