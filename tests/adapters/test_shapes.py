"""Programs of many shapes on CTRE's drivetrain, without any code for simcore, each driven over the same course.

The course is 5 m across the field, into the depot's fuel and against the wall; some programs also run in real time.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.slow

ROBOTS = Path(__file__).parent / "robots"
TIMED = """
import measures
import wpilib
from phoenix6 import controls, swerve


class Drive(swerve.SwerveDrivetrain):
    pass


class Robot(wpilib.TimedRobot):
    own_hook = 0

    def robotInit(self):
        self.parts = {{"drive": measures.build({drivetrain})}}
        {more}

    def teleopPeriodic(self):
        self.parts["drive"].set_control(measures.driver_request())
"""
STEPPING = """
    def _simulationPeriodic(self):
        self.own_hook += 1
        self.parts["drive"].update_sim_state(0.02, 12.0)

    def facts(self):
        return {"own_hook": self.own_hook}
"""
MECHANISMS = """self.intake = measures.talon(40, ratio=4.0, k_v=0.5)
        self.other = measures.talon(41, ratio=4.0, k_v=0.5, k_p=0.1)"""
RUNS_MECHANISMS = """
        self.intake.set_control(controls.VoltageOut(6.0))
        self.other.set_control(controls.VelocityVoltage(5.0))

    def facts(self):
        return {"intake_rps": self.intake.get_velocity().value, "other_rps": self.other.get_velocity().value}
"""
OWN_PHYSICS = '''
"""What a team had before: a drivetrain without a field, and an intake that is slow as molasses."""
import measures
from phoenix6.swerve.sim_swerve_drivetrain import SimSwerveDrivetrain
from wpilib import RobotController


class PhysicsEngine:
    def __init__(self, physics_controller, robot):
        self.robot, self.drive = robot, robot.parts["drive"]
        locations, gyro = self.drive.module_locations, self.drive.pigeon2.sim_state
        self.model = SimSwerveDrivetrain(locations, gyro, measures.modules())

    def update_sim(self, now, tm_diff):
        volts = RobotController.getBatteryVoltage()
        self.model.update(tm_diff, volts, list(self.drive.modules))
        self.drive.pigeon2.sim_state.add_yaw(1.0)  # a spinning robot, if any code listened
        intake = self.robot.intake.sim_state
        intake.set_supply_voltage(volts)
        rps = -4.0 * 0.25 * intake.motor_voltage
        intake.set_rotor_velocity(-rps)
        intake.add_rotor_position(-rps * tm_diff)
'''


@dataclass(frozen=True, kw_only=True)
class Shape:
    """A robot program and its peculiarities."""

    source: Path | str | dict[str, str]
    sticks: str = "robot"
    """Frame of the sticks: `field` or `robot`."""
    needs: tuple[str, ...] = ()
    """Modules that the program imports."""
    believes: tuple[float, float] = (0.0, 0.0)
    """Odometry position before the robot moves [m]."""
    says: tuple[str, ...] = ("drivetrain TalonFX 1-4 11-14, CANcoder 21-24, Pigeon2 9",)
    """Expected parts of the log of device owners."""
    holds: Callable[[dict[str, Any]], bool] = field(default=lambda run: True)
    """Further checks of the program's `facts` and of the course."""


SHAPES = {
    "generated": Shape(
        source=ROBOTS / "team_generated",
        sticks="field",
        needs=("pathplannerlib",),
        says=("drivetrain TalonFX 1-8, CANcoder 11-14, Pigeon2 20",),
    ),
    "described": Shape(  # the file's pivot is down on its stop, its roller took fuel in; each shot slows the wheels
        source=ROBOTS / "described",
        believes=(12.96, 4.01),
        says=("'wheels': TalonFX 31 32", "'pivot': TalonFX 35", "48 kg, bumpers 0.88 x 0.76 m"),
        holds=lambda run: (
            abs(run["pressed"]["pivot"]) < 0.01
            and run["pressed"]["wheels_rps"] == pytest.approx(55.0, rel=0.1)
            and run["pressed"]["heartbeat"] > 100
            and run["shots"] >= 3
            and run["taken_in"] > 0
            and run["start"][:2] == pytest.approx([2.0, 1.2], abs=0.01)  # its pose was reset, not moved
        ),
    ),
    "its own steps of CTRE's simulation": Shape(
        source=TIMED.format(drivetrain="Drive, inverted_steer=False, coupling=3.57, slip_current=60.0", more="")
        + STEPPING,
        holds=lambda run: run["pressed"]["own_hook"] > 100,
    ),
    "MagicBot": Shape(source=ROBOTS / "magic", needs=("magicbot",)),
    "TalonFXS and CANdi": Shape(
        source=TIMED.format(drivetrain="inverted_steer=False, fxs=True", more=""),
        says=("drivetrain TalonFX 11-14, TalonFXS 1-4, CANdi 21-24, Pigeon2 9",),
    ),
    "physics.py of its own": Shape(
        source={
            "robot.py": TIMED.format(drivetrain="", more=MECHANISMS).rstrip("\n") + RUNS_MECHANISMS,
            "physics.py": OWN_PHYSICS,
        },
        needs=("pyfrc.physics",),
        says=(
            "own physics TalonFX 40",
            "guessed TalonFX 41: 1 x Kraken X60 FOC, 4:1",
            "what the project's own simulation writes into it is dropped",
        ),
        holds=lambda run: (  # its own model: 0.25 turns/s per volt, 3-6 V; simcore's model would do 12
            0.5 < run["pressed"]["intake_rps"] < 1.6 and run["pressed"]["other_rps"] == pytest.approx(5.0, rel=0.1)
        ),
    ),
    "SPARKs": Shape(
        source=ROBOTS / "sparked",
        needs=("rev",),
        says=("'intake': SPARK MAX 41 42", "guessed SPARK MAX 44: 1 x NEO, 40:1", "own physics SPARK MAX 46"),
        holds=lambda run: (
            run["pressed"]["shooter_rpm"] == pytest.approx(3500.0, rel=0.1)  # each shot slows it
            and run["pressed"]["hood_deg"] == pytest.approx(30.0, abs=1.0)
            and run["pressed"]["intake_rpm"][0] == pytest.approx(-run["pressed"]["intake_rpm"][1])
            and run["shots"] >= 3
            and abs(run["released"]["feeder_rps"]) < 1.0  # it coasts
        ),
    ),
}
IN_REAL_TIME = ("generated", "described", "TalonFXS and CANdi", "SPARKs")
"""Shapes that also run on CTRE's own simulation."""
REAL_ONLY = {
    "TalonFXS and CANdi": "only TalonFX motors are modelled in simulated time, got motor arrangements 0 (drive)"
}
"""Shapes that simulated time refuses, with a part of the message."""


