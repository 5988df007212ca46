"""Every check of `simcore doctor`, in each of its branches, and the command as a whole."""

from __future__ import annotations

import argparse
import importlib
import io
import json
import os
import socket
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from packaging.requirements import Requirement
from rich.console import Console

from simcore import season
from simcore.errors import ConfigError
from simcore.install_text import install_command
from simcore.robotpy import doctor
from simcore.robotpy.checks import computer_checks, install_checks, project_checks
from simcore.robotpy.checks.findings import Level, fail, ok, warn

if sys.version_info >= (3, 11):
    import tomllib as tomli
else:
    import tomli

ROOT = Path(__file__).resolve().parents[3]
OK, WARN, FAIL = Level.OK, Level.WARN, Level.FAIL
NEW = (2, 36)


# --- Python and packages --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("version", "level", "advice"),
    [
        ((3, 9, 18), FAIL, "install Python 3.13"),
        ((3, 10, 0), OK, ""),
        ((3, 14, 8), OK, ""),
        ((3, 15, 0), FAIL, "py -3.13 -m venv"),
    ],
)
def test_python(version, level, advice):
    found = install_checks.check_python(version)
    assert found.level is level and advice in found.advice and bool(found.advice) == (level is not OK)


@pytest.mark.parametrize(
    ("system", "machine_name", "version", "glibc", "level", "advice"),
    [
        ("Linux", "x86_64", (3, 11, 7), NEW, OK, ""),
        ("Windows", "AMD64", (3, 13, 0), None, OK, ""),
        ("Darwin", "arm64", (3, 10, 1), None, OK, ""),
        ("Darwin", "x86_64", (3, 12, 1), None, OK, ""),
        ("Darwin", "x86_64", (3, 13, 1), None, OK, ""),
        ("Linux", "aarch64", (3, 12, 1), NEW, OK, ""),
        ("Linux", "aarch64", (3, 10, 1), NEW, WARN, "try Python 3.13"),
        ("Windows", "ARM64", (3, 12, 1), None, WARN, "compiles it"),
        ("Windows", "x86", (3, 12, 1), None, WARN, "compiles it"),
        ("Linux", "x86_64", (3, 12, 1), (2, 27), WARN, "glibc 2.28"),
        ("Linux", "x86_64", (3, 12, 1), None, WARN, "glibc 2.28"),
        ("Linux", "x86_64", (3, 14, 0), NEW, OK, ""),
        ("Linux", "x86_64", (3, 15, 0), NEW, WARN, "compiles it"),
    ],
)
def test_wheels(system, machine_name, version, glibc, level, advice):
    found = install_checks.check_wheels(system, machine_name, version, glibc)
    assert found.level is level and advice in found.advice


@pytest.mark.parametrize("minor", range(10, 15))
@pytest.mark.parametrize(
    ("system", "machine_name"),
    [
        ("Windows", "AMD64"),
        ("Windows", "ARM64"),
        ("Linux", "x86_64"),
        ("Linux", "aarch64"),
        ("Linux", "armv7l"),
        ("Darwin", "arm64"),
        ("Darwin", "x86_64"),
    ],
)
def test_every_platform_gets_one_engine_of_which_there_is_a_wheel(system, machine_name, minor):
    """By the markers of pyproject.toml: one engine to begin with, and both with the extra, unless one has no wheel."""
    project = tomli.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    around = {"platform_system": system, "platform_machine": machine_name, "python_version": f"3.{minor}"}

    def of(lines):
        wanted = [Requirement(line) for line in lines]
        return [
            r.name for r in wanted if r.name in install_checks.ENGINES and (not r.marker or r.marker.evaluate(around))
        ]

    names = {"PyBullet": ["pybullet-arm64"], "": []}
    mujoco = ["mujoco" if minor == 10 or (system, machine_name) == ("Darwin", "x86_64") else "mujoco-core"]
    engine = install_checks.engine_of(system, machine_name, (3, minor))
    assert of(project["dependencies"]) == names.get(engine, mujoco)
    assert of(project["optional-dependencies"]["mujoco"]) == (mujoco if engine else [])


def broken() -> None:
    raise ImportError("DLL load failed")


