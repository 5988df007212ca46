"""Robots with equal ids on two CAN buses: found, described, driven, and refused on CTRE's own simulation."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROBOTS = Path(__file__).parent / "robots"
TWO_BUSES = """
import measures
import wpilib
from phoenix6 import configs, controls, hardware, signals


class Robot(wpilib.TimedRobot):
    def robotInit(self):
        self.drivetrain = measures.build(bus="canivore", inverted_steer=True, coupling=3.5)
        self.shooter, self.partner = measures.talon(1, k_v=0.125, k_p=0.3), hardware.TalonFX(3)
        self.partner.set_control(controls.Follower(1, signals.MotorAlignmentValue.OPPOSED))
        self.encoder, self.arm = hardware.CANcoder(21), hardware.TalonFX(11)
        config = configs.TalonFXConfiguration()
        config.feedback.feedback_sensor_source = signals.FeedbackSensorSourceValue.FUSED_CANCODER
        config.feedback.feedback_remote_sensor_id = 21
        config.feedback.rotor_to_sensor_ratio = 45.0
        config.slot0.k_p, config.slot0.k_d = 90.0, 1.0
        self.arm.configurator.apply(config)
        self.roller = measures.talon(2, ratio=3.0, k_v=0.4, k_p=0.2)

    def teleopPeriodic(self):
        self.drivetrain.set_control(measures.driver_request())
        self.shooter.set_control(controls.VelocityVoltage(50.0))
        self.arm.set_control(controls.PositionVoltage(0.2))
        self.roller.set_control(controls.VelocityVoltage(10.0))
"""
"""CTRE's swerve on a CANivore, and a shooter, an arm and a roller with the same ids on the roboRIO's bus."""


DESCRIBED = """
[[mechanism]]
name = "shooter"
kind = "flywheel"
leader = {shooter}
followers = [{partner}]
opposed = [{partner}]
gearing = 1.0
inertia = 0.002

[[mechanism]]
name = "arm"
kind = "arm"
leader = 11
gearing = 45.0
cancoder = {encoder}
mass = 2.0
center_of_mass = 0.2
min_deg = -10
max_deg = 100
"""
COURSE = """
import math

import pytest


def test_five_meters_while_its_mechanisms_turn(sim):
    robot, pad, sim_robot = sim.robot, sim.joystick(0), sim.robot_sim
    sim.place(2.8, 1.2, 0.5 * math.pi)
    sim.teleop(seconds=0.2)
    start, believed = sim_robot.chassis.pose, sim_robot.estimated_pose
    pad.axis(1, -0.9)
    sim.run(2.1)
    pad.center()
    sim.run(0.5)
    true = math.dist(sim_robot.chassis.pose[:2], start[:2])
    told = math.dist(sim_robot.estimated_pose[:2], believed[:2])
    assert true > 5.0 and told == pytest.approx(true, rel=0.02), (true, told)
    assert not [text for text in sim.warnings if "odometry is off" in text]
    speeds = [abs(motor.get_velocity().value) for motor in (robot.shooter, robot.partner, robot.roller)]
    assert speeds == pytest.approx([50.0, 50.0, 10.0], rel=0.03)
    assert abs(robot.drivetrain.modules[0].drive_motor.get_velocity().value) < 0.5  # TalonFX 1 on the other bus
    assert [d.get_position().value for d in (robot.arm, robot.encoder)] == pytest.approx([0.2, 0.2], abs=0.01)
    steered = [module.encoder.get_absolute_position().value for module in robot.drivetrain.modules]
    assert max(map(abs, steered)) < 0.6 and abs(steered[0] - 0.2) > 0.01
    print("FACTS", round(true, 3), sim.digest)
