"""Every check of `simcore doctor`, in each of its branches, and the command as a whole."""

import argparse
import importlib
import io
import json
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from each_case import each
from rich.console import Console

from simcore import season
from simcore.errors import ConfigError
from simcore.install_text import install_command
from simcore.robotcode.sim import doctor
from simcore.robotcode.sim.doctor import Finding


@each(
    ("version", "level", "advice"),
    [((3, 9, 18), "fail", "python3.13 -m venv"), ((3, 10, 0), "ok", ""), ((3, 14, 8), "ok", ""),
     ((3, 15, 0), "fail", "py -3.13 -m venv")],
)  # fmt: skip
def test_an_unsupported_python_version_is_reported_with_advice(version, level, advice):
    found = doctor.check_python(version)
    assert found.level == level and advice in found.advice and bool(found.advice) == (level != "ok")


@each(
    ("installed", "level", "words"),
    [
        ({"simcore": "1.0", "wpilib": "2026.2.2", "numpy": "2.4"}, "ok", "simcore 1.0, numpy 2.4, wpilib 2026.2.2"),
        ({"simcore": "1.0", "wpilib": "2026.2.2", "pyntcore": "2025.3.2"}, "fail", "2025.3.2 next to WPILib of 2026"),
        ({"simcore": "1.0", "wpilib": "2027.0.0a7", "phoenix6": "26.3.0"}, "fail", "26.3.0 next to WPILib of 2027"),
        ({"simcore": "1.0", "numpy": "2.0"}, "warn", "no WPILib"),
        ({"wpilib": "2026.2.2"}, "warn", "runs from a folder and is not installed"),
    ],
)
def test_mixed_seasons_and_missing_packages_are_reported_with_advice(installed, level, words):
    found = doctor.check_versions(installed)
    assert found.level == level and words in found.text
    assert bool(found.advice) == (level != "ok") and "\n" not in found.text + found.advice


def test_the_error_for_a_library_that_fails_to_load_names_mixed_seasons(monkeypatch):
    """For a missing library, the error gives the command that installs it."""
    monkeypatch.setattr(season, "import_module", lambda name: importlib.import_module(f"{name}_is_not_there"))
    mixture = {"wpilib": "2026.2.2", "pyntcore": "2027.0.0a7"}
    monkeypatch.setattr(
        season.metadata,
        "distributions",
        lambda: [SimpleNamespace(metadata={"Name": name}, version=version) for name, version in mixture.items()],
    )
    load = season._module.__wrapped__
    with pytest.raises(ConfigError, match=r"two seasons are mixed, pyntcore 2027\.0\.0a7 next to WPILib of 2026: make"):
        load("ntcore")
    mixture.clear()
    with pytest.raises(ConfigError, match=r"this needs ntcore of WPILib, which cannot be imported .* installs it"):
        load("ntcore")


def test_failing_imports_of_the_robot_program_are_reported(tmp_path, monkeypatch):
    """A missing library is reported with the extra that installs it; optional libraries and tests do not count."""
    assert [f.level for f in doctor.check_imports(tmp_path)] == ["warn"]
    vendors = tmp_path / "vendors"
    vendors.mkdir()
    (vendors / "of_a_vendor.py").write_text("raise ImportError('DLL load failed')")
    monkeypatch.setenv("PYTHONPATH", str(vendors))
    monkeypatch.syspath_prepend(str(vendors))
    project = tmp_path / "robot"
    (project / "subsystems").mkdir(parents=True)
    (project / "tests").mkdir()
    (project / "robot.py").write_text(
        "import os, subsystems.arm, constants\ntry:\n    import nowhere\nexcept E: pass\n"
    )
    (project / "constants.py").write_text("import numpy as np, of_a_vendor\nimport broken.\n")
    (project / "subsystems" / "arm.py").write_text("from . import other\nfrom phoenix6.hardware import TalonFX\n")
    (project / "tests" / "test_it.py").write_text("import not_there")
    monkeypatch.setattr(
        doctor, "find_spec", lambda name: None if name == "phoenix6" else importlib.util.find_spec(name)
    )
    missing, fine = doctor.check_imports(project)
    assert missing.text == "subsystems/arm.py imports phoenix6, which is not installed" and missing.level == "fail"
    assert missing.advice == install_command("phoenix6")
    (project / "constants.py").write_text("import numpy as np, of_a_vendor\n")
    _, broken, fine = sorted(doctor.check_imports(project), key=lambda found: found.text != missing.text)
    assert (broken.level, broken.text) == ("fail", "of_a_vendor does not load: ImportError: DLL load failed")
    assert fine == Finding("imports", "robot.py is here; numpy can be imported")


