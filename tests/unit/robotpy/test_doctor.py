"""Every check of `simcore doctor`, in each of its branches, and the command as a whole."""

from __future__ import annotations

import argparse
import importlib
import io
import json
import os
import socket
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from rich.console import Console

from simcore import season
from simcore.errors import ConfigError
from simcore.install_text import install_command
from simcore.robotpy import doctor
from simcore.robotpy.doctor import Finding


@pytest.mark.parametrize(
    ("version", "level", "advice"),
    [((3, 9, 18), "fail", "python3.13 -m venv"), ((3, 10, 0), "ok", ""), ((3, 14, 8), "ok", ""),
     ((3, 15, 0), "fail", "py -3.13 -m venv")],
)  # fmt: skip
def test_python(version, level, advice):
    found = doctor.check_python(version)
    assert found.level == level and advice in found.advice and bool(found.advice) == (level != "ok")


@pytest.mark.parametrize(
    ("installed", "level", "words"),
    [
        ({"pybullet-arm64": "3.2.8"}, "ok", "pybullet-arm64 3.2.8"),
        ({"pybullet-arm64": "3.2.8", "mujoco": "3.17.0"}, "ok", "pybullet-arm64 3.2.8, mujoco 3.17.0"),
        ({"mujoco": "4.0.0", "mujoco-core": "4.0.0"}, "ok", "mujoco-core 4.0.0"),
        ({"mujoco": "3.17.0", "mujoco-core": "4.0.0"}, "fail", "the same files twice"),
        ({"pybullet": "3.2.7", "pybullet-arm64": "3.2.8"}, "fail", "the same files twice"),
        ({}, "fail", "no physics engine is installed"),
    ],
)
def test_engine(installed, level, words):
    found = doctor.check_engine(installed)
    assert found.level == level and words in found.text and bool(found.advice) == (level == "fail")


def broken(*_, **__):
    raise ImportError("DLL load failed")


def test_an_engine_and_a_loop_that_do_not_load(monkeypatch):
    monkeypatch.setattr("simcore.physics.world.PhysicsWorld", broken)
    assert doctor.check_engine({"pybullet": "3.2.7"}).text == "pybullet 3.2.7 does not load: DLL load failed"
    assert doctor.check_loop().level == "ok"
    monkeypatch.setattr("simcore.loop.compiled.cache_folder", None)
    assert "compiled anew in every run" in doctor.check_loop().text and doctor.check_loop().advice
    monkeypatch.setattr("simcore.loop.step.prepare", broken)
    assert doctor.check_loop().text == "the physics cannot be compiled: DLL load failed"


REQUIRES = [
    "numpy>=1.26",
    "tomli>=2; python_version < '3.4'",
    "pybullet-arm64>=3.2.8",
    "mujoco-core>=4.0.1; extra == 'mujoco'",
    "pyfrc<2027,>=2026.0; extra == 'robotpy2026'",
    "wpilib<2027,>=2026.2; extra == 'robotpy2026'",
    "wpilib<2028,>=2027.0.0a7; extra == 'robotpy2027'",
    "pytest>=8; extra == 'test'",
]
WHOLE = {"numpy": "2.4.6", "wpilib": "2026.2.2", "pyfrc": "2026.0.3", "simcore": "0.1.0"}


def of_requirements(**installed):
    whole = {name: version for name, version in {**WHOLE, **installed}.items() if version}
    return {found.check: found for found in doctor.check_requirements(whole, REQUIRES)}


