"""Robots whose drivetrains are their own, shaped as teams write them, with no line of code for simcore."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

import simcore

pytestmark = pytest.mark.slow

PACKAGES = Path(simcore.__file__).resolve().parents[1]
ROBOTS = Path(__file__).parent / "robots"
NEEDS = ("wpilib", "pyfrc", "phoenix6", "rev", "commands2", "magicbot")
FOUND = {
    "maxswerve": ("swerve", "SPARK MAX", "wired"),
    "spark_cancoder": ("swerve", "SPARK MAX", "CANcoder"),
    "talons": ("swerve", "TalonFX", "CANcoder"),
    "rio_loops": ("swerve", "PWM", "DutyCycleEncoder"),
    "magic": ("swerve", "TalonFX", "AnalogEncoder"),
    "six": ("swerve", "SPARK Flex", "wired"),
    "tank_sparks": ("tank", "SPARK MAX", None),
    "tank_pwm": ("tank", "PWM", None),
    "tank_groups": ("tank", "PWM", None),
    "mecanum": ("mecanum", "TalonFX", None),
}
"""Kind, controller of the drive motors and encoder of the azimuths, as simcore finds them."""
SAMPLE = ("maxswerve", "tank_groups", "mecanum")
"""Those that are run without --whole."""


@pytest.fixture(scope="module")
def project(tmp_path_factory, distribution) -> Callable[[str], Path]:
    def copy(name: str) -> Path:
        for module in NEEDS:
            if find_spec(module) is None:
                pytest.skip(f"needs {module}, which is not installed")
        folder = tmp_path_factory.mktemp(name) / name
        shutil.copytree(ROBOTS / f"own_{name}", folder, ignore=shutil.ignore_patterns("__pycache__"))
        (folder / "tests").mkdir()
        shutil.copy(ROBOTS / "shared" / "own_course.py", folder / "tests" / "course_test.py")
        return folder

    return copy


@pytest.fixture(scope="module")
def python(distribution) -> Callable[..., str]:
    """Runs Python in a folder and returns what it printed; it must end well."""

    def run(folder: Path, *arguments: str, fails: bool = False) -> str:
        path = os.pathsep.join([*map(str, (distribution, PACKAGES)), *filter(None, [os.environ.get("PYTHONPATH")])])
        done = subprocess.run(
            [sys.executable, *arguments],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": path},
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
        said = done.stdout + done.stderr
        assert (done.returncode != 0) is fails, said
        return said

    return run


@pytest.fixture
def driven(project, python) -> Callable[[Path], dict[str, Any]]:
    """Runs the course in a process of its own."""

    def drive(folder: Path) -> dict[str, Any]:
        python(folder, "-m", "robotpy", "test", "--", "-q", "-p", "no:cacheprovider", "tests/course_test.py")
        facts: dict[str, Any] = json.loads((folder / "facts.json").read_text())
        return facts

    return drive


def sampled(name: str, request: pytest.FixtureRequest) -> str:
    if name not in SAMPLE and not request.config.getoption("--whole"):
        pytest.skip("not in the sample: --whole runs all of them")
    return name


def require_course(facts: dict[str, Any]) -> None:
    (true, _), (told, _) = facts["true"], facts["told"]
    assert true > 5.0 and abs(told - true) < 0.05 * true
    assert facts["pushed"] > 50 and not facts["warned"]
    assert abs(facts["at_wall"]) < 0.06 and abs(facts["speed_at_wall"]) < 0.01
    if facts["holonomic"]:
        true, told = facts["true_left"][1], facts["told_left"][1]
        assert true > 1.5 and abs(told - true) < 0.05 * true


@pytest.mark.parametrize("name", FOUND)
def test_it_drives_as_its_odometry_says_the_same_in_two_processes(name, project, driven, request):
    folder = project(sampled(name, request))
    first, second = driven(folder), driven(folder)
    require_course(first)
    assert first == second


@pytest.mark.parametrize("name", FOUND)
def test_what_init_writes_drives_the_same(name, project, driven, python, request):
    folder = project(sampled(name, request))
    plain = driven(folder)
    python(folder, "-m", "simcore", "init")
    kind, controller, encoder = FOUND[name]
    text = (folder / "simcore.toml").read_text(encoding="utf-8")
    assert f'kind = "{kind}"' in text and f'controller = "{controller}"' in text
    assert encoder is None or f'encoder = "{encoder}"' in text
    described = driven(folder)
    assert [*plain] == [*described]
    for fact, value in plain.items():  # measures are written with seven digits, and fuel multiplies what they leave
        if fact not in ("digest", "pushed"):
            assert described[fact] == pytest.approx(value, rel=5e-3, abs=0.02), fact
    said = python(folder, "-m", "simcore", "check")
    assert f"note: {kind} drive: as simcore.toml says" in said and "nothing wrong" in said


AUTO = """
import math


