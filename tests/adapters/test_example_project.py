"""Examples as projects: the deployed files, a start without PathPlanner, and their own tests."""

from __future__ import annotations

import os
import shutil
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "examples" / "rebuilt_robot"
DESCRIBED = ROOT / "examples" / "reefscape_robot"
"""Example described by a simcore.toml."""

DIGEST = """
def test_two_coral(sim):
    sim.autonomous("two coral", seconds=10)
    assert sim.score.blue >= 14 and sim.match.count.is_conserved and sim.own_threads == []
    with open("digests", "a") as file:
        file.write(f"{sim.digest}\\n")
"""


@pytest.fixture
def project(request, tmp_path):
    """Return a copy of an example without files of earlier runs."""
    if find_spec("phoenix6") is None or find_spec("pyfrc") is None:
        pytest.skip("needs phoenix6 and pyfrc: pip install .[phoenix6,robotpy]")
    folder = tmp_path / "project"
    shutil.copytree(
        getattr(request, "param", EXAMPLE),
        folder,
        ignore=shutil.ignore_patterns("ctre_sim", "__pycache__", "networktables*"),
    )
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("absent", [(), ("pathplannerlib",)], ids=["complete", "without PathPlanner"])
def test_the_deployed_program_starts_without_the_simulation(scenario, absent):
    """A robot has no simcore, games or pyfrc. If PathPlanner is missing, the program reports it and starts."""
    pytest.importorskip("robotpy_installer", reason="needs robotpy deploy: pip install robotpy")
    if not absent:
        pytest.importorskip("pathplannerlib", reason="needs PathPlanner: pip install robotpy-pathplannerlib")
    done = scenario("deployed", str(EXAMPLE), *absent)
    assert done["loaded"] == []
    assert {"robot.py", "deploy/pathplanner/autos/neutral.auto"} <= set(done["files"])
    assert {"depot", "preload", "nothing"} <= set(done["autos"])
    assert ("neutral (PathPlanner)" in done["autos"]) == (not absent)
    assert ("no PathPlanner autos (neutral): No module named 'pathplannerlib" in done["output"]) == bool(absent)


@pytest.mark.slow
def test_a_deployed_program_with_a_simcore_toml_starts_without_the_simulation(scenario):
    pytest.importorskip("robotpy_installer", reason="needs robotpy deploy: pip install robotpy")
    done = scenario("deployed", str(DESCRIBED))
    assert done["loaded"] == [] and set(done["autos"]) == {"two coral", "nothing"}
    assert "physics.py" not in done["files"]


@pytest.mark.slow
@pytest.mark.parametrize("project", [DESCRIBED], indirect=True, ids=["reefscape"])
def test_a_robot_described_by_its_file_scores_two_coral(project, python, whole):
    """The robot is red; `--whole` adds its other tests and the digest of five processes."""
    test = ("-m", "robotpy", "test", "--", "-q")
    code, said = python(project, *test, *(() if whole else ("-k", "red")))
    assert code == 0 and f"{6 if whole else 1} passed" in said, said[-4000:]
    if not whole:
        return
    (project / "tests" / "digest_test.py").write_text(DIGEST)
    for _ in range(5):
        code, said = python(project, *test, "tests/digest_test.py")
        assert code == 0, said[-4000:]
    first, *others = (project / "digests").read_text().splitlines()
    assert others == [first] * 4


@pytest.mark.slow
@pytest.mark.parametrize("folder", sorted((ROOT / "examples").glob("*/tests")), ids=lambda path: path.parent.name)
def test_pytest_collects_the_tests_of_an_example_in_its_folder(folder, python):
    """The settings of this checkout would leave the examples out."""
    if find_spec("phoenix6") is None or find_spec("pyfrc") is None:
        pytest.skip("needs phoenix6 and pyfrc: pip install .[phoenix6,robotpy]")
    _, said = python(folder.parent, "-m", "pytest", "-q", "--collect-only", "-p", "no:cacheprovider")
    files = {line.split("::")[0] for line in said.splitlines() if "::" in line}
    assert files == {f"tests/{path.name}" for path in folder.glob("*_test.py")}, said


@pytest.mark.slow
def test_the_unit_tests_of_the_examples_camera_reader_pass(project, python):
    """These tests need no robot."""
    code, said = python(project, "-m", "pytest", "-q", "-c", os.devnull, "--rootdir", ".", "tests/vision_test.py")
    assert code == 0 and " passed" in said and "skipped" not in said, said[-4000:]


@pytest.mark.slow
def test_robotpy_test_passes_in_the_example(project, python):
    code, said = python(project, "-m", "robotpy", "test")
    assert code == 0, said[-6000:]


@pytest.mark.slow
@pytest.mark.realtime
def test_keyboard_keys_drive_the_robot_take_in_fuel_and_shoot(scenario):
    """Keys go to the simulator's window on a virtual screen: W A S D, Q E, M, comma, period, slash."""
    for tool in ("Xvfb", "xdotool"):
        if shutil.which(tool) is None:
            pytest.skip(f"needs {tool} for a virtual screen: apt-get install xvfb xdotool")
    pytest.importorskip("halsim_gui", reason="needs the simulator's window: pip install robotpy-halsim-gui")
    run = scenario("keyboard", str(EXAMPLE))
    did = run["did"]
    assert did["w"]["x"] > 0.3 and did["s"]["x"] < -0.3
    assert did["a"]["y"] > 0.3 and did["d"]["y"] < -0.3
    assert did["q"]["yaw"] > 0.2 and did["e"]["yaw"] < -0.2
    assert did["period"]["hood_deg"] > 3.0 and did["comma"]["hood_deg"] < -1.0
    assert did["m"]["intake"] > 0.8
    assert did["slash"]["shots"] == 8 and run["hits"] >= 7
