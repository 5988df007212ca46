"""`simcore init` starts the robot program for a moment and finds its motors."""

from __future__ import annotations

import shutil
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import pytest

from simcore.cli import main
from simcore.robot_file.init_command import find_devices
from simcore.robot_file.template import FoundMotor

pytestmark = pytest.mark.skipif(
    any(find_spec(m) is None for m in ("phoenix6", "wpilib", "commands2")), reason="needs .[phoenix6,robotpy]"
)

ROBOTS = Path(__file__).parent / "robots"


@pytest.fixture
def project(tmp_path):
    shutil.copy(ROBOTS / "generated" / "robot.py", tmp_path)
    shutil.copy(ROBOTS / "shared" / "measures.py", tmp_path)
    return tmp_path


def test_groups_of_motors_and_their_gears_are_found_and_the_drivetrain_left_out(project):
    motors, ports, cameras, _, why_not = find_devices(project)
    assert (ports, cameras, why_not) == ([], [], "")
    assert [m.remark for m in motors] == ["", *["it holds a weight"] * 2, "it reads CANcoder 36", ""]
    assert [m.turns_freely for m in motors] == [True, False, False, False, True]
    assert motors[0].motor == "Kraken X60 FOC" and motors[0].inertia == pytest.approx(0.0013, rel=0.01)
    motors = [replace(m, inertia=0.0, friction_volts=0.0, motor="", remark="", turns_freely=True) for m in motors]
    assert motors == [
        FoundMotor(controller="TalonFX", leader=31, followers=(32, 33), opposed=(33,), gearing=0.75, name="shooter"),
        FoundMotor(controller="TalonFX", leader=34, gearing=9.0, name="elevator"),
        FoundMotor(controller="TalonFX", leader=35, gearing=45.0, name="arm"),
        FoundMotor(controller="TalonFX", leader=36, gearing=25.0, name="turret"),
        FoundMotor(controller="TalonFXS", leader=37, gearing=3.0, name="roller"),
    ]
    assert sorted(p.name for p in project.iterdir() if p.name != "__pycache__") == ["measures.py", "robot.py"]


def test_what_is_on_ports_is_found_with_its_class(project):
    shutil.copy(ROBOTS / "ports" / "robot.py", project)
    motors, ports, _, _, why_not = find_devices(project)
    assert why_not == "" and [(m.controller, m.leader, m.name) for m in motors] == [("TalonFX", 31, "wheels")]
    found = {(port.model, port.channels, port.made_by) for port in ports}
    assert len(ports) == len(found) == 21
    assert {
        ("PWM", (0,), "Spark"),
        ("PWM", (3,), "Servo"),
        ("PWM", (7,), "AddressableLED"),
        ("DIO", (0, 1), "Encoder"),
        ("DIO", (3,), "DutyCycleEncoder"),
        ("Analog", (1,), "AnalogPotentiometer"),
        ("REVPH 1 Solenoid", (0, 1), "DoubleSolenoid"),
        ("REVPH 1 Solenoid", (2,), "Solenoid"),
        ("Relay", (1,), "Relay"),
        ("CANrange", (12,), ""),
        ("CANdi", (30,), ""),
    } <= found


def test_cameras_are_found_with_the_place_that_the_program_tells(project, capsys):
    """Limelights and a headset by the tables that are asked for, PhotonCameras by their names."""
    shutil.copy(ROBOTS / "sighted" / "robot.py", project)
    shutil.copy(ROBOTS / "shared" / "questnav.py", project)
    assert main(["init", str(project)]) == 0
    said = capsys.readouterr().out
    assert (
        "found 3 cameras: limelight-front, limelight, questnav; say in the file where limelight-front, limelight sit\n"
    ) in said
    text = (project / "simcore.toml").read_text()
    assert all(f"# camera {name}\n" in text for name in ("limelight-front", "limelight", "questnav"))
    if find_spec("photonlibpy") is None:
        return
    shutil.copy(ROBOTS / "photon" / "robot.py", project)
    found = {camera.name: camera for camera in find_devices(project)[2]}
    assert found["front"].source == "VisionSystemSim.addCamera" and not found["unknown"].source
    assert found["rear"].place == pytest.approx((-0.25, -0.1, 0.5, 0.0, -10.0, 180.0))


def test_a_program_that_cannot_start_says_why(project):
    (project / "robot.py").write_text("import wpilib\nraise OSError('no gamepad')\n")
    assert find_devices(project)[::4] == (None, "OSError: no gamepad")
    (project / "robot.py").write_text("import wpilib\n")
    assert find_devices(project)[::4] == (
        None,
        f"ConfigError: {project}/robot.py: want one class derived from wpilib.RobotBase, got []",
    )


def test_motors_that_a_program_had_built_before_it_failed_are_found_too(project):
    text = (project / "robot.py").read_text()
    (project / "robot.py").write_text(
        text.replace(
            "        self.mechanisms = Mechanisms()\n", "        self.mechanisms = Mechanisms()\n        1 / 0\n"
        )
    )
    motors, _, _, _, why_not = find_devices(project)
    assert why_not == "ZeroDivisionError: division by zero"
    assert [motor.leader for motor in motors] == [31, 34, 35, 36, 37]


def test_one_motor_that_does_not_answer_does_not_hide_the_others(project):
    text = (project / "robot.py").read_text()
    lost = "        self.roller.configurator.refresh = lambda *a: signals.StatusCode.RX_TIMEOUT\n"
    text = text.replace("    def run_all(self)", lost + "\n    def run_all(self)", 1)
    (project / "robot.py").write_text(
        text.replace("import measures\n", "import measures\nimport phoenix6\n", 1).replace(
            "signals.StatusCode", "phoenix6.StatusCode"
        )
    )
    motors, _, _, _, why_not = find_devices(project)
    assert why_not == "" and [motor.leader for motor in motors] == [31, 34, 35, 36, 37]
    assert "could not read its configuration (RX_TIMEOUT" in motors[-1].remark
    assert not any("could not" in motor.remark for motor in motors[:-1]) and not motors[-1].turns_freely