def test_requirements():
    found = of_requirements()
    assert [*found] == ["simcore", "packages", "extra [robotpy2026]"] and not any(f.advice for f in found.values())
    assert found["packages"].text == "numpy 2.4.6", "markers of other Pythons, the engine and tests do not count"
    assert found["extra [robotpy2026]"].text == "pyfrc 2026.0.3, wpilib 2026.2.2"
    assert of_requirements(numpy="1.24.0")["packages"].text == "numpy 1.24.0 is not >=1.26"
    assert of_requirements(numpy="")["packages"].text == "numpy is missing"
    half = of_requirements(pyfrc="")["extra [robotpy2026]"]
    assert (half.level, half.text) == ("fail", "pyfrc is missing")
    assert half.advice == install_command("robotpy2026", upgrade=True)
    assert [*of_requirements(wpilib="", pyfrc="")] == ["simcore", "packages"]
    assert [*of_requirements(wpilib="", pyfrc="", pyntcore="2026.2")] == [*found]
    next_year = of_requirements(wpilib="2027.0.0a7", pyfrc="")
    assert next_year["extra [robotpy2027]"].text == "wpilib 2027.0.0a7"
    (from_a_folder,) = doctor.check_requirements(WHOLE, None)
    assert from_a_folder.level == "warn" and from_a_folder.advice == install_command()


NEXT = {"wpilib": "2027.0.0a7", "pyntcore": "2027.0.0a7", "phoenix6": "26.70.0a2", "robotpy-native-wpi": "2027.0.0a7"}


@pytest.mark.parametrize(
    ("installed", "level", "words"),
    [
        ({"wpilib": "2026.2.2", "pyntcore": "2026.2.1", "robotpy-cli": "2024.0.0"}, "ok", "season 2026: 2026.2"),
        (NEXT, "ok", "2027: 2027.0; not final yet: phoenix6 26.70.0a2, pyntcore 2027.0.0a7, wpilib 2027.0.0a7"),
        ({"wpilib": "2026.2.2", "pyntcore": "2025.3.2"}, "fail", "pyntcore 2025.3.2 beside WPILib of 2026"),
        ({"wpilib": "2027.0.0a7", "phoenix6": "26.3.0"}, "fail", "phoenix6 26.3.0 beside WPILib of 2027"),
        ({"phoenix6": "26.70.0a2"}, "fail", "phoenix6 26.70.0a2 without WPILib of 2027"),
        ({"wpilib": "2026.2.2", "robotpy-hal": "2026.1.0"}, "warn", "robotpy-hal 2026.1.0 beside 2026.2"),
        ({"numpy": "2.0"}, "fail", "nothing of WPILib"),
    ],
)
def test_season(installed, level, words):
    found = doctor.check_season(installed)
    assert found.level == level and words in found.text
    assert bool(found.advice) == (level != "ok") and "\n" not in found.text + found.advice


def test_a_mixture_of_seasons_is_what_is_said_when_a_library_of_it_does_not_load(monkeypatch):
    """Of a library that is not there at all, the command that brings it."""
    monkeypatch.setattr(season, "import_module", lambda name: importlib.import_module(f"{name}_is_not_there"))
    mixture = {"wpilib": "2026.2.2", "pyntcore": "2027.0.0a7"}
    monkeypatch.setattr(
        season.metadata,
        "distributions",
        lambda: [SimpleNamespace(metadata={"Name": name}, version=version) for name, version in mixture.items()],
    )
    load = season._module.__wrapped__
    with pytest.raises(ConfigError, match=r"two seasons are mixed, pyntcore 2027\.0\.0a7 beside WPILib of 2026: make"):
        load("ntcore")
    mixture.clear()
    with pytest.raises(ConfigError, match=r"this needs ntcore of WPILib, which cannot be imported .* brings it"):
        load("ntcore")


def test_a_library_that_does_not_load_is_named_with_the_reason(tmp_path, monkeypatch):
    (tmp_path / "of_a_vendor.py").write_text("raise ImportError('DLL load failed')")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    assert doctor.check_imports(["json"]) == Finding("imports", "json")
    found = doctor.check_imports(["json", "of_a_vendor", "re"])
    assert (found.level, found.text) == ("fail", "of_a_vendor does not load: ImportError: DLL load failed")


