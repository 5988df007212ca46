import pytest

from simcore.errors import EngineError, UnknownNameError
from simcore.world import engine_choice
from simcore.world.engine_choice import ENGINES, VARIABLE, choose_engine
from simcore.world.world import PhysicsWorld


@pytest.fixture(autouse=True)
def _no_variable(monkeypatch):
    monkeypatch.delenv(VARIABLE, raising=False)


@pytest.mark.parametrize("name", ENGINES)
def test_a_named_engine_overrides_the_environment(name, monkeypatch):
    assert choose_engine(name) == name
    monkeypatch.setenv(VARIABLE, "bullet" if name == "mujoco" else "mujoco")
    assert choose_engine(name) == name
    assert choose_engine() != name


@pytest.mark.parametrize(("installed", "chosen"), [(("pybullet", "mujoco"), "bullet"), (("mujoco",), "mujoco")])
def test_without_a_name_the_first_installed_engine_is_chosen(installed, chosen, monkeypatch):
    monkeypatch.setattr(engine_choice, "find_spec", lambda package: package if package in installed else None)
    assert choose_engine() == chosen


def test_without_any_engine_the_error_names_both_ways_to_install_an_engine(monkeypatch):
    monkeypatch.setattr(engine_choice, "find_spec", lambda package: None)
    with pytest.raises(EngineError, match=r"pip install pybullet-arm64.*pip install mujoco"):
        choose_engine()


def test_the_error_for_an_unknown_engine_lists_the_known_engines(monkeypatch):
    with pytest.raises(UnknownNameError, match=r"no physics engine named 'bulet'.*'bullet', 'mujoco'"):
        PhysicsWorld(engine="bulet")
    monkeypatch.setenv(VARIABLE, "ode")
    with pytest.raises(UnknownNameError, match="ode"):
        PhysicsWorld()
