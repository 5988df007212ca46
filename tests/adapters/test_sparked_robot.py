"""A robot with REV mechanisms on a generated swerve, from `init` to a run: SPARKs, hoot log and friction."""

from __future__ import annotations

import os
import shutil
from importlib.util import find_spec
from pathlib import Path

import pytest

import simcore
from simcore.robot_file.init_command import find_robot_py, survey

PACKAGES = Path(simcore.__file__).resolve().parents[1]
ROBOTS = Path(__file__).parent / "robots"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(find_spec("rev") is None, reason="needs rev: pip install .[rev]"),
    pytest.mark.skipif(
        any(find_spec(m) is None for m in ("phoenix6", "wpilib", "pyfrc")), reason="needs .[phoenix6,robotpy]"
    ),
]

TEST = """
import pytest

from simcore.quantities import DeviceAddress


def test_it_shoots_while_the_trigger_is_held(sim):
    stick = sim.joystick(0)
    sim.teleop()
    sim.run(0.5)
    mechanisms = sim.robot_sim.mechanisms
    shooter, feeder, intake = (mechanisms[name] for name in ("shooter", "feeder", "intake"))
    gearbox = shooter.gearbox
    assert gearbox.friction_torque == pytest.approx(0.15 / gearbox.resistance * gearbox.torque_per_amp)
    code = sim.robot.superstructure
    stick.press(1)
    sim.run(1.6)
    shots = len(sim.match.record.shots)
    assert shots >= 2
    assert code.shooter.getEncoder().getVelocity() == pytest.approx(3500.0, rel=0.1)  # each shot slows it
    assert code.intake.getEncoder().getVelocity() == pytest.approx(-code.intake_follower.getEncoder().getVelocity())
    assert intake.velocity > 50.0 and code.intake.getOutputCurrent() > 0.0
    assert code.hood.getAbsoluteEncoder().getPosition() == pytest.approx(30.0, abs=0.5)  # a guessed mechanism
    shown = sim.match.snapshot()
    assert shown.doubles["Sim/Debug/ShooterVelocityRPSSetpoint"] == pytest.approx(3500.0 / 60.0)
    assert "Sim/Debug/IntakeVelocityRPSSetpoint" not in shown.doubles, "it is told a duty cycle"
    assert shown.state_arrays["Sim/Robot/SwerveStates"].shape == (4, 2)
    stick.release(1)
    speed, slowing = feeder.velocity, feeder.gearbox.friction_torque / feeder.inertia
    sim.run(0.12 + speed / slowing)  # request and tick lag by some ticks
    assert feeder.velocity == 0.0 and speed / slowing < 1.0
    left = sim.pieces.held
    sim.run(0.6)
    assert sim.pieces.held == left > 0
    assignment = sim.physics.assignment
    described, guessed = dict(assignment.described), dict(assignment.guessed)
    print("TABLE", described, guessed, assignment.foreign, "DIGEST", sim.digest)
    assert described["SPARK MAX 41 42"] == "'intake'" and described["SPARK Flex 43"] == "'shooter'"
    assert guessed["SPARK MAX 44"].startswith("1 x NEO, 40:1")
    assert ("SPARK MAX", DeviceAddress(46)) in assignment.foreign


def test_again(sim):
    test_it_shoots_while_the_trigger_is_held(sim)
"""


@pytest.fixture
def path(distribution):
    rev = Path(find_spec("rev").origin).parents[1]
    return os.pathsep.join(map(str, (distribution, PACKAGES, rev)))


def test_a_robot_with_sparks_shoots_fuel_and_its_undriven_motors_stop(project_of, path):
    run = project_of(ROBOTS / "sparked")
    shutil.copy(ROBOTS / "shared" / "measures.py", run.folder)
    code, said = run(TEST, "-rP", PYTHONPATH=path)
    assert code == 0 and "2 passed" in said, said
    digests = [line.split()[-1] for line in said.splitlines() if "DIGEST" in line]
    assert len(digests) == 2 and digests[0] == digests[1]


def test_init_finds_motors_of_a_program_in_a_src_folder_that_reads_its_deploy_folder(tmp_path):
    (tmp_path / "pyproject.toml").write_text("[tool.robotpy]\nrobotpy_version = '2026.2.2'\n")
    shutil.copytree(ROBOTS / "sparked", tmp_path / "src", ignore=shutil.ignore_patterns("simcore.toml", "__pycache__"))
    shutil.copy(ROBOTS / "shared" / "measures.py", tmp_path / "src")
    found = survey(find_robot_py(tmp_path))
    assert "error" not in found
    keys = ("controller", "leader", "followers", "opposed", "gearing", "name")
    assert [tuple(m[key] for key in keys) for m in found["motors"]] == [
        ("TalonFX", 45, [], [], 2.0, "feeder"),
        ("SPARK MAX", 41, [42], [42], 1.0, "intake"),
        ("SPARK Flex", 43, [], [], 1.0, "shooter"),
        ("SPARK MAX", 44, [], [], 40.0, "hood"),
        ("SPARK MAX", 46, [], [], 1.0, "winch"),
    ]