def test_a_port_that_somebody_holds(monkeypatch):
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        server.listen()
        port = server.getsockname()[1]
        assert doctor.is_taken(port)
    assert not doctor.is_taken(port)
    monkeypatch.setattr(doctor, "is_taken", lambda port: port == 5810)
    found = doctor.check_ports()
    assert found.text == "another program has 5810 (NetworkTables 4)" and "5810" in found.advice
    monkeypatch.setattr(doctor, "is_taken", lambda port: False)
    assert doctor.check_ports().level == "ok"


def of_folder(folder, now=0.0):
    return {found.check: found for found in doctor.check_folder(folder, now)}


def test_the_folder_of_a_project(tmp_path):
    found = of_folder(tmp_path)
    assert {name: one.level for name, one in found.items()} == {
        "folder": "ok",
        "robot.py": "warn",
        "simcore.toml": "ok",
    }
    (tmp_path / "robot.py").write_text("")
    (tmp_path / "simcore.toml").write_text("[robot]\nmass = -1\n")
    found = of_folder(tmp_path)
    assert found["robot.py"].level == "ok" and found["simcore.toml"].level == "fail"
    assert found["simcore.toml"].text == "simcore.toml [robot]: mass must be a number from 20 to 75 kg, got -1"
    (tmp_path / "file").write_text("")
    assert "cannot write to" in of_folder(tmp_path / "file")["folder"].text


@pytest.mark.parametrize(
    ("requires", "level", "said"),
    [
        ('["phoenix6"]', "warn", "brings no simcore"),
        ('["simcore[robotpy]>=1"]', "warn", "for the robot, too"),
        ("""['simcore>=1; platform_machine != "roborio"']""", "warn", "for the robot, too"),
        (
            """['simcore>=1; platform_machine != "roborio" and platform_machine != "systemcore"']""",
            "ok",
            "laptops alone",
        ),
        ("""['simcore @ git+https://h/s ; platform_machine != "roborio"']""", "warn", "for the robot, too"),
        ('["simcore = 1"]', "fail", "simcore = 1"),
        ("3", "fail", "not iterable"),
    ],
)
def test_how_other_laptops_get_simcore(tmp_path, monkeypatch, requires, level, said):
    file = tmp_path / "pyproject.toml"
    assert not [*doctor.check_requires(file)], "no robot project"
    file.write_text(f"[tool.robotpy]\nrequires = {requires}\n")
    for there, advice in (
        (
            "simcore[robotpy]==1.2.0",
            'write into requires: \'simcore[robotpy]>=1.2.0; platform_machine != "roborio" and',
        ),
        (
            "simcore[robotpy] @ git+https://h/s@c0",
            "write 'simcore[robotpy] @ git+https://h/s@c0' into requirements-sim",
        ),
        ("", "write 'simcore[phoenix6,robotpy] @ git+https://...' into requirements-sim.txt"),
    ):
        monkeypatch.setattr(doctor, "shared_requirement", lambda *extras, there=there: there)
        (found,) = doctor.check_requires(file)
        assert found.level == level and said in found.text
        assert advice in found.advice or level != "warn"


def test_what_earlier_runs_left_in_the_folder(tmp_path):
    (tmp_path / "ctre_sim").mkdir()
    (tmp_path / "ctre_sim" / "Talon FX - 01 - 0 - ext.dat").write_bytes(b"")
    os.utime(tmp_path / "ctre_sim" / "Talon FX - 01 - 0 - ext.dat", (1e9, 1e9))
    (tmp_path / "networktables.json").write_text("[]\n")
    assert not {"ctre_sim", "stored values"} & {*of_folder(tmp_path, 1e9 + 600.0)}
    (tmp_path / "networktables.json").write_text('[{"name": "/Preferences/kP"}]')
    found = of_folder(tmp_path, 1e9 + 13 * 3600.0)
    assert "settings of 1 devices, 13 hours old" in found["ctre_sim"].text and "delete" in found["stored values"].advice


