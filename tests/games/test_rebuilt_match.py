"""A match of REBUILT: its telemetry keys, its moving parts, its fuel, and what comes out of the hubs."""

from __future__ import annotations

import math

import numpy as np
import pytest

from games.rebuilt import REBUILT, RebuiltSim
from games.rebuilt.staging import Staging
from simcore.match.game import RobotEntry
from simcore.match.runner import play_auto
from simcore.match.scoring import ScoreEvent
from simcore.pieces.pool import PieceStatus
from simcore.telemetry.sinks import MemorySink

DOUBLES = {
    "Sim/Robot/GroundClearance", "Sim/Match/Time", "Sim/Match/TimeLeft", "Sim/Performance/TickMs",
    *(f"Sim/Debug/{name}" for name in (
        "ShooterVelocityRPS", "ShooterVoltageIn", "FeederVelocityRPS", "FeederVoltageIn", "SpindexerVelocityRPS",
        "SpindexerVoltageIn", "HoodAngleDeg", "HoodVoltageIn", "HoodPositionRot", "IntakeDeployPositionRot",
        "IntakeDeployExtendedPct", "IntakeRollerVelocityRPS", "BatteryVoltage")),
}  # fmt: skip
INTEGERS = {
    "Sim/Score/Total", "Sim/Score/Red", "Sim/Score/Blue", "Sim/Score/BlueHub", "Sim/Score/RedHub",
    "Sim/Intake/HeldCount", "Sim/Debug/HeldCount", "Sim/Performance/SubSteps", "Sim/Performance/AwakePieces",
    "Sim/Performance/FlyingPieces", "Sim/Performance/PiecesInContact", "Sim/Performance/SleepingPieces",
}  # fmt: skip
BOOLEANS = {
    "Sim/Match/BlueHubActive",
    "Sim/Match/RedHubActive",
    "Sim/Robot/IsAirborne",
    "Sim/Debug/IntakeZoneActive",
    "Sim/Debug/ShootingGateOpen",
}
POSES = {"Sim/Robot/Pose3d"}
POSE_ARRAYS = {"Sim/Robot/ComponentPoses", "Sim/GamePieces/Fuel"}


# --- telemetry ----------------------------------------------------------------------------------------------------


def test_every_promised_key_is_published_with_its_kind():
    sink = MemorySink()
    run = play_auto(REBUILT, "depot", seconds=2.0, sinks=[sink])
    with run.match:
        snapshot = sink.snapshots[-1]
        assert set(snapshot.doubles) >= DOUBLES and all(type(v) is float for v in snapshot.doubles.values())
        assert set(snapshot.integers) >= INTEGERS and all(type(v) is int for v in snapshot.integers.values())
        assert set(snapshot.booleans) >= BOOLEANS and all(type(v) is bool for v in snapshot.booleans.values())
        assert set(snapshot.poses) >= POSES and set(snapshot.pose_arrays) >= POSE_ARRAYS
        assert snapshot.pose_arrays["Sim/Robot/ComponentPoses"].shape == (16, 7)
        assert (
            len(snapshot.pose_arrays["Sim/GamePieces/Fuel"]) == run.report.pieces.on_field + run.report.pieces.in_flight
        )
        assert [s.tick for s in sink.snapshots] == list(range(100))
        names = [*snapshot.doubles, *snapshot.integers, *snapshot.booleans, *snapshot.poses, *snapshot.pose_arrays]
        assert len(set(names)) == len(names), "one key has one kind"
        for values in (*snapshot.poses.values(), *snapshot.pose_arrays.values()):
            quats = values.reshape(-1, 7)[:, 3:]
            assert np.linalg.norm(quats, axis=1) == pytest.approx(1.0)


def test_sixteen_parts_follow_their_mechanisms():
    with RebuiltSim() as match:
        robot = match.robots[0]
        before = robot.component_poses()
        assert before.shape == (16, 7) == (len(robot.config.components), 7)
        assert not before.flags.writeable
        for _ in range(50):
            robot.mechanisms["spindexer"].set_volts(6.0)
            robot.mechanisms["intake_deploy"].set_volts(6.0)
            match.tick()
        after = robot.component_poses()
        moved = {
            part.name
            for part, a, b in zip(robot.config.components, before, after, strict=True)
            if np.abs(a - b).max() > 1e-6
        }
        assert {"intake", "hopper", "spindexer plate", "spindexer cone", "spindexer kicker"} <= moved
        assert not moved & {"feeder wheel, lower left", "hopper roller", "shooter wheel, left"}
        intake = [part.name for part in robot.config.components].index("intake")
        assert before[intake, 0] - after[intake, 0] == pytest.approx(robot.mechanisms["intake_deploy"].extension)
        plate = [part.name for part in robot.config.components].index("spindexer plate")
        turned = 2.0 * math.atan2(after[plate, 6], after[plate, 3])
        assert math.remainder(turned - robot.mechanisms["spindexer"].position, math.tau) == pytest.approx(0.0, abs=1e-9)


# --- robots and fuel ----------------------------------------------------------------------------------------------


def test_scored_fuel_comes_out_of_the_hubs_exits_into_the_neutral_zone():
    run = play_auto(REBUILT, "depot", seconds=9.0, options=["hub_exits"])
    with run.match as match:
        assert run.report.score.blue >= 8
        assert run.report.pieces.scored == 0 and run.report.pieces.is_conserved
        came_out = {event.slot for event in match.tracker.events}
        places = match.pieces.state.pos[sorted(came_out)]
        assert (places[:, 0] > 5.0).all(), "on the far side of the hub"
        assert (places[:, 2] < 0.8).all()


@pytest.mark.parametrize(
    ("staging", "preload", "total", "on_field"),
    [
        (Staging(), 8, 504, 400 + 48),
        (Staging(), 0, 504, 408 + 48),
        (Staging(neutral=0, depot=0, chute=0, robots=1), 3, 8, 5),
        (Staging(neutral=10, depot=2, chute=1, robots=1), 8, 24, 14),
    ],
)
def test_counts_are_configurable_and_add_up(staging, preload, total, on_field):
    with RebuiltSim(staging=staging, robots=(RobotEntry(preload=preload),)) as match:
        fuel = match.count
        assert (fuel.staged, fuel.on_field, fuel.held, fuel.off_field) == (total, on_field, preload, 2 * staging.chute)
        match.tick()
        assert match.count.is_conserved
        assert match.pieces.count(PieceStatus.FREE) == 0


def test_practice_counts_every_fuel():
    with RebuiltSim(practice=True) as match:
        assert all(match.rules.is_active(alliance, 50.0) for alliance in ("blue", "red"))
    with RebuiltSim() as match:
        assert not all(match.rules.is_active(alliance, 50.0) for alliance in ("blue", "red"))


def test_game_data_follows_the_auto_that_a_driver_station_started():
    """Practice for a while, then a match: game data comes with teleop, of the auto fuel of this match alone."""
    with RebuiltSim() as match:
        match.play(0.5)
        match.start_mode("auto")
        assert match.timer.time == 0.0 and match.rules.game_data() == ""
        zone = next(z for z in match.tracker.zones if z.alliance == "red")
        match.rules.scored(ScoreEvent(0.0, zone.name, "red", match.rules.worth(zone), 0))
        match.play(0.1)
        match.start_mode("teleop")
        assert match.timer.time == pytest.approx(23.0)
        assert match.rules.game_data() == "R"  # red scored more, so its hub is off first
        match.start_mode("auto")
        assert match.rules.game_data() == ""
