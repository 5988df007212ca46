"""A robot project of 2026, as it is written for 2027."""

# ruff: noqa: E501

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from simcore.errors import ConfigError, OutputError
from simcore.upgrade_2027.source_rewriter import names_of_project, rewrite
from simcore.upgrade_2027.upgrade_command import upgrade, upgrade_settings

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"


def new(text: str) -> str:
    return rewrite(text, names_of_project([ast.parse(text)])).text


@pytest.mark.parametrize(
    ("old", "expected"),
    [
        ("import wpilib\nwpilib.Timer.getFPGATimestamp()\n", "import wpilib\nwpilib.Timer.get_monotonic_timestamp()\n"),
        (
            "from wpilib import DriverStation\nred = DriverStation.getAlliance() == DriverStation.Alliance.kRed\n",
            "from wpilib import Alliance, MatchState\nred = MatchState.get_alliance() == Alliance.RED\n",
        ),
        ("import rev\nrev.SparkMax(3, rev.B)\n", "import spark_units\nimport rev\nspark_units.SparkMax(3, rev.B)\n"),
        (
            "from rev import SparkFlex\nSparkFlex(deviceID=3, type=kind)\n",
            "from spark_units import SparkFlex\nSparkFlex(device_id=3, type=kind)\n",
        ),
        (
            "import rev\nclass A:\n    def getPosition(self):\n        self.e, self.n = rev.SparkMax(1).getEncoder(), 2\n"
            "        return self.e.getPosition() + self.other.getPosition()\n",
            "import spark_units\nimport rev\nclass A:\n    def getPosition(self):\n"
            "        self.e, self.n = spark_units.SparkMax(1).get_encoder(), 2\n"
            "        return self.e.get_position() + self.other.getPosition()\n",
        ),
        ("def go(state):\n    state.optimize(a)\n    return state.speed\n", "def go(state):\n    state = state.optimize(a)\n    return state.velocity\n"),
        (
            "from wpimath.kinematics import ChassisSpeeds\ns = ChassisSpeeds.fromFieldRelativeSpeeds(1, 2, 3, yaw)\n",
            "from wpimath import ChassisVelocities\ns = ChassisVelocities(1, 2, 3).to_robot_relative(yaw)\n",
        ),
        (
            "import rev\nimport wpilib\nm, p = rev.SparkMax(1), wpilib.XboxController(0)\nm.set(p.getRawAxis(1))\n",
            "import spark_units\nimport rev\nimport wpilib\nm, p = spark_units.SparkMax(1), wpilib.NiDsXboxController(0)\n"
            "m.set_throttle(p.get_hid().get_raw_axis(1))\n",
        ),
        ("import wpilib\nwpilib.DriverStation.isTest()\n", "import wpilib\nwpilib.RobotState.is_utility()\n"),
        (
            "from wpimath.geometry import Pose2d\nfrom wpimath.kinematics import ChassisSpeeds\n"
            "x = Pose2d().X() + ChassisSpeeds().vx\n",
            "from wpimath import ChassisVelocities, Pose2d\nx = Pose2d().x + ChassisVelocities().vx\n",
        ),
        ("from wpimath.units import inchesToMeters as m\nm(2)\n", "from wpimath.units import inches_to_meters as m\nm(2)\n"),
        (
            "from wpilib import SmartDashboard\nSmartDashboard.putNumberArray('a', [1.0])\n",
            "import telemetry\ntelemetry.log('a', [1.0], element_type=float)\n",
        ),
        (
            "from wpilib import SendableChooser, SmartDashboard\nc = SendableChooser()\nc.addOption('a', 1)\n"
            "SmartDashboard.putData('Auto', c)\n",
            "import tunables\nfrom tunables import Selectable\nc = Selectable()\nc.add('a', 1)\n"
            "tunables.publish('Auto', c)\n",
        ),
        (
            "from phoenix6 import hardware, utils\nm = hardware.TalonFX(3)\nm.set(0.5)\nt = utils.fpga_to_current_time(2 + 1)\n",
            'from phoenix6 import CANBus, hardware, utils\nm = hardware.TalonFX(3, CANBus(""))\nm.set_throttle(0.5)\n'
            "t = (2 + 1)\n",
        ),
        (
            "import ntcore\no = ntcore.PubSubOptions(sendAll=True)\nage = s.getLastChange() * 1e-6\n",
            "import ntcore\no = ntcore.PubSubOptions(send_all=True)\nage = s.get_last_change() * 1e-9\n",
        ),
        (
            "import wpilib\nclass R(wpilib.TimedRobot):\n    def robotInit(self):\n        self.a = 1\n",
            "import wpilib\nclass R(wpilib.TimedRobot):\n    def __init__(self):\n        super().__init__()\n        self.a = 1\n",
        ),
        (
            "import wpilib\nclass R(wpilib.TimedRobot):\n    def testPeriodic(self):\n        self.isReal()\n",
            "import wpilib\nclass R(wpilib.TimedRobot):\n    def utility_periodic(self):\n        self.is_real()\n",
        ),
        ("import helper\nhelper.isAbsolute()\n", "import helper\nhelper.isAbsolute()\n"),
        ("from photonlibpy import C\nc = C()\nc.getLatestResult()\n", "from photonlibpy import C\nc = C()\nc.getLatestResult()\n"),
        ("from pyfrc.tests import *\n", "from wpilib.testing.robot_tests import *\n"),
        ("class A:\n    def leaderSim(self): ...\nA().leaderSim()\n", "class A:\n    def leaderSim(self): ...\nA().leaderSim()\n"),
    ],
)  # fmt: skip
def test_code(old, expected):
    assert new(old) == expected


