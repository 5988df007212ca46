"""The examples as projects: what a deploy carries, what one does without PathPlanner, and their own tests."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

import simcore

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = Path(simcore.__file__).resolve().parents[1]
EXAMPLE = ROOT / "examples" / "rebuilt_robot"
DESCRIBED = ROOT / "examples" / "reefscape_robot"
"""The one that a simcore.toml describes."""

DIGEST = """
def test_two_coral(sim):
    sim.autonomous("two coral", seconds=10)
    assert sim.score.blue >= 14 and sim.match.count.is_conserved and sim.own_threads == []
    with open("digests", "a") as file:
        file.write(f"{sim.digest}\\n")
"""


@pytest.fixture
def project(request, tmp_path):
    """A copy without what earlier runs left."""
    if find_spec("phoenix6") is None or find_spec("pyfrc") is None:
        pytest.skip("needs phoenix6 and pyfrc: pip install .[phoenix6,robotpy]")
    folder = tmp_path / "project"
    shutil.copytree(
        getattr(request, "param", EXAMPLE),
        folder,
        ignore=shutil.ignore_patterns("ctre_sim", "__pycache__", "networktables*"),
    )
    return folder


def run(
    *command: str, cwd: Path, path: tuple[Path, ...] = (), timeout: float = 90.0
) -> subprocess.CompletedProcess[str]:
    """In a folder of its own, with our packages but without entry points, unless a path has them."""
    return subprocess.run(
        [sys.executable, *command],
        cwd=cwd,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(map(str, (*path, PACKAGES, cwd)))},
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
    )


@pytest.mark.slow
@pytest.mark.parametrize("absent", [(), ("pathplannerlib",)], ids=["complete", "without PathPlanner"])
def test_what_a_deploy_copies_starts_without_the_simulation(scenario, absent):
    """simcore, its games and pyfrc are not on a robot. PathPlanner may be missing: then the robot says so."""
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
def test_what_a_deploy_copies_of_a_described_robot_starts_too(scenario):
    pytest.importorskip("robotpy_installer", reason="needs robotpy deploy: pip install robotpy")
    done = scenario("deployed", str(DESCRIBED))
    assert done["loaded"] == [] and set(done["autos"]) == {"two coral", "nothing"}
    assert "physics.py" not in done["files"]


@pytest.mark.slow
@pytest.mark.parametrize("project", [DESCRIBED], indirect=True, ids=["reefscape"])
def test_a_described_robot_scores_two_coral(project, distribution, whole):
    """As red; in full also everything else that its tests ask, and five processes with one digest."""
    chosen = () if whole else ("-k", "red")
    done = run("-m", "robotpy", "test", "--", "-q", *chosen, cwd=project, path=(distribution,), timeout=600.0)
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]
    assert f"{6 if whole else 1} passed" in done.stdout
    if not whole:
        return
    (project / "tests" / "digest_test.py").write_text(DIGEST)
    for _ in range(5):
        done = run(
            *("-m", "robotpy", "test", "--", "-q", "tests/digest_test.py"),
            cwd=project,
            path=(distribution,),
            timeout=300.0,
        )
        assert done.returncode == 0, done.stdout[-4000:]
    first, *others = (project / "digests").read_text().splitlines()
    assert others == [first] * 4


@pytest.mark.slow
@pytest.mark.parametrize("folder", sorted((ROOT / "examples").glob("*/tests")), ids=lambda path: path.parent.name)
def test_pytest_finds_the_tests_of_an_example_where_it_lies(folder, distribution):
    """The checkout around it has settings of its own, which leave the examples out."""
    if find_spec("phoenix6") is None or find_spec("pyfrc") is None:
        pytest.skip("needs phoenix6 and pyfrc: pip install .[phoenix6,robotpy]")
    done = run(
        *("-m", "pytest", "-q", "--collect-only", "-p", "no:cacheprovider"), cwd=folder.parent, path=(distribution,)
    )
    files = {line.split("::")[0] for line in done.stdout.splitlines() if "::" in line}
    assert files == {f"tests/{path.name}" for path in folder.glob("*_test.py")}, done.stdout


@pytest.mark.slow
def test_the_camera_reader_and_its_filters(project):
    """The example's own unit tests, which need no robot."""
    done = run("-m", "pytest", "-q", "-c", os.devnull, "--rootdir", ".", "tests/vision_test.py", cwd=project)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    assert " passed" in done.stdout and "skipped" not in done.stdout


@pytest.mark.slow
@pytest.mark.realtime
def test_robotpy_test_passes(project):
    done = run("-m", "robotpy", "test", cwd=project, timeout=180.0)
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]


@pytest.mark.slow
@pytest.mark.realtime
def test_keys_drive_take_in_and_shoot(scenario):
    """Through the simulator's window on a virtual screen: W A S D, Q E, M, comma, period, slash."""
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