def test_its_auto_ends_where_it_believes_and_scores(sim):
    worst = 0.0
    sim.autonomous(seconds=0.1)
    for _ in range(95):
        sim.run(0.2)
        told = sim.robot.container.drive.get_pose()
        worst = max(worst, math.dist((sim.pose.X(), sim.pose.Y()), (told.X(), told.Y())))
    end, estimates = math.dist((sim.pose.X(), sim.pose.Y()), (2.3, 5.4)), sim.robot.container.drive.vision.estimates
    off = math.dist((sim.pose.X(), sim.pose.Y()), (told.X(), told.Y()))
    turned = math.degrees((sim.pose.rotation() - told.rotation()).radians())
    record = sim.record
    print("AUTO", off, worst, end, turned, estimates, sim.score, len(record.taken_in), len(record.shots))
    assert estimates > 100
    assert off < 0.05 and abs(turned) < 1.0
    assert end < 0.25
    assert len(sim.match.record.taken_in) >= 8 and sim.score.blue >= 12 and sim.score.red == 0
"""
FILLED = {
    "# mass = 55.0": "mass = 57.0", "# bumper_length = 0.8": "bumper_length = 0.88",
    "# bumper_width = 0.8": "bumper_width = 0.86", "# capacity = 1": "capacity = 40",
    "\nx = 2.0": "\nx = 2.6", "\ny = 1.2": "\ny = 5.6", "\npreload = 0": "\npreload = 8",
}  # fmt: skip
"""What a student writes over what `init` proposes."""


def test_a_spark_swerve_with_a_camera_drives_its_drawn_auto_and_scores(tmp_path, python, drawn):
    """MAXSwerve modules, navX, a pose estimator that PhotonVision corrects, PathPlanner's auto through the depot."""
    for module in (*NEEDS, "navx", "pathplannerlib", "photonlibpy", "cv2", "robotpy_apriltag"):
        if find_spec(module) is None:
            pytest.skip(f"needs {module}, which is not installed")
    folder = tmp_path / "paths"
    (folder / "tests").mkdir(parents=True)
    for name, chosen in (
        ("own_maxswerve", "*.py"),
        ("team_photon", "vision.py"),
        ("own_paths", "*.*"),
    ):  # own come last
        for source in sorted((ROBOTS / name).glob(chosen)):
            shutil.copy(source, folder)
    drawn(folder, "own_paths")
    (folder / "tests" / "auto_test.py").write_text(AUTO)
    python(folder, "-m", "simcore", "init", "--all")
    file = folder / "simcore.toml"
    text = file.read_text(encoding="utf-8") + (folder / "filled.toml").read_text(encoding="utf-8")
    for proposed, true in FILLED.items():
        assert proposed in text
        text = text.replace(proposed, true, 1)
    file.write_text(text, encoding="utf-8")
    print(python(folder, "-m", "robotpy", "test", "--", "-q", "-rP", "-p", "no:cacheprovider", "tests/auto_test.py"))