@pytest.mark.parametrize(("milliseconds", "level"), [(1.0, "ok"), (9.0, "warn"), (25.0, "fail")])
def test_a_computer_too_slow_for_real_time_is_reported(milliseconds, level, monkeypatch):
    clock = iter(range(10**6))
    monkeypatch.setattr(doctor.time, "perf_counter", lambda: next(clock) * 1e-3 * milliseconds)
    *_, found = doctor.check_run()
    assert found.level == level and f"a tick takes {milliseconds:.1f} of its 20 ms" in found.text


def test_a_run_that_cannot_be_played_is_reported(monkeypatch):
    def games(found):
        monkeypatch.setattr("simcore.match.registry.installed_games", found)
        return list(doctor.check_run())

    def broken(*_, **__):
        raise ImportError("DLL load failed")

    assert [f.text for f in games(lambda say: {})] == ["no game is installed"]
    assert [f.text for f in games(broken)] == ["the match does not run: ImportError: DLL load failed"]
    left, none = games(lambda say: say("left out: game mine: mine/autos.py, line 42: NameError") or {})
    assert left.level == "warn" and "mine/autos.py, line 42" in left.text and "uninstall its package" in left.advice
    assert none.level == "fail"


def parsed(*words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    doctor.add_arguments(parser)
    return parser.parse_args(words)


def test_doctor_checks_this_computer_and_advises_on_every_finding_that_is_not_ok(tmp_path, capsys):
    status = doctor.run(parsed("--json", "--folder", str(tmp_path)))
    report = json.loads(capsys.readouterr().out)
    levels = {row["check"]: row["level"] for row in report["findings"]}
    assert report["ok"] == (status == 0) == ("fail" not in levels.values())
    assert (levels["Python"], levels["robot.py"]) == ("ok", "warn") and "run" in levels
    assert all(row["advice"] for row in report["findings"] if row["level"] != "ok")


def test_a_failed_check_gives_exit_status_1_and_a_row_with_a_remedy(tmp_path, capsys):
    (tmp_path / "robot.py").write_text("import no_such_library")
    assert doctor.run(parsed("--no-physics", "--folder", str(tmp_path))) == 1
    said = capsys.readouterr().out
    assert "no_such_library" in said and "do this:" in said and "must be fixed" in said


@each("encoding", ["utf-8", "cp1252", "ascii"])
def test_the_table_can_be_printed_on_any_terminal(encoding):
    file = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    findings = [Finding("a", "ä [b]"), Finding("c", "d", "e", "warn"), Finding("f", "g" * 200, "h", "fail")]
    doctor.print_findings(findings, Console(file=file, width=80))
    file.seek(0)
    lines = file.read().splitlines()
    assert max(map(len, lines)) <= 80
    assert "1 of these must be fixed" in lines[-1]
    assert any("[b]" in line for line in lines), "square brackets are no markup"


def test_the_check_loads_no_vendor_library():
    """The check must work even if vendor libraries are missing."""
    code = (
        "import sys, simcore.robotcode.sim.doctor\n"
        "assert not {'wpilib', 'hal', 'phoenix6', 'pyfrc', 'pybullet', 'mujoco'} & set(sys.modules)"
    )
    root = str(Path(__file__).resolve().parents[3])
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60, env={**os.environ, "PYTHONPATH": root})