@pytest.mark.parametrize(
    ("installed", "load", "level", "words"),
    [
        ({"pybullet-arm64": "3.2.8"}, int, OK, "pybullet-arm64 3.2.8"),
        ({"pybullet": "3.2.7"}, int, OK, "pybullet 3.2.7"),
        ({"mujoco-core": "4.0.1"}, int, OK, "mujoco-core 4.0.1"),
        ({"pybullet-arm64": "3.2.8", "mujoco": "3.17.0"}, int, OK, "pybullet-arm64 3.2.8, mujoco 3.17.0"),
        ({"mujoco": "4.0.0", "mujoco-core": "4.0.0"}, int, OK, "mujoco-core 4.0.0"),
        ({"mujoco": "3.17.0", "mujoco-core": "4.0.0"}, int, FAIL, "the same files twice"),
        ({}, int, FAIL, "no physics engine is installed"),
        ({"pybullet": "3.2.7", "pybullet-arm64": "3.2.8"}, int, FAIL, "the same files twice"),
        ({"pybullet-arm64": "3.2.8"}, broken, FAIL, "does not load: DLL load failed"),
    ],
)
def test_engine(installed, load, level, words):
    found = install_checks.check_engine(installed, load, "PyBullet")
    assert found.level is level and words in found.text and bool(found.advice) == (level is FAIL)


def test_a_missing_engine_is_the_one_that_has_a_wheel_here():
    for wanted, package in (("PyBullet", "pybullet-arm64"), ("MuJoCo", "mujoco")):
        assert f"pip install {package}`" in install_checks.check_engine({}, int, wanted).advice


REQUIRES = [
    "numpy>=1.26",
    "tomli>=2; python_version < '3.11'",
    "pybullet-arm64>=3.2.8",
    "mujoco-core>=4.0.1; extra == 'mujoco'",
    "phoenix6<27,>=26.1; extra == 'phoenix6'",
    "wpilib<2027,>=2026.2; extra == 'phoenix6'",
    "pyfrc<2027,>=2026.0; extra == 'robotpy2026'",
    "wpilib<2028,>=2027.0.0a7; extra == 'robotpy2027'",
    "pytest>=8; extra == 'test'",
]
WHOLE = {"numpy": "2.4.6", "phoenix6": "26.3.0", "wpilib": "2026.2.2", "pyfrc": "2026.0.3", "simcore": "0.1.0"}


def of_requirements(installed, python="3.12"):
    findings = install_checks.check_requirements(installed, REQUIRES, {"python_version": python})
    return {finding.check: finding for finding in findings}


def test_requirements_of_a_whole_installation():
    found = of_requirements(WHOLE)
    assert [(f.check, f.level) for f in found.values()] == [
        ("simcore", OK), ("packages", OK), ("extra [phoenix6]", OK), ("extra [robotpy2026]", OK),
    ]  # fmt: skip
    assert found["packages"].text == "numpy 2.4.6", "markers of other Pythons, the engine and tests do not count"
    assert found["extra [phoenix6]"].text == "phoenix6 26.3.0, wpilib 2026.2.2"


def test_requirements_that_are_missing_old_or_not_wanted():
    assert of_requirements({**WHOLE, "numpy": "1.24.0"})["packages"].text == "numpy 1.24.0 is not >=1.26"
    assert of_requirements(WHOLE, "3.10")["packages"].text == "tomli is missing"
    assert of_requirements(WHOLE, "3.10")["packages"].level is FAIL
    for version in ("25.4.0", "27.0.0"):
        found = of_requirements({**WHOLE, "phoenix6": version})["extra [phoenix6]"]
        assert found.level is FAIL and f"phoenix6 {version} is not <27,>=26.1" in found.text
        assert found.advice == install_command("phoenix6", upgrade=True)
    without = {key: value for key, value in WHOLE.items() if key not in ("phoenix6", "wpilib", "pyfrc")}
    assert of_requirements(without)["extra [robotpy2026]"].level is WARN
    half = {key: value for key, value in WHOLE.items() if key != "phoenix6"}
    assert of_requirements(half)["extra [phoenix6]"].level is FAIL, "half an extra is worse than none"


def test_simcore_that_is_not_installed():
    (found,) = install_checks.check_requirements(WHOLE, None)
    assert found.level is WARN and found.advice == install_command()


