"""Measure the drivetrain against its acceptance figures: launches, stops, limits, slopes, pushes.

    python scripts/drivetrain_figures.py [--json] [--cost] [--step SECONDS]

Two robots, both 55 kg, 0.8 m bumpers, modules on a 0.527 m square, MK4i L2, wheel radius 0.0508 m, tread 1.2:
`ideal` has no losses and nearly no rotor or wheel inertia, as the closed forms assume;
`reference` has a rotor of 4.5e-5 kg m^2, a wheel of 8e-4 kg m^2 (deduced from the 40 A and 60 A rows), gears of 95 %
and rolling resistance of 0.01. Like the figures, neither has load transfer between axles (center of mass on the floor)
or dry friction in the drive. Exit code 1 when a row fails.
"""

from __future__ import annotations

import argparse
import itertools
import json
import logging
import math
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from typing import Any

from simcore.robot.battery import Battery, BatteryConfig
from simcore.robot.dc_motor import motor
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.swerve_drive import SwerveDrive
from simcore.testing.benches import DriveBench, hold
from simcore.units import GRAVITY

TRACKWIDTH = 0.527
STEP = 0.005
UNLIMITED = dict.fromkeys(
    ("drive_stator_limit", "drive_supply_limit", "steer_stator_limit", "steer_supply_limit"), math.inf
)
MK4I = SwerveModuleConfig(x=0.0, y=0.0, drive_friction_volts=0.0, **UNLIMITED)
IDEAL = replace(
    MK4I,
    drive_motor=replace(MK4I.drive_motor, rotor_inertia=0.0),
    wheel_inertia=1e-4,
    drive_efficiency=1.0,
    rolling_resistance=0.0,
)


@dataclass(frozen=True)
class Row:
    """One figure: expected and measured value with the allowed range."""

    section: str
    name: str
    expected: float
    measured: float
    low: float
    high: float
    unit: str
    note: str = ""

    @property
    def ok(self) -> bool:
        """Whether it is within tolerance, with a small slack for bounds such as +0 %."""
        slack = 1e-3 * abs(self.expected)
        return self.low - slack <= self.measured <= self.high + slack


def row(section: str, name: str, expected: float, measured: float, tol: float, unit: str, note: str = "") -> Row:
    """Make a row with a symmetric tolerance, as a share of the expected value."""
    room = tol * abs(expected)
    return Row(section, name, expected, measured, expected - room, expected + room, unit, note)


def robot(
    module: SwerveModuleConfig, battery: BatteryConfig | None = None, *, height: float = 0.0, **changes: Any
) -> SwerveDrive:
    """Make the 55 kg robot with four of these modules."""
    config = SwerveConfig.square(TRACKWIDTH, replace(module, **changes), height=height)
    return SwerveDrive(config, battery=Battery(battery) if battery else None)


def with_motor(module: SwerveModuleConfig, name: str) -> SwerveModuleConfig:
    """Return the module with another drive motor, its rotor inertia unchanged."""
    return replace(module, drive_motor=replace(motor(name), rotor_inertia=module.drive_motor.rotor_inertia))


def sagging(volts: float) -> BatteryConfig:
    """Return a battery with a fixed open-circuit voltage behind 0.02 ohm, and a roboRIO that never browns out."""
    return BatteryConfig(
        full_voltage=volts, empty_voltage=volts, resistance=0.02, recovery_resistance=0.0, brownout_enabled=False
    )


def tangential(drive: SwerveDrive) -> list[float]:
    """Return steer angles for turning in place."""
    return [math.atan2(x, -y) for x, y in drive.config.positions]


@dataclass
class Launch:
    """Result of a launch from rest at 12 V."""

    top: float
    t50: float
    t90: float
    t95: float
    peak: float
    x: float
    odometry: float
    min_voltage: float