"""


def test_a_swerve_on_a_canivore_drives_next_to_mechanisms_with_the_same_ids(project_of):
    run = project_of(TWO_BUSES)
    code, told = run("", command=("-m", "simcore", "init"))
    text = (run.folder / "simcore.toml").read_text()
    assert code == 0 and 'name = "shooter"' in text and "leader = 1\nfollowers = [3]\n" in text, told + text
    facts = []
    for numbers in (
        {"shooter": 1, "partner": 3, "encoder": 21},
        {"shooter": '"rio:1"', "partner": '"rio:3"', "encoder": 21},
    ):
        (run.folder / "simcore.toml").write_text(DESCRIBED.format(**numbers))
        code, said = run(COURSE, "-rP")
        assert code == 0, said
        facts.append(next(line for line in said.splitlines() if line.startswith("FACTS")))
    assert facts[0] == facts[1]
    code, said = run("", command=("-m", "simcore", "check"))
    assert code == 0 and "nothing wrong" in said, said


@pytest.mark.parametrize(
    ("told", "sentence"),
    [
        (
            {"shooter": 1, "partner": '"canivore:4"', "encoder": 21},
            "TalonFX canivore:4 cannot follow TalonFX 1: it is on another CAN bus",
        ),
        (
            {"shooter": '"canivore:2"', "partner": '"canivore:3"', "encoder": 21},
            "TalonFX canivore:2 is the drivetrain's",
        ),
        (
            {"shooter": 1, "partner": 3, "encoder": '"other:21"'},
            "builds no CANcoder other:21; it builds CANcoder [21, canivore:21,",
        ),
    ],
)
def test_the_error_names_the_device_whose_bus_is_wrong(told, sentence, project_of):
    run = project_of(TWO_BUSES)
    (run.folder / "simcore.toml").write_text(DESCRIBED.format(**told))
    code, said = run(COURSE)
    assert code != 0 and sentence in said, said


@pytest.fixture
def crossed(project_of):
    """Return a project whose steer motors and encoders on a CANivore have the ids of its drive motors."""
    run = project_of(ROBOTS / "own_talons")
    robot = run.folder / "robot.py"
    text = robot.read_text()
    for old, new in (
        ("hardware.TalonFX(number + 10)", 'hardware.TalonFX(number, "canivore")'),
        ("hardware.CANcoder(number + 20)", 'hardware.CANcoder(number, "canivore")'),
        ("feedback_remote_sensor_id = number + 20", "feedback_remote_sensor_id = number"),
    ):
        assert old in text
        text = text.replace(old, new)
    robot.write_text(text)
    return run


def test_steer_motors_with_the_ids_of_drive_motors_steer_with_true_odometry(crossed):
    course = "import legs\n\n\ndef test_course(sim):\n    legs.drive(sim, legs.HOLONOMIC)\n"
    rows = []
    for described in (False, True):
        if described:
            code, said = crossed("", command=("-m", "simcore", "init"))
            text = (crossed.folder / "simcore.toml").read_text()
            row = '["canivore:1", "canivore:2", "canivore:3", "canivore:4"]'
            assert code == 0 and f"drive = [1, 2, 3, 4]\nsteer = {row}" in text and f"encoders = {row}" in text, said
        code, said = crossed(course)
        assert code == 0, said
        facts = json.loads((crossed.folder / "facts.json").read_text())
        for leg in ("ahead", "left"):
            true, told, _ = facts["legs"][leg]
            assert true > 0.8 and told == pytest.approx(true, rel=0.02)
        assert not [text for text in facts["warnings"] if "odometry is off" in text]
        rows.append(facts["legs"]["ahead"])
    assert rows[1] == pytest.approx(rows[0], abs=0.01)
    code, said = crossed("", command=("-m", "simcore", "check"))
    assert code == 0 and "nothing wrong" in said, said


ENABLES_ITSELF = """
    def robotPeriodic(self) -> None:
        import json
        import os

        from simcore.robotcode.sim.robot_physics import latest_physics
        from wpilib.simulation import DriverStationSim

        super().robotPeriodic()
        physics = latest_physics()
        ticks = 0 if physics is None else physics.times.ticks
        if ticks > 20 and not wpilib.DriverStation.isEnabled():
            self.start, self.believed = physics.robot_sim.chassis.pose, self.swerve.odometry.getPose()
            DriverStationSim.setAutonomous(True)
            DriverStationSim.setEnabled(True)
            DriverStationSim.notifyNewData()
        if ticks > 120:
            pose, told = physics.robot_sim.chassis.pose, self.swerve.odometry.getPose() - self.believed
            print(json.dumps([math.dist(pose[:2], self.start[:2]), told.translation().norm()]), flush=True)
            os._exit(0)

    def autonomousPeriodic(self) -> None:
        self.swerve.drive(ChassisSpeeds(0.0, 1.2, 0.0))
"""


def test_one_id_on_two_buses_is_refused_on_ctres_simulation_but_not_on_the_emulator(crossed):
    """In CTRE's simulation, the device that was configured or written last acts as both devices."""
    code, said = crossed("", command=("-m", "robotpy", "sim", "--simcore", "--nogui"))
    assert code == 1 and "TalonFX 1 and TalonFX canivore:1, on two CAN buses, are one device in CTRE's" in said, said
    robot = crossed.folder / "robot.py"
    robot.write_text(robot.read_text() + ENABLES_ITSELF)
    sim = ("-m", "robotpy", "sim", "--simcore", "--nogui")
    code, said = crossed("", command=sim, SIMCORE_PHOENIX="simulated")
    assert code == 0 and "TalonFX 1-4, TalonFX canivore:1-4" in said, said
    true, told = json.loads(next(line for line in said.splitlines() if line.startswith("[")))
    assert true > 1.5 and told == pytest.approx(true, rel=0.05)
