"""Brownouts and disabling stop the outputs that a roboRIO stops; a custom field mesh can be loaded."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from games.rebuilt import RebuiltSim
from games.rebuilt.robot import rebuilt_robot
from games.rebuilt.staging import Staging
from simcore.match.game import RobotEntry
from simcore.match.match import Match
from simcore.robot.battery import BatteryConfig
from simcore.robot.dc_motor import motor
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.robot_config import RobotConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.telemetry.sinks import MemorySink

UNLIMITED = dict.fromkeys(
    ("drive_stator_limit", "drive_supply_limit", "steer_stator_limit", "steer_supply_limit"), math.inf
)
NO_FUEL = Staging(neutral=0, depot=0, chute=0, preload_per_robot=0, robots=1)


def spin(robot, time):
    robot.mechanisms["shooter"].set_volts(12.0)
    robot.drive.set_volts([6.0] * 4, [0.0] * 4)


@pytest.fixture
def match():
    with RebuiltSim(robots=(RobotEntry(preload=0),), staging=NO_FUEL, controllers=[spin]) as match:
        yield match


def test_a_disabled_robot_coasts_and_continues_when_enabled_again(match):
    robot = match.robots[0]
    for _ in range(25):
        match.tick()
    running = robot.mechanisms["shooter"].velocity
    assert running > 50.0
    robot.drive.enabled = False
    for _ in range(10):
        match.tick()
    assert robot.mechanisms["shooter"].current == 0.0, "the circuit is open"
    assert robot.mechanisms["shooter"].velocity <= running
    assert robot.drive.drive_motors.supply == pytest.approx([0.0] * 4, abs=1.0)
    robot.drive.enabled = True
    for _ in range(10):
        match.tick()
    assert robot.mechanisms["shooter"].velocity > running


def test_a_brownout_stops_the_drive_and_the_mechanisms():
    """With a brownout level above the battery's voltage, a roboRIO never enables its outputs."""
    weak = replace(rebuilt_robot(), battery=BatteryConfig(brownout_voltage=13.0, recovered_voltage=13.5))
    entry = RobotEntry(preload=0, config=weak)
    with RebuiltSim(robots=(entry,), staging=NO_FUEL, controllers=[spin]) as match:
        for _ in range(25):
            match.tick()
        robot = match.robots[0]
        assert robot.battery.browned_out
        assert robot.mechanisms["shooter"].velocity == 0.0
        assert robot.chassis.pose == pytest.approx(match.start_pose(0), abs=1e-3)


def full_speed(robot, time):
    robot.drive.set_volts([12.0] * 4, [0.0] * 4)


@pytest.mark.parametrize(
    ("limits", "battery", "way", "has_brownouts"),
    [
        ({}, BatteryConfig(), 7.5, False),  # Phoenix 6 defaults of a TalonFX
        (UNLIMITED, BatteryConfig(), 7.0, True),
        ({}, BatteryConfig(resistance=0.028, initial_charge=0.5), 5.0, True),  # at 0.03: below 4.5 V for 17 ms, a reset
        (UNLIMITED, BatteryConfig(resistance=0.08, initial_charge=0.2, reset_hold=0.1), 0.5, True),
    ],
)
def test_any_robot_accelerates_at_full_voltage_and_logs_its_brownouts(limits, battery, way, has_brownouts, caplog):
    """From rest, 12 V for 2 s: a brownout lasts one heartbeat; a line gives its time and cause, another the count."""
    module = SwerveModuleConfig(x=0.0, y=0.0, **limits)
    config = RobotConfig(drivetrain=SwerveConfig.square(0.53, module), battery=battery)
    log = MemorySink()
    with Match.bare(config, start=(1.0, 4.0, 0.0), controllers=[full_speed], sinks=[log]) as match:
        match.play(2.0)
        robot = match.robots[0]
        gone, spent = robot.chassis.pose[0] - 1.0, robot.battery
    assert gone > way
    lowest = min(snapshot.doubles["Sim/Debug/BatteryVoltageMin"] for snapshot in log.snapshots)
    low_ticks = [snapshot.booleans["Sim/Debug/BrownedOut"] for snapshot in log.snapshots]
    assert lowest == pytest.approx(spent.min_voltage, abs=5e-4)  # telemetry rounds to 1 mV
    said = [record.getMessage() for record in caplog.records if "brownout" in record.getMessage()]
    if not has_brownouts:
        assert spent.brownouts == 0 and not any(low_ticks) and lowest > 6.75 and said == []
        return
    # battery behind its resistance, and four motors as resistors
    r = battery.resistance + battery.recovery_resistance
    stalled = module.drive_motor.resistance / 4.0
    assert lowest > battery.empty_voltage * stalled / (stalled + r)
    assert spent.off_time == pytest.approx(0.02 * spent.brownouts, abs=0.02)
    assert sum(low_ticks) >= spent.brownouts > 3
    begin, end = said
    assert begin.startswith("robot 0: brownout at 0.0 s: ") and ", drive " in begin and "7.5 V are back" in begin
    assert end == (
        f"robot 0: {spent.brownouts} brownouts in this run, {spent.off_time:.2f} s without motors; "
        f"lowest {lowest:.1f} V"
    )


