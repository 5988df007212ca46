"""A match of REBUILT: its telemetry keys, its moving parts, its fuel, and what comes out of the hubs."""

from __future__ import annotations

import copy
import math
from dataclasses import replace

import numpy as np
import pytest

from games.rebuilt import REBUILT, RebuiltSim
from games.rebuilt import dimensions as dim
from games.rebuilt.field import FIELD, HUB_TARGET
from games.rebuilt.fuel import FUEL
from games.rebuilt.fuel_ways import hub_exit
from games.rebuilt.staging import Staging
from simcore.match.game import RobotEntry
from simcore.match.match import Match
from simcore.match.runner import play_auto
from simcore.match.scoring import ScoreEvent
from simcore.pieces.pool import PieceStatus
from simcore.telemetry.sinks import MemorySink
from simcore.units import inches

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


def test_scored_fuel_comes_out_of_the_hubs_exit_into_the_neutral_zone():
    run = play_auto(REBUILT, "depot", seconds=4.0, options=["hub_exits"])
    with run.match as match:
        scored = [event.slot for event in match.tracker.events]
        assert run.report.score.blue == len(scored) >= 8
        match.set_controller(0, None)
        match.robots[0].drive.set_chassis_speeds(0.0, 0.0, 0.0)
        for _ in range(100):
            match.tick()
            assert match.count.is_conserved and match.count.scored == 0
        assert match.rules.ways.in_hub("blue") == 0
        places = match.pieces.state.pos[scored]
        assert (places[:, 0] > 5.0).all(), "on the far side of the hub"
        assert (np.abs(places[:, 1] - dim.HUB_CENTER[1]) < 1.5).all() and (places[:, 2] < 0.3).all()


def test_a_hub_lets_fuel_out_of_one_opening_and_at_most_ten_a_second():
    rng = np.random.default_rng(1)
    out = np.array([hub_exit("blue", rng)[0] for _ in range(500)])
    assert np.abs(out[:, 1] - dim.HUB_CENTER[1]).max() < 0.5 * inches(35.6) - FUEL.bounding_radius + 1e-3
    assert out[:, 2].min() > 0.765 + FUEL.bounding_radius and out[:, 2].max() < 0.988 - FUEL.bounding_radius
    with RebuiltSim(options=["hub_exits"]) as match:
        slots = match.pieces.on_field()[:12]
        match.pieces.score(slots)
        for slot in slots.tolist():
            match.rules.ways.enter_hub("blue", slot)
        left = []
        for _ in range(125):
            match.tick()
            left.append(match.rules.ways.in_hub("blue"))
        assert left[35] == 12, "nothing comes out within 0.75 s"
        assert left[-1] == 0 and max(a - b for a, b in zip(left, left[5:], strict=False)) <= 1


def test_two_hundred_fuel_in_each_hub_are_counted_and_come_back_red_turned_as_blue():
    """With the same chance in both hubs: red's exits are blue's, turned, within 1 mm after a tick."""
    empty = replace(REBUILT, staging=lambda rng, entries: [], preload=0)
    with Match(empty, options=["hub_exits"], robots=(RobotEntry(preload=0, start=(1.0, 1.0, 0.0)),)) as match:
        pieces, ways = match.pieces, match.rules.ways
        ways._rng["red"] = copy.deepcopy(ways._rng["blue"])
        goals = {"blue": HUB_TARGET, "red": (*FIELD.symmetry.flip_point(*HUB_TARGET[:2]), HUB_TARGET[2])}
        out = {"blue": [], "red": []}
        fuel = {"blue": [], "red": []}
        for tick in range(1150):
            if tick % 2 == 0 and tick < 400:
                for alliance, (x, y, z) in goals.items():
                    slots = pieces.spawn("Fuel", np.array([[x, y, z + 0.4]]))
                    pieces.push(slots, np.array([[0.0, 0.0, -5.0]]), flying=True)
                    fuel[alliance] += slots.tolist()
            aside = pieces.state.status == PieceStatus.STAGED
            match.tick()
            comes_out = aside & (pieces.state.status == PieceStatus.IN_FLIGHT)
            for alliance, slots in fuel.items():
                out[alliance] += [pieces.state.pos[slot].copy() for slot in slots if comes_out[slot]]
        assert match.count.is_conserved and match.count.on_field == 400
        assert (match.score.blue, match.score.red) == (200, 200)
        x, y, _ = pieces.state.pos[pieces.on_field()].T
        assert (0.0 < x).all() and (x < dim.FIELD_LENGTH).all() and (0.0 < y).all() and (y < dim.FIELD_WIDTH).all()
        turned = FIELD.symmetry.flip_points(np.array(out["red"]))
        assert len(turned) == 200 and np.abs(turned - out["blue"]).max() < 1e-3


def test_people_bring_back_what_left_the_field_of_a_match_after_some_seconds():
    with RebuiltSim(options=["human_players"]) as match:
        slot = match.pieces.on_field()[:1]
        match.pieces.release(slot, np.array([[8.0, 7.9, 2.0]]))
        match.pieces.push(slot, np.array([[0.0, 6.0, 3.0]]), flying=True)
        away = []
        for _ in range(500):
            match.tick()
            away.append(match.pieces.state.status[slot[0]] == PieceStatus.STAGED)
            assert match.count.is_conserved
        assert 150 <= sum(away) <= 401 and not away[-1]
        assert match.pieces.state.pos[slot[0], 1] < dim.FIELD_WIDTH


def test_a_human_player_takes_what_rolls_into_the_corral_and_opens_the_door_for_a_robot_that_waits():
    with RebuiltSim(options=["human_players"], robots=(RobotEntry(preload=0),)) as match:
        assert match.rules.human_players.stock == {"blue": 24, "red": 24}
        slot = match.pieces.on_field()[:1]
        match.pieces.release(slot, np.array([[0.3, dim.OUTPOST_Y - 0.3, FUEL.bounding_radius]]))
        match.pieces.push(slot, np.array([[-1.5, 0.0, 0.0]]))
        match.play(0.4)
        assert match.pieces.state.status[slot[0]] == PieceStatus.STAGED and match.count.is_conserved
        before = match.rules.human_players.stock["blue"]
        assert before >= 24, "one came, and one may have been thrown"
        match.robots[0].carry_to((0.7, dim.OUTPOST_Y, math.pi))
        stock = [before]
        for _ in range(60):
            match.tick()
            stock.append(match.rules.human_players.stock["blue"])
        assert -np.minimum(np.diff(stock), 0).sum() >= 8, "one each 0.12 s; some roll back into the corral"
        assert match.rules.human_players.stock["red"] >= 22, "nobody waits there; it throws one each 1.3 s"


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
