"""Twelve robot programs shaped as teams write theirs, with no line of code for simcore: the same course for each.

Real time under `robotpy sim --simcore`, simulated time under `robotpy test` and `pytest`, their own tests beside. Three
of them have a `described.toml`: what `simcore init` writes, filled in as a student would.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path

import pytest

import simcore

pytestmark = pytest.mark.slow

PACKAGES = Path(simcore.__file__).resolve().parents[1]
ROBOTS, SCENARIOS = (Path(__file__).parent / name for name in ("robots", "scenarios"))
EVERYBODY_NEEDS = ("phoenix6", "wpilib", "commands2", "pyfrc")


@dataclass(frozen=True, kw_only=True)
class Team:
    """What is special about a robot program."""

    sticks: str
    """What they mean: directions of the `field`, or of the `robot`."""
    needs: tuple[str, ...] = ()
    """Modules without which it cannot start."""
    believes: tuple[float, float] | None = (0.0, 0.0)
    """Where its odometry stands before anybody moves [m]; None: it goes on to be told, or chance decides."""
    sees_within: float | None = None
    """How far from the truth cameras keep its odometry, after 5 m [m]; None: it has none that say where it is."""
    pressed: dict[str, float] = field(default_factory=dict)
    """What its mechanisms show after 1.5 s of its buttons, within 10 % (0: within 0.02)."""
    stops: tuple[str, ...] = ()
    """Which of them stand still 2 s after the buttons were let go, coasting."""
    says: tuple[str, ...] = ()
    """In the log of who moves what."""
    own_tests: int = 0
    """Beside those that pyfrc brings."""


DRIVETRAIN = "drivetrain TalonFX 1-4 11-14, CANcoder 21-24, Pigeon2 9"
TEAMS = {
    "generated": Team(
        sticks="field",
        needs=("pathplannerlib",),
        says=("drivetrain TalonFX 1-8, CANcoder 11-14, Pigeon2 20",),
        own_tests=1,
    ),
    "timed": Team(
        sticks="field",
        pressed={"wheels": 45.0},
        stops=("feeder", "roller"),
        says=(DRIVETRAIN, "TalonFX 31 + 32", "TalonFX 33:", "TalonFX 34:", "TalonFX 35:"),
    ),
    "paths": Team(
        sticks="field",
        needs=("pathplannerlib",),
        pressed={"wheels": 45.0},
        stops=("feeder", "roller"),
        says=("drivetrain TalonFX 1-8, CANcoder 1-4, Pigeon2 0", "TalonFX 44 + 45", "TalonFX 43:"),
    ),
    "magic": Team(sticks="field", needs=("magicbot",), believes=(2.0, 1.2), pressed={"wheels": 40.0}),
    "slow_magic": Team(sticks="robot", needs=("magicbot",), pressed={"lift": 2.0, "arm": 0.2}),
    "logged": Team(sticks="field", pressed={"arm": 0.25}, says=(DRIVETRAIN,)),
    "photon": Team(
        sticks="robot",
        needs=("photonlibpy", "cv2", "robotpy_apriltag"),
        believes=None,
        sees_within=0.05,
    ),
    "quest": Team(sticks="field", believes=None, says=("CANdle 30", "CANrange 31", "TalonFX 32:")),
    "sparks": Team(
        sticks="robot",
        needs=("rev",),
        pressed={"rpm": 3000.0, "arm": 0.25},
        stops=("rpm",),
        says=("SPARK MAX 31 + 32", "SPARK Flex 33", "SPARK MAX 34"),
    ),
    "pwm": Team(sticks="robot", says=("PWM 0 4 (PWMSparkMax)", "DIO 3 (DigitalInput)", "PWM 5 (Servo)")),
    "physics": Team(
        sticks="robot", believes=None, pressed={"height": 2.0}, says=("own physics TalonFX 40", "TalonFX 41:")
    ),
    "turret": Team(sticks="field", stops=("feeder",), pressed={"aim": 0.0}, says=("TalonFX 39 + 40", "CANrange 42")),
}
IN_REAL_TIME = ("generated", "sparks")
IN_SIMULATED_TIME = ("generated",)  # own loops: test_attach; own physics: test_shapes
DESCRIBED = ("timed", "paths", "turret")
SCORED = ("turret",)


@pytest.fixture(scope="module")
def project(tmp_path_factory, distribution, drawn) -> Callable[..., Path]:
    """Copies a robot program by its name, with a library of measures as its own; `described` adds its simcore.toml."""

    def copy(name: str, *, described: bool = False) -> Path:
        for module in (*EVERYBODY_NEEDS, *TEAMS[name].needs):
            if find_spec(module) is None:
                pytest.skip(f"{name} needs {module}, which is not installed")
        folder = tmp_path_factory.mktemp(name) / name
        shutil.copytree(ROBOTS / f"team_{name}", folder, ignore=shutil.ignore_patterns("__pycache__"))
        for library in ("measures.py", "questnav.py", "logged_robot.py"):
            shutil.copy(ROBOTS / "shared" / library, folder)
        drawn(folder, f"team_{name}")
        (folder / "tests").mkdir(exist_ok=True)
        (folder / "tests" / "pyfrc_test.py").write_text("from pyfrc.tests import *\n")
        if (folder / "described.toml").exists():
            (folder / "described.toml").rename(folder / ("simcore.toml" if described else "unused.toml"))
        return folder

    return copy


@pytest.fixture(scope="module")
def python(distribution) -> Callable[..., tuple[int, str]]:
    """Runs Python in a folder, and returns its code and what it printed."""

    def run(folder: Path, *arguments: str) -> tuple[int, str]:
        places = (distribution, PACKAGES, ROBOTS / "shared")
        path = os.pathsep.join([*map(str, places), *filter(None, [os.environ.get("PYTHONPATH")])])
        done = subprocess.run(
            [sys.executable, *arguments],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": path},
            capture_output=True,
            text=True,
            timeout=400,
            check=False,
        )
        return done.returncode, done.stdout + done.stderr

    return run


def in_sample(request, sample: tuple[str, ...]) -> str:
    """The robot's name; skips those that are run with --whole only."""
    if request.param not in sample and not request.config.getoption("--whole"):
        pytest.skip("not in the sample: --whole runs all twelve")
    return str(request.param)


