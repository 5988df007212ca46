"""Cache of compiled functions: folder, messages and failures."""

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


_SWINGING = """
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.chassis_config import ChassisConfig
from simcore.world.hanging import HangingBody, HangingConfig
from simcore.world.shapes import Box
from simcore.world.world import PhysicsWorld
cage = HangingConfig(name="cage", shape=Box((0.2, 0.2, 0.6)), mass=7.0, pivot=(2.0, 2.0, 1.5), drop=1.1)
plate = HangingConfig(name="plate", shape=Box((1.9, 1.6, 0.04)), mass=60.0, pivot=(5.0, 2.0, 0.16), drop=-0.03,
                      hinge="y", spring=800.0, drivable=True)
with PhysicsWorld() as world:
    bodies = [HangingBody(world, config) for config in (cage, plate)]
    robots = [ChassisSimulation(world, ChassisConfig(), pose=(0.0, y, 0.0)) for y in (0.0, 4.0)]
    for robot, place, speed in zip(robots, ((1.4, 1.9, 0.1), (5.4, 2.1, 0.25)), ((2.0, 0.0, 0.0), (0.0, 0.0, -1.0))):
        world.set_pose(robot.row, place)
        world.set_velocity(robot.row, speed)
    world.step(0.2)
    print(world.has_engine, *[body.is_awake for body in bodies], [body.quat + body.rate for body in bodies])
    print(world.bodies.records["pos"].tolist(), world.bodies.records["vel"].tolist())
"""


def run(program: str = _TICK, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", program], env={**os.environ, **environment}, capture_output=True, text=True, check=True
    )


def test_compiled_code_is_cached_next_to_the_sources_or_in_the_users_cache_folder():
    folder = Path(compiled.__file__).parent
    assert compiled.cache_folder is not None and compiled.cache_folder.name.startswith("simcore-")
    assert compiled.cache_folder.parent in (folder / "__pycache__", compiled._user_caches() / "simcore")
    assert compiled.is_prepared(), "this test run has compiled it"


def test_a_second_process_compiles_nothing_and_prints_nothing():
    done = run()
    assert done.stdout.split()[1] == "True" and "Preparing" not in done.stderr


def test_the_loop_code_also_runs_without_the_compiler():
    done = run(NUMBA_DISABLE_JIT="1")
    assert done.stdout.split() == ["None", "True"] and not done.stderr


def test_touching_bumpers_give_bit_identical_results_with_and_without_compilation():
    plain, made = run(_BUMPERS, NUMBA_DISABLE_JIT="1").stdout, run(_BUMPERS).stdout
    assert plain == made and plain.startswith("True True")


def test_swinging_bodies_give_bit_identical_results_with_and_without_compilation():
    plain, made = run(_SWINGING, NUMBA_DISABLE_JIT="1").stdout, run(_SWINGING).stdout
    assert plain == made and plain.startswith("False True True")


def test_the_cache_uses_the_first_writable_folder_or_no_folder(monkeypatch, tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    monkeypatch.setattr(compiled, "_HERE", blocked)
    monkeypatch.setattr(compiled, "_user_caches", lambda: blocked)
    monkeypatch.setattr(compiled.tempfile, "gettempdir", lambda: str(blocked))
    assert compiled._choose_folder() is None
    monkeypatch.setattr(compiled.tempfile, "gettempdir", lambda: str(tmp_path))
    assert compiled._choose_folder().parent.parent == tmp_path
    monkeypatch.setattr(compiled, "_user_caches", lambda: tmp_path)
    assert compiled._choose_folder().parent == tmp_path / "simcore"


def test_a_prepared_read_only_folder_is_used(monkeypatch, tmp_path):
    monkeypatch.setattr(compiled, "_HERE", tmp_path)
    folder = compiled._choose_folder()
    for name in compiled._PREPARED:
        (folder / f"{name}-1.py{sys.version_info[0]}{sys.version_info[1]}.nbi").touch()
    monkeypatch.setattr(compiled, "_is_writable", lambda folder: False)
    assert compiled._choose_folder() == folder


def test_the_start_and_the_duration_of_a_slow_compilation_are_printed(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(compiled, "_said", set())
    monkeypatch.setattr(compiled, "cache_folder", tmp_path)
    with compiled.preparing("a.function_of_nobody"):
        pass
    assert capsys.readouterr().err == (
        f"Preparing the physics for this computer ...\n... a in 0 s, kept in {tmp_path}\n"
    )


_SMALL = """
from simcore.loop import compiled
def twice(x):
    return 2.0 * x
print(compiled.compiled(twice)(3.0), compiled.not_kept)
"""


def small(folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a small compiled function in a new process that keeps its cache in a folder."""
    script = folder / "small.py"
    if not script.exists():
        script.write_text(
            _SMALL.replace("import compiled\n", f"import compiled\ncompiled.cache_folder = {str(folder)!r}\n")
        )
    return subprocess.run([sys.executable, str(script)], capture_output=True, text=True, check=True)


@pytest.mark.parametrize("kind", ["nbi", "nbc"])
@pytest.mark.parametrize("content", [b"", b"half", b"\x80\x05garbage."])
def test_a_damaged_cache_file_is_compiled_again_with_a_one_sentence_message(kind, content, tmp_path):
    assert small(tmp_path).stdout == "6.0 \n"
    (file,) = tmp_path.rglob(f"*.{kind}")
    file.write_bytes(content)
    done = small(tmp_path)
    assert done.stdout == "6.0 \n"
    assert done.stderr.count("is damaged") == 1 and len(done.stderr.splitlines()) == 1
    assert small(tmp_path).stderr == ""


@pytest.mark.skipif(sys.platform != "linux", reason="a device that is full")
def test_a_function_runs_although_a_full_disk_prevents_caching(monkeypatch, tmp_path):
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(compiled, "cache_folder", tmp_path)
    monkeypatch.setattr(compiled, "not_kept", "")
    twice = compiled.compiled(lambda x: 2.0 * x)
    monkeypatch.setattr(twice._cache._cache_file, "save", full)
    assert twice(3.0) == 6.0
    assert compiled.not_kept == f"{twice._cache.cache_path} cannot be written: No space left on device"


def test_one_process_compiles_while_the_others_wait(tmp_path):
    script = f"""
import sys, time
from pathlib import Path
from simcore.loop import compiled
compiled.cache_folder = Path({str(tmp_path)!r})
with compiled.preparing("a.slow"):
    if not compiled.is_prepared(["a.slow"]):
        time.sleep(0.5)
        (compiled.cache_folder / f"a.slow-1.py{{sys.version_info[0]}}{{sys.version_info[1]}}.nbi").touch()
        print("compiled")
"""
    started = [subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) for _ in range(3)]
    assert sorted(one.communicate(timeout=60)[0] for one in started) == ["", "", "compiled\n"]


@pytest.mark.parametrize("system", ["win32", "darwin", "linux"])
def test_each_operating_system_has_its_own_cache_folder(system, monkeypatch, tmp_path):
    monkeypatch.setattr(compiled.sys, "platform", system)
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "local"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    wanted = {"win32": tmp_path / "local", "darwin": Path.home() / "Library" / "Caches", "linux": tmp_path / "xdg"}
    assert compiled._user_caches() == wanted[system]
