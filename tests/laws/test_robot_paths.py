"""Path of a robot: it hardly depends on the step length, and follows closed forms on the flat and at walls."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from simcore.match.match import Match
from simcore.match.motion import Motion
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.chassis_config import ChassisConfig
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.fixed_wheel_drive import TankDrive
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.swerve_drive import SwerveDrive
from simcore.testing.benches import DriveBench, LoneChassis
from simcore.world.world import PhysicsWorld

pytestmark = pytest.mark.engines("bullet")

DT = 0.02
RAW = SwerveModuleConfig(x=0.0, y=0.0)
LIMITED = replace(
    RAW, drive_stator_limit=60.0, drive_supply_limit=40.0, steer_stator_limit=40.0, steer_supply_limit=20.0
)


def swerve(module):
    body = ChassisConfig()
    modules = tuple(replace(module, x=x, y=y) for x, y in body.wheel_positions)
    config = SwerveConfig(
        modules=modules,
        mass=body.mass,
        yaw_inertia=body.inertia[2],
        center_of_mass=(0.0, 0.0, body.center_of_mass_height),
    )
    return SwerveDrive(config), body


def tank():
    config = TankConfig(stator_limit=60.0)
    return TankDrive(config), ChassisConfig.around(config, bumper=(0.8, 0.8))


# --- scripts: voltages and module angles as functions of time ---------------------------------------------------------


def sway(drive, time):
    """Drive gently forward and back while the modules turn slowly."""
    drive.set_volts([4.0 * math.sin(1.3 * time)] * 4, [0.6 * math.cos(2.0 * time)] * 4)


def strain(drive, time):
    """Drive the wheels at different speeds and directions, so that they scrub."""
    speeds = [2.0 * math.sin(1.1 * time) + 0.5 * k for k in range(4)]
    drive.set_module_states(speeds, [0.8 * math.sin(1.7 * time + 0.3 * k) for k in range(4)])


def steps(drive, time):
    """Step the voltages, reverse at full speed and throw the modules around, so that wheels spin and slide."""
    k = int(time / 0.5)
    drive.set_volts([(8, -6, 12, 0, -12, 5, 10, -10, 3, -3)[k]] * 4, [(0, 2, -2, 1, 0, -1, 3, -3, 0.5, 0)[k]] * 4)


def spin(drive, time):
    """Drive at 2.5 m/s along the field while turning at 6 rad/s, from rest."""
    turned, speeds, angles = 6.0 * time, [], []
    for x, y in drive.config.positions:
        vx, vy = 2.5 * math.cos(turned) - 6.0 * y, -2.5 * math.sin(turned) + 6.0 * x
        speeds.append(math.hypot(vx, vy))
        angles.append(math.atan2(vy, vx))
    drive.set_module_states(speeds, angles)


def skid(drive, time):
    """Drive at 12 V forward and back with less on the right: burnouts and slides to a stop."""
    volts = 12.0 if time % 2.0 < 0.8 else -12.0 if time % 2.0 < 1.4 else 0.0
    drive.set_volts([volts, 0.8 * volts] * 2, [0.8 * math.sin(3.0 * time)] * 4)


def tank_sway(drive, time):
    drive.set_volts(4.0 * math.sin(1.3 * time), 3.0 * math.cos(time))


def tank_steps(drive, time):
    """Drive out, turn on the spot and reverse in a curve."""
    k = int(time / 0.5)
    drive.set_volts((8, -6, 12, 0, -12, 5, 10, -10, 3, -3)[k], (8, 6, 10, 0, -12, -5, 10, -8, 3, 3)[k])


SCRIPTS = {
    "sway": (lambda: swerve(LIMITED), sway),
    "strain": (lambda: swerve(LIMITED), strain),
    "steps": (lambda: swerve(LIMITED), steps),
    "steps without limits": (lambda: swerve(RAW), steps),
    "spin": (lambda: swerve(LIMITED), spin),
    "skid": (lambda: swerve(RAW), skid),
    "tank sway": (tank, tank_sway),
    "tank steps": (tank, tank_steps),
}


def path(name, seconds=5.0):
    """Return x, y and unwrapped yaw of a robot in a world after every tick [m, m, rad]."""
    make, script = SCRIPTS[name]
    drive, body = make()
    rows = []
    with PhysicsWorld() as world:
        chassis = ChassisSimulation(world, body, drivetrain=drive)
        motion = Motion(world, robots=[LoneChassis(chassis)])
        for tick in range(round(seconds / DT)):
            script(drive, tick * DT)
            motion.tick()
            rows.append(chassis.pose)
    result = np.array(rows)
    result[:, 2] = np.unwrap(result[:, 2])
    return result


def planar_path(name, step, seconds=5.0):
    """Return the path of the drivetrain alone on a plane, with a given step [s]."""
    make, script = SCRIPTS[name]
    drive, _ = make()
    chassis, rows = DriveBench(drive), []
    for tick in range(round(seconds / DT)):
        script(drive, tick * DT)
        for _ in range(round(DT / step)):
            chassis.step(step)
        rows.append((chassis.x, chassis.y, chassis.yaw))
    return np.array(rows)


def apart(a, b):
    """Return the largest distance and heading difference of two paths at equal ticks [m, rad]."""
    return np.hypot(*(a - b)[:, :2].T).max(), np.abs(a - b)[:, 2].max()


@pytest.mark.parametrize("name", SCRIPTS)
def test_a_path_hardly_depends_on_the_step_length(name):
    """For 5 s of rough commands it stays within 50 mm and 1.4 degrees of the path with steps of 0.1 ms.

    Steps are 5 ms here and 1 ms in the loop, where first-order errors are a fifth.
    """
    converged = planar_path(name, 1e-4)
    assert np.ptp(converged[:, 0]) + np.ptp(converged[:, 2]) > 0.3
    distance, turn = apart(planar_path(name, 0.005), converged)
    assert distance < 0.050
    assert turn < math.radians(1.4)


def test_a_constant_force_moves_a_robot_by_half_the_acceleration_times_time_squared():
    """x = F t^2 / 2m, yaw = M t^2 / 2I without tires. Steps of h add a h t / 2: 2 mm."""
    with PhysicsWorld() as world:
        chassis = ChassisSimulation(world, ChassisConfig())
        chassis.apply_forces((200.0, 0.0, 0.0), (0.0, 0.0, 2.0))
        Motion(world, robots=[LoneChassis(chassis)]).advance(1.0)
        assert chassis.pose[0] == pytest.approx(0.5 * 200.0 / 55.0, abs=3e-3)
        assert chassis.pose[2] == pytest.approx(0.5 * 2.0 / chassis.config.inertia[2], abs=1e-3)
        assert chassis.vel[0] == pytest.approx(200.0 / 55.0, rel=1e-3)


# --- walls ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("longest", [math.inf, 0.004])
@pytest.mark.parametrize("heading", [0.0, 0.2, 0.5, 1.2])
def test_a_robot_that_leans_on_a_wall_does_not_rattle(heading, longest):
    """After 3 s of driving into a wall with all its grip, it moves by less than 1 mm and below 10 mm/s.

    In a step the tires accelerate the robot to 0.1 m/s; bounces at this speed would never end. Nor do they begin when
    pieces need steps of 4 ms.
    """
    with Match.bare(start=(14.0, 4.0, heading)) as match:
        robot, places, speeds = match.robots[0], [], []
        own = match.pieces.begin_tick
        match.pieces.begin_tick = lambda movers, dt: min(own(movers, dt), longest)
        for _ in range(200):
            robot.drive.set_chassis_speeds(2.0 * math.cos(heading), -2.0 * math.sin(heading), 0.0)
            match.tick()
            places.append(robot.chassis.pos[0])
            speeds.append(math.hypot(*robot.chassis.vel[:2]))
        assert places[-1] > 15.3
        assert np.ptp(places[150:]) < 0.001
        assert max(speeds[150:]) < 0.01
