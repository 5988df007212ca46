"""Robot tests in simulated time: whole projects under `robotpy test`, in separate processes."""

from __future__ import annotations

from pathlib import Path

import pytest
from page_reader import PageReader

from simcore.quantities import text_flag
from simcore.robotcode.sim import pytest_plugin

pytestmark = pytest.mark.slow


def files(folder: Path) -> set[str]:
    found = (p.relative_to(folder) for p in folder.rglob("*") if p.is_file() and "__pycache__" not in p.parts)
    return {str(p) for p in found if p.name != ".gitignore" and ".pytest_cache" not in p.parts}


AUTO = """
def test_auto(sim):
    sim.autonomous("depot", seconds=20)
    assert sim.score.blue >= 8
    print("DIGEST", sim.digest, "FACTOR", round(sim.realtime_factor, 2))

def test_again(sim):
    test_auto(sim)
"""


def test_an_auto_repeats_bit_for_bit_and_leaves_no_files(project):
    before = files(project.folder)
    code, said = project(AUTO, "-rP")
    assert code == 0, said
    digests = [line.split()[1] for line in said.splitlines() if line.startswith("DIGEST")]
    assert len(digests) == 2 and digests[0] == digests[1]
    assert files(project.folder) - before == {"tests/test_robot.py"}


def test_the_match_clock_stands_while_disabled_and_pyfrcs_fixtures_are_available(project):
    """The match clock stands while the driver station disables the robot."""
    code, said = project(
        """
from simcore.telemetry.sinks import MemorySink

def test_auto(sim):
    memory = MemorySink()
    sim.start()
    sim.add_sink(memory)
    sim.disable(seconds=0.5)
    sim.autonomous("preload", seconds=4)
    assert sim.score.blue >= 1
    sim.disable(seconds=0.5)
    sim.teleop(seconds=0.5)
    rows = []
    for seen in memory.snapshots:
        time, period = seen.doubles["Sim/Match/Time"], seen.strings["Sim/Match/Period"]
        phase = sim.game.game.clock.phase(time)
        assert abs(seen.doubles["Sim/Match/TimeLeft"] - (sim.game.game.clock.duration - time)) < 1e-9
        assert period == phase.name and seen.booleans["Sim/Match/BlueHubActive"]
        rows.append((time, period, seen.booleans["Sim/Match/Enabled"]))
    waits = [row for row in rows if not row[2]]
    assert {row[0] for row in waits[:20]} == {0.0} and len({row[0] for row in waits[-20:]}) == 1
    assert 3.9 < waits[-1][0] < 4.1 and rows[-1][1] == "transition" and 23.4 < rows[-1][0] < 23.6, rows[-1]

def test_the_field_obeys_tests_but_no_dashboard(sim):
    import ntcore
    sim.start()
    network = ntcore.NetworkTableInstance.getDefault()
    assert not network.getTopics("/Sim/Control/")
    button, pose = (network.getTable("Sim/Control").getEntry(name) for name in ("ResetField", "RobotPose"))
    button.setBoolean(True), pose.setDoubleArray([3.0, 6.0, 90.0])
    sim.run(0.1)
    assert sim.match.control.count == 0
    sim.physics.control.place_robot((3.0, 6.0, 1.0))
    sim.physics.control.spawn("Fuel", [(3.0, 6.8)])
    sim.run(0.02)
    assert sim.match.control.count == 2 and abs(sim.pose.Y() - 6.0) < 0.01 and sim.pieces.on_field == 449

def test_old(control, robot):
    with control.run_robot():
        control.step_timing(seconds=2.0, autonomous=True, enabled=True)
        assert robot.container.drivetrain.get_state().timestamp > 1.9
""",
    )
    assert code == 0 and "3 passed" in said, said


