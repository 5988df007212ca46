"""Values of the NetworkTables sink, as a WPILib client in another process decodes them."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from simcore.errors import ConfigError, OutputError
from simcore.telemetry.snapshot import STRUCT_SCHEMAS, Snapshot

ntcore = pytest.importorskip("ntcore", reason="pyntcore is not installed")

from simcore.robotcode.networktables.networktables_sink import NetworkTablesSink, start_local_server  # noqa: E402

FUEL = np.column_stack((np.arange(504.0), np.full(504, 2.5), np.full(504, 0.075), np.ones(504), np.zeros((504, 3))))

EVERY_KEY = """
import json, sys, time
import ntcore
from wpimath.geometry import Pose3d
from wpimath.kinematics import SwerveModuleState
inst = ntcore.NetworkTableInstance.create()
everything = ntcore.MultiSubscriber(inst, ["/"], ntcore.PubSubOptions(sendAll=True))
inst.startClient4("reader")
inst.setServer("127.0.0.1", int(sys.argv[1]))
row = lambda p: [p.X(), p.Y(), p.Z(), *(getattr(p.rotation().getQuaternion(), a)() for a in "WXYZ")]
def subscribe(topic):
    name, kind = topic.getName(), topic.getTypeString()
    if kind == "struct:Pose3d":
        sub = inst.getStructTopic(name, Pose3d).subscribe(Pose3d(9, 9, 9, Pose3d().rotation()))
        return lambda: row(sub.get())
    if kind == "struct:Pose3d[]":
        sub = inst.getStructArrayTopic(name, Pose3d).subscribe([])
        return lambda: [row(p) for p in sub.get()]
    if kind == "struct:SwerveModuleState[]":
        states = inst.getStructArrayTopic(name, SwerveModuleState).subscribe([])
        return lambda: [[s.speed, s.angle.radians()] for s in states.get()]
    make, default = {
        "double": (inst.getDoubleTopic, -77.0), "int": (inst.getIntegerTopic, -77),
        "boolean": (inst.getBooleanTopic, False), "string": (inst.getStringTopic, "none"),
        "int[]": (inst.getIntegerArrayTopic, [-77]),
    }[kind]
    sub = make(name).subscribe(default)
    return sub.get
end = time.monotonic() + 20
topics = {}
while len(topics) < int(sys.argv[2]) and time.monotonic() < end:
    for topic in inst.getTopics("/Sim/") + inst.getTopics("/Robot/"):
        topics.setdefault(topic.getName(), subscribe(topic))
    time.sleep(0.02)