def launch(drive: SwerveDrive, *, spin: bool = False, seconds: float = 3.0, top: float | None = None) -> Launch:
    """Apply 12 V from rest; speeds are m/s or, for a spin, rad/s. t50, t90, t95 refer to `top`, or to the end speed."""
    if spin:
        drive.reset(angles=tangential(drive))
    chassis = DriveBench(drive)
    drive.set_volts([12.0] * 4, [0.0] * 4)
    times, speeds, x, odometry = [0.0], [0.0], 0.0, 0.0
    lowest = drive.bus_voltage

    def each() -> None:
        nonlocal x, odometry, lowest
        times.append(chassis.time)
        speeds.append(chassis.omega if spin else chassis.vx)
        lowest = min(lowest, drive.battery.min_voltage)
        if abs(chassis.time - 0.5) < 0.5 * STEP:
            x, odometry = chassis.x, drive.wheel_distances()[0]

    chassis.run(seconds, h=STEP, each=each)

    def reach(share: float) -> float:
        goal = share * (top or speeds[-1])
        k = next(k for k, v in enumerate(speeds) if v >= goal)
        return times[k - 1] + (goal - speeds[k - 1]) / (speeds[k] - speeds[k - 1]) * STEP

    peak = max((b - a) / STEP for a, b in itertools.pairwise(speeds))
    return Launch(speeds[-1], reach(0.5), reach(0.9), reach(0.95), peak, x, odometry, lowest)


def held(drive: SwerveDrive, v: float = 0.0, *, seconds: float = 0.04) -> float:
    """Compute the push of the tires while the chassis is held at a speed (a wall at 0) [N].

    It needs short steps: the chassis is free within a step, and at 68 m/s^2 (tread 10) it would move away in 5 ms.
    """
    bench = DriveBench(drive)
    for _ in range(round(seconds / 2e-4)):
        bench.hold(2e-4, (v, 0.0, 0.0))
    return float(drive.wheel_forces[:, 0].sum())


def bisect(low: float, high: float, too_high: Callable[[float], bool], rounds: int = 40) -> float:
    """Find the value at which a condition starts to hold."""
    for _ in range(rounds):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if too_high(middle) else (middle, high)
    return 0.5 * (low + high)


def knee(module: SwerveModuleConfig) -> float:
    """Find the speed above which 12 V no longer reaches the grip [m/s]."""

    def below_grip(v: float) -> bool:
        drive = robot(module)
        drive.set_volts([12.0] * 4, [0.0] * 4)
        return held(drive, v) < 0.998 * 1.2 * 55.0 * GRAVITY

    return bisect(0.5, 6.0, below_grip)


def grip_current(module: SwerveModuleConfig) -> float:
    """Find the stator current at which a wheel against a wall starts to slip [A]."""

    def slips(amps: float) -> bool:
        drive = robot(module)
        drive.set_torque_currents([amps] * 4, [0.0] * 4)
        held(drive)
        return drive.wheel_speeds()[0] > 0.01

    return bisect(10.0, 200.0, slips)


def time_constant(module: SwerveModuleConfig) -> float:
    """Measure the time to 63 % of the speed at 12 V [s], on a tread of 10 that hardly slips."""
    drive = robot(module, wheel_cof=10.0, slip_ratio=0.001)
    chassis = DriveBench(drive)
    drive.set_volts([12.0] * 4, [0.0] * 4)
    top = 12.0 * module.drive_motor.kv / module.drive_gearing * module.wheel_radius
    while chassis.vx < top * (1.0 - math.exp(-1.0)):
        before = chassis.vx
        chassis.step(0.001)
    return chassis.time - 0.001 * (chassis.vx - top * (1.0 - math.exp(-1.0))) / (chassis.vx - before)


