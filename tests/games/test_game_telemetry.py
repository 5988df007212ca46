"""Telemetry of every game: the log holds the values of the match."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from games.rebuilt.robot import rebuilt_robot
from simcore.match.match import Match
from simcore.match.runner import play_auto
from simcore.robot.battery import BatteryConfig
from simcore.telemetry.sinks import MemorySink
from simcore.telemetry.wpilog import WpilogSink, read_log


def test_a_log_read_back_equals_the_match(game, tmp_path):
    """The test compares poses, ids, held pieces and the clock at every tick."""
    truth = []

    def look(match: Match) -> None:
        state = match.pieces.state
        kinds = {}
        for kind in match.pieces.types:
            slots = match.pieces.on_field(kind.name)
            held = [slot for slot in match.robots[0].held if match.pieces.types[state.kind[slot]] is kind]
            kinds[kind.name] = (slots.tolist(), state.pos[slots].copy(), held)
        robot = match.robots[0]
        truth.append((robot.chassis.pos, kinds, match.timer.time, robot.battery.voltage, match.score.total))

    path = tmp_path / "run.wpilog"
    run = play_auto(game, seconds=6.0, seed=1, sinks=[WpilogSink(path, bulk_period=0.02)], on_tick=look)
    chassis = run.match.robots[0].chassis.config
    placers = len(run.match.robots[0].placers)
    run.match.close()
    log = read_log(path)
    held_at_all = 0
    for tick, (pos, kinds, time, volts, total) in enumerate(truth):
        shown = log.snapshot_at(0.02 * (tick + 1) + 1e-4)
        assert shown.poses["Sim/Robot/Pose3d"][:3] == pytest.approx(pos, abs=1e-6)
        assert shown.doubles["Sim/Match/Time"] == pytest.approx(time)
        assert shown.doubles["Sim/Debug/BatteryVoltage"] == pytest.approx(volts, abs=5.1e-4)
        assert shown.integers["Sim/Score/Total"] == total
        for name, (slots, places, held) in kinds.items():
            assert shown.integer_arrays[f"Sim/PieceIds/{name}"].tolist() == slots
            assert shown.pose_arrays[f"Sim/GamePieces/{name}"][:, :3] == pytest.approx(places)
            assert shown.integer_arrays[f"Sim/HeldIds/{name}"].tolist() == held
            inside = shown.pose_arrays[f"Sim/Held/{name}"][:, :3] - np.array(pos)
            assert len(inside) == len(held)
            held_at_all += len(held)
            reach = np.hypot(chassis.bumper_length, chassis.bumper_width) / 2 + (0.5 if placers else 0.0)
            assert (np.hypot(inside[:, 0], inside[:, 1]) < reach).all(), "inside of the bumpers, or in the claw"
    assert held_at_all > 0


def test_the_clock_keys_of_telemetry_are_consistent(game):
    """The match runs through the end of auto, the pause and the start of teleop."""
    sink = MemorySink()
    auto = game.clock.duration if not game.clock.phases else game.clock.phases[0].duration
    with Match(game, sinks=[sink]) as match:
        match.timer._start = auto - 0.2
        pause = game.clock.phases[1]
        match.play(0.4)
        match.timer._start = auto + pause.duration - 0.2 - match.timer._ticks * 0.02
        match.play(0.4)
    seen = set()
    for s in sink.snapshots:
        time, period = s.doubles["Sim/Match/Time"], s.strings["Sim/Match/Period"]
        assert s.doubles["Sim/Match/TimeLeft"] == pytest.approx(game.clock.duration - time)
        assert game.clock.phase(time).name == period
        assert s.booleans["Sim/Match/Enabled"] == (game.clock.phase(time).mode != "disabled")
        seen.add(period)
    assert seen == {phase.name for phase in game.clock.phases[:3]}


@pytest.mark.engines("bullet", "mujoco")
def test_a_robot_at_rest_logs_only_the_clock(tmp_path):
    """After driving and coasting down, wheels, rollers and pose are exactly at rest."""

    def drive_and_stop(robot, time):
        is_on = 0.0 < time < 0.4
        robot.drive.set_volts([3.0 * is_on] * 4, [0.0] * 4)
        for name, mechanism in robot.mechanisms.items():
            mechanism.set_volts(6.0 * is_on * (name != "hood"))

    path = tmp_path / "rest.wpilog"
    config = replace(rebuilt_robot(), battery=BatteryConfig.stiff())
    with Match.bare(config, sinks=[WpilogSink(path)], controllers=[drive_and_stop]) as match:
        match.play(15.0)
        robot = match.robots[0]
        assert robot.chassis.pos[0] > 2.1 and robot.drive.wheel_speeds() == [0.0] * 4
        assert [mechanism.velocity for mechanism in robot.mechanisms.values()] == [0.0] * 6
    late = {key: int((column.times > 13.0).sum()) for key, column in read_log(path).columns.items()}
    assert {late.pop("Sim/Match/Time"), late.pop("Sim/Match/TimeLeft")} == {100}
    assert late.pop("Sim/Robot/EstimatedPose") < 40, "a gyro's noise, to 1 mrad"
    late.pop("Sim/Warnings", None)  # shortfalls, logged at the end
    assert sum(late.values()) <= 1, {key: count for key, count in late.items() if count}  # the end of the period
