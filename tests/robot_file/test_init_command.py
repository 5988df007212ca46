"""Command `simcore init`: the written file can be read, and obstacles are reported."""

import importlib.util
import os
import re
import shlex
from dataclasses import replace
from pathlib import Path

import pytest

from simcore.cli import COMMANDS, main
from simcore.match.registry import installed_games
from simcore.robot_file.reader import read_settings
from simcore.robot_file.robot_settings import RobotSettings
from simcore.robot_file.template import template


def motor_row(controller, leader, name="", **more):
    """Return a motor as a row of the survey."""
    row = {"controller": controller, "leader": leader, "name": name, "followers": [], "opposed": [], "motor": ""}
    row |= {"gearing": 1.0, "inertia": 0.0, "friction_volts": 0.0, "turns_freely": True, "remark": ""}
    return {**row, **more}


MOTORS = [
    motor_row("TalonFX", 20, followers=[21, 22], opposed=[22], gearing=0.75, inertia=0.0015),
    motor_row("TalonFXS", 20, turns_freely=False, remark="it holds a weight"),
]
CAMERAS = [
    {"maker": "limelight", "name": "limelight-front"},
    {"maker": "photonvision", "name": "rear", "source": "its estimator"},
    {"maker": "questnav"},
]


@pytest.fixture
def project(tmp_path, monkeypatch):
    (tmp_path / "robot.py").write_text("")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("every", [False, True])
@pytest.mark.parametrize("motors", [[], MOTORS])
def test_the_file_that_init_writes_is_read_as_defaults_plus_the_found_motors(tmp_path, motors, every):
    path = tmp_path / "simcore.toml"
    path.write_text(template({"motors": motors, "cameras": CAMERAS}, every=every))
    settings = read_settings(path)
    assert [m.name for m in settings.mechanisms] == (["motor20_20"] if motors else [])
    assert replace(settings, mechanisms=(), given=frozenset()) == RobotSettings()


def test_the_file_that_init_writes_is_short_and_has_only_active_keys():
    rows = [("kind", "swerve", ""), *((f"drive{k}", k, "") for k in range(19))]
    text = template({"motors": NAMED, "cameras": CAMERAS, "drivetrain": {"rows": rows}})
    assert len(text.splitlines()) < 110 and not re.search(r"^# ?(\[|\w+ = )", text, re.MULTILINE)
    assert len(template({"motors": NAMED, "cameras": CAMERAS}, every=True).splitlines()) > 250


def test_the_written_file_names_found_cameras_and_ports():
    text = template({"cameras": CAMERAS, "ports": [{"model": "DIO", "channels": [0, 1], "made_by": "Encoder"}]})
    for line in ("camera limelight-front\n", "camera rear: placed by its estimator\n", "DIO 0 1: Encoder\n"):
        assert f"# {line}" in text


def test_the_keys_page_is_generated_from_the_tables():
    """If this fails, run python scripts/write_key_reference.py."""
    root = Path(__file__).resolve().parents[2]
    spec = importlib.util.spec_from_file_location("page", root / "scripts" / "write_key_reference.py")
    page = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(page)
    assert (root / "docs" / "simcore_toml.md").read_text(encoding="utf-8") == page.text()


def test_a_found_motor_becomes_a_mechanism_with_its_measured_gearing_and_inertia(tmp_path):
    path = tmp_path / "simcore.toml"
    text = template({"motors": MOTORS})
    path.write_text(text)
    motor = read_settings(path).mechanism("motor20_20")
    assert (
        motor.channels == (20, 21, 22) and motor.opposed == motor.followers[1:] and motor.config.gearbox.gearing == 0.75
    )
    assert motor.config.inertia == 0.0015 and "inertia = 0.0015 " in text and not motor.guessed
    assert "# 'motor20_20', TalonFXS 20, stays a guess: it holds a weight" in text


NAMED = [
    motor_row(controller, leader, name, gearing=2.0, inertia=0.002, friction_volts=0.2)
    for controller, leader, name in (
        ("TalonFX", 3, "intake_roller"), ("TalonFX", 4, "intake_pivot"), ("SPARK MAX", 5, "feeder1"),
        ("TalonFX", 6, "shooter_top"), ("TalonFX", 7, "shooter_bottom"), ("TalonFX", 8, "hood"),
        ("TalonFX", 9, "wrist"), ("TalonFX", 10, ""),
    )
]  # fmt: skip


