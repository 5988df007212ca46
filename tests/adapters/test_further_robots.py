"""Partners and opponents in simcore.toml next to unchanged robot code, in simulated time."""

from __future__ import annotations

from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

STARTING = Path(__file__).parent / "robots" / "starting"

EMPTY = """
def test_it(sim):
    sim.start()
    assert sim.match.game.name == "none" and sim.match.piece_positions() == {}
    start = sim.pose
    sim.autonomous(seconds=1.5)
    assert sim.pose.translation().distance(start.translation()) > 1.0
"""


def test_a_robot_drives_on_the_empty_field(project_of):
    run = project_of(STARTING)
    (run.folder / "simcore.toml").write_text('game = "none"\nfield_size = [10.0, 6.0]\n')
    code, said = run(EMPTY)
    assert code == 0, said


WHOLE = """
import os


def test_it(sim):
    sim.alliance("blue")
    sim.start()
    match = sim.match
    assert match.alliances == ["blue"] * 3 + ["red"] * 3 and not match.practice
    assert [len(robot.held) for robot in match.robots[1:]] == [8] * 5
    before = [robot.chassis.pose for robot in match.robots]
    sim.autonomous(seconds=6.0)
    sim.teleop(seconds=4.0)
    ways = [max(abs(a - b) for a, b in zip(robot.chassis.pose[:2], pose)) for robot, pose in zip(match.robots, before)]
    assert ways[1] > 0.5 and ways[4] > 0.5, ways
    assert match.score.blue > 0 and match.score.red > 0 and match.count.is_conserved
    with open(os.environ["DIGESTS"], "a") as file:
        file.write(f"{sim.digest}\\n")
"""


def test_robot_code_plays_as_one_of_six_robots_identically_in_two_processes(project_of, tmp_path):
    run, digests = project_of(STARTING), tmp_path / "digests"
    (run.folder / "simcore.toml").write_text(
        'game = "rebuilt"\nmatch = "collector:3,shuttle/collector:2,defender,climber"\n[robot]\nmass = 48.0\n'
    )
    for _ in range(2):
        code, said = run(WHOLE, DIGESTS=str(digests))
        assert code == 0, said
    first, second = digests.read_text().splitlines()
    assert first == second
