"""`simcore init`: the file it writes can be read, and it says what stands in its way."""

from __future__ import annotations

import importlib.util
import os
import re
import shlex
from dataclasses import replace
from pathlib import Path

import pytest

from simcore.cli import COMMANDS, main
from simcore.robot_file.reader import read_settings
from simcore.robot_file.robot_settings import RobotSettings
from simcore.robot_file.template import FoundCamera, FoundMotor, template

MOTORS = [
    FoundMotor(controller="TalonFX", leader=20, followers=(21, 22), opposed=(22,), gearing=0.75, inertia=0.0015),
    FoundMotor(controller="TalonFXS", leader=20, turns_freely=False, remark="it holds a weight"),
]


CAMERAS = [
    FoundCamera(maker="limelight", name="limelight-front"),
    FoundCamera(
        maker="photonvision", name="rear", place=(-0.25, 0.1, 0.5, 180.0, -10.0, 175.5), source="its estimator"
    ),
    FoundCamera(maker="questnav"),
]


@pytest.fixture
def project(tmp_path, monkeypatch):
    (tmp_path / "robot.py").write_text("")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def uncommented(text: str) -> str:
    """As a team would: the # off every line that is a key or the head of a table."""
    return re.sub(r"^# (?=\[|\w+ = [^<])", "", text, flags=re.MULTILINE)


@pytest.mark.parametrize("every", [False, True])
@pytest.mark.parametrize("motors", [None, MOTORS])
def test_the_file_as_written_means_the_defaults_and_the_motors_that_were_found(tmp_path, motors, every):
    path = tmp_path / "simcore.toml"
    path.write_text(template(motors, cameras=CAMERAS, every=every))
    settings = read_settings(path)
    assert [m.name for m in settings.mechanisms] == ([] if motors is None else ["motor20_20"])
    assert replace(settings, mechanisms=(), given=frozenset()) == RobotSettings()


def test_the_file_is_short_and_has_live_keys_alone():
    rows = [("kind", "swerve", ""), *((f"drive{k}", k, "") for k in range(19))]
    text = template(NAMED, cameras=CAMERAS, drivetrain={"rows": rows})
    assert len(text.splitlines()) < 110 and not re.search(r"^# ?(\[|\w+ = )", text, re.MULTILINE)
    assert len(template(NAMED, cameras=CAMERAS, every=True).splitlines()) > 250


def test_a_camera_that_was_found_becomes_one_with_its_place(tmp_path):
    path = tmp_path / "simcore.toml"
    text = template(cameras=CAMERAS, every=True)
    found = text.index("# Your program has these cameras")
    path.write_text(uncommented(text[found : text.index("# [[sensor]]")]))
    settings = read_settings(path)
    front, rear = settings.cameras
    assert (front.name, front.maker, front.mount.z) == ("limelight-front", "limelight", 0.4)
    assert (rear.name, rear.maker) == ("rear", "photonvision")
    m = rear.mount
    assert (m.x, m.y, m.z, m.roll_deg, m.pitch_deg, m.yaw_deg) == (-0.25, 0.1, 0.5, 180.0, -10.0, 175.5)
    assert settings.headset is not None