def test_attribute_names_determine_the_names_and_kinds_of_mechanisms(tmp_path):
    text = template({"motors": NAMED})
    path = tmp_path / "simcore.toml"
    path.write_text(text)
    robot = read_settings(path)
    assert [m.name for m in robot.mechanisms] == [
        *("intake_roller", "intake_pivot", "feeder1", "shooter_top", "shooter_bottom", "hood", "wrist", "motor10")
    ]
    assert [type(m.config).__name__ for m in robot.mechanisms[2:5]] == ["RollerConfig", *["FlywheelConfig"] * 2]
    assert 'by its name "arm", with inertia, min_deg, max_deg' in text


def test_gitignore_covers_all_files_that_runs_leave_behind(project, capsys):
    ignored = project / ".gitignore"
    ignored.write_text("*.pyc\n/out\nctre_sim")
    assert main(["init", "--no-look"]) == 0 and str(ignored.name) in capsys.readouterr().out
    lines = ignored.read_text().splitlines()
    assert lines[:3] == ["*.pyc", "/out", "ctre_sim"] and {"test_output/", "networktables.json", "*.wpilog"} < {*lines}
    assert "simgui.json" in lines and not {"simgui*.json", "simgui-ds.json"} & {*lines}  # the keyboard is kept
    assert not {"out/", "ctre_sim/"} & {*lines}
    assert main(["init", "--no-look", "--force"]) == 0 and ignored.read_text().splitlines() == lines
    assert ".gitignore" not in capsys.readouterr().out


@pytest.mark.parametrize(("code", "is_own"), [("", False), ("self.motor.sim_state.x()", True), ("rev.SparkSim", True)])
def test_init_omits_motors_that_the_program_simulates_itself(project, capsys, monkeypatch, code, is_own):
    (project / "robot.py").write_text(code)
    rows = [["kind", "tank", ""], ["left", [1], ""]]
    found = {"motors": [dict(NAMED[0])], "drivetrain": {"rows": rows}}
    monkeypatch.setattr("simcore.robot_file.init_command.survey", lambda *_: found)
    assert main(["init"]) == 0
    assert [m.name for m in read_settings(project / "simcore.toml").mechanisms] == ([] if is_own else ["intake_roller"])
    text = (project / "simcore.toml").read_text()
    assert ("stays a guess: your program has its own simulation" in text) is is_own
    said = capsys.readouterr().out
    assert "cannot be written as a table: simcore.toml [drivetrain]: left and right must both name motors" in said


def test_a_timeout_of_the_program_keeps_the_written_drivetrain_table(project, capsys, monkeypatch):
    """The program loaded without the file, so a timeout on a busy computer is no evidence against its table."""
    found = {"drivetrain": {"rows": [["kind", "tank", ""], ["reversed", True, ""]]}}
    answers = iter([found, {"error": "it did not start within 180 s"}])
    monkeypatch.setattr("simcore.robot_file.init_command.survey", lambda *_: next(answers))
    assert main(["init"]) == 1
    assert "does not start with it: it did not start within 180 s" in capsys.readouterr().out
    assert read_settings(project / "simcore.toml").drivetrain.kind == "tank"


@pytest.mark.parametrize(("keys", "shown"), [([], 0), (["real", "serial_number"], 2)])
def test_keys_for_is_real_and_serial_number_calls_in_the_program_are_commented_out(tmp_path, keys, shown):
    path = tmp_path / "simcore.toml"
    path.write_text(template({"answering_keys": keys}))
    assert len(re.findall(r"^# (?:real = false|serial_number = ).*", path.read_text(), re.MULTILINE)) == shown
    assert replace(read_settings(path), given=frozenset()) == RobotSettings()


def test_init_writes_a_short_file_and_with_all_a_long_file(project, capsys):
    assert main(["init", "--no-look"]) == 0
    assert "python -m robotpy sim --simcore" in capsys.readouterr().out
    short = (project / "simcore.toml").read_text()
    assert main(["init", "--no-look", "--all", "--force"]) == 0
    assert len(short.splitlines()) < 22 < 200 < len((project / "simcore.toml").read_text().splitlines())


def test_init_overwrites_a_file_only_with_force(project, capsys):
    (project / "simcore.toml").write_text("[robot]\nmass = 40")
    assert main(["init", "--no-look"]) == 1
    assert "simcore init --force overwrites it" in capsys.readouterr().err
    assert read_settings(project / "simcore.toml").mass == 40.0
    assert main(["init", "--no-look", "--force"]) == 0
    assert read_settings(project / "simcore.toml").mass == 55.0