@pytest.mark.parametrize(
    ("text", "line", "word"),
    [
        ("import wpilib\n\ns = wpilib.Servo(1)\n", 3, "removed"),
        ("import wpilib\ns = wpilib.PWMSparkMax(1)\n", 2, "no pulses"),
        ("import wpilib\nx = wpilib.SmartDashboard.getNumber('a', 0)\n", 2, "tunables"),
        ("from pyfrc.physics.core import PhysicsInterface\n", 1, "robotpy sim --simcore"),
        ("from photonlibpy import PhotonCamera\n", 1, "no release"),
        ("import wpilib\nclass R(wpilib.TimedRobot):\n    def __init__(self): ...\n    def robotInit(self): ...\n", 4, "robotInit"),
    ],
)  # fmt: skip
def test_what_it_cannot_decide_is_said_with_its_line(text, line, word):
    notes = rewrite(text, set()).notes
    assert any(at == line and word in note for at, note in notes), notes


@pytest.mark.parametrize("name", ["first_robot", "rebuilt_robot", "reefscape_robot"])
def test_the_examples_become_python_without_names_of_2026(tmp_path, name):
    upgrade(EXAMPLES / name, tmp_path / "copy")
    files = list((tmp_path / "copy").rglob("*.py"))
    assert len(files) == len(list((EXAMPLES / name).rglob("*.py")))
    for path in files:
        text = path.read_text()
        ast.parse(text)
        for old in ("robotInit", "getAlliance", "DriverStation.", "wpimath.geometry", "SmartDashboard", "kRed"):
            assert old not in text, f"{path}: {old}"
    assert "2027.0.0a7" in (tmp_path / "copy" / "pyproject.toml").read_text()


def test_what_a_module_of_the_project_has_keeps_its_name_and_its_methods_do_not(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "constants.py").write_text("kPlaces = SwerveDrive4Kinematics()\n")
    (tmp_path / "a" / "robot.py").write_text(
        "import constants\nimport numpy\nconstants.kPlaces.toTwist2d(numpy.isNan)\n"
    )
    upgrade(tmp_path / "a", tmp_path / "b")
    assert "constants.kPlaces.to_twist2d(numpy.isNan)" in (tmp_path / "b" / "robot.py").read_text()


def test_a_project_with_sparks_gets_what_keeps_their_units(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "robot.py").write_text("import rev\nm = rev.SparkMax(1, k)\n")
    upgrade(tmp_path / "a", tmp_path / "b")
    ast.parse((tmp_path / "b" / "spark_units.py").read_text())
    (tmp_path / "a" / "robot.py").write_text("import wpilib\n")
    upgrade(tmp_path / "a", tmp_path / "c")
    assert not (tmp_path / "c" / "spark_units.py").exists()


def test_settings():
    text, notes = upgrade_settings('[tool.robotpy.pyfrc]\nisolated = true\nrobotpy_version = "2026.2.2"\n')
    assert text == '[tool.robotpy.testing]\nisolated = true\nrobotpy_version = "2027.0.0a7"\n' and notes == []


def test_a_folder_that_cannot_be_is_refused(tmp_path):
    with pytest.raises(ConfigError, match=r"no robot\.py"):
        upgrade(tmp_path, tmp_path / "to")
    (tmp_path / "robot.py").write_text("def (")
    with pytest.raises(ConfigError, match="line 1"):
        upgrade(tmp_path, tmp_path.with_name("other"))
    with pytest.raises(ConfigError, match="inside"):
        upgrade(tmp_path, tmp_path / "to")
    with pytest.raises(OutputError, match="already"):
        upgrade(tmp_path, tmp_path)
