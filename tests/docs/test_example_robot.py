"""The page that walks through a whole robot shows what is in its files, word for word."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace

import pytest

from games.reefscape.robot import reefscape_robot
from simcore.geometry.linkage import part_pose
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot_file.reader import read_settings

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "example_robot.md"
PROJECT = ROOT / "examples" / "reefscape_robot"


@pytest.mark.parametrize(("language", "at_least"), [("toml", 3), ("py", 2)])
def test_every_block_of_the_page_is_in_a_file_of_the_project(language, at_least):
    blocks = re.findall(rf"^```{language}\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    files = [path.read_text(encoding="utf-8") for path in PROJECT.rglob(f"*.{language}")]
    assert len(blocks) >= at_least
    for block in blocks:
        assert any(block in text for text in files), block


def test_the_models_of_the_game_fit_its_parts():
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
