"""A program in C++, RobotPy or Java runs bit-identically over the bridge, and almost equally in process."""

from __future__ import annotations

import json
import math
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

PROGRAMS = Path(__file__).parent / "programs"
TANK = Path(__file__).parents[2] / "examples" / "cpp_tank"
SECONDS = {"tank": 6.0, "swerve": 6.0, "elevator": 10.0, "arm": 5.5}
"""Seconds of the auto; elevator and arm have reached their goals by then."""

IN_PROCESS = """
import json
from pathlib import Path

def test_auto(sim):
    sim.autonomous(seconds={seconds})
    places = {{name: m.position for name, m in sim.robot_sim.mechanisms.items()}}
    way = sim.record.robots[0].distance
    Path("answer.json").write_text(json.dumps({{"pose": sim.robot_sim.chassis.pose, "way": way, **places}}))
"""


def _in_process(name: str, folder: Path) -> dict[str, object]:
    """Run the program as a robot project with simcore in its process; return pose, distance and positions."""
    (folder / "tests").mkdir()
    shutil.copy(PROGRAMS / f"{name}.py", folder / "robot.py")
    file = TANK / "simcore.toml" if name == "tank" else PROGRAMS / f"{name}.toml"
    shutil.copy(file, folder / "simcore.toml")
    (folder / "tests" / "test_auto.py").write_text(IN_PROCESS.format(seconds=SECONDS[name]))
    done = subprocess.run(
        [sys.executable, "-m", "robotpy", "test", "--", "-q"], cwd=folder, capture_output=True, text=True, timeout=300,
        check=False,
    )  # fmt: skip
    found = list(folder.rglob("answer.json"))
    assert found, done.stdout + done.stderr
    return dict(json.loads(found[0].read_text()))


@pytest.mark.slow
@pytest.mark.parametrize("name", SECONDS)
def test_cpp_and_python_programs_run_identically(name, compiled, play, tmp_path):
    """The digest covers every tick. In process, ticks are split differently, so positions agree within 0.5 %."""
    cpp = play(f"{name}.toml", SECONDS[name], str(compiled(name)))
    wired = play(f"{name}.toml", SECONDS[name], sys.executable, str(PROGRAMS / f"{name}.py"))
    assert cpp["digest"] == wired["digest"]
    if find_spec("pyfrc") is None:
        pytest.skip("in process it needs pyfrc: pip install .[robotpy]")
    here = _in_process(name, tmp_path)
    for mechanism in {"lift", "arm"} & here.keys():
        assert cpp[mechanism] == pytest.approx(here[mechanism], rel=0.005)
    way = here.pop("way")
    if way > 1.0:
        assert math.dist(cpp["pose"][:2], here["pose"][:2]) < 0.005 * way


def _jdk_17() -> str:
    """Return the folder of WPILib's native libraries; skip the test without JDK 17 or without wpilib."""
    found = shutil.which("javac") and subprocess.run(["javac", "-version"], capture_output=True, text=True, check=False)
    if not found or not (found.stdout + found.stderr).startswith("javac 17"):
        pytest.skip("needs JDK 17, whose foreign functions stand for WPILib's Java")
    native = find_spec("native.wpihal")
    if native is None or not native.submodule_search_locations:
        pytest.skip("needs the libraries that come with wpilib: pip install .[robotpy]")
    return str(Path(native.submodule_search_locations[0]).parent)


def test_the_java_example_has_the_robot_file_of_the_cpp_example():
    """Both examples describe one robot."""
    assert (TANK.parent / "java_tank" / "simcore.toml").read_text() == (TANK / "simcore.toml").read_text()


@pytest.mark.slow
def test_a_program_on_a_jvm_runs_identically_to_the_cpp_program(compiled, play, tmp_path):
    native = _jdk_17()
    module = ("--add-modules", "jdk.incubator.foreign")
    subprocess.run(["javac", *module, "-d", str(tmp_path), str(PROGRAMS / "HalTank.java")], check=True)
    libraries = [f"{native}/wpiutil/lib/libwpiutil.so", f"{native}/wpihal/lib/libwpiHal.so"]
    allowed = (*module, "--enable-native-access=ALL-UNNAMED")
    java = play("tank.toml", 5.0, "java", *allowed, "-cp", str(tmp_path), "HalTank", *libraries)
    assert java["digest"] == play("tank.toml", 5.0, str(compiled("tank")))["digest"]