def project(name: str, project_of) -> Callable[..., tuple[int, str]]:
    for module in SHAPES[name].needs:
        pytest.importorskip(module, reason=f"{name} needs {module}, which is not installed")
    return project_of(SHAPES[name].source)


def check(run: dict[str, Any], said: str, shape: Shape) -> None:
    """Check the course results that hold in both kinds of time."""
    assert run["crept"] < 0.008, "odometry moves though the robot stands"
    assert run["believed_start"][:2] == pytest.approx(shape.believes, abs=0.005)
    assert 5.0 < run["true_way"] < 6.0
    assert run["off"] < 0.03 * run["true_way"]
    assert run["pushed"] >= 8
    assert -0.01 < run["gap_at_wall"] < 0.08  # pressed against it with all its grip
    assert run["speed_at_wall"] < 0.05
    assert run["counted"] == run["staged"]
    assert shape.holds(run), run
    for words in shape.says:
        assert words in " ".join(said.split())


def error_lines(text: str) -> list[str]:
    """Return lines that look like a fault; a loop overrun of the robot is not a fault of simcore."""
    wanted = re.compile(r"Traceback|NotImplementedError|Segmentation|\bERROR\b|stale|terminate called|Fatal")
    return [line for line in text.splitlines() if wanted.search(line)]


@pytest.mark.realtime
@pytest.mark.parametrize("name", IN_REAL_TIME)
def test_each_kind_of_program_drives_the_course_in_real_time(name, project_of, scenario):
    folder, shape = project(name, project_of).folder, SHAPES[name]
    flags = ("shape", "blue", "--simcore", "--game", "rebuilt")
    run = scenario("robot_sim", str(folder), *flags, path=(ROBOTS / "shared",), STICKS=shape.sticks)
    check(run, run["output"], shape)
    assert error_lines(run["output"]) == []


COURSE = """
import json
from course import Course


def test_course(sim, caplog):
    caplog.set_level("INFO", "simcore")
    sim.start()
    course = Course(sim.physics, is_field_centric=FIELD, enable=sim.teleop)
    for _ in course.run():
        sim.run(0.02)
    print("LOG", caplog.text.encode())
    print("COURSE", json.dumps(course.results))
"""


@pytest.mark.parametrize("name", SHAPES)
def test_each_kind_of_program_drives_the_course_in_simulated_time(name, project_of):
    run, shape = project(name, project_of), SHAPES[name]
    code, said = run(COURSE.replace("FIELD", str(shape.sticks == "field")), "-rP")
    if name in REAL_ONLY:
        assert code == 1 and REAL_ONLY[name] in said, said[-4000:]
        return
    assert code == 0, said[-4000:]
    results = next(line for line in said.splitlines() if line.startswith("COURSE"))
    check(json.loads(results.removeprefix("COURSE")), said.replace("\\n", " "), shape)


OWN_TESTS = """
import pytest
from pyfrc.tests import *


def test_autonomous_drives_the_path_of_the_chooser_and_a_routine_of_sysid_runs(sim):
    sim.autonomous("Ahead", seconds=4.0)
    assert (sim.pose.X(), sim.pose.Y()) == pytest.approx((3.0, 2.6), abs=0.05)
    pad = sim.xbox(0)
    sim.teleop()
    pad.back = pad.y = True
    sim.run(0.4)
    assert sim.pose.X() > 3.1  # a step of 4 V, straight forward
    print("DIGEST", sim.digest)


def test_again(sim):
    test_autonomous_drives_the_path_of_the_chooser_and_a_routine_of_sysid_runs(sim)
"""


def test_a_generated_projects_own_tests_pass_with_the_same_digest_in_two_processes(project_of, whole):
    code, said = project("generated", project_of)(OWN_TESTS, "-rP", *(() if whole else ("-k", "autonomous or again")))
    assert code == 0 and f"{6 if whole else 3} passed" in said, said[-4000:]
    first, second = (line for line in said.splitlines() if line.startswith("DIGEST"))
    assert first == second and error_lines(said) == []