def closed_forms() -> Iterator[Row]:
    """Yield the figures of section 5.1."""
    s = "5.1"
    drive = robot(IDEAL)
    drive.set_volts([12.0] * 4, [0.0] * 4)
    push = held(drive)
    yield row(s, "grip, total", 647.2, push, 0.01, "N", "pushing a wall at 12 V")
    yield row(s, "grip, per wheel", 161.8, push / 4.0, 0.01, "N")
    peak = launch(robot(IDEAL)).peak
    yield Row(s, "traction-limited acceleration", 11.77, peak, 0.97 * 11.77, 11.77, "m/s^2")
    reference = launch(robot(MK4I))
    yield row(s, "free speed (datasheet)", 4.729, reference.top, 0.01, "m/s", "reference robot: rolling .01 costs .008")
    yield row(s, "zero-torque speed", 4.755, launch(robot(IDEAL)).top, 0.01, "m/s")
    yield row(s, "motor current at the grip limit", 62.9, grip_current(IDEAL), 0.03, "A", "ideal gears; 66.2 A at 95 %")
    sticky = robot(IDEAL, wheel_cof=10.0)
    sticky.set_volts([12.0] * 4, [0.0] * 4)
    yield row(s, "wheel force at 12 V stall", 942.0, held(sticky) / 4.0, 0.02, "N", "tread 10, so that it cannot slip")
    yield row(s, "knee: end of traction limit", 3.94, knee(IDEAL), 0.03, "m/s")
    for name, amps in (("Kraken X60", 366.0), ("Kraken X60 FOC", 483.0), ("Falcon 500", 257.0)):
        sticky = robot(with_motor(IDEAL, name), wheel_cof=10.0)
        sticky.set_volts([12.0] * 4, [0.0] * 4)
        held(sticky)
        yield row(s, f"stall current {name}", amps, sticky.drive_motors.current[0], 0.01, "A")
    for limit, accel, force in ((40.0, 7.49, 412.0), (60.0, 11.23, 618.0), (80.0, 11.77, 647.0)):
        drive = robot(IDEAL, drive_stator_limit=limit)
        yield row(s, f"{limit:.0f} A stator: acceleration", accel, launch(drive).peak, 0.03, "m/s^2")
        drive = robot(IDEAL, drive_stator_limit=limit)
        drive.set_volts([12.0] * 4, [0.0] * 4)
        yield row(s, f"{limit:.0f} A stator: push", force, held(drive), 0.03, "N")
        if limit == 40.0:
            m = drive.drive_motors
            yield row(s, "40 A stalled: volts", 1.31, m.volts[0], 0.03, "V")
            heat = m.heat[0]
            held(drive, seconds=1.0)
            yield row(s, "40 A stalled: heat per motor", 52.0, drive.drive_motors.heat[0] - heat, 0.03, "W")
            supply = drive.drive_motors.supply[0]
            yield row(s, "40 A stalled: supply per motor", 4.37, supply, 0.03, "A")
    spin = launch(robot(MK4I), spin=True)
    yield row(s, "spin rate at free speed", 12.69, spin.top, 0.02, "rad/s", "reference robot")
    alpha = launch(robot(IDEAL), spin=True).peak
    yield Row(s, "angular acceleration at grip", 41.1, alpha, 0.97 * 41.1, 41.1, "rad/s^2")
    for name, tau in (("Kraken X60", 0.069), ("Kraken X60 FOC", 0.051), ("Falcon 500", 0.112)):
        yield row(s, f"time constant {name}", tau, time_constant(with_motor(IDEAL, name)), 0.05, "s")
    yield from slopes()
    yield from loads()
    for v, radius in ((3.0, 0.76), (4.0, 1.36)):
        yield row(s, f"minimum turn radius at {v:.0f} m/s", radius, turn_radius(v), 0.05, "m")
    yield row(s, "push, tread 1.2 against 0.9", 1.47, push_match(1.2, 0.9)[0], 0.10, "m/s^2")
    drift = push_match(1.2, 1.2)[1]
    yield Row(s, "push, equal robots: speed after 2 s", 0.0, drift, -0.05, 0.05, "m/s")
    for name in ("Kraken X60", "Falcon 500"):
        t = steer_time(name)
        yield Row(s, f"steer 90 degrees, {name}", 0.059, t, 0.05, math.inf, "s", "never faster than free speed allows")


def slopes() -> Iterator[Row]:
    """Yield the figures of a 15 degree ramp."""
    s, slope = "5.1", math.radians(15.0)
    parked = robot(IDEAL)
    chassis = DriveBench(parked, slope=slope)
    chassis.run(1.0, h=STEP)
    yield row(s, "15 deg: force that holds", 139.6, float(parked.wheel_forces[:, 0].sum()), 0.05, "N")

    def climbs(amps: float) -> bool:
        drive = robot(IDEAL)
        drive.set_torque_currents([amps] * 4, [0.0] * 4)
        on = DriveBench(drive, slope=slope)
        on.run(0.2, h=STEP)
        return on.vx > 0.0

    yield row(s, "15 deg: current that holds", 13.6, bisect(1.0, 60.0, climbs), 0.05, "A")
    climbing = robot(IDEAL)
    climbing.set_volts([12.0] * 4, [0.0] * 4)
    chassis = DriveBench(climbing, slope=slope)
    chassis.run(0.2, h=STEP)
    yield row(s, "15 deg: grip", 625.0, float(climbing.wheel_forces[:, 0].sum()), 0.05, "N")
    yield row(s, "15 deg: climbing acceleration", 8.83, chassis.vx / chassis.time, 0.05, "m/s^2")