def test_games(monkeypatch):
    def games(found):
        monkeypatch.setattr("simcore.match.registry.installed_games", found)
        return doctor.check_games()

    assert games(lambda say: {})[0].level == "fail"
    assert games(broken)[0].text == "games cannot be loaded: ImportError: DLL load failed"
    new, old = (SimpleNamespace(name=name, year=year) for name, year in (("newer", 2026), ("older", 2025)))
    found, game = games(lambda say: {"newer": new, "older": old})
    assert game is new and found.text.startswith("newer (2026), the newest") and "older (2025)" in found.text
    found, game = games(lambda say: say("left out: game mine: mine/autos.py, line 42: NameError") or {"newer": new})
    assert game is new and found.level == "warn" and "mine/autos.py, line 42" in found.text
    assert "uninstall its package" in found.advice


@pytest.mark.parametrize(("milliseconds", "level"), [(1.0, "ok"), (9.0, "warn"), (25.0, "fail")])
def test_speed(milliseconds, level):
    found = doctor._of_speed("rebuilt", milliseconds)
    assert found.level == level and f"a tick takes {milliseconds:.1f} of its 20 ms" in found.text


def test_a_match_that_cannot_be_built_or_does_not_move(monkeypatch):
    monkeypatch.setattr("simcore.match.match.Match", broken)
    assert doctor.check_run(None).text == "the match does not run: DLL load failed"
    chassis = SimpleNamespace(pose=(0.0, 0.0, 0.0))
    robot = SimpleNamespace(chassis=chassis, drive=SimpleNamespace(set_chassis_speeds=lambda *_: None))

    class Match(SimpleNamespace):
        __enter__ = lambda self: self  # noqa: E731
        __exit__ = tick = lambda *_: None

    monkeypatch.setattr("simcore.match.match.Match", lambda game: Match(robots=[robot]))
    assert "moved 0.00 m" in doctor.check_run(None).text


def parsed(*words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    doctor.add_arguments(parser)
    return parser.parse_args(words)


def test_the_command_here_and_now(tmp_path, capsys):
    status = doctor.run(parsed("--json", "--folder", str(tmp_path)))
    report = json.loads(capsys.readouterr().out)
    levels = {row["check"]: row["level"] for row in report["findings"]}
    assert report["ok"] == (status == 0) == ("fail" not in levels.values())
    assert (levels["Python"], levels["engine"], levels["folder"]) == ("ok", "ok", "ok")
    assert all(row["advice"] for row in report["findings"] if row["level"] != "ok")
    if levels["game"] == "ok":  # it is found by its entry point: simcore is installed
        assert "run" in levels


def test_a_failure_is_status_1_and_stands_in_the_table(tmp_path, capsys):
    (tmp_path / "simcore.toml").write_text("[robot")
    assert doctor.run(parsed("--no-physics", "--folder", str(tmp_path))) == 1
    said = capsys.readouterr().out
    assert "simcore.toml" in said and "do this:" in said and "cannot work" in said


@pytest.mark.parametrize("encoding", ["utf-8", "cp1252", "ascii"])
def test_the_table_on_any_terminal(encoding):
    file = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    findings = [Finding("a", "ä [b]"), Finding("c", "d", "e", "warn"), Finding("f", "g" * 200, "h", "fail")]
    doctor.print_findings(findings, Console(file=file, width=80))
    file.seek(0)
    lines = file.read().splitlines()
    assert max(map(len, lines)) <= 80
    assert "1 of these cannot work" in lines[-1]
    assert any("[b]" in line for line in lines), "square brackets are no markup"


def test_nothing_of_a_vendor_is_loaded_by_looking():
    """It must work where half of it is missing."""
    code = (
        "import sys, simcore.robotpy.doctor\n"
        "assert not {'wpilib', 'hal', 'phoenix6', 'pyfrc', 'pybullet', 'mujoco'} & set(sys.modules)"
    )
    root = str(Path(__file__).resolve().parents[3])
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60, env={**os.environ, "PYTHONPATH": root})