def test_a_weak_battery_resets_the_roborio_and_stops_the_robot(caplog):
    """80 mohm and motors without limits leave 1.5 V for a heartbeat: the roboRIO reboots and motors stay off."""
    module = SwerveModuleConfig(x=0.0, y=0.0, **UNLIMITED)
    weak = BatteryConfig(resistance=0.08, initial_charge=0.2)
    config = RobotConfig(drivetrain=SwerveConfig.square(0.53, module), battery=weak)
    with Match.bare(config, start=(1.0, 4.0, 0.0), controllers=[full_speed]) as match:
        match.play(2.0)
        assert match.robots[0].battery.resets == 1 and match.robots[0].battery.browned_out
        assert match.robots[0].chassis.pose[0] < 1.1
    reset, *_, end = [record.getMessage() for record in caplog.records if "robot 0: " in record.getMessage()]
    assert reset.startswith("robot 0: roboRIO reset at 0.0 s: 1.") and reset.endswith("; no motor runs for 25 s")
    assert "1 resets of the roboRIO" in end


def test_twelve_stalled_motors_without_limits_share_the_battery_voltage(caplog):
    """V = V0 (R / 12) / (R / 12 + Rb) at 12 V against a wall, on tires that cannot slip; after release it recovers.

    The voltage is that of the heartbeat before a brownout; at the next heartbeat the motors are off.
    """
    kraken, battery = motor("Kraken X60"), BatteryConfig(resistance=0.02, reset_hold=100.0)
    drivetrain = TankConfig(
        motor=kraken, motors_per_side=6, wheel_cof=10.0, stator_limit=math.inf, supply_limit=math.inf
    )
    config = RobotConfig(drivetrain=drivetrain, battery=battery)

    def push(robot, time):
        robot.drive.set_volts(12.0, 12.0)

    with Match.bare(config, start=(0.41, 4.0, math.pi), controllers=[push]) as match:
        drive, spent = match.robots[0].drive, match.robots[0].battery
        volts = []
        for _ in range(50):
            match.tick()
            volts.append((spent.tick_min_voltage, drive.bus_voltage, drive.supply_current))
        stalled = kraken.resistance / 12.0
        expected = battery.full_voltage * stalled / (stalled + battery.resistance)
        assert min(volts)[0] == pytest.approx(expected, rel=0.03) and np.isfinite(volts).all()  # bumpers yield a little
        assert spent.brownouts == 25, "on for one heartbeat, off for the next"
        match.carry_to(0, (8.0, 4.0, 0.0))
        match.set_controller(0, None)
        drive.set_volts(0.0, 0.0)
        match.play(1.0)
        assert np.isfinite(match.robots[0].chassis.pose).all() and drive.bus_voltage > 12.0
    begin, end = [record.getMessage() for record in caplog.records if "robot 0: " in record.getMessage()]
    assert begin.startswith("robot 0: brownout at 0.0 s: ") and "drive " in begin and "25 brownouts" in end


def test_a_custom_field_mesh_needs_no_built_in_names(tmp_path: Path):
    """The mesh has a box, and a ridge that is named like a bump, over which robots drive."""
    corners = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    box = [(4, 3, 2, 1), (5, 6, 7, 8), (1, 2, 6, 5), (2, 3, 7, 6), (3, 4, 8, 7), (4, 1, 5, 8)]

    def group(name, at, scale, offset):
        lines = [f"o {name}"]
        lines += [f"v {at + x * scale} {2 + y} {z * 0.1 * scale}" for x, y, z in corners]
        lines += ["f " + " ".join(str(i + offset) for i in face) for face in box]
        return lines

    mesh = tmp_path / "field.obj"
    mesh.write_text("\n".join(group("post", 3.0, 1.0, 0) + group("my_bump_1", 6.0, 0.5, 8)) + "\n")
    with RebuiltSim(robots=(RobotEntry(preload=0),), staging=NO_FUEL, field_mesh=mesh) as match:
        match.tick()
        assert [element.name for element in match.field.elements] == ["post", "my_bump_1"]


def test_mechanisms_load_the_battery_but_estimated_mechanisms_do_not(match):
    """Wheels that spin up lower the voltage by current times resistance, in the same tick."""
    from simcore.robot.gearbox import GearboxConfig
    from simcore.robot.mechanisms import ShaftSim

    robot = match.robots[0]
    estimate = ShaftSim(GearboxConfig(motor=robot.mechanisms["shooter"].gearbox.motor, gearing=1.0), 0.01)
    robot.add_estimated_mechanism(estimate)
    estimate.set_volts(12.0)
    match.set_controller(0, lambda robot, time: robot.mechanisms["shooter"].set_volts(8.0))
    match.tick()
    shooter, battery = robot.mechanisms["shooter"], robot.battery
    assert shooter.supply_current > 10.0 and estimate.supply_current > 100.0
    # in the last millisecond of the tick; motors and battery agree on a voltage to 0.1 mV
    assert battery.current == pytest.approx(float(shooter.record["supply"][0]), rel=1e-4)
    assert battery.current == pytest.approx(shooter.supply_current, rel=0.02)
    assert battery.voltage == pytest.approx(battery.open_voltage - battery.config.resistance * battery.current)
    robot.remove_estimated_mechanism(estimate)
    speed = estimate.velocity
    match.tick()
    assert estimate.velocity == speed