def test_init_finds_robot_py_in_a_subfolder_unless_there_are_two(project, capsys):
    (project / "robot.py").unlink()
    for place in ("src", ".venv", ".venv/lib", "tests"):
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


def test_init_needs_a_robot_py(tmp_path, capsys):
    assert main(["init", str(tmp_path)]) == 1
    assert f"no robot.py in {tmp_path}" in capsys.readouterr().err


def test_init_reports_that_the_file_cannot_be_written(project, capsys, monkeypatch):
    (project / "simcore.toml").mkdir()
    assert main(["init", "--no-look", "--force"]) == 1
    assert "simcore init: cannot write" in capsys.readouterr().err


def test_init_writes_no_file_for_a_program_that_does_not_load(project, capsys):
    pytest.importorskip("phoenix6")
    (project / "robot.py").write_text("import no_such_package")
    assert main(["init"]) == 1
    said = capsys.readouterr()
    assert "does not load (ModuleNotFoundError: No module named 'no_such_package')" in said.err and not said.out
    assert not (project / "simcore.toml").exists()


def test_a_file_that_stops_the_program_from_starting_is_reported(project, capsys, monkeypatch):
    answers = {(): {"motors": [dict(NAMED[0])]}, ("described", "started"): {"start_problem": "no motor 7"}}
    monkeypatch.setattr("simcore.robot_file.init_command.survey", lambda path, *options: answers[options])
    assert main(["init"]) == 1
    assert "but the program does not start with it: no motor 7" in capsys.readouterr().out


def test_a_game_that_is_installed_later_does_not_change_the_game_of_a_project(project, monkeypatch):
    assert main(["init", "--no-look"]) == 0
    newest = next(iter(installed_games()))
    assert read_settings(project / "simcore.toml").game == newest
    monkeypatch.setattr("simcore.robot_file.init_command.installed_games", dict)  # no game: the key is left out
    assert main(["init", "--no-look", "--force"]) == 0 and read_settings(project / "simcore.toml").game is None


def test_every_subcommand_in_the_table_has_a_help_text(capsys):
    for name in COMMANDS:
        with pytest.raises(SystemExit) as end:
            main([name, "--help"])
        assert end.value.code == 0
        assert COMMANDS[name].help in capsys.readouterr().out.replace("\n", " ")


def test_an_unknown_subcommand_is_a_usage_error(capsys):
    with pytest.raises(SystemExit) as end:
        main(["inti"])
    assert end.value.code == 2
    assert "init" in capsys.readouterr().err


@pytest.fixture
def repository(project):
    """Return a robot project in a folder of a git repository, with the RobotPy packages that it requires."""
    (project / ".git").mkdir()
    robot = project / "2026 robot"
    robot.mkdir()
    (robot / "robot.py").write_text("")
    (project / "robot.py").unlink()
    told = 'robotpy_version = "2026.2.2"\ncomponents = ["commands2"]\nrequires = ["phoenix6>=26.1,<27"]\n'
    (robot / "pyproject.toml").write_text(f"[tool.robotpy]\n{told}")
    return project


def test_a_workflow_installs_the_packages_of_the_project_and_runs_its_tests(repository, capsys):
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
    assert steps[1:] == ["python -m robotpy test"]
    assert job["steps"][-1]["with"]["path"] == "2026 robot/test_output"
    assert not (repository / "2026 robot" / "simcore.toml").exists()
    (repository / "2026 robot" / "requirements.txt").write_text("numpy\n")
    assert main(words) == 1 and "init --ci --force overwrites it" in capsys.readouterr().err
    assert main([*words, "--force"]) == 0 and "-r requirements.txt" in path.read_text()


def test_init_refuses_a_workflow_without_a_reachable_source_or_a_git_repository(repository, capsys, monkeypatch):
    monkeypatch.setattr("simcore.robot_file.init_command.shared_requirement", lambda *extras, source: source)
    assert main(["init", "--ci", "2026 robot"]) == 1
    assert (
        "which GitHub cannot reach: say where GitHub gets it, as in `simcore init --ci --source git+"
        in capsys.readouterr().err
    )
    (repository / ".git").rmdir()
    assert main(["init", "--ci", "--source", "git+https://x/y", "2026 robot"]) == 1
    assert "is not in a git repository" in capsys.readouterr().err


def test_simcores_own_folder_is_refused_as_a_robot_project(capsys):
    assert main(["init", str(Path(__file__).resolve().parents[2])]) == 1
    assert "is simcore's own folder: go to that of your robot.py" in capsys.readouterr().err