def test_every_key_in_the_comments_is_one_that_is_read(tmp_path):
    path = tmp_path / "simcore.toml"
    named = "".join(
        f'[[mechanism]]\nname = "{name}"\nkind = "{kind}"\nleader = {k}\ngearing = 1.0\n{more}\n'
        for k, (name, kind, more) in enumerate(
            (
                ("shooter", "flywheel", "inertia = 0.01\nfollowers = [21, 22]"),
                ("intake", "roller", ""),
                ("feeder", "roller", ""),
                ("pivot", "arm", "inertia = 0.1\nmin_deg = 0\nmax_deg = 90"),
                ("hood", "arm", "inertia = 0.1\nmin_deg = 0\nmax_deg = 40"),
                ("turret", "turret", "inertia = 0.1\nmin_deg = -90\nmax_deg = 90"),
                ("lift", "elevator", "mass = 5\ndrum_radius = 0.02\nmax_height = 1.0\nx = 0.1\nlean_deg = 0"),
                ("arm", "arm", 'inertia = 0.1\nmin_deg = 0\nmax_deg = 90\non = "lift"\nyaw_deg = 180'),
                ("claw", "roller", ""),
                ("climb", "rack", "mass = 2\npinion_radius = 0.02\ntravel = 0.5\nrise_deg = 90"),
            )
        )
    )
    text = uncommented(template(every=True))
    path.write_text(text + named)
    robot = read_settings(path)
    assert robot.bumper == (0.8, 0.8) and robot.drive_motor == "Kraken X60"
    assert robot.mechanism("shooter").followers == (21, 22)
    assert robot.game == "name" and robot.capacity == 1
    (intake,), (shooter,) = robot.intakes, robot.shooters
    assert intake.deploy == "pivot" and intake.kinds == ("Name",)
    assert shooter.hood == "hood" and shooter.turret == "turret" and shooter.gate == ("feeder",)
    (claw,), (climber,), (storage,) = robot.placers, robot.climbers, robot.storages
    assert [joint.mechanism for joint in claw.joints] == ["lift", "arm"] and claw.offset == (0.35, 0.0, 0.0)
    assert [joint.mechanism for joint in climber.joints] == ["climb"]
    assert (storage.name, storage.capacity, intake.storage, shooter.storage) == ("front", 20, "front", "front")
    assert robot.auto_starts == {"Left two piece": (2.0, 1.2, 0.0)}
    assert [(camera.name, camera.maker) for camera in robot.cameras] == [
        ("limelight", "limelight"), ("front", "photonvision")
    ]  # fmt: skip
    assert robot.headset is not None and robot.headset.frame_rate == 100.0


def test_the_page_of_keys_is_made_of_the_tables_that_read_them():
    """If it is not: python scripts/write_key_reference.py."""
    root = Path(__file__).resolve().parents[3]
    spec = importlib.util.spec_from_file_location("page", root / "scripts" / "write_key_reference.py")
    page = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(page)
    assert (root / "docs" / "simcore_toml.md").read_text(encoding="utf-8") == page.text()


def test_a_motor_that_was_found_is_a_mechanism_with_its_guess(tmp_path):
    path = tmp_path / "simcore.toml"
    text = template(MOTORS)
    path.write_text(text)
    motor = read_settings(path).mechanism("motor20_20")
    assert motor.devices == (20, 21, 22) and motor.opposed == (22,) and motor.config.gearbox.gearing == 0.75
    assert motor.config.inertia == 0.0015 and "inertia = 0.0015 " in text and not motor.guessed
    assert "# 'motor20_20', TalonFXS 20, stays a guess: it holds a weight" in text


NAMED = [
    FoundMotor(controller=controller, leader=leader, name=name, gearing=2.0, inertia=0.002, friction_volts=0.2)
    for controller, leader, name in (
        ("TalonFX", 3, "intake_roller"), ("TalonFX", 4, "intake_pivot"), ("SPARK MAX", 5, "feeder1"),
        ("TalonFX", 6, "shooter_top"), ("TalonFX", 7, "shooter_bottom"), ("TalonFX", 8, "hood"),
        ("TalonFX", 9, "wrist"), ("TalonFX", 10, ""),
    )
]  # fmt: skip


def test_names_of_attributes_name_mechanisms_and_propose_intake_and_shooter(tmp_path):
    text = template(NAMED, every=True)
    proposed = text[text.index("# Proposed by the names") : text.index("# [[storage]]")]
    path = tmp_path / "simcore.toml"
    path.write_text(text + uncommented(proposed).replace('"intake_pivot"', '"arm"').replace('"hood"', '"arm"')
                    + '[[mechanism]]\nname = "arm"\nkind = "arm"\nleader = 40\n')  # fmt: skip
    robot = read_settings(path)
    assert [m.name for m in robot.mechanisms] == [
        *("intake_roller", "intake_pivot", "feeder1", "shooter_top", "shooter_bottom", "hood", "wrist", "motor10"),
        "arm",
    ]
    assert [type(m.config).__name__ for m in robot.mechanisms[2:5]] == ["RollerConfig", *["FlywheelConfig"] * 2]
    (intake,), (shooter,) = robot.intakes, robot.shooters
    assert (intake.roller, intake.deploy) == ("intake_roller", "arm") and 'deploy = "intake_pivot"' in proposed
    assert (shooter.wheels, shooter.gate, shooter.hood) == (("shooter_top", "shooter_bottom"), ("feeder1",), "arm")
    assert 'by its name "arm", with inertia, min_deg, max_deg' in text
    assert "Proposed" not in template(MOTORS, every=True) + template(NAMED)