def error_lines(text: str) -> list[str]:
    """Lines that a team would take for a fault; a loop of the robot that took too long is not one of simcore's."""
    wanted = re.compile(r"Traceback|NotImplementedError|Segmentation|\bERROR\b|stale|terminate called|Fatal")
    return [line for line in text.splitlines() if wanted.search(line)]


def check(run: dict, team: Team) -> None:
    """What holds of the course in either time."""
    if team.believes is not None:
        assert run["crept"] < 0.008, "odometry moves though the robot stands"
        assert run["believed_start"][:2] == pytest.approx(team.believes, abs=0.005)
    assert 5.0 < run["true_way"] < 6.0
    assert run["off"] < 0.03 * run["true_way"]
    if team.sees_within is not None:
        assert run["apart"] < team.sees_within
    assert run["pushed"] >= 8
    assert -0.01 < run["gap_at_wall"] < 0.08  # pressed on with all its grip
    assert run["speed_at_wall"] < 0.05
    assert run["counted"] == run["staged"]
    assert run["min_volts"] > 4.0, "for one step of 5 ms; then the roboRIO has cut the outputs"
    for name, goal in team.pressed.items():
        assert run["pressed"][name] == pytest.approx(goal, rel=0.1, abs=0.02), name
    for name in team.stops:
        assert abs(run["pressed"][name]) > 1.0
        assert abs(run["released"][name]) < 0.1 * abs(run["pressed"][name]), f"{name} goes on turning"


# --- real time ----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module", params=TEAMS)
def real_run(request, project, python):
    name = in_sample(request, IN_REAL_TIME)
    code, said = python(project(name), str(SCENARIOS / "team_course.py"), TEAMS[name].sticks)
    assert code == 0, said[-4000:]
    result = json.loads(next(line for line in reversed(said.splitlines()) if line.startswith('{"')))
    return {**result, "name": name, "said": said}


@pytest.mark.realtime
def test_the_course_in_real_time(real_run):
    check(real_run, TEAMS[real_run["name"]])


