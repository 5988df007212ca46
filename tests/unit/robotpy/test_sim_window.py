from __future__ import annotations

import json

import pytest

from games.rebuilt import REBUILT
from simcore.robotpy.sim_window import SETTINGS, WINDOWS, is_for_simcore, prepare_map


@pytest.fixture
def settings(tmp_path):
    return tmp_path / SETTINGS


def field_of(settings):
    return json.loads(settings.read_text())["NTProvider"]["windows"]["/SmartDashboard/Field"]


def test_a_fresh_project_gets_an_open_map_with_fuel_of_its_size_and_color(settings):
    assert prepare_map(settings.parent, [REBUILT])
    (kind,) = (supply.kind for supply in REBUILT.pieces)
    field = field_of(settings)
    assert field["window"]["visible"]
    assert field["Fuel"]["length"] == field["Fuel"]["width"] == pytest.approx(1.6 * kind.shape.radius)
    assert field["Fuel"]["color"][0] > field["Fuel"]["color"][2] + 0.5  # yellow
    assert "###/SmartDashboard/Field" in json.loads((settings.parent / WINDOWS).read_text())["Window"]
    assert not prepare_map(settings.parent, [REBUILT])  # the second time all is there


def test_what_the_user_has_set_stays(settings):
    mine = {"NTProvider": {"windows": {"/SmartDashboard/Field": {"window": {"visible": False}}}}, "Docking": [1]}
    settings.write_text(json.dumps(mine))
    assert prepare_map(settings.parent, [REBUILT])
    field = field_of(settings)
    assert field.pop("Fuel")["length"] < 0.2
    assert field == {"window": {"visible": False}}
    assert json.loads(settings.read_text())["Docking"] == [1]
    assert not (settings.parent / WINDOWS).exists()


@pytest.mark.parametrize("text", ["{", "[]", '{"NTProvider": 3}'])
def test_settings_that_make_no_sense_are_left_alone(settings, text):
    settings.write_text(text)
    assert not prepare_map(settings.parent, [REBUILT])
    assert settings.read_text() == text


def test_only_projects_on_simcores_field_are_prepared(tmp_path):
    assert not is_for_simcore(tmp_path, has_flag=False)
    (tmp_path / "physics.py").write_text("from pyfrc.physics.core import PhysicsInterface\n")
    assert not is_for_simcore(tmp_path, has_flag=False)
    assert is_for_simcore(tmp_path, has_flag=True)
    (tmp_path / "physics.py").write_text("from simcore import RobotPhysics\n")
    assert is_for_simcore(tmp_path, has_flag=False)