def test_runs_leave_nothing_behind_that_git_would_take(project, capsys):
    ignored = project / ".gitignore"
    ignored.write_text("*.pyc\n/out\nctre_sim")
    assert main(["init", "--no-look"]) == 0 and str(ignored.name) in capsys.readouterr().out
    lines = ignored.read_text().splitlines()
    assert lines[:3] == ["*.pyc", "/out", "ctre_sim"] and {"test_output/", "networktables.json", "*.wpilog"} < {*lines}
    assert not {"out/", "ctre_sim/"} & {*lines}
    assert main(["init", "--no-look", "--force"]) == 0 and ignored.read_text().splitlines() == lines
    assert ".gitignore" not in capsys.readouterr().out


@pytest.mark.parametrize(("code", "is_own"), [("", False), ("self.motor.sim_state.x()", True), ("rev.SparkSim", True)])
def test_motors_that_a_program_simulates_itself_stay_its_own(project, capsys, monkeypatch, code, is_own):
    (project / "robot.py").write_text(code)
    found = (NAMED[:1], [], [], {"rows": [["kind", "tank", ""], ["left", [1], ""]]}, "")
    monkeypatch.setattr("simcore.robot_file.init_command.find_devices", lambda _: found)
    assert main(["init"]) == 0
    assert [m.name for m in read_settings(project / "simcore.toml").mechanisms] == ([] if is_own else ["intake_roller"])
    text = (project / "simcore.toml").read_text()
    assert ("stays a guess: your program has a simulation of its own" in text) is is_own
    said = capsys.readouterr().out
    assert "cannot be written as a table: simcore.toml [drivetrain]: left and right must both name motors" in said


def test_init_writes_the_file(project, capsys):
    assert main(["init", "--no-look"]) == 0
    assert "python -m robotpy sim --simcore" in capsys.readouterr().out
    short = (project / "simcore.toml").read_text()
    assert main(["init", "--no-look", "--all", "--force"]) == 0
    assert len(short.splitlines()) < 20 < 200 < len((project / "simcore.toml").read_text().splitlines())


def test_init_overwrites_only_when_told(project, capsys):
    (project / "simcore.toml").write_text("[robot]\nmass = 40")
    assert main(["init", "--no-look"]) == 1
    assert "simcore init --force overwrites it" in capsys.readouterr().err
    assert read_settings(project / "simcore.toml").mass == 40.0
    assert main(["init", "--no-look", "--force"]) == 0
    assert read_settings(project / "simcore.toml").mass == 55.0


def test_init_finds_robot_py_wherever_the_project_keeps_it(project, capsys):
    (project / "robot.py").unlink()
    for place in ("src", ".venv/lib", "tests"):
        (project / place).mkdir(parents=True)
        (project / place / "robot.py").write_text("")
    assert main(["init", "--no-look"]) == 0
    assert "python -m robotpy --main src/robot.py sim --simcore" in capsys.readouterr().out.replace(os.sep, "/")
    assert (project / "src" / "simcore.toml").exists()
    (project / "other").mkdir()
    (project / "other" / "robot.py").write_text("")
    assert main(["init", "--no-look"]) == 1
    assert "2 robot.py in" in capsys.readouterr().err
    (project / "other" / "rocky.py").write_text("")
    assert main(["init", "--no-look", str(project / "other" / "rocky.py")]) == 0
    assert (project / "other" / "simcore.toml").exists()


