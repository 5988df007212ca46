"""A whole match: repeatable, logged, with two robots, and with fuel that comes out of the hub again."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from games.rebuilt.components import COMPONENTS
from games.rebuilt.runner import play_auto
from games.rebuilt.scripted import ScriptedRobot
from games.rebuilt.sim import RebuiltConfig, RebuiltSim, RobotEntry
from wpimath.geometry import Pose3d
from wpiutil import wpistruct
from wpiutil.log import DataLogReader

from games.rebuilt.autos import find_auto
from games.rebuilt.staging import Staging
from simcore.errors import ConfigError, FieldMeshError
from simcore.pieces.pool import PieceStatus
from simcore.telemetry.sinks import MemorySink
from simcore.telemetry.wpilog import WpilogSink

ROOT = Path(__file__).resolve().parents[2]

DOUBLES = {
    "Sim/Robot/GroundClearance", "Robot/Intake/ExtensionPct", "Sim/Performance/TickMs",
    *(f"Sim/Debug/{name}" for name in (
        "ShooterVelocityRPS", "ShooterVoltageIn", "FeederVelocityRPS", "FeederVoltageIn", "SpindexerVelocityRPS",
        "SpindexerVoltageIn", "HoodAngleDeg", "HoodVoltageIn", "HoodPositionRot", "IntakeDeployPositionRot",
        "IntakeDeployExtendedPct", "IntakeRollerVelocityRPS", "BatteryVoltage")),
}  # fmt: skip
INTEGERS = {
    "Sim/Score/Total", "Sim/Score/Red", "Sim/Score/Blue", "Sim/Score/BlueHub", "Sim/Score/RedHub",
    "Sim/Intake/HeldCount", "Sim/Debug/FuelHeld", "Sim/Performance/SubSteps", "Sim/Performance/AwakePieces",
}  # fmt: skip
BOOLEANS = {"Sim/Robot/IsAirborne", "Sim/Debug/IntakeZoneActive", "Sim/Debug/ShootingGateOpen"}
POSES = {"Sim/Robot/Pose3d"}
POSE_ARRAYS = {"Sim/Robot/ComponentPoses", "Sim/GamePieces/Fuel"}


def digest(folder: Path, *arguments: str) -> str:
    run = subprocess.run(
        [sys.executable, "-m", "games.rebuilt", "--json", "--seconds", "8", *arguments],
        cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)["digest"]


def test_the_same_seed_is_the_same_match_in_another_process_and_another_seed_is_another(tmp_path):
    """8 s: preload shot, robot in the depot, fuel pushed around."""
    first = digest(tmp_path, "--seed", "3")
    assert digest(tmp_path, "--seed", "3") == first
    assert digest(tmp_path, "--seed", "4") != first


def test_sinks_do_not_change_the_match(tmp_path):
    digests = set()
    for sinks in ([], [MemorySink()], [WpilogSink(tmp_path / "run.wpilog")]):
        run = play_auto(find_auto("depot"), seconds=3.0, sinks=sinks)
        with run.sim:
            digests.add(run.report.digest)
    assert len(digests) == 1


# --- telemetry ----------------------------------------------------------------------------------------------------


def test_every_promised_key_is_published_with_its_kind():
    sink = MemorySink()
    run = play_auto(find_auto("depot"), seconds=2.0, sinks=[sink])
    with run.sim:
        snapshot = sink.snapshots[-1]
        assert set(snapshot.doubles) >= DOUBLES and all(type(v) is float for v in snapshot.doubles.values())
        assert set(snapshot.integers) >= INTEGERS and all(type(v) is int for v in snapshot.integers.values())
        assert set(snapshot.booleans) >= BOOLEANS and all(type(v) is bool for v in snapshot.booleans.values())
        assert set(snapshot.poses) >= POSES and set(snapshot.pose_arrays) >= POSE_ARRAYS
        assert snapshot.pose_arrays["Sim/Robot/ComponentPoses"].shape == (16, 7)
        assert len(snapshot.pose_arrays["Sim/GamePieces/Fuel"]) == run.report.fuel.on_field + run.report.fuel.in_flight
        assert [s.tick for s in sink.snapshots] == list(range(100))
        names = [*snapshot.doubles, *snapshot.integers, *snapshot.booleans, *snapshot.poses, *snapshot.pose_arrays]
        assert len(set(names)) == len(names), "one key has one kind"
        for values in (*snapshot.poses.values(), *snapshot.pose_arrays.values()):
            quats = values.reshape(-1, 7)[:, 3:]
            assert np.linalg.norm(quats, axis=1) == pytest.approx(1.0)


def test_the_log_read_back_with_wpilib_shows_the_run(tmp_path):
    """Keys as NetworkTables has them, and the robot's poses as they were at each tick."""
    path = tmp_path / "run.wpilog"
    poses = []
    run = play_auto(
        find_auto("tour"),
        seconds=4.0,
        sinks=[WpilogSink(path)],
        on_tick=lambda sim: poses.append((*sim.robots[0].chassis.pos, *sim.robots[0].chassis.quat)),
    )
    run.sim.close()
    names, types, logged, fuel = {}, {}, [], []
    for record in DataLogReader(str(path)):
        if record.isStart():
            start = record.getStartData()
            names[start.entry] = start.name
            types[start.name] = start.type
        elif not record.isControl():
            name = names[record.getEntry()]
            if name == "NT:/Sim/Robot/Pose3d":
                logged.append((record.getTimestamp(), wpistruct.unpack(Pose3d, record.getRaw())))
            elif name == "NT:/Sim/GamePieces/Fuel":
                fuel.append(len(record.getRaw()) // 56)
    for keys, kind in ((DOUBLES, "double"), (INTEGERS, "int64"), (BOOLEANS, "boolean"), (POSES, "struct:Pose3d"),
                       (POSE_ARRAYS, "struct:Pose3d[]")):  # fmt: skip
        for key in keys:
            assert types[f"NT:/{key}"] == kind, key
    assert [stamp for stamp, _ in logged] == [20_000 * (i + 1) for i in range(200)]
    assert set(fuel) == {456}
    for (_, got), (x, y, z, qx, qy, qz, qw) in zip(logged, poses, strict=True):
        quat = got.rotation().getQuaternion()
        assert (got.x, got.y, got.z) == pytest.approx((x, y, z))
        assert abs(np.dot((quat.X(), quat.Y(), quat.Z(), quat.W()), (qx, qy, qz, qw))) == pytest.approx(1.0)


def test_sixteen_parts_follow_their_mechanisms():
    with RebuiltSim() as sim:
        from games.rebuilt.components import component_poses

        robot = sim.robots[0]
        before = component_poses(robot)
        assert before.shape == (16, 7) == (len(COMPONENTS), 7)
        assert not before.flags.writeable
        for _ in range(50):
            robot.spindexer.set_volts(6.0)
            robot.deploy.set_volts(6.0)
            sim.tick()
        after = component_poses(robot)
        moved = {part.name for part, a, b in zip(COMPONENTS, before, after, strict=True) if np.abs(a - b).max() > 1e-6}
        assert {"intake", "hopper", "spindexer plate", "spindexer cone", "spindexer kicker"} <= moved
        assert not moved & {"feeder wheel, lower left", "hopper roller", "shooter wheel, left"}
        intake = [part.name for part in COMPONENTS].index("intake")
        assert before[intake, 0] - after[intake, 0] == pytest.approx(robot.deploy.extension)
        plate = [part.name for part in COMPONENTS].index("spindexer plate")
        turned = 2.0 * math.atan2(after[plate, 6], after[plate, 3])
        assert math.remainder(turned - robot.spindexer.position, math.tau) == pytest.approx(0.0, abs=1e-9)


# --- robots and fuel ----------------------------------------------------------------------------------------------


def test_two_robots_play_their_autos_in_one_match_as_each_does_alone():
    """Blue and red on opposite ends: each scores in its own hub."""
    auto = find_auto("depot")
    entries = tuple(RobotEntry(alliance=a, pose=auto.start) for a in ("blue", "red"))
    sink = MemorySink(period=1.0)
    with RebuiltSim(RebuiltConfig(robots=entries), sinks=[sink]) as sim:
        for number, entry in enumerate(entries):
            sim.set_robot_code(
                number,
                ScriptedRobot(
                    auto.script,
                    alliance=entry.alliance,
                    held=lambda n: len(sim.pieces.held(n)),
                    fuel_places=lambda: sim.pieces.state.pos[sim.pieces.on_field()],
                ),
            )
        for _ in range(1000):
            sim.tick()
            assert sim.fuel.is_conserved
        assert sim.fuel.staged == 504
        assert sim.tracker.totals["blue"] >= 20 and sim.tracker.totals["red"] >= 20
        assert abs(sim.tracker.totals["blue"] - sim.tracker.totals["red"]) <= 6
        assert {shot.robot for shot in sim.shots} == {0, 1}
        assert "Sim/Robots/1/Robot/Pose3d" in sink.snapshots[-1].poses


def test_a_gyros_noise_does_not_depend_on_other_robots():
    starts = ((2.6, 5.3, 0.0), (2.6, 2.0, 0.0), (14.0, 5.3, 0.0))
    noise = []
    for count in (1, 2, 3):
        with RebuiltSim(RebuiltConfig(robots=tuple(RobotEntry(pose=pose) for pose in starts[:count]))) as sim:
            for _ in range(50):
                sim.tick()
            noise.append([robot.gyro.rates.tolist() for robot in sim.robots])
    for fewer, more in ((noise[0], noise[1]), (noise[1], noise[2])):
        # The engine's arithmetic differs by 1e-8 when there is more in its world; the noise is some 1e-3.
        assert np.array(more[: len(fewer)]) == pytest.approx(np.array(fewer), abs=1e-6)
    assert np.abs(np.diff(noise[2], axis=0)).max() > 1e-4, "each robot has its own"


def test_scored_fuel_comes_out_of_the_hubs_exits_into_the_neutral_zone():
    run = play_auto(find_auto("depot"), seconds=9.0, config=RebuiltConfig(hub_exits=True))
    with run.sim as sim:
        assert run.report.score.blue >= 8
        assert run.report.fuel.scored == 0 and run.report.fuel.is_conserved
        came_out = {event.slot for event in sim.tracker.events}
        places = sim.pieces.state.pos[sorted(came_out)]
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
    config = RebuiltConfig(staging=staging, robots=(RobotEntry(preload=preload),))
    with RebuiltSim(config) as sim:
        fuel = sim.fuel
        assert (fuel.staged, fuel.on_field, fuel.held, fuel.outside) == (total, on_field, preload, 2 * staging.chute)
        sim.tick()
        assert sim.fuel.is_conserved
        assert sim.pieces.count(PieceStatus.FREE) == 0


def test_a_match_without_robots_runs_and_nothing_wakes():
    with RebuiltSim(RebuiltConfig(robots=())) as sim:
        for _ in range(50):
            sim.tick()
        assert sim.fuel.on_field == 456 and len(sim.pieces.awake) == 0


def test_more_preload_than_allowed_is_refused():
    with pytest.raises(ConfigError, match=r"preload must be 0\.\.8 fuel, got 9"):
        RebuiltConfig(robots=(RobotEntry(preload=9),))


def test_a_missing_mesh_ends_the_build(tmp_path):
    with pytest.raises(FieldMeshError, match=r"none\.obj"):
        RebuiltSim(RebuiltConfig(field_mesh=tmp_path / "none.obj"))


def test_errors_of_robot_code_pass_through_unchanged():
    class TeamError(Exception):
        pass

    error = TeamError("our bug")

    def code(robot, now):
        raise error

    with RebuiltSim(robot_code=[code]) as sim, pytest.raises(TeamError) as caught:
        sim.tick()
    assert caught.value is error


@pytest.mark.parametrize("seconds", [0.0, -1.0, math.nan, math.inf])
def test_an_auto_takes_a_finite_time(seconds):
    with pytest.raises(ConfigError, match="seconds must be finite and > 0"):
        play_auto(find_auto("depot"), seconds=seconds)
