"""Robots with cameras: PhotonVision, Limelights and QuestNav get true poses without extra code."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROBOTS = Path(__file__).parent / "robots"

START = 'game = "rebuilt"\n\n[start]\nx = 2.3\ny = 4.2\n'

PHOTON_TOML = (
    START
    + """
[[camera]]
maker = "photonvision"
name = "pieces"
mode = ["tags", "pieces"]
resolution = [640, 480]
diagonal_fov_deg = 75.0
fps = 20
latency_ms = 45
x = -0.1
y = 0.1
z = 0.5
pitch_deg = 12.0
yaw_deg = 125.0
"""
)

PHOTON = """
import math

import pytest


def off(sim):
    believed, true = sim.robot.drivetrain.get_state().pose, sim.pose
    return math.hypot(believed.X() - true.X(), believed.Y() - true.Y())


@pytest.fixture(autouse=True)
def log(caplog):
    caplog.set_level("INFO", "simcore")


def test_an_estimate_3_m_off_is_corrected_in_2_s(sim, caplog):
    sim.start()
    while sim.time < 2.0:
        sim.run(0.02)
    assert sim.pose.X() == pytest.approx(2.3, abs=1e-3)  # the estimate was 5.3
    assert off(sim) < 0.05
    assert sim.robot.used["front"] > 60 and sim.robot.used["rear"] > 40  # 40 and 30 frames a second
    stick = sim.joystick(0)
    sim.teleop()
    stick.axis(1, 0.3)  # 0.9 m/s toward its own wall
    sim.run(1.0)
    stick.center()
    sim.run(0.5)
    assert sim.pose.X() < 1.7 and off(sim) < 0.05

    # The robot updates its own simulation with its estimate in every loop, but the simulation shows the true pose.
    from simcore.robotcode.makers.photonvision.photon_program import photon_program

    shown = sim.robot.vision_sim.getRobotPose(sim.time - 0.02)
    assert shown.X() == pytest.approx(sim.pose.X(), abs=0.02)
    assert photon_program().dropped > 150
    # From exposure to the loop that reads it: the camera's latency, plus one loop at most.
    front = sim.robot.cameras["front"].getLatestResult()
    assert front.getLatencyMillis() == pytest.approx(60.0, abs=0.1)  # of SimCameraProperties.OV9281_1280_720
    assert min(sim.robot.latencies) > 0.029 and max(sim.robot.latencies) < 0.060 + 0.041
    ids = [target.getFiducialId() for target in front.getTargets()]
    assert {25, 26} <= set(ids) and front.multitagResult.fiducialIDsUsed == sorted(ids)

    assert all(sim.robot.connected[30:])
    pieces = sim.robot.pieces
    pieces.setPipelineIndex(1)
    sim.run(0.5)
    assert pieces.getPipelineIndex() == 1
    seen = pieces.getLatestResult().getTargets()
    assert seen and all(t.objDetectId == 0 and 0.0 < t.objDetectConf <= 1.0 for t in seen)
    pieces.setDriverMode(True)
    sim.run(0.3)
    assert pieces.getDriverMode() and not pieces.getLatestResult().hasTargets()

    from wpimath.geometry import Rotation3d, Transform3d

    sim.robot.estimators["rear"].robotToCamera = Transform3d(-0.1, 0.0, 0.6, Rotation3d(0.0, 0.0, 2.0))  # of a turret
    sim.run(0.04)
    moved = sim.match.cameras.camera("rear").settings.mount  # forward, right, up, roll, pitch, yaw
    assert moved == pytest.approx((-0.1, 0.0, 0.6, 0.0, 0.0, math.degrees(2.0)), abs=1e-9)

    log = caplog.text
    assert "PhotonCamera('front'): x 0.25, y 0.10, z 0.40 m, pitch -15, yaw 0 degrees, as VisionSystemSim" in log
    assert "PhotonCamera('rear'): x -0.25, y -0.10, z 0.50 m, pitch -10, yaw 180" in log
    assert "PhotonCamera('unknown') sees nothing" in log and 'name = "unknown"' in log
    assert "camera 'pieces' (photonvision OV9281): x -0.10" in log
    print("DIGEST", sim.digest)
"""

SIGHTED_TOML = (
    START
    + """
[[camera]]
name = "limelight-front"
type = "LL4"
mode = ["tags", "pieces"]
json = true
x = 0.25
y = 0.1
z = 0.4
pitch_deg = -15.0
"""
)

SIGHTED = """
import json
import math

import pytest