def test_init_wants_a_robot(tmp_path, capsys):
    assert main(["init", str(tmp_path)]) == 1
    assert f"no robot.py in {tmp_path}" in capsys.readouterr().err


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="this user may write everywhere")
def test_init_in_a_folder_that_cannot_be_written(project, capsys):
    project.chmod(0o500)
    try:
        assert main(["init", "--no-look"]) == 1
    finally:
        project.chmod(0o700)
    assert "cannot write" in capsys.readouterr().err


def test_init_says_why_it_could_not_write(project, capsys, monkeypatch):
    (project / "simcore.toml").mkdir()
    assert main(["init", "--no-look", "--force"]) == 1
    assert "simcore init: cannot write" in capsys.readouterr().err


def test_a_program_that_fails_does_not_keep_init_from_writing(project, capsys):
    (project / "robot.py").write_text("raise RuntimeError('no such gamepad')")
    assert main(["init"]) == 0
    said = capsys.readouterr().out
    assert "could not look at the robot program" in said
    assert (project / "simcore.toml").exists()


def test_every_subcommand_of_the_table_explains_itself(capsys):
    for name in COMMANDS:
        with pytest.raises(SystemExit) as end:
            main([name, "--help"])
        assert end.value.code == 0
        assert COMMANDS[name].help in capsys.readouterr().out.replace("\n", " ")


def test_an_unknown_subcommand_is_a_wrong_call(capsys):
    with pytest.raises(SystemExit) as end:
        main(["inti"])
    assert end.value.code == 2
    assert "init" in capsys.readouterr().err


@pytest.fixture
def repository(project):
    """A robot in a folder of a git repository, with what RobotPy installs for it."""
    (project / ".git").mkdir()
    robot = project / "2026 robot"
    robot.mkdir()
    (robot / "robot.py").write_text("")
    (project / "robot.py").unlink()
    told = 'robotpy_version = "2026.2.2"\ncomponents = ["commands2"]\nrequires = ["phoenix6>=26.1,<27"]\n'
    (robot / "pyproject.toml").write_text(f"[tool.robotpy]\n{told}")
    return project


def test_a_workflow_installs_what_the_project_needs_and_runs_its_tests(repository, capsys):
    yaml = pytest.importorskip("yaml")
    source = "git+https://github.com/team/simcore@v1"
    words = ["init", "--ci", "--source", source, "2026 robot"]
    assert main(words) == 0
    path = repository / ".github" / "workflows" / "robot-tests.yml"
    job = yaml.safe_load(path.read_text())["jobs"]["robot-tests"]
    assert job["defaults"]["run"]["working-directory"] == "2026 robot"
    steps = [step["run"] for step in job["steps"] if "run" in step]
    assert shlex.split(steps[0]) == [
        *("python", "-m", "pip", "install", f"simcore[phoenix6,robotpy] @ {source}"),
        *("robotpy[commands2]==2026.2.2", "phoenix6>=26.1,<27"),
    ]
    assert steps[1:] == ["python -m pytest"]
    assert job["steps"][-1]["with"]["path"] == "2026 robot/test_output"
    assert not (repository / "2026 robot" / "simcore.toml").exists()
    (repository / "2026 robot" / "requirements.txt").write_text("numpy\n")
    assert main(words) == 1 and "init --ci --force overwrites it" in capsys.readouterr().err
    assert main([*words, "--force"]) == 0 and "-r requirements.txt" in path.read_text()


def test_a_workflow_that_could_not_work_is_refused(repository, capsys, monkeypatch):
    monkeypatch.setattr("simcore.robot_file.ci_workflow.source_address", lambda: "")
    assert main(["init", "--ci", "2026 robot"]) == 1
    assert "which GitHub cannot reach: say where it is, e.g. simcore init --ci --source git+" in capsys.readouterr().err
    (repository / ".git").rmdir()
    assert main(["init", "--ci", "--source", "git+https://x/y", "2026 robot"]) == 1
    assert "is in no git repository" in capsys.readouterr().err