@pytest.mark.parametrize(
    ("installed", "level", "words"),
    [
        (
            {"wpilib": "2026.2.2", "pyntcore": "2026.2.1", "robotpy-cli": "2024.0.0"},
            OK,
            "season 2026: 2026.2 (2 packages)",
        ),
        (
            {
                "wpilib": "2027.0.0a7",
                "pyntcore": "2027.0.0a7",
                "phoenix6": "26.70.0a2",
                "robotpy-native-ntcore": "2027.0.0a7",
            },
            OK,
            "2027: 2027.0 (3 packages); not final yet: phoenix6 26.70.0a2, pyntcore 2027.0.0a7, wpilib 2027.0.0a7",
        ),
        ({"wpilib": "2026.2.2", "pyntcore": "2025.3.2"}, FAIL, "pyntcore 2025.3.2 beside WPILib of 2026"),
        ({"wpilib": "2026.2.2", "pyntcore": "2027.0.0a7"}, FAIL, "pyntcore 2027.0.0a7 beside WPILib of 2026"),
        ({"wpilib": "2027.0.0a7", "pyfrc": "2026.0.3"}, FAIL, "pyfrc 2026.0.3 beside WPILib of 2027"),
        ({"wpilib": "2027.0.0a7", "phoenix6": "26.3.0"}, FAIL, "phoenix6 26.3.0 beside WPILib of 2027"),
        ({"phoenix6": "26.70.0a2"}, FAIL, "phoenix6 26.70.0a2 without WPILib of 2027"),
        ({"wpilib": "2026.2.2", "robotpy-hal": "2026.1.0"}, WARN, "robotpy-hal 2026.1.0 beside 2026.2"),
        ({"numpy": "2.0"}, FAIL, "nothing of WPILib"),
    ],
)
def test_year(installed, level, words):
    found = install_checks.check_year(installed)
    assert found.level is level and words in found.text
    assert bool(found.advice) == (level is not OK) and "\n" not in found.text + found.advice


def test_extras_are_those_of_the_season():
    found = of_requirements({"numpy": "2.5", "simcore": "1.0", "wpilib": "2027.0.0a7", "phoenix6": "26.70.0a2"})
    assert [*found] == ["simcore", "packages", "extra [robotpy2027]"]
    assert found["extra [robotpy2027]"].text == "wpilib 2027.0.0a7"


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


# --- the computer ---------------------------------------------------------------------------------------------------


def test_ports_free_taken_and_by_whom():
    assert computer_checks.check_ports(lambda port: False, str).level is OK
    found = computer_checks.check_ports(lambda port: port == 5810, lambda port: "process 77: robotpy sim")
    assert found.level is WARN
    assert "5810 (NetworkTables 4" in found.text and "process 77: robotpy sim" in found.text
    assert "lsof" not in found.advice and "netstat" not in found.advice
    unknown = computer_checks.check_ports(lambda port: True, lambda port: "")
    assert "1735" in unknown.text and ("lsof -i :5810" in unknown.advice or "netstat" in unknown.advice)


def test_a_port_that_we_hold_is_seen_as_ours():
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        server.listen()
        port = server.getsockname()[1]
        assert computer_checks.is_taken(port)
        if sys.platform == "linux":
            assert computer_checks.owner_of(port).startswith(f"process {os.getpid()}: ")
    assert not computer_checks.is_taken(port)
    assert computer_checks.owner_of(port) == ""


def test_owner_is_unknown_where_there_is_no_proc(tmp_path):
    assert computer_checks.owner_of(5810, tmp_path) == ""


@pytest.mark.parametrize(
    ("system", "environment", "installed", "level", "words"),
    [
        ("Linux", {"DISPLAY": ":0"}, {"robotpy-halsim-gui"}, OK, "can open"),
        ("Linux", {"WAYLAND_DISPLAY": "w"}, {"robotpy-halsim-gui"}, OK, "can open"),
        ("Windows", {}, {"robotpy-halsim-gui"}, OK, "can open"),
        ("Linux", {"DISPLAY": ""}, {"robotpy-halsim-gui"}, WARN, "no screen"),
        ("Windows", {}, set(), WARN, "not installed"),
    ],
)
def test_screen(system, environment, installed, level, words):
    found = computer_checks.check_screen(system, environment, installed)
    assert found.level is level and words in found.text and ("--nogui" in found.advice) == (level is WARN)