@pytest.mark.realtime
def test_the_log_says_who_moves_what_and_nothing_alarming(real_run):
    for words in TEAMS[real_run["name"]].says:
        assert words in " ".join(real_run["said"].split())
    if real_run["lateness_ms"] < 5.0:
        assert error_lines(real_run["said"]) == []


# --- simulated time -----------------------------------------------------------------------------------------------

COURSE = """
import json

from course import Course


def test_course(sim):
    sim.start()
    course = Course(sim.physics, is_field_centric=FIELD, enable=sim.teleop)
    for _ in course.run():
        sim.run(0.02)
    print("COURSE", json.dumps(course.results))
"""


@pytest.fixture(scope="module", params=TEAMS)
def simulated_runs(request, project, python):
    """With the team's own tests, and alone: two processes."""
    name = in_sample(request, IN_SIMULATED_TIME)
    folder = project(name)
    (folder / "tests" / "course_test.py").write_text(COURSE.replace("FIELD", str(TEAMS[name].sticks == "field")))
    chosen = () if request.config.getoption("--whole") else ("-k", "course or autonomous")
    whole = python(folder, "-m", "robotpy", "test", "--", "-rA", *chosen)
    alone = python(folder, "-m", "robotpy", "test", "--", "-rA", "tests/course_test.py")
    results = []
    for _, said in (whole, alone):
        line = next((line for line in said.splitlines() if line.startswith("COURSE")), None)
        results.append({} if line is None else json.loads(line.removeprefix("COURSE")))
    return {"name": name, "whole": whole, "alone": alone, "results": results}


def test_the_course_in_simulated_time(simulated_runs):
    code, said = simulated_runs["alone"]
    assert code == 0, said[-4000:]
    check(simulated_runs["results"][1], TEAMS[simulated_runs["name"]])


def test_its_own_tests_pass_and_end_well(simulated_runs, whole):
    code, said = simulated_runs["whole"]
    assert code == 0, said[-4000:]
    own = TEAMS[simulated_runs["name"]].own_tests
    assert f"{5 + own if whole else 2 + own} passed" in said
    assert error_lines(said) == []


def test_two_processes_agree_to_the_last_bit(simulated_runs):
    first, second = simulated_runs["results"]
    assert first["digest"] == second["digest"]
    assert first == second


# --- described robots ---------------------------------------------------------------------------------------------

SCORES = """
X = 3


def test_the_auto_takes_in_and_scores(sim):
    sim.autonomous(seconds=20.0)
    print("AUTO", sim.score, sim.pieces.held, len(sim.match.record.taken_in))
    assert len(sim.match.record.taken_in) >= 12
    assert sim.score.blue >= 20 and sim.score.red == 0


def test_nothing_leaves_after_the_trigger(sim):
    pad = sim.xbox(0)
    sim.teleop()
    pad.x = True
    sim.run_until(lambda: len(sim.match.record.shots) >= 3, timeout=4.0)
    pad.x = False
    sim.run(0.6)  # feeders that coast, with the friction of unmeasured ones
    left = len(sim.match.record.shots)
    assert left <= 5
    sim.run(3.0)
    print("SHOTS", left, len(sim.match.record.shots))
    assert len(sim.match.record.shots) == left
    assert sim.pieces.held == 8 - left
"""


@pytest.fixture(params=DESCRIBED)
def described(request):
    return in_sample(request, SCORED)


def test_a_described_robot_scores_and_stops_shooting(described, project, python):
    folder = project(described, described=True)
    (folder / "tests" / "score_test.py").write_text(SCORES)
    code, said = python(folder, "-m", "pytest", "-rA", "tests/score_test.py")
    assert code == 0, said[-4000:]


def test_init_finds_every_motor_that_the_file_names(described, project, python):
    folder = project(described, described=True)
    wanted = set(re.findall(r"^leader = (\d+)", (folder / "simcore.toml").read_text(), re.MULTILINE))
    (folder / "simcore.toml").unlink()
    code, said = python(folder, "-m", "simcore", "init")
    assert code == 0, said
    text = (folder / "simcore.toml").read_text()
    found = {*re.findall(r"leader = (\d+)", text), *re.findall(r"', [\w ]+ (\d+), stays a guess", text)}
    assert wanted <= found, said