def loads() -> Iterator[Row]:
    """Yield load transfer and tipping of a robot that slides with held wheels."""
    s = "5.1"
    held = replace(MK4I, rolling_resistance=0.0, drive_friction_volts=20.0)

    def slide(cof: float, height: float, seconds: float) -> DriveBench:
        bench = DriveBench(robot(replace(held, wheel_cof=cof), height=height))
        bench.reset(vx=5.0)
        bench.run(seconds, h=STEP)
        return bench

    for height, accel in ((0.20, 12.9), (0.25, 10.3), (0.30, 8.6)):

        def lifts(a: float, height: float = height) -> bool:
            return slide(a / GRAVITY, height, 0.2).chassis.roll_pitch_yaw[1] > math.radians(0.5)

        yield row(s, f"tip-over, center of mass at {height:.2f} m", accel, bisect(6.0, 16.0, lifts, 8), 0.05, "m/s^2")
    front = sum(slide(1.0 / GRAVITY, 0.25, 0.2).loads[:2])
    yield row(s, "load transfer per axle and m/s^2", 26.1, front - 0.5 * 55.0 * GRAVITY, 0.05, "N")


def turn_radius(v: float) -> float:
    """Measure the radius of the tightest path at a speed [m], commanding a turn 10 % tighter than grip allows."""
    omega = v / (0.9 * v * v / (1.2 * GRAVITY))
    drive = robot(IDEAL)
    chassis = DriveBench(drive)
    chassis.reset(vx=v, omega=omega)
    wheels = [(v - omega * y, omega * x) for x, y in drive.config.positions]
    drive.reset(angles=[math.atan2(wy, wx) for wx, wy in wheels])
    drive.state.wheel_speed[:] = [math.hypot(wx, wy) / IDEAL.wheel_radius for wx, wy in wheels]
    drive.set_chassis_speeds(v, 0.0, omega)
    centripetal: list[float] = []
    chassis.run(
        0.3,
        h=STEP,
        each=lambda: centripetal.append((chassis.vx * chassis.ay - chassis.vy * chassis.ax) / chassis.speed),
    )
    return v * v / max(centripetal)


def push_match(left: float, right: float) -> tuple[float, float]:
    """Push two robots bumper to bumper at full throttle; return acceleration [m/s^2], and speed after 2 s [m/s]."""
    a, b = robot(MK4I, wheel_cof=left), robot(MK4I, wheel_cof=right)
    for drive in (a, b):
        drive.set_volts([12.0] * 4, [0.0] * 4)
    benches = DriveBench(a), DriveBench(b)
    v, early = 0.0, 0.0
    for k in range(round(2.0 / STEP)):
        da = benches[0].hold(STEP, (v, 0.0, 0.0))[0]
        db = benches[1].hold(STEP, (-v, 0.0, 0.0))[0]
        v += 0.5 * (da - db)  # a rigid contact divides the impulses of two equal masses
        if k + 1 == round(0.3 / STEP):
            early = v / 0.3
    return early, v


def steer_time(name: str) -> float:
    """Measure a quarter turn of the azimuths at 12 V, in the air [s]."""
    drive = robot(MK4I, steer_motor=motor(name))
    drive.set_volts([0.0] * 4, [12.0] * 4)
    t, bench = 0.0, DriveBench(drive)
    while drive.steer_angles[0] < math.pi / 2.0:
        bench.hold(0.001, (0.0, 0.0, 0.0), in_air=True)
        t += 0.001
    return t


MOTORS = (
    ("Kraken X60", 4.729, 4.755, 942.0, 62.9, 3.94, 0.069, 0.413, 12.69),
    ("Kraken X60 FOC", 4.571, 4.590, 1245.0, 62.8, 3.99, 0.051, 0.384, 12.27),
    ("Falcon 500", 5.028, 5.058, 623.0, 66.7, 3.74, 0.112, 0.490, 13.49),
    ("Falcon 500 FOC", 4.792, 4.815, 776.0, 63.4, 3.81, 0.085, 0.438, 12.86),
    ("NEO", 4.473, 4.551, 345.0, 49.2, 2.42, 0.181, 0.560, 12.00),
    ("NEO Vortex", 5.347, 5.440, 478.0, 71.4, 3.60, 0.156, 0.561, 14.35),
)


