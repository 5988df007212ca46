"""A seed repeats a match: in another process, after other matches and after a reset; a second auto starts at zero."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from game_table import GAMES

from simcore.match.game import Game, RobotEntry
from simcore.match.match import Match
from simcore.match.runner import play_auto
from simcore.telemetry.sinks import MemorySink
from simcore.telemetry.wpilog import WpilogSink
from simcore.testing.game_laws import check_questions

HERE = Path(__file__).resolve().parent
SECONDS = {"rebuilt": 3.0, "reefscape": 5.0, "crates": 3.0}
"""Time after which random numbers have had an effect [s]."""

CODE = """
import sys
from game_table import GAMES
from simcore.match.runner import play_auto
run = play_auto(GAMES[sys.argv[1]], seconds=float(sys.argv[2]), seed=int(sys.argv[3]))
print(run.report.digest)
"""


def digest(game: Game, seed: int, **settings) -> str:
    run = play_auto(game, seconds=SECONDS[game.name], seed=seed, **settings)
    run.match.close()
    return run.report.digest


def test_a_seed_gives_the_same_match_in_another_process_and_after_other_matches(game):
    before = digest(game, 8)
    digest(GAMES["crates"], 2)
    mine = digest(game, 3)
    path = os.pathsep.join((str(HERE.parents[1]), str(HERE)))
    other = subprocess.run(
        [sys.executable, "-c", CODE, game.name, str(SECONDS[game.name]), "3"],
        env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert other.returncode == 0, other.stderr
    assert other.stdout.strip() == mine
    assert before != mine


def test_sinks_do_not_change_the_match(game, tmp_path):
    sinks = [MemorySink(), WpilogSink(tmp_path / "run.wpilog")]
    assert digest(game, 0, sinks=sinks) == digest(game, 0)


def test_queries_to_the_rules_leave_the_match_unchanged(game):
    """Displays query piece values, the game message and counts; the match stays the same."""
    check_questions(game, next(iter(game.autos)), seconds=1.0)


def test_changing_only_the_status_of_a_piece_changes_the_digest(game):
    """Status is part of the state: a piece in the robot differs from a piece with the human player."""
    digests = []
    for kept in (False, True):
        with Match(game, seed=1) as match:
            (slot,) = match.robots[0].held[:1]
            if not kept:
                match.robots[0].storage.discard(slot)
                match.pieces.state.status[slot] = 1  # staged
            match.tick()
            digests.append(match.digest.hexdigest())
    assert digests[0] != digests[1]


def with_auto(game: Game, **settings) -> Match:
    auto = game.auto()
    match = Match(game, robots=(RobotEntry(start=auto.start, preload=auto.preload),), **settings)
    match.set_controller(0, auto.controller(match, "blue"))
    return match


def replay(match: Match, times: int, seconds: float) -> tuple[set[str], int]:
    """Play and reset repeatedly; return the digests, and the growth in objects after the first fifth."""
    digests, start = set(), 0
    for number in range(times):
        match.reset()
        match.play(seconds)
        digests.add(match.digest.hexdigest())
        assert match.count.is_conserved
        if number == times // 5:
            gc.collect()
            start = len(gc.get_objects())
    gc.collect()
    return digests, len(gc.get_objects()) - start


def test_a_reset_match_repeats_exactly(game, whole):
    with with_auto(game, seed=5) as match:
        match.play(0.2)
        first = match.digest.hexdigest()
        digests, more = replay(match, 6 if whole else 3, 0.2)
        assert digests == {first}
        assert more < 200, "nothing of a run stays"
        places = match.pieces.state.pos.copy()
        match.reset(seed=6)
        assert match.seed == 6 and not np.array_equal(match.pieces.state.pos, places)


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="reads Linux' figures of memory")
def test_resets_leak_no_memory(game, whole):
    """The memory includes that of the engine; 36 resets of one game, 300 of each game with `--whole`.

    PyBullet never frees the hulls of a moving compound shape: 9 KB each, 24 in a coral.
    """
    if game.name != "crates" and not whole:
        pytest.skip("sampled: --whole plays all games")

    def resident() -> int:
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE")

    with with_auto(game, seed=5) as match:
        replay(match, 60 if whole else 12, 0.1)
        before = resident()
        digests, more = replay(match, 240 if whole else 24, 0.1)
        assert len(digests) == 1 and more < 200
        lost = (
            0.0 if match.world.engine.name == "mujoco" or game.name != "reefscape" else 0.23e6 * (240 if whole else 24)
        )
        assert resident() - before < 8e6 + lost


def test_a_second_auto_begins_with_time_and_score_at_zero(game):
    """In `robotpy sim`, a driver enables auto again in this way; pieces on the field stay in place."""
    with with_auto(game) as match:
        match.start_mode("auto")
        match.play(5.0)
        assert match.record.shots or match.record.taken_in or match.record.put_down
        match.start_mode("teleop")
        assert match.timer.time == game.clock.start_of_mode("teleop")
        match.play(0.2)
        match.start_mode("auto")
        assert (match.score.total, match.record.shots, match.record.taken_in, match.record.hits) == (0, [], [], 0)
        assert match.timer.time == 0.0 and match.timer.phase.name == "auto"
        assert not any(match.rules.breakdown().values()) and not any(match.tracker.pieces.values())
        assert match.tracker.events == []
        match.play(0.1)
        assert match.timer.time == pytest.approx(0.1)
        assert match.count.is_conserved


def test_the_end_hook_of_the_rules_is_called_once(game):
    ends = []
    with Match(game, robots=(RobotEntry(preload=0),)) as match:
        match.rules.end = lambda: ends.append(match.timer.time)  # type: ignore[method-assign]
        match.timer._start = game.clock.duration - 0.1
        match.play(0.3)
        assert ends == [pytest.approx(game.clock.duration)]
        assert not match.timer.is_enabled and match.timer.remaining == 0.0
