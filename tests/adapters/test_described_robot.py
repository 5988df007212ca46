"""Robots unlike the default one, in simulated time: one described by simcore.toml alone, and a tank drive."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROBOTS = Path(__file__).parent / "robots"

TURRETED = """
import math

import numpy as np

A, B, X = 1, 2, 3


def drive(sim, stick, seconds, ahead=0.0, turn=0.0, heading=0.0):
    for _ in range(round(seconds / 0.1)):
        off = math.remainder(heading - sim.pose.rotation().radians(), math.tau)
        stick.axis(1, -ahead / 3.0)
        stick.axis(4, -min(max(3.0 * off, -2.5), 2.5) / 3.0)
        sim.run(0.1)
    stick.center()
    sim.run(0.3)


def test_two_intakes_a_turret_and_two_wheels(sim):
    stick = sim.joystick(0)
    sim.teleop()
    assert sim.pieces.held == 6
    stick.press(B)
    drive(sim, stick, 1.5, ahead=-1.0)  # its back toward the depot
    by_the_back = sim.pieces.held - 6
    assert by_the_back >= 3
    drive(sim, stick, 1.5, ahead=1.0)
    drive(sim, stick, 2.0, heading=math.pi)
    pieces = sim.match.pieces  # people add fuel where the back intake has left little
    pieces.put_down(pieces.spare("Fuel", 4), np.array([[0.4, y] for y in (5.75, 5.9, 6.05, 6.2)]))
    stick.press(A)
    drive(sim, stick, 1.6, ahead=1.0, heading=math.pi)  # its front
    by_the_front = sim.pieces.held - 6 - by_the_back
    assert by_the_front >= 1
    stick.press(B)
    drive(sim, stick, 1.5, ahead=-1.0, heading=math.pi)
    stick.press(X)
    sim.run_until(lambda: sim.pieces.held == 0, timeout=8.0)
    sim.run(1.5)
    shooter, = sim.robot_sim.shooters
    print("HELD", by_the_back, by_the_front, "SCORE", sim.score, "DIGEST", sim.digest)
    assert sim.score.blue >= 0.8 * len(sim.match.record.shots) and len(sim.match.record.shots) >= 10
    assert sim.score.red == 0


def test_its_log_is_its_own(sim):
    sim.start()
    snapshot = sim.match.snapshot()
    debug = {key.split("/")[-1] for kind in (snapshot.doubles, snapshot.booleans) for key in kind if "/Debug/" in key}
    own = ("LowerWheel", "UpperWheel", "Turret", "Feeder", "Kicker", "FrontRoller", "BackRoller")
    assert {f"{name}VelocityRPS" for name in own} == {key for key in debug if key.endswith("VelocityRPS")}
    assert {"IntakeZoneActive", "IntakeZoneActive2", "ShootingGateOpen", "TurretAngleDeg"} <= debug
    assert not [key for key in debug if key.startswith(("Hood", "Spindexer", "Shooter", "IntakeDeploy"))]
    assert len(snapshot.pose_arrays["Sim/Robot/ComponentPoses"]) == 0
"""

TANK = """
import pytest
from pyfrc.tests import test_practice
from wpilib import DriverStation