def motors() -> Iterator[Row]:
    """Yield the figures of section 5.2."""
    s = "5.2"
    for name, datasheet, zero_torque, stall, amps, knee_speed, tau, t95, spin in MOTORS:
        module = with_motor(IDEAL, name)
        m = module.drive_motor
        at_datasheet = m.free_speed / module.drive_gearing * module.wheel_radius
        run = launch(robot(module), top=at_datasheet)
        yield row(s, f"{name}: free speed, datasheet", datasheet, at_datasheet, 0.02, "m/s", "from the motor table")
        yield row(s, f"{name}: zero-torque speed", zero_torque, run.top, 0.02, "m/s")
        sticky = robot(module, wheel_cof=10.0)
        sticky.set_volts([12.0] * 4, [0.0] * 4)
        yield row(s, f"{name}: stall force per wheel", stall, held(sticky) / 4.0, 0.03, "N")
        yield row(s, f"{name}: current at grip", amps, grip_current(module), 0.03, "A")
        yield row(s, f"{name}: knee", knee_speed, knee(module), 0.03, "m/s")
        yield row(s, f"{name}: time constant", tau, time_constant(module), 0.05, "s")
        yield row(s, f"{name}: t95", t95, run.t95, 0.05, "s", "95 % of the datasheet speed")
        turned = m.free_speed / module.drive_gearing * module.wheel_radius / (TRACKWIDTH / math.sqrt(2.0))
        measured = launch(robot(module), spin=True).top * at_datasheet / run.top
        yield row(s, f"{name}: spin at datasheet speed", spin, measured, 0.02, "rad/s", f"closed form {turned:.2f}")


LAUNCHES: tuple[tuple[Any, ...], ...] = (
    # name, battery, changes, top, t50, t90, t95, peak, x, odometry, lowest voltage
    ("12 V stiff, no limit", None, {}, 4.747, 0.204, 0.382, 0.438, 11.67, 1.379, 2.008, 12.0),
    ("12 V stiff, 80 A", None, {"drive_stator_limit": 80.0}, 4.747, 0.204, 0.382, 0.438, 11.67, 1.378, 1.786, 12.0),
    ("12 V stiff, 60 A", None, {"drive_stator_limit": 60.0}, 4.747, 0.243, 0.446, 0.502, 9.79, 1.209, 1.220, 12.0),
    ("12 V stiff, 40 A", None, {"drive_stator_limit": 40.0}, 4.747, 0.366, 0.659, 0.715, 6.49, 0.811, 0.818, 12.0),
    ("13.5 V .02 ohm, no limit", 13.5, {}, 4.747, 0.204, 0.486, 0.556, 11.67, 1.286, 1.488, 4.2),
    (
        *("13.5 V, 120 A + 60 A supply", 13.5, {"drive_stator_limit": 120.0, "drive_supply_limit": 60.0}),
        *(4.747, 0.205, 0.488, 0.558, 11.67, 1.283, 1.459, 8.7),
    ),
    (
        *("13.5 V, 60 A + 40 A supply", 13.5, {"drive_stator_limit": 60.0, "drive_supply_limit": 40.0}),
        *(4.747, 0.246, 0.548, 0.617, 9.79, 1.135, 1.144, 10.3),
    ),
    (
        *("12.6 V, 60 A + 40 A supply", 12.6, {"drive_stator_limit": 60.0, "drive_supply_limit": 40.0}),
        *(4.747, 0.251, 0.621, 0.735, 9.79, 1.107, 1.116, 9.4),
    ),
    ("Falcon 500, 12 V stiff", None, {"motor": "Falcon 500"}, 5.046, 0.217, 0.444, 0.533, 11.67, 1.378, 1.924, 12.0),
    ("X60 FOC, 12 V stiff", None, {"motor": "Kraken X60 FOC"}, 4.585, 0.197, 0.359, 0.4, 11.67, 1.374, 2.031, 12.0),
)