def test_limelights_and_a_headset(sim, caplog):
    caplog.set_level("INFO", "simcore")
    sim.start()
    robot = sim.robot
    seen = robot.seen()
    assert seen["tv"] == 1 and seen["type"] == "pipe_fiducial"
    assert {25, 26} <= {int(number) for number in seen["raw"][::7]}
    assert seen["tid"] in seen["raw"][::7] and seen["ta"] > 0.05
    assert len(seen["targets"]) == 9 or len(seen["targets"]) == 3 * len(seen["raw"][::7])
    x, y = seen["botpose"][:2]
    assert math.hypot(x - sim.pose.X(), y - sim.pose.Y()) < 0.03
    # Right, down and forward from the robot's center to tag 25 or 26 on the front of the blue hub, some 1.8 m away.
    assert 1.0 < seen["target"][2] < 2.5 and abs(seen["target"][0]) < 0.6 and -1.5 < seen["target"][1] < -0.5
    told = json.loads(seen["json"])
    assert told["v"] == 1 and {tag["fID"] for tag in told["Fiducial"]} >= {25, 26}

    robot.ask(pipeline=1.0)
    sim.run(0.2)
    assert robot.seen()["type"] == "pipe_neuraldetector" and robot.seen()["tid"] == -1
    robot.ask(pipeline=0.0, camMode=1.0)
    sim.run(0.2)
    assert robot.seen()["tv"] == 0  # driver mode
    robot.ask(camMode=0.0)
    sim.run(0.2)
    assert robot.seen()["tv"] == 1

    # QuestNav: its first pose reset implied its mount; then 1.5 m while the robot also turns.
    assert robot.has_told_quest and robot.quest.tracking
    assert dict(robot.quest_device())[3] > 95 and dict(robot.quest_response()) == {1: 1, 2: 1}
    stick = sim.joystick(0)
    sim.teleop()
    stick.axis(0, 0.35)
    stick.axis(4, 0.3)
    sim.run(1.3)
    stick.center()
    sim.run(0.4)
    assert sim.pose.translation().distance(type(sim.pose)(2.3, 4.2, 0.0).translation()) > 0.6
    believed = robot.quest.pose.toPose2d()
    # noise of 2 mm and 0.05 degrees on 0.22 m of lever arm and on the reset pose, and 2 cm of drift in 150 s
    assert believed.translation().distance(sim.pose.translation()) < 0.02
    assert abs((believed.rotation() - sim.pose.rotation()).degrees()) < 1.0
    numbers = robot.quest.numbers
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    assert len(numbers) == pytest.approx(100.0 * sim.time, abs=8)
    assert min(robot.quest.ages) >= 0.0 and max(robot.quest.ages) < 0.041

    log = caplog.text
    assert "camera 'limelight-front' (limelight LL4): x 0.25, y 0.10, z 0.40 m, pitch -15" in log
    assert "robot code asks for a Limelight 'limelight', which nothing publishes" in log
    assert 'name = "limelight"' in log
    assert "ledMode changes nothing here: there are no lights" in log
    assert "fiducial_offset_set is not modeled" in log
    assert "robot code writes priorityID, which a Limelight does not read. Did you mean 'priorityid'?" in log
    assert log.count("priorityID") == 1
    assert "QuestNav: x -0.20, y 0.10, z 0.60 m, pitch 0, yaw" in log and "first pose reset implies" in log
    print("DIGEST", sim.digest)
"""


def test_a_photon_robot_localizes_despite_its_own_simulation(project_of):
    if find_spec("photonlibpy") is None:
        pytest.skip("needs photonlibpy: pip install .[photonvision]")
    run = project_of(ROBOTS / "photon")
    (run.folder / "simcore.toml").write_text(PHOTON_TOML)
    code, said = run(PHOTON, "-rP")
    assert code == 0 and "1 passed" in said, said


def test_a_robot_reads_limelights_and_questnav_from_networktables_topics(project_of):
    run = project_of(ROBOTS / "sighted")
    (run.folder / "simcore.toml").write_text(SIGHTED_TOML)
    code, said = run(SIGHTED, "-rP")
    assert code == 0 and "1 passed" in said, said


MISLED = """
import ntcore
import pytest
from wpimath.geometry import Pose2d


def test_cameras_correct_odometry_and_find_fuel(sim):
    pad, heard = sim.xbox(0), ntcore.NetworkTableInstance.getDefault().getTable("limelight-two")
    sim.start()
    sim.place(2.6, 5.3, -0.5)
    sim.teleop(seconds=0.2)
    drivetrain, true = sim.robot.container.drivetrain, sim.pose

    def error():
        return drivetrain.get_state().pose.translation().distance(sim.pose.translation())

    drivetrain.reset_pose(Pose2d(true.X() + 0.5, true.Y() - 0.3, true.rotation()))
    sim.run(0.02)
    assert error() > 0.5
    pad.left_y = -0.2
    sim.run_until(lambda: error() < 0.05, timeout=2.0)
    pad.left_y = 0.0
    sim.run(1.0)
    assert error() < 0.05
    heading = heard.getNumberArray("robot_orientation_set", [0.0])[0]
    assert heading == pytest.approx(sim.pose.rotation().degrees(), abs=1.5)
    pad.left_bumper = True  # drives to the fuel that its other camera detects
    sim.run(4.0)
    assert len(sim.record.taken_in) >= 3
"""


def test_the_example_corrects_a_start_error_of_0_6_m_in_2_s(project):
    code, said = project(MISLED)
    assert code == 0, said