def test_it_drives_and_its_currents_are_known(sim):
    sim.alliance("blue")
    sim.start()
    assert {side: len(amps) for side, amps in sim.currents.items()} == {"left": 2, "right": 2}
    start, believed = sim.pose, sim.robot.odometry.getPose()
    sim.robot.goal = (2.0, 0.0, 0.0)
    sim.teleop(seconds=0.3)
    assert min(sum(amps) for amps in sim.currents.values()) > 5.0
    sim.run(1.2)
    assert sim.pose.translation().distance(start.translation()) > 1.0
    assert sim.pieces.held == 0 and sim.battery.min_voltage < 12.5
    assert sim.match is sim.game and sim.robot_sim is sim.plant
    told = DriverStation.getGameSpecificMessage()  # in teleop without auto (practice) as well
    assert told == sim.match.rules.hubs.first_inactive[0].upper()

    sim.robot.goal = (0.0, 0.0, 0.0)
    sim.run(0.5)
    middle, after = sim.pose, sim.robot.odometry.getPose()
    way = middle.translation().distance(start.translation())
    assert after.translation().distance(believed.translation()) == pytest.approx(way, rel=0.02)
    sim.robot.goal = (0.0, 0.0, 2.0)
    sim.run(0.5)
    turned = (sim.pose.rotation() - middle.rotation()).radians()
    assert abs(turned) > 0.5
    assert (sim.robot.odometry.getPose().rotation() - after.rotation()).radians() == pytest.approx(turned, abs=0.03)
    sim.robot.goal = (1.0, 0.0, 0.0)
    sim.run(0.3)
    sim.disable(seconds=1.0)  # its code never takes the voltage back
    assert sim.robot_sim.chassis.speed < 0.02
    sim.autonomous(seconds=0.1)
    assert DriverStation.getGameSpecificMessage() == ""  # a new auto starts without game data
    print("DIGEST", sim.digest)


def test_again(sim):
    test_it_drives_and_its_currents_are_known(sim)
"""


def test_a_robot_described_by_its_file_takes_fuel_in_at_both_ends_and_scores(project_of):
    run = project_of(ROBOTS / "turreted")
    code, said = run(TURRETED, "-rP")
    assert code == 0 and "2 passed" in said, said


GENERATED = """
import json

import pytest


def test_guessed_mechanisms_reach_their_setpoints(sim):
    sim.teleop(seconds=2.0)
    facts = sim.robot.facts()
    assert facts["shooter_rps"] == pytest.approx(60.0, rel=0.03)
    assert [abs(rps) for rps in facts["follower_rps"]] == pytest.approx([45.0, 45.0], rel=0.03)
    assert facts["elevator"] == pytest.approx(3.0, abs=0.01)
    assert facts["arm"] == pytest.approx(0.2, abs=0.01)
    assert facts["turret"] == pytest.approx(0.4, abs=0.01)
    assert facts["encoder"] == pytest.approx(facts["turret"], abs=0.01)
    assert facts["roller_rps"] == pytest.approx(10.0, rel=0.1)
    print("GUESSED", dict(sim.physics.assignment.guessed))
    numbers = {name: value for name, value in facts.items() if isinstance(value, (int, float))}
    pose = sim.pose
    print("FACTS", json.dumps({**numbers, "x": pose.X(), "y": pose.Y(), "yaw": pose.rotation().radians()}))
"""


def test_undescribed_motors_turn_guessed_mechanisms_with_or_without_a_file(project_of):
    run = project_of(ROBOTS / "generated")
    (run.folder / "simcore.toml").write_text('game = "rebuilt"\n')
    code, said = run(GENERATED, "-rP")
    assert code == 0 and "'TalonFX 31 + 32 + 33': '3 x Kraken X60 FOC, 0.75:1" in said, said
    assert "'TalonFXS 37': '1 x Minion, 3:1" in said, said
    code, told = run("", "--force", command=("-m", "simcore", "init"))
    text = (run.folder / "simcore.toml").read_text()
    assert code == 0 and "found 5 motors" in told, told
    assert text.count("\n[[mechanism]]") == 2 and text.count(", stays a guess: ") == 3 and "inertia = 0.001296 " in text
    code, again = run(GENERATED, "-rP")
    assert code == 0, again
    one, other = (json.loads(line.split(maxsplit=1)[1]) for line in (said + again).splitlines() if "FACTS" in line)
    assert other == pytest.approx(one, rel=2e-3, abs=2e-3)


def test_a_tank_robot_drives_with_true_odometry_identically_in_two_tests(project_of):
    run = project_of(ROBOTS / "tank")
    code, said = run(TANK, "-rP")
    assert code == 0, said
    digests = [line.split()[1] for line in said.splitlines() if line.startswith("DIGEST")]
    assert len(digests) == 2 and digests[0] == digests[1]