def launches() -> Iterator[Row]:
    """Yield the figures of section 5.3."""
    s = "5.3"
    for name, volts, changes, top, t50, t90, t95, peak, x, odometry, lowest in LAUNCHES:
        changes = dict(changes)
        module = with_motor(MK4I, str(changes.pop("motor", "Kraken X60")))
        run = launch(robot(module, sagging(volts) if volts else None, **changes))
        yield row(s, f"{name}: top speed", top, run.top, 0.02, "m/s", "rolling resistance .01")
        for share, want, got in (("t50", t50, run.t50), ("t90", t90, run.t90), ("t95", t95, run.t95)):
            yield row(s, f"{name}: {share}", want, got, 0.05, "s")
        yield Row(s, f"{name}: peak acceleration", peak, run.peak, 0.97 * peak, peak, "m/s^2", "gears .95, rolling .01")
        yield row(s, f"{name}: x at .5 s", x, run.x, 0.03, "m")
        skids = odometry > 1.1 * x
        if skids:
            low, high, note = 1.1 * run.x, 2.0 * run.x, "skids: sign and order"
            if not volts:
                low, note = 1.2 * run.x, "skids: > 1.2 x truth"
        else:
            low, high, note = 0.985 * run.x, 1.015 * run.x, "no skid: within 1.5 % of truth"
        yield Row(s, f"{name}: wheel odometry at .5 s", odometry, run.odometry, low, high, "m", note)
        sag = "3.92 at standstill: 13.5 (R/4) / (R/4 + .02)" if lowest < 5.0 else ""
        yield row(s, f"{name}: lowest voltage", lowest, run.min_voltage, 0.10 if sag else 0.03, "V", sag)
    for name, limit, top, t50, t90, t95, peak in (
        ("spin, 12 V stiff", math.inf, 12.74, 0.157, 0.294, 0.338, 40.8),
        ("spin, 60 A", 60.0, 12.74, 0.191, 0.350, 0.394, 33.4),
    ):
        run = launch(robot(MK4I, drive_stator_limit=limit), spin=True)
        yield row(s, f"{name}: top", top, run.top, 0.02, "rad/s")
        for share, want, got in (("t50", t50, run.t50), ("t90", t90, run.t90), ("t95", t95, run.t95)):
            yield row(s, f"{name}: {share}", want, got, 0.05, "s")
        yield Row(s, f"{name}: peak", peak, run.peak, 0.97 * peak, peak, "rad/s^2")
    yield from stops()


def stops() -> Iterator[Row]:
    """Yield the figures of braking at zero volts and of sliding across locked wheels."""
    s = "5.3"
    for name, limit, stop, decel, distance, odometry in (
        ("0 V brake from 4.5 m/s", math.inf, 0.506, 11.9, 0.880, 0.314),
        ("0 V brake, 60 A", 60.0, 0.530, 11.0, 0.943, 0.930),
    ):
        drive = robot(MK4I, drive_stator_limit=limit)
        chassis = DriveBench(drive)
        chassis.reset(vx=4.5)
        drive.state.wheel_speed[:] = [4.5 / MK4I.wheel_radius] * 4
        drive.set_volts([0.0] * 4, [0.0] * 4)
        worst = 0.0
        while chassis.vx > 0.05:
            chassis.step(STEP)
            worst = max(worst, -chassis.ax)
        t = chassis.time
        yield row(s, f"{name}: time to .05 m/s", stop, t, 0.05, "s", "'stop' taken as .05 m/s")
        # + 0 for a figure printed with one decimal: 11.03 is the closed form of '11.0'.
        yield Row(s, f"{name}: peak deceleration", decel, worst, 0.97 * decel, decel + 0.05, "m/s^2", "drag uses grip")
        chassis.run(0.5, h=STEP)
        yield row(s, f"{name}: distance", distance, chassis.x, 0.03, "m")
        measured = drive.wheel_distances()[0]
        if limit < math.inf:
            yield Row(
                s, f"{name}: wheel odometry", odometry, measured, 0.97 * chassis.x, chassis.x, "m", "hardly skids"
            )
        else:
            yield Row(s, f"{name}: wheel odometry", odometry, measured, 0.0, 0.5 * chassis.x, "m", "skids: far below")
    m = motor("Kraken X60")
    shorted = robot(MK4I, wheel_cof=10.0)
    shorted.state.wheel_speed[:] = [4.5 / MK4I.wheel_radius] * 4
    shorted.set_volts([0.0] * 4, [0.0] * 4)
    hold(shorted, 1e-5, (4.5, 0.0, 0.0))
    yield row(s, "0 V brake: back-EMF current", 346.0, -shorted.drive_motors.current[0], 0.03, "A", m.name)
    drive = robot(MK4I)
    chassis = DriveBench(drive)
    chassis.reset(vx=4.5)
    drive.reset(angles=[math.pi / 2.0] * 4)
    while chassis.vx > 1e-3:
        chassis.step(STEP)
    yield row(s, "ideal grip stop from 4.5 m/s: time", 0.382, chassis.time, 0.05, "s", "locked wheels crosswise")
    yield row(s, "ideal grip stop from 4.5 m/s: distance", 0.860, chassis.x, 0.03, "m")
    chassis.reset(vx=3.0)
    drive.reset(angles=[math.pi / 2.0] * 4)
    chassis.step(STEP)
    yield Row(s, "side slide from 3 m/s: deceleration", 11.77, -chassis.ax, 0.97 * 11.77, 11.77, "m/s^2")
    chassis.run(1.0, h=STEP)
    yield row(s, "side slide from 3 m/s: distance", 0.382, chassis.x, 0.03, "m")


