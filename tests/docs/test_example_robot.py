"""The page about a robot file shows the files of the example and the output of `simcore check`."""

from __future__ import annotations

import re
import shutil
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace

import pytest

from games.reefscape.robot import reefscape_robot
from simcore.cli import main
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot_file.reader import read_settings
from simcore.world.linkage import part_pose

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "robot.md").read_text(encoding="utf-8")
PROJECT = ROOT / "examples" / "reefscape_robot"


@pytest.mark.parametrize(("language", "count"), [("toml", 4), ("py", 1)])
def test_code_blocks_about_the_example_are_copied_from_the_example_files(language, count):
    """The other blocks are about a shooter and ports, which the example does not have."""
    blocks = re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    files = [path.read_text(encoding="utf-8") for path in PROJECT.rglob(f"*.{language}")]
    assert len([block for block in blocks if any(block in text for text in files)]) == count


def test_simcore_check_prints_the_table_on_the_page(whole, tmp_path, monkeypatch, capsys):
    if not whole:
        pytest.skip("starts a robot program: with --whole")
    if find_spec("phoenix6") is None or find_spec("pyfrc") is None:
        pytest.skip('needs the extras: pip install -e ".[phoenix6,robotpy]"')
    shutil.copytree(PROJECT, tmp_path / "robot", ignore=shutil.ignore_patterns("ctre_sim", "out", "__pycache__"))
    monkeypatch.chdir(tmp_path / "robot")
    assert main(["check"]) == 0
    said = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    rows = re.search(r"^      mechanism  full.*?\n\n", PAGE, re.MULTILINE | re.DOTALL)[0].strip().splitlines()
    assert [" ".join(row.split()) for row in rows] == said[said.index(" ".join(rows[0].split())) :][: len(rows)]


def test_the_parts_of_the_example_have_the_names_and_poses_of_the_games_robot():
    settings = read_settings(PROJECT / "simcore.toml")
    assert settings is not None
    described = settings.robot_config(SwerveConfig.square(0.5, SwerveModuleConfig(x=0.0, y=0.0))).components
    own = reefscape_robot().components
    assert [part.name for part in described] == [part.name for part in own]
    shafts = {
        name: SimpleNamespace(position=3.0) for name in ("elevator", "arm", "claw", "algae_wheel", "funnel", "climber")
    }
    for part, model in zip(described, own, strict=True):
        poses = [part_pose(one.joints, shafts, one.offset)[0] for one in (part, model)]
        assert poses[0] == pytest.approx(poses[1], abs=0.001), part.name