time.sleep(0.5)
values = {name[1:]: read() for name, read in topics.items()}
print(json.dumps({"values": values, "types": {t.getName(): t.getTypeString() for t in inst.getTopics("/")}}))
"""


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@pytest.fixture
def instance() -> Iterator[Any]:
    created = ntcore.NetworkTableInstance.create()
    yield created
    created.stopServer()
    ntcore.NetworkTableInstance.destroy(created)


@pytest.mark.slow
def test_a_client_in_another_process_decodes_every_key_of_a_game(instance: Any) -> None:
    """The keys are all that REBUILT publishes with two robots and a shot in the air, and some odd ones."""
    pytest.importorskip("wpimath.geometry", reason="the client decodes with robotpy-wpimath")
    from games.rebuilt import RebuiltSim
    from simcore import RobotEntry
    from simcore.telemetry.sinks import MemorySink

    memory = MemorySink()

    def shoot(robot: Any, time: float) -> None:
        volts = {"shooter": 9.0, "hood": 1.0, "intake_deploy": 4.0, "intake_roller": 6.0, "spindexer": 3.0}
        for name, mechanism in robot.mechanisms.items():
            mechanism.set_volts(volts.get(name, 6.0 if time > 1.0 else 0.0))

    entries = (RobotEntry(), RobotEntry(alliance="red"))
    with RebuiltSim(robots=entries, controllers=[shoot], sinks=[memory]) as sim:
        while not len(sim.record.flying):
            assert sim.time < 5.0
            sim.last_tick_ms = 1.5
            sim.tick()
    last = memory.snapshots[-1]
    truth = replace(
        last,
        pose_arrays={**last.pose_arrays, "Sim/Nothing": np.empty((0, 7))},
        doubles={**last.doubles, "Sim/OfNumpy": np.float64(0.125)},
        integer_arrays={**last.integer_arrays, "Sim/Large": np.array([7, -1, 2**40])},
    )
    kinds = (
        *(truth.poses, truth.pose_arrays, truth.state_arrays, truth.doubles, truth.integers),
        *(truth.booleans, truth.integer_arrays, truth.strings),
    )
    count = sum(len(kind) for kind in kinds)
    port = free_port()
    start_local_server(instance, port=port)
    sink = NetworkTablesSink(instance)
    command = [sys.executable, "-c", EVERY_KEY, str(port), str(count)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as client:
        sink.write(truth)  # once: a client that connects later gets the last value of each key
        try:
            out, _ = client.communicate(timeout=40)
        finally:
            client.kill()
    answer = json.loads(out)
    got, types = answer["values"], answer["types"]
    sink.close()
    assert types["/Sim/GamePieces/Fuel"] == "struct:Pose3d[]"
    assert all(types[f"/.schema/{name}"] == "structschema" for name in STRUCT_SCHEMAS)
    assert sorted(got) == sorted(key for kind in kinds for key in kind)
    for key, pose in truth.poses.items():
        assert got[key] == pytest.approx(pose.tolist(), abs=1e-6), key  # the client makes attitudes unit quaternions
    for key, rows in truth.pose_arrays.items():
        np.testing.assert_allclose(np.array(got[key]).reshape(-1, 7), rows, atol=1e-6, err_msg=key)
    for key, states in truth.state_arrays.items():
        assert np.array(got[key]).reshape(-1, 2) == pytest.approx(states), key
    for key, integers in truth.integer_arrays.items():
        assert got[key] == integers.tolist(), key
    for numbers in (truth.doubles, truth.integers, truth.booleans, truth.strings):
        assert {key: got[key] for key in numbers} == dict(numbers)
    assert len(got["Sim/Robot/ComponentPoses"]) == 16 and len(got["Sim/InFlight/Fuel"]) >= 1
    assert got["Sim/Debug/ShooterVelocityRPS"] > 5.0 and got["Sim/Robots/1/Robot/IsRed"] is True
    moved = [r for r in got["Sim/Robot/ComponentPoses"] if r[3] < 0.999999]
    assert len(moved) >= 10, "the parts really turn"


def test_the_server_listens_only_on_this_computer(instance: Any) -> None:
    port = free_port()
    start_local_server(instance, port=port)
    end = time.monotonic() + 5.0
    while True:
        try:
            socket.create_connection(("127.0.0.1", port), timeout=1.0).close()
            break
        except OSError:
            assert time.monotonic() < end, "the server never came up"
            time.sleep(0.02)
    with pytest.raises(OSError):  # all of 127/8 is this computer, but the server listens on one address
        socket.create_connection(("127.0.0.2", port), timeout=1.0).close()


def test_a_port_in_use_is_reported(instance: Any) -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        with pytest.raises(OutputError, match="Another robot program or simulation may be running"):
            start_local_server(instance, port=other.getsockname()[1])
    with pytest.raises(ConfigError, match="1 to 65535"):
        start_local_server(instance, port=0)


def test_bad_snapshots_and_writes_to_a_closed_sink_raise(instance: Any) -> None:
    sink = NetworkTablesSink(instance, period=0.1)
    sink.write(Snapshot(time=0.0, tick=0, doubles={"x": 1.0}))
    assert instance.getTopic("/x").getTypeString() == "double"
    assert not sink.due(0.05)
    assert sink.due(0.1)
    with pytest.raises(ConfigError, match="x: published as double before, now as int"):
        sink.write(Snapshot(time=0.0, tick=0, integers={"x": 1}))
    with pytest.raises(ConfigError, match="shape"):
        sink.write(Snapshot(time=0.0, tick=0, poses={"p": np.zeros(3)}))
    with pytest.raises(ConfigError, match=r"ids: integers need shape \(n,\)"):
        sink.write(Snapshot(time=0.0, tick=0, integer_arrays={"ids": np.zeros((2, 2), dtype=np.int64)}))
    with pytest.raises(ConfigError, match="without a leading '/'"):
        sink.write(Snapshot(time=0.0, tick=0, doubles={"": 1.0}))
    sink.close()
    sink.close()
    assert not sink.due(9.0)
    with pytest.raises(OutputError, match="closed"):
        sink.write(Snapshot(time=0.0, tick=0))
    with pytest.raises(ConfigError, match="period"):
        NetworkTablesSink(instance, period=0.0)


def test_a_field_is_published_for_dashboards_with_a_map(instance: Any) -> None:
    """Like WPILib's `Field2d`, it has x, y and degrees of each object, ten times a second."""
    instance.startLocal()
    turned = np.array([3.0, 4.0, 0.0, np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])

    def told(time: float) -> Snapshot:
        poses = {"Sim/Robot/Pose3d": turned, "Sim/Robots/2/Robot/EstimatedPose": turned + 1.0 * (np.arange(7) < 2)}
        return Snapshot(time=time, tick=round(50 * time), poses=poses, pose_arrays={"Sim/GamePieces/Fuel": FUEL[:3]})

    sink = NetworkTablesSink(instance, field="SmartDashboard/Field")
    table = instance.getTable("SmartDashboard/Field")
    sink.write(told(0.0))
    assert table.getString(".type", "") == "Field2d"
    assert table.getNumberArray("Robot", []) == pytest.approx([3.0, 4.0, 90.0])
    assert table.getNumberArray("Estimate 2", []) == pytest.approx([4.0, 5.0, 90.0])
    pieces = np.column_stack((FUEL[:3, :2], np.zeros(3)))
    assert table.getNumberArray("Fuel", []) == pytest.approx(pieces.ravel().tolist())
    turned[0] = 9.0
    sink.write(told(0.06))
    assert table.getNumberArray("Robot", [])[0] == 3.0, "not due yet"
    sink.write(told(0.1))
    assert table.getNumberArray("Robot", [])[0] == 9.0
    sink.close()
    NetworkTablesSink(instance).write(told(0.2))
    assert "Robot" not in table.getKeys(), "a robot program has its own"