def cost(robots: int, step: float) -> float:
    """Measure the median wall time of a 20 ms tick [ms]: closed loop, battery, limits, loads, encoders, pose."""
    module = replace(MK4I, drive_stator_limit=80.0, drive_supply_limit=60.0)
    fleet = [DriveBench(robot(module, BatteryConfig(), height=0.2)) for _ in range(robots)]
    spent = []
    for tick in range(200):
        total = 0.0
        for chassis in fleet:
            drive = chassis.drive
            assert isinstance(drive, SwerveDrive)
            start = time.perf_counter()
            drive.set_chassis_speeds(2 * math.cos(tick / 50), math.sin(tick / 40), math.sin(tick / 60))
            chassis.run(0.02, h=step)
            drive.encoders.drain()
            total += time.perf_counter() - start
        spent.append(total)
    return 1e3 * statistics.median(spent)


def measure() -> list[Row]:
    """Return all rows, in the order of the table."""
    return [*closed_forms(), *motors(), *launches()]


def main() -> int:
    """Print the table, and return 1 when a row fails."""
    global STEP
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--json", action="store_true", help="one JSON object on stdout instead of the table")
    parser.add_argument("--step", type=float, default=STEP, help="step in s (default 0.005)")
    parser.add_argument("--cost", action="store_true", help="also the wall time of a 20 ms tick, 1 and 6 robots")
    options = parser.parse_args()
    STEP = options.step
    logging.getLogger("simcore").setLevel(logging.ERROR)  # a tread of 10 is intended
    rows = measure()
    failed = [r for r in rows if not r.ok]
    costs = {f"{n} x {h * 1e3:g} ms": cost(n, h) for n in (1, 6) for h in (0.004, 0.005)} if options.cost else {}
    if options.json:
        print(json.dumps({"rows": [{**asdict(r), "ok": r.ok} for r in rows], "failed": len(failed), "cost_ms": costs}))
        return 1 if failed else 0
    from rich.console import Console
    from rich.table import Table

    table = Table(title=f"Drivetrain figures, step {STEP * 1e3:g} ms")
    for heading in ("", "figure", "expected", "measured", "allowed", "unit", "", "note"):
        table.add_column(heading, justify="right" if heading in ("expected", "measured") else "left")
    for r in rows:
        allowed = f"{r.low:.3f} .. {r.high:.3f}"
        verdict = "ok" if r.ok else "[bold red]FAIL[/]"
        table.add_row(r.section, r.name, f"{r.expected:.3f}", f"{r.measured:.3f}", allowed, r.unit, verdict, r.note)
    console = Console(width=None if sys.stdout.isatty() else 170)
    console.print(table)
    console.print(f"{len(rows) - len(failed)} of {len(rows)} rows within tolerance")
    for name, milliseconds in costs.items():
        console.print(f"cost of a 20 ms tick, robots x step: {name}: {milliseconds:.3f} ms")
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