def test_a_program_without_a_drivetrain_runs_without_a_field_and_its_tests_say_what_to_write(project, python):
    folder = project("maxswerve")
    (folder / "robot.py").write_text(
        "import wpilib\n\nclass Robot(wpilib.TimedRobot):\n    def robotPeriodic(self):\n"
        "        print('loop', wpilib.Timer.getFPGATimestamp() > 1.0, flush=True)\n"
        "        if wpilib.Timer.getFPGATimestamp() > 2.0:\n            raise SystemExit\n"
    )
    said = python(
        folder, "-m", "robotpy", "test", "--", "-q", "-p", "no:cacheprovider", "tests/course_test.py", fails=True
    )
    sentence = "no drivetrain found: the program builds none of"
    assert sentence in said and "[drivetrain] table in simcore.toml describes it" in said
    path = os.pathsep.join(map(str, (PACKAGES, *sys.path)))
    done = subprocess.run(
        [sys.executable, "-m", "robotpy", "sim", "--simcore", "--nogui"],
        cwd=folder, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert sentence in done.stdout + done.stderr and "loop True" in done.stdout


def test_absolute_encoders_that_are_read_as_volts_steer(project, driven):
    folder = project("magic")
    robot = folder / "robot.py"
    text = robot.read_text().replace("wpilib.AnalogEncoder(channel)", "wpilib.AnalogInput(channel)")
    robot.write_text(text.replace("self.absolute.get()", "self.absolute.getVoltage() / 5.0"))
    assert "AnalogEncoder(" not in robot.read_text() and "getVoltage" in robot.read_text()
    require_course(driven(folder))


def test_a_tank_that_builds_no_drive_class_is_known_by_the_names_of_its_motors(project, python):
    """Not by those of a lift; conversion factors that count turns of the wheel, 1 / 10, are its gearing."""
    folder = project("tank_sparks")
    (folder / "robot.py").write_text(
        "import rev\nimport wpilib\n\nSPARK = rev.SparkLowLevel.MotorType.kBrushless\n\n\n"
        "class Pair:\n    def __init__(self, first: int) -> None:\n"
        "        self.left_motor, self.right_motor = rev.SparkMax(first, SPARK), rev.SparkMax(first + 1, SPARK)\n"
        "        config = rev.SparkMaxConfig()\n        config.encoder.positionConversionFactor(0.1)\n"
        "        for motor in (self.left_motor, self.right_motor):\n            motor.configure(\n"
        "                config, rev.ResetMode.kResetSafeParameters, rev.PersistMode.kPersistParameters)\n\n\n"
        "class Robot(wpilib.TimedRobot):\n    def robotInit(self) -> None:\n"
        "        self.lift, self.drive_base = Pair(1), Pair(3)\n"
    )
    said = python(folder, "-m", "simcore", "init")
    text = (folder / "simcore.toml").read_text(encoding="utf-8")
    assert "tank drive: sides of names of motors" in said and "drive_gearing 10 " in said, said
    assert "left = [3]" in text and "right = [4]" in text


def test_modules_that_keep_what_they_read_are_found_as_those_that_read_at_once(project, python):
    """Loggers and layers of input do so; modules that read no sensor in simulation are told by name."""
    folder = project("spark_cancoder")
    robot, file = folder / "robot.py", folder / "simcore.toml"
    at_once, asked = (
        robot.read_text(),
        "        return SwerveModulePosition(self.drive_encoder.getPosition(), self.angle)\n",
    )
    assert asked in at_once
    sentence = "SwerveModule says the same position whatever its sensors read"
    said = python(folder, "-m", "simcore", "init")
    table = file.read_text(encoding="utf-8")
    assert sentence not in said
    keeps = "        return getattr(self, 'last', SwerveModulePosition())\n\n    def periodic(self) -> None:\n"
    for text, is_told in ((keeps + asked.replace("return", "self.last ="), False), (keeps + "        pass\n", True)):
        robot.write_text(at_once.replace(asked, text))
        file.unlink()
        said = python(folder, "-m", "simcore", "init")
        assert (sentence in said) is is_told
        assert (file.read_text(encoding="utf-8") == table) is not is_told


def test_modules_of_an_installed_library_are_found(project, python):
    folder = project("spark_cancoder")
    robot, library = folder / "robot.py", folder / "site-packages" / "shared_modules.py"
    library.parent.mkdir()
    head, rest = robot.read_text().split("class SwerveModule:")
    body, program = rest.split("class Robot(")
    library.write_text(f"{head}class SwerveModule:{body}")
    place = f"import sys\n\nsys.path.insert(0, {str(library.parent)!r})\nfrom shared_modules import SwerveModule\n"
    robot.write_text(f"{head}{place}\n\nclass Robot({program}")
    said = python(folder, "-m", "simcore", "init")
    assert "swerve drive: 4 modules (SwerveModule)" in said, said


def test_the_page_of_robots_names_the_models_of_every_maker(tmp_path):
    """`scripts/write_which_robots.py` brings it up to date."""
    for module in (*NEEDS, "navx"):
        if find_spec(module) is None:
            pytest.skip(f"needs {module}, which is not installed")
    made = tmp_path / "page.md"
    program = "import runpy, pathlib, sys; m = runpy.run_path('scripts/write_which_robots.py'); "
    subprocess.run(
        [sys.executable, "-c", program + "pathlib.Path(sys.argv[1]).write_text(m['text'](), 'utf-8')", str(made)],
        cwd=PACKAGES, env={**os.environ, "PYTHONPATH": str(PACKAGES)}, capture_output=True, check=True, timeout=100,
    )  # fmt: skip
    assert made.read_text(encoding="utf-8") == (PACKAGES / "docs" / "which_robots.md").read_text(encoding="utf-8")