def test_the_report_names_the_cause_of_a_failure_or_misuse(project):
    """Cases are failed tests, unknown autos, conditions that never hold, errors in robot code and bad stick values."""
    code, said = project(
        """
import logging

import pytest

def test_fails(sim):
    sim.autonomous("preload", seconds=0.2)
    logging.getLogger("simcore.any").warning("the odometry is off, says this test")
    sim.physics.robot_sim.estimated_pose = (1.0, 1.0, 0.0)
    assert sim.score.blue >= 99

def test_skips(sim):
    pytest.skip("says why")

def test_refusals(sim):
    with pytest.raises(KeyError, match="Did you mean 'depot'"):
        sim.autonomous("depto")
    with pytest.raises(AssertionError, match="did not hold within 0.1 s"):
        sim.run_until(lambda: False, timeout=0.1)
    with pytest.raises(ValueError, match="from -1 to 1, got 2.0"):
        sim.xbox(0).left_y = 2.0
    with pytest.raises(ValueError, match="left_trigger"):
        sim.xbox(0).trigger = True
    for mode in ("teleop", "utility", "autonomous"):
        with pytest.raises(ValueError, match=f"seconds a keyword argument: {mode}.seconds=10."):
            getattr(sim, mode)(10)
    with pytest.raises(ValueError, match="run_until needs a function .*got False"):
        sim.run_until(sim.pieces.held < 0, timeout=1.0)
    with pytest.raises(ValueError, match="run: seconds must be a number"):
        sim.run("5")

def test_late_color(sim):
    sim.teleop(seconds=0.04)
    sim.alliance("red")
    assert sim.score > 8

def test_without():
    sim.teleop(seconds=1)

def test_nothing(sim):
    sim.teleop()
    assert sim.score.blue < 5

def test_nothing_before(sim):
    sim.teleop(seconds=0)
    sim.autonomous("preload", seconds=0.1)

def test_robot_raises(sim):
    sim.start()
    def boom():
        raise ZeroDivisionError("of the robot")
    sim.robot.container.publish = boom
    with pytest.raises(ZeroDivisionError, match="of the robot"):
        sim.run(0.1)
"""
    )
    assert code == 1 and "5 failed, 2 passed, 1 skipped" in said, said
    assert "Watchdog not fed" not in said and "overrun" not in said, said
    assert said.count("ConditionError: teleop has begun, but 0 s of it have run: say how long, e.g. teleop(sec") >= 2
    assert "look at the run: page" in said and "PytestAssertRewriteWarning" not in said
    assert "sim is a fixture, which a test asks for: def test_without(sim)" in said
    assert "_manager.py" not in said, "no line of pytest's own"
    assert "- alliance('red') after the robot was enabled changes its color and leaves it where it stands" in said
    assert "ConfigError: a score has points of red and of blue, got 8: did you mean score.blue or score.red?" in said
    for why in ("- the odometry is off, says this test", "- the program believes that it is at "):
        assert said.count(why) == 1, said
    notes = PageReader(project.folder / "test_output" / "test_fails" / "run.html").words
    assert "says this test" in notes and "the program believes that it is at " in notes
    left = {
        file for file in files(project.folder / "test_output") if not file.startswith(("test_nothing", "test_late"))
    }
    assert left == {"test_fails/run.wpilog", "test_fails/run.html"}


def test_without_physics_py_a_project_runs_and_a_failed_start_prints_one_sentence(project):
    test = "def test_it(sim):\n    sim.start()\n"
    (project.folder / "physics.py").unlink()
    code, said = project(test)  # attached as with --simcore
    assert code == 0 and "1 passed" in said, said
    (project.folder / "simcore.toml").write_text("[start]\nx = 4.6\ny = 4.03\n")
    code, said = project(test)
    assert code == 1 and "Traceback" not in said and "simcore/match" not in said, said
    last = said.rstrip().rpartition("\n\n")[2]
    assert last.startswith("simcore.toml [start]: the robot starts inside of a field element") and "\n" not in last, (
        said
    )
    code, said = project(test, SIMCORE_PHOENIX="imagined")
    assert code != 0 and "must be simulated or real" in said, said


def test_a_hanging_program_is_terminated_with_a_report_of_its_source_line(project):
    (project.folder / "pytest.ini").write_text("[pytest]\nsimcore_hang = 4\n")
    code, said = project(
        """
import time

def test_hangs(sim):
    sim.start()
    sim.robot.container.publish = lambda: time.sleep(60)
    sim.run(1.0)
"""
    )
    assert code == 1 and "exited with exit code 1" in said, said[-3000:]
    assert "no robot loop has finished in 4 s: the program is at test_robot.py:6 in <lambda>" in said, said[-3000:]


def test_running_plain_pytest_prints_the_command_for_robot_tests(project):
    code, said = project(
        "def test_it(sim):\n    sim.start()\n\ndef test_other():\n    pass\n", command=("-m", "pytest")
    )
    assert code == 1 and "1 passed, 1 error" in said, said
    assert "a robot test needs its own process" in said and "as in `python -m robotpy test -- -k test_it`" in said


def test_a_traceback_shows_only_lines_of_tests_and_programs(request):
    """The error is raised by a function that simcore's `text_flag` calls."""

    def program(text):
        return {}[text]

    with pytest.raises(KeyError) as caught:
        text_flag(program)("pose")
    assert any("quantities" in str(entry.path) for entry in caught.traceback)
    pytest_plugin._end_at_callers_line(request.config, caught)
    step, lines = caught.tb, []
    while step is not None:
        lines.append(Path(step.tb_frame.f_code.co_filename).name)
        step = step.tb_next
    assert set(lines) == {Path(__file__).name} and len(lines) == 2
