"""What cannot work is refused before the first tick, and nothing is left open."""

from __future__ import annotations

import math
import subprocess
import sys

import numpy as np
import pytest
from games.rebuilt.runner import play_auto
from games.rebuilt.sim import RebuiltConfig, RebuiltSim, RobotEntry

from games.rebuilt.autos import Auto
from games.rebuilt.fuel import FUEL
from games.rebuilt.scoring import RebuiltScoring
from games.rebuilt.staging import Staging
from simcore.errors import ConfigError, EngineError, NonFiniteError
from simcore.physics.bullet import BulletEngine
from simcore.physics.world import PhysicsWorld
from simcore.pieces.piece_manager import GamePieceManager
from simcore.pieces.pool import PieceStatus
from simcore.pieces.wake_grid import WakeSettings
from simcore.telemetry.sinks import MemorySink


@pytest.mark.parametrize(
    ("robots", "words"),
    [
        ((RobotEntry(alliance="green"),), "alliance must be 'blue' or 'red'"),  # type: ignore[arg-type]
        ((RobotEntry(), RobotEntry()), "start inside of each other"),
        ((RobotEntry(pose=(4.6, 4.0, 0.0)),), "starts inside of a field element"),
        (tuple(RobotEntry(pose=(1.0 + i, 2.0, 0.0)) for i in range(8)), "8 robots"),
    ],
)
def test_a_match_that_cannot_start_is_refused(robots, words):
    with pytest.raises(ConfigError, match=words):
        RebuiltSim(RebuiltConfig(robots=robots))


def test_more_robot_codes_than_robots_are_refused():
    with pytest.raises(ConfigError, match="2 robot codes for 1 robots"):
        RebuiltSim(robot_code=[None, None])


def test_a_script_with_a_bug_passes_its_error_on_and_leaves_nothing_open():
    def script(robot):
        yield from robot.wait(0.1)
        raise RuntimeError("student bug")

    sink = MemorySink()
    seen = []
    auto = Auto(name="bug", summary="", script=script, start=(2.5, 5.6, 0.0), preload=0)
    with pytest.raises(RuntimeError, match="student bug"):
        play_auto(auto, seconds=1.0, sinks=[sink], on_tick=seen.append)
    assert len(sink.snapshots) == 5, "the log goes up to the bug"
    assert sink.closed
    with pytest.raises(EngineError, match="closed"):
        seen[0].world.step(0.02)


def test_a_sink_that_cannot_be_closed_keeps_nobody_else_open():
    class Full(MemorySink):
        def close(self):
            raise OSError("disk full")

    other = MemorySink()
    sim = RebuiltSim(RebuiltConfig(staging=Staging(neutral=0, depot=0, chute=0)), sinks=[Full(), other])
    with pytest.raises(OSError, match="disk full"):
        sim.close()
    assert other.closed
    with pytest.raises(EngineError, match="closed"):
        sim.tick()


def test_requests_for_pieces_are_checked_before_the_first_change():
    with PhysicsWorld() as world:
        pieces = GamePieceManager(world, [(FUEL, 4)], field_size=(16.0, 8.0))
        slots = pieces.spawn("Fuel", np.array([[2.0, 2.0, 0.075], [3.0, 2.0, 0.075]]))
        free = np.array([3])
        for request in (
            lambda: pieces.score(free),
            lambda: pieces.hold(free, 0),
            lambda: pieces.push(free, np.ones((1, 3))),
            lambda: pieces.release(free, np.ones((1, 3))),
        ):
            with pytest.raises(ConfigError, match="piece 3 is FREE"):
                request()
        bad = np.array([[1.0, 1.0, 1.0], [math.nan, 1.0, 1.0]])
        for request in (lambda: pieces.release(slots, bad), lambda: pieces.push(slots, bad)):
            with pytest.raises(NonFiniteError, match="three finite numbers"):
                request()
        assert pieces.count(PieceStatus.ASLEEP) == 2


def test_a_pushed_piece_flies_as_a_launched_one_at_any_substep():
    """x where a ball pushed at 5 m/s from 1.5 m is after half a second; 50 mm apart before the push was corrected."""
    ends = []
    for substeps in (1, 4, 16):
        with PhysicsWorld() as world:
            pieces = GamePieceManager(world, [(FUEL, 1)], field_size=(16.0, 8.0))
            slots = pieces.spawn("Fuel", np.array([[2.0, 4.0, 1.5]]))
            pieces.push(slots, np.array([[5.0, 0.0, 0.0]]), flying=True)
            for _ in range(25):
                pieces.wake_reachable([], 0.02)
                world.step(0.02, substeps=substeps, before_substep=pieces.before_substep)
                pieces.gather(0.02)
            ends.append(pieces.state.pos[0].copy())
    assert np.ptp(np.array(ends), axis=0).max() < 0.003


@pytest.mark.parametrize("setting", [{"chunk_linger": -5}, {"chunk_linger": 1.5}, {"waking_speed": math.nan}])
def test_proximity_settings_that_cannot_work_are_refused(setting):
    with pytest.raises(ConfigError, match=next(iter(setting))):
        WakeSettings(**setting)


def test_a_world_has_the_gravity_of_its_engine():
    with PhysicsWorld(engine=BulletEngine(gravity=1.6)) as world:
        assert world.gravity == 1.6
    engine = BulletEngine()
    with engine, pytest.raises(ConfigError, match="gravity"):
        PhysicsWorld(engine=engine, gravity=1.6)


@pytest.mark.parametrize("seed", range(6))
def test_the_coin_of_a_mirrored_match_is_mirrored(seed):
    blue = RebuiltScoring(np.random.default_rng(seed), favorite="blue").first_inactive
    red = RebuiltScoring(np.random.default_rng(seed), favorite="red").first_inactive
    assert {blue, red} == {"blue", "red"}


@pytest.mark.skipif(sys.platform == "win32", reason="no such pipe on Windows")
def test_a_reader_that_goes_away_is_no_error():
    run = subprocess.Popen(
        [sys.executable, "-m", "games.rebuilt", "--list"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert run.stdout is not None and run.stderr is not None
    run.stdout.close()
    assert run.wait(30) == 0
    assert b"Traceback" not in run.stderr.read()
    run.stderr.close()
