"""`simcore init` starts the robot program for a moment and finds its motors."""

from __future__ import annotations

import shutil
from importlib.util import find_spec
from pathlib import Path

import pytest

from simcore.cli import main
from simcore.robot_file.init_command import survey

pytestmark = pytest.mark.skipif(
    any(find_spec(m) is None for m in ("phoenix6", "wpilib", "commands2")), reason="needs .[phoenix6,robotpy]"
)

ROBOTS = Path(__file__).parent / "robots"


@pytest.fixture
def project(tmp_path):
    shutil.copy(ROBOTS / "generated" / "robot.py", tmp_path)
    shutil.copy(ROBOTS / "shared" / "measures.py", tmp_path)
    return tmp_path


def row(controller, leader, gearing, name, followers=(), opposed=()):
    """Return a motor of the survey without its guessed values."""
    return {"name": name, "controller": controller, "leader": leader, "followers": [*followers],
            "opposed": [*opposed], "gearing": gearing}  # fmt: skip


def test_the_survey_finds_all_motor_groups_except_those_of_the_drivetrain(project):
    found = survey(project / "robot.py")
    motors = found["motors"]
    assert (found["ports"], found["cameras"]) == ([], []) and "error" not in found
    assert [m["remark"] for m in motors] == ["", *["it holds a weight"] * 2, "it reads CANcoder 36", ""]
    assert [m["turns_freely"] for m in motors] == [True, False, False, False, True]
    assert motors[0]["motor"] == "Kraken X60 FOC" and motors[0]["inertia"] == pytest.approx(0.0013, rel=0.01)
    assert [{key: m[key] for key in row("", 0, 1.0, "")} for m in motors] == [
        row("TalonFX", 31, 0.75, "shooter", (32, 33), (33,)),
        row("TalonFX", 34, 9.0, "elevator"),
        row("TalonFX", 35, 45.0, "arm"),
        row("TalonFX", 36, 25.0, "turret"),
        row("TalonFXS", 37, 3.0, "roller"),
    ]
    assert sorted(p.name for p in project.iterdir() if p.name != "__pycache__") == ["measures.py", "robot.py"]


def test_devices_on_ports_are_found_with_their_class(project):
    shutil.copy(ROBOTS / "ports" / "robot.py", project)
    answer = survey(project / "robot.py")
    motors, ports = answer["motors"], answer["ports"]
    assert [(m["controller"], m["leader"], m["name"]) for m in motors] == [("TalonFX", 31, "wheels")]
    found = {(port["model"], tuple(port["channels"]), port["made_by"]) for port in ports}
    assert len(ports) == len(found) == 21 and "error" not in answer
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


def test_cameras_are_found_with_the_mounting_that_the_program_uses(project, capsys):
    """Limelights and headsets are found by the tables that the program reads, PhotonCameras by their names."""
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
    found = {camera["name"]: camera for camera in survey(project / "robot.py")["cameras"] if "name" in camera}
    assert found["front"]["source"] == "VisionSystemSim.addCamera" and "source" not in found["unknown"]
    assert found["rear"]["place"] == pytest.approx((-0.25, -0.1, 0.5, 0.0, -10.0, 180.0))


def test_the_survey_reports_the_error_of_a_program_that_cannot_start(project):
    (project / "robot.py").write_text("import wpilib\nraise OSError('no gamepad')\n")
    assert survey(project / "robot.py")["error"] == "OSError: no gamepad"
    (project / "robot.py").write_text("import wpilib\n")
    said = f"ConfigError: {project}/robot.py: there must be one class derived from wpilib.RobotBase, got []"
    assert survey(project / "robot.py")["error"] == said


def test_motors_built_before_a_failure_are_still_found(project):
    text = (project / "robot.py").read_text()
    (project / "robot.py").write_text(
        text.replace(
            "        self.mechanisms = Mechanisms()\n", "        self.mechanisms = Mechanisms()\n        1 / 0\n"
        )
    )
    found = survey(project / "robot.py")
    assert found["error"] == "ZeroDivisionError: division by zero"
    assert [motor["leader"] for motor in found["motors"]] == [31, 34, 35, 36, 37]


def test_all_motors_are_found_even_if_the_configuration_of_one_cannot_be_read(project):
    text = (project / "robot.py").read_text()
    lost = "        self.roller.configurator.refresh = lambda *a: signals.StatusCode.RX_TIMEOUT\n"
    text = text.replace("    def run_all(self)", lost + "\n    def run_all(self)", 1)
    (project / "robot.py").write_text(
        text.replace("import measures\n", "import measures\nimport phoenix6\n", 1).replace(
            "signals.StatusCode", "phoenix6.StatusCode"
        )
    )
    found = survey(project / "robot.py")
    assert "error" not in found and [motor["leader"] for motor in found["motors"]] == [31, 34, 35, 36, 37]
    *others, last = found["motors"]
    assert "could not read its configuration (RX_TIMEOUT" in last["remark"] and not last["turns_freely"]
    assert not any("could not" in motor["remark"] for motor in others)