# --- the project ----------------------------------------------------------------------------------------------------


def test_robot_file(tmp_path):
    assert project_checks.check_robot_file(tmp_path).level is WARN
    (tmp_path / "robot.py").write_text("")
    assert project_checks.check_robot_file(tmp_path).level is OK


@pytest.mark.parametrize(
    ("content", "level", "words"),
    [
        (None, OK, "none is needed"),
        (b"class PhysicsEngine:\n    pass\n", OK, "has a PhysicsEngine"),
        (b"from mine import Engine as PhysicsEngine\n", OK, "has a PhysicsEngine"),
        (b"class Physics:\n    pass\n", FAIL, "no class PhysicsEngine"),
        (b"class PhysicsEngine(:\n", FAIL, "line 1"),
        (b"# \xff\xfe\n", FAIL, "cannot be read"),
        (b"x = 1\n\0\n", FAIL, ""),
    ],
)
def test_physics_file(tmp_path, content, level, words):
    if content is not None:
        (tmp_path / "physics.py").write_bytes(content)
    found = project_checks.check_physics_file(tmp_path)
    assert found.level is level and words in found.text


def test_settings_file(tmp_path):
    def refuse(path):
        raise ConfigError("simcore.toml [robot]: mass must be > 0, got -1")

    def unreadable(path):
        raise PermissionError(13, "Permission denied")

    assert project_checks.check_settings_file(tmp_path, refuse).level is OK, "there is none"
    (tmp_path / "simcore.toml").write_text("[robot]\nmass = -1\n")
    assert project_checks.check_settings_file(tmp_path, lambda path: path.read_text()).level is OK
    assert project_checks.check_settings_file(tmp_path, refuse).text == "simcore.toml [robot]: mass must be > 0, got -1"
    assert project_checks.check_settings_file(tmp_path, unreadable).text == "cannot be read: Permission denied"


def test_a_settings_file_that_is_no_toml_is_found_by_the_real_reader(tmp_path):
    (tmp_path / "simcore.toml").write_text("[robot\n")
    assert project_checks.check_settings_file(tmp_path, doctor.read_settings).level is FAIL


def test_device_settings_of_phoenix(tmp_path):
    assert project_checks.check_device_settings(tmp_path, 0.0).level is OK
    folder = tmp_path / "ctre_sim"
    folder.mkdir()
    for name in (
        "Talon FX vers. C - 011 - 0 - ext",
        "Talon FX vers. C - 02 - 0 - ext",
        "Talon FXS - 037 - 0 - ext",
        "odd",
    ):
        path = folder / f"{name}.dat"
        path.write_bytes(b"")
        os.utime(path, (1e9, 1e9))
    fresh = project_checks.check_device_settings(tmp_path, 1e9 + 600.0)
    assert fresh.level is OK
    assert fresh.text == "settings of 4 devices, 10 minutes old: Talon FX 2 11, Talon FXS 37, odd"
    old = project_checks.check_device_settings(tmp_path, 1e9 + 3 * 86400.0)
    assert old.level is WARN and "3 days old" in old.text and "delete the folder" in old.advice
    assert "13 hours old" in project_checks.check_device_settings(tmp_path, 1e9 + 13 * 3600.0).text


@pytest.mark.parametrize(
    ("content", "level", "words"),
    [
        (None, OK, "no networktables.json"),
        ("[]", OK, "is empty"),
        ("", OK, "is empty"),
        ('[{"name": "/Preferences/kP"}, {"name": "/Preferences/kD"}, {"name": "/x"}]', WARN, "Preferences (2), x (1)"),
        ("{", WARN, "cannot be read"),
    ],
)
def test_stored_values(tmp_path, content, level, words):
    if content is not None:
        (tmp_path / "networktables.json").write_text(content)
    found = project_checks.check_stored_values(tmp_path)
    assert found.level is level and words in found.text


def test_writable(tmp_path):
    assert project_checks.check_writable(tmp_path).level is OK
    (tmp_path / "file").write_text("")
    found = project_checks.check_writable(tmp_path / "file")
    assert found.level is WARN and "cannot write to" in found.text


# --- the game -------------------------------------------------------------------------------------------------------


