"""Where what is compiled is kept, and what is said about it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from simcore.loop import compiled

_TICK = """
from simcore.loop.step import prepare
from simcore.loop import compiled
prepare()
print(compiled.cache_folder, compiled.is_prepared())
"""


_BUMPERS = """
from simcore.match.game import Game, RobotEntry
from simcore.match.match import Match
starts = (5.38, 1.0, 0.0), (4.57, 1.0, 0.0)  # bumper to bumper, and 2 cm from the wall of the field
with Match(Game.bare(size=(5.8, 2.0)), robots=[RobotEntry(start=start) for start in starts], seed=1) as match:
    for robot in match.robots:
        robot.drive.set_volts([6.0] * 4, [0.1] * 4)
    match.play(0.2)
    touched = match.contacts.elements(0) != set(), match.contacts.robots != set()
    print(*touched, [robot.chassis.pos + robot.chassis.vel for robot in match.robots])
"""


def run(program: str = _TICK, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", program], env={**os.environ, **environment}, capture_output=True, text=True, check=True
    )


def test_what_is_compiled_is_kept_by_the_contents_of_its_sources():
    folder = Path(compiled.__file__).parent
    assert compiled.cache_folder is not None and compiled.cache_folder.name.startswith("simcore-")
    assert compiled.cache_folder.parent in (folder / "__pycache__", compiled._user_caches() / "simcore")
    assert compiled.is_prepared(), "this test run has compiled it"


def test_a_second_process_says_nothing_and_compiles_nothing():
    done = run()
    assert done.stdout.split()[1] == "True" and "Preparing" not in done.stderr


def test_without_the_compiler_the_same_lines_run():
    done = run(NUMBA_DISABLE_JIT="1")
    assert done.stdout.split() == ["None", "True"] and not done.stderr


def test_bumpers_that_touch_do_the_same_in_plain_python_to_the_last_bit():
    plain, made = run(_BUMPERS, NUMBA_DISABLE_JIT="1").stdout, run(_BUMPERS).stdout
    assert plain == made and plain.startswith("True True")


def test_folders_that_cannot_be_written_are_no_error(monkeypatch, tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    monkeypatch.setattr(compiled, "_HERE", blocked)
    monkeypatch.setattr(compiled, "_user_caches", lambda: blocked)
    assert compiled._choose_folder() is None
    monkeypatch.setattr(compiled, "_user_caches", lambda: tmp_path)
    assert compiled._choose_folder().parent == tmp_path / "simcore"


def test_it_is_said_once_before_something_is_compiled(monkeypatch, capsys):
    monkeypatch.setattr(compiled, "_told", False)
    compiled.announce("a.function_of_nobody")
    compiled.announce("a.function_of_nobody")
    assert capsys.readouterr().err == "Preparing the physics for this computer, once, half a minute ...\n"


@pytest.mark.parametrize("system", ["win32", "darwin", "linux"])
def test_each_system_has_its_place_for_caches(system, monkeypatch, tmp_path):
    monkeypatch.setattr(compiled.sys, "platform", system)
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "local"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    wanted = {"win32": tmp_path / "local", "darwin": Path.home() / "Library" / "Caches", "linux": tmp_path / "xdg"}
    assert compiled._user_caches() == wanted[system]