def test_game():
    assert computer_checks.check_games(dict)[0].level is FAIL
    assert computer_checks.check_games(broken)[0].text == "a game does not load: DLL load failed"
    new, old = (SimpleNamespace(name=name, year=year) for name, year in (("newer", 2026), ("older", 2025)))
    found, game = computer_checks.check_games(lambda: {"newer": new, "older": old})
    assert (
        found.level is OK
        and found.text.startswith("newer (2026), the newest")
        and "older (2025)" in found.text
        and game is new
    )


class Match:
    """A match whose ticks take as long as it is told, on a clock of its own."""

    def __init__(self, milliseconds, step=0.02):
        self.now, self.took, self.x, self.step, self.closed = 0.0, milliseconds / 1e3, 0.0, step, False
        self.robots = [SimpleNamespace(drive=SimpleNamespace(set_chassis_speeds=lambda *_: None), chassis=self)]

    @property
    def pose(self):
        return self.x, 0.0, 0.0

    def tick(self):
        self.now += self.took
        self.x += self.step

    def piece_positions(self):
        return {"Fuel": [0] * 448}

    def close(self):
        self.closed = True


@pytest.mark.parametrize(
    ("milliseconds", "step", "level", "words"),
    [
        (1.0, 0.02, OK, "a tick takes 1.0 ms"),
        (9.0, 0.02, WARN, "9.0 ms"),
        (25.0, 0.02, FAIL, "25.0 ms"),
        (1.0, 0.0, FAIL, "moved 0.00 m"),
        (1.0, float("nan"), FAIL, "moved nan m"),
    ],
)
def test_speed(milliseconds, step, level, words):
    match = Match(milliseconds, step)
    field, found = computer_checks.check_speed(lambda: match, lambda: match.now)
    assert field.text == "mesh and 448 pieces are there"
    assert found.level is level and words in found.text
    assert match.closed


def test_a_game_that_cannot_be_built():
    def build():
        raise FileNotFoundError("field_collision.obj")

    (found,) = computer_checks.check_speed(build, float)
    assert found.level is FAIL and "field_collision.obj" in found.text


# --- the command ----------------------------------------------------------------------------------------------------


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
    if "field" in levels:  # the game is found by its entry point: simcore is installed
        assert levels["field"] == "ok" and "speed" in levels


def test_a_failure_is_status_1_and_stands_in_the_table(tmp_path, capsys):
    (tmp_path / "physics.py").write_text("class PhysicsEngine(:")
    assert doctor.run(parsed("--no-physics", "--folder", str(tmp_path))) == 1
    said = capsys.readouterr().out
    assert "physics.py" in said and "do this:" in said and "cannot work" in said


@pytest.mark.parametrize("encoding", ["utf-8", "cp1252", "ascii"])
def test_the_table_on_any_terminal(encoding):
    file = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    console = Console(file=file, width=80)
    doctor.print_findings([ok("a", "ä [b]"), warn("c", "d", "e"), fail("f", "g" * 200, "h")], console)
    file.seek(0)
    lines = file.read().splitlines()
    assert max(map(len, lines)) <= 80
    assert "1 of these cannot work" in lines[-1]
    assert any("[b]" in line for line in lines), "square brackets are no markup"


def test_nothing_of_a_vendor_is_loaded_by_looking(tmp_path):
    """It must work where half of it is missing."""
    import subprocess

    code = (
        "import sys, simcore.robotpy.doctor\n"
        "assert not {'wpilib', 'hal', 'phoenix6', 'pyfrc', 'pybullet', 'mujoco'} & set(sys.modules)"
    )
    root = str(Path(__file__).resolve().parents[3])
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60, env={**os.environ, "PYTHONPATH": root})


@pytest.mark.parametrize(
    ("prepare", "level", "words"),
    [
        (lambda: Path("somewhere"), Level.OK, "kept in somewhere"),
        (lambda: None, Level.WARN, "compiled anew in every run"),
        (lambda: 1 / 0, Level.FAIL, "cannot be compiled: division by zero"),
    ],
)
def test_the_loop_is_compiled_and_said_where(prepare, level, words):
    found = install_checks.check_loop(prepare)
    assert found.level is level and words in found.text
    assert bool(found.advice) == (level is not Level.OK)
