"""Bumpers against walls and robots: the robot stays level and straight, slowed by mu N."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from simcore.match.game import Game, RobotEntry
from simcore.match.match import Match
from simcore.match.motion import Motion
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.chassis_config import BUMPER_STIFFNESS, ChassisConfig
from simcore.robot.fixed_wheel_drive import TankConfig
from simcore.robot.robot_config import RobotConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.testing.benches import LoneChassis
from simcore.units import GRAVITY, inches
from simcore.world.contact_law import WALL
from simcore.world.field import FieldElement
from simcore.world.shapes import Box, Hull
from simcore.world.world import PhysicsWorld

pytestmark = pytest.mark.engines("bullet")

DT = 0.02
MODULE = SwerveModuleConfig(
    x=0.0, y=0.0, drive_stator_limit=60.0, drive_supply_limit=40.0, steer_stator_limit=40.0, steer_supply_limit=20.0
)
SWERVE = RobotConfig(drivetrain=SwerveConfig.square(0.53, MODULE))
TANK = RobotConfig(drivetrain=TankConfig(stator_limit=60.0))
GUARDRAIL = [  # two pieces, vertical at the bottom and slanting back above the bumpers, like a field's guardrail
    FieldElement(
        name=f"rail {number}",
        shape=Hull(np.array([(x, y, z) for x in ends for y, z in ((0.8, 0.0), (1.0, 0.0), (0.8, 0.3), (0.9, 0.5))])),
        position=np.zeros(3),
        surface=WALL,
    )
    for number, ends in enumerate(((0.0, 4.0), (4.0, 30.0)))
]


def drive(robot, along, across, heading=0.0):
    """Command a field-frame velocity [m/s] and hold a heading with a gain of 6/s."""
    yaw = robot.chassis.pose[2]
    c, s = math.cos(yaw), math.sin(yaw)
    robot.drive.set_chassis_speeds(
        c * along + s * across, c * across - s * along, -6.0 * math.remainder(yaw - heading, math.tau)
    )


class Watch:
    """Largest tilt and turn of some robots [degrees], and their ticks with a lifted wheel."""

    def __init__(self, *robots):
        self.robots, self.start = robots, [robot.chassis.pose[2] for robot in robots]
        self.tilt = self.turn = 0.0
        self.lifted = 0

    def look(self):
        for robot, start in zip(self.robots, self.start, strict=True):
            roll, pitch, yaw = robot.chassis.roll_pitch_yaw
            self.tilt = max(self.tilt, math.degrees(max(abs(roll), abs(pitch))))
            self.turn = max(self.turn, abs(math.degrees(math.remainder(yaw - start, math.tau))))
            self.lifted += not all(robot.chassis.touching)


def field(*starts, elements=(), robot=SWERVE):
    game = Game.bare(size=(30.0, 8.0), elements=elements, pieces=(), zones=(), places=(), robot=lambda: robot)
    return Match(game, robots=tuple(RobotEntry(start=start) for start in starts))


# --- along walls ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("into", [50.0, 200.0])
def test_friction_with_a_wall_slows_a_robot_pushed_along_it_by_mu_n(into):
    """x = (F - mu N) t^2 / 2m for a robot without tires; mu = 0.7 x 0.5. The bumpers touch in every tick."""
    with PhysicsWorld() as world:
        world.add_static("wall", Box((60.0, 0.3, 1.0)), (20.0, 0.55, 0.5), surface=WALL)
        chassis = ChassisSimulation(world, ChassisConfig())
        chassis.apply_forces((150.0, into, 0.0))
        motion = Motion(world, robots=[LoneChassis(chassis)])
        for _ in range(100):
            motion.tick(DT)
        assert chassis.pose[0] == pytest.approx((150.0 - 0.35 * into) * 2.0**2 / (2.0 * 55.0), rel=0.01)
        rolled = 0.05 * into / (55.0 * GRAVITY / 3e-4 * 0.2667**2)  # pushed 50 mm above the middle of the bumpers
        assert chassis.pose[1] == pytest.approx(into / (BUMPER_STIFFNESS * 0.8) - 0.15 * rolled, abs=1e-6)
        turned = 0.35 * into * 0.4 / (BUMPER_STIFFNESS * 0.8 * 0.4**2)  # wall friction turns it
        assert chassis.pose[2] == pytest.approx(turned, abs=2e-5)


def test_bumper_friction_stops_a_slide_by_coulombs_law():
    """x = v^2 / (2 mu N / m) along a wall with N = 300 N; then the robot sticks."""
    with PhysicsWorld() as world:
        world.add_static("wall", Box((60.0, 0.3, 1.0)), (20.0, 0.55, 0.5), surface=WALL)
        chassis = ChassisSimulation(world, ChassisConfig(bumper_friction=0.8))
        world.set_velocity(chassis.row, (1.5, 0.0, 0.0))
        chassis.apply_forces((60.0, 300.0, 0.0))
        motion = Motion(world, robots=[LoneChassis(chassis)])
        for _ in range(150):
            motion.tick(DT)
        assert chassis.pose[0] == pytest.approx(1.5**2 * 55.0 / (2.0 * (0.4 * 300.0 - 60.0)), rel=0.02)
        assert chassis.vel[0] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("heading", [0.0, 30.0])
@pytest.mark.parametrize("depth", [0.002, 0.015])
def test_a_robot_placed_slightly_into_a_wall_is_not_thrown_off(depth, heading):
    """The robot comes out at 0.05 m/s at most, and moves no farther than the initial overlap."""
    yaw = math.radians(heading)
    reach = 0.4 * (math.cos(yaw) + math.sin(yaw))
    with PhysicsWorld() as world:
        world.add_static("wall", Box((60.0, 0.3, 1.0)), (20.0, 0.15 + reach - depth, 0.5), surface=WALL)
        chassis = ChassisSimulation(world, ChassisConfig(), pose=(5.0, 0.0, yaw))
        for _ in range(2):
            motion, fastest = Motion(world, robots=[LoneChassis(chassis)]), 0.0
            for _ in range(50):
                motion.tick(DT)
                fastest = max(fastest, math.hypot(*chassis.vel))
            assert fastest < 0.06
            assert -0.06 * 1.0 - 1e-3 < chassis.pose[1] < 1e-4
            chassis.set_pose(5.0, 0.0, yaw)


@pytest.mark.parametrize("wall", ["guardrail", "alliance wall"])
@pytest.mark.parametrize(("along", "into"), [(0.5, 0.1), (2.0, 0.3), (3.0, 1.0)])
def test_a_robot_slides_along_a_wall_level_and_without_turning(wall, along, into):
    """For two seconds no wheel lifts, the robot does not tilt, and its heading stays within half a degree."""
    rail = wall == "guardrail"
    with field((2.0, 1.45 if rail else 0.45, 0.0), elements=GUARDRAIL if rail else ()) as match:
        (robot,) = match.robots
        watch = Watch(robot)
        for _ in range(100):
            drive(robot, along, -into)
            match.tick()
            watch.look()
        assert match.contacts.touching(robot.chassis.row) == []
        assert robot.chassis.pose[1] == pytest.approx(1.39 if rail else 0.4, abs=3e-3)  # the lower edge of the rail
        assert robot.chassis.pose[0] > 2.4
        assert (watch.lifted, watch.tilt < 0.05, watch.turn < 0.5) == (0, True, True)


def test_a_tank_drive_steered_into_a_wall_slides_along_it():
    """With 6.5 V left, 6.0 V right and a wall on the right, the robot keeps moving straight."""
    with field((2.0, 0.41, 0.0), robot=TANK) as match:
        (robot,) = match.robots
        watch = Watch(robot)
        for _ in range(100):
            robot.drive.set_volts(6.5, 6.0)
            match.tick()
            watch.look()
        assert robot.chassis.pose[0] > 5.0
        assert watch.tilt < 1.5, "it rocks on its drop center"
        assert watch.turn < 2.0


# --- robots -----------------------------------------------------------------------------------------------------------


def test_a_robot_hit_from_the_side_escapes_with_all_wheels_on_the_carpet():
    """A robot drives into the side of another at 3 m/s, then that robot leaves at 3 m/s: no wheel lifts."""
    with field((4.0, 4.0, 0.0), (6.0, 4.0, math.pi / 2)) as match:
        a, b = match.robots
        watch = Watch(a, b)
        met = False
        for tick in range(110):
            drive(a, 3.0, 0.0)
            drive(b, 0.0, 3.0 if tick > 40 else 0.0, math.pi / 2)
            match.tick()
            watch.look()
            met |= (0, 1) in match.contacts.robots
        assert met
        assert b.chassis.pose[1] > 6.0
        assert (watch.lifted, watch.tilt < 1.0, watch.turn < 30.0) == (0, True, True)


def tire_moment(robot):
    """Return the moment of the tire forces about the field origin [N m]."""
    x, y, yaw = robot.chassis.pose
    c, s = math.cos(yaw), math.sin(yaw)
    return sum(
        (x + c * px - s * py) * (s * fx + c * fy) - (y + s * px + c * py) * (c * fx - s * fy)
        for (px, py), (fx, fy) in zip(robot.config.body.wheel_positions, robot.drive.wheel_forces.tolist(), strict=True)
    )


def spin(robot):
    """Return the angular momentum about the field origin [N m s]."""
    (x, y, _), (vx, vy, _), (mass, _, inertia) = robot.chassis.pos, robot.chassis.vel, robot.chassis.distribution
    return mass * (x * vy - y * vx) + inertia[2] * robot.chassis.rate[2]


SCRAPE = ((4.0, 4.0, 0.0), (5.0, 4.84, 0.0)), lambda tick: ((2.0, 0.3), (0.0, 0.0))
"""One robot slides along a robot at rest: start poses, and velocities by tick [m/s]."""
ESCAPE = ((4.0, 4.0, 0.0), (6.0, 4.0, math.pi / 2)), lambda tick: ((3.0, 0.0), (0.0, 3.0 if tick > 40 else 0.0))


@pytest.mark.parametrize("scene", (SCRAPE, ESCAPE), ids=("scrape", "escape"))
def test_the_contact_of_two_robots_conserves_angular_momentum(scene):
    """Only their own tires can change the angular momentum of both robots about a fixed point.

    The robots turn by 4 degrees in a scrape and by 22 degrees when one leaves a T-bone. Tire moments are taken at the
    end of each tick, within 3 % of the sum of their magnitudes.
    """
    starts, wanted = scene
    moment = size = 0.0
    with field(*starts) as match:
        for tick in range(80):
            for robot, start, way in zip(match.robots, starts, wanted(tick), strict=True):
                drive(robot, *way, heading=start[2])
            match.tick()
            moments = [tire_moment(robot) for robot in match.robots]
            moment, size = moment + DT * sum(moments), size + DT * sum(map(abs, moments))
        assert match.contacts.robots or size > 1000.0
        assert sum(map(spin, match.robots)) == pytest.approx(moment, abs=0.03 * size)


def held_heading(torque):
    """Return the heading error at which a swerve drive with a gain of 6/s balances a torque [N m], in radians.

    Each wheel, at the lever arm R, provides torque r / 4 R through its motor, gear loss and friction. Its current
    takes a voltage that the module's loop reaches at a speed error s: kV s + kP s + kS min(1, 20 s). The heading
    loop commands s = 6/s R theta.
    """
    module, motor, arm = MODULE, MODULE.limited_drive_motor, 0.5 * math.sqrt(2.0) * 0.53
    load = SWERVE.body.mass * GRAVITY / 4.0
    volts = (torque * module.wheel_radius / (4.0 * arm) - motor.friction) / motor.torque_driven * motor.winding
    drag = motor.friction + module.rolling_resistance * load * module.wheel_radius
    slope, ks = motor.emf / module.wheel_radius + module.drive_kp, drag / motor.torque_driving * motor.winding
    return max((volts - ks) / slope, volts / (slope + 20.0 * ks)) / (6.0 * arm)


@pytest.mark.parametrize("torque", [100.0, 150.0, 200.0])
def test_a_held_heading_yields_to_a_torque_by_the_gains_of_its_loops(torque):
    """It yields 2.3, 5.2 and 8.1 degrees in 0.8 s, within 5 %: the transient and tire creep are not modelled."""
    with field((5.0, 4.84, 0.0)) as match:
        (robot,) = match.robots
        for _ in range(40):
            drive(robot, 0.0, 0.0)
            robot.chassis.apply_forces((0.0, 0.0, 0.0), (0.0, 0.0, torque))
            match.tick()
        assert robot.chassis.pose[2] == pytest.approx(held_heading(torque), rel=0.05)


def test_a_robot_leaving_a_t_bone_turns_because_all_its_tires_are_at_their_limit():
    """The robot turns by 22 degrees: every tire already exerts mu N, so no grip is left to hold the heading."""
    starts, wanted = ESCAPE
    used, turned = [], [0.0]
    with field(*starts) as match:
        robot = match.robots[1]
        for tick in range(110):
            for one, start, way in zip(match.robots, starts, wanted(tick), strict=True):
                drive(one, *way, heading=start[2])
            match.tick()
            turned.append(robot.chassis.pose[2] - starts[1][2])
            if turned[-1] - turned[-2] > math.radians(0.02):
                grip = robot.config.drivetrain.wheel_cof * sum(robot.chassis.normal_loads)
                used.append(float(np.hypot(*robot.drive.wheel_forces.T).sum()) / grip)
    assert math.degrees(max(turned)) == pytest.approx(22.2, abs=1.0)
    assert len(used) > 20 and min(used) > 0.95


def test_a_scraped_robot_turns_like_a_free_robot_under_the_same_force_and_torque():
    """It turns by 4 degrees, the error at which a gain of 6/s balances the largest contact torque, 130 N m."""
    starts, wanted = SCRAPE
    pushes, turned, lone = [], [], []
    with field(*starts) as match:
        other = match.robots[1].chassis
        for tick in range(80):
            for robot, way in zip(match.robots, wanted(tick), strict=True):
                drive(robot, *way)
            before = (*other.vel[:2], other.rate[2])
            tires = match.robots[1].drive.wheel_forces
            match.tick()
            tires = 0.5 * (tires + match.robots[1].drive.wheel_forces)
            arms = zip(match.robots[1].config.body.wheel_positions, tires.tolist(), strict=True)
            held = (*tires.sum(axis=0).tolist(), sum(x * fy - y * fx for (x, y), (fx, fy) in arms))
            after, mass = (*other.vel[:2], other.rate[2]), other.distribution.mass
            inert = (mass, mass, other.distribution.inertia[2])
            pushes.append([m * (b - a) / DT - f for m, a, b, f in zip(inert, before, after, held, strict=True)])
            turned.append(other.pose[2])
    with field(starts[1]) as match:
        (robot,) = match.robots
        for fx, fy, torque in pushes:
            drive(robot, 0.0, 0.0)
            robot.chassis.apply_forces((fx, fy, 0.0), (0.0, 0.0, torque))
            match.tick()
            lone.append(robot.chassis.pose[2])
    torque = max(torque for _, _, torque in pushes)
    assert 100.0 < torque < 160.0
    assert max(lone) == pytest.approx(held_heading(torque), rel=0.1)
    assert max(turned) == pytest.approx(max(lone), rel=0.15)


@pytest.mark.parametrize("speed", [3.0, 5.0])
@pytest.mark.parametrize("heading", [0.0, 0.5])
def test_bumpers_of_two_robots_overlap_no_more_than_their_stiffness_allows(speed, heading):
    """At most v sqrt(m / k) with the reduced mass and two bumpers in series; a corner has half a side's stiffness."""
    with PhysicsWorld() as world:
        a = ChassisSimulation(world, ChassisConfig(), pose=(0.0, 0.0, 0.0), name="a")
        b = ChassisSimulation(world, ChassisConfig(mass=40.0), pose=(1.55, 0.2, heading), name="b")
        world.set_velocity(a.row, (speed, 0.0, 0.0))
        world.set_velocity(b.row, (-0.5 * speed, 0.0, 0.0))
        a.read(), b.read()
        momentum = 55.0 * a.vel[0] + 40.0 * b.vel[0]
        deepest, energies = 0.0, []
        motion = Motion(world, robots=[LoneChassis(a), LoneChassis(b)])
        for _ in range(30):
            motion.tick(DT)
            c, s = math.cos(b.pose[2]), math.sin(b.pose[2])
            for x, y in ((0.4, 0.4), (0.4, -0.4), (-0.4, 0.4), (-0.4, -0.4)):  # corners of b in a's box
                px, py = b.pose[0] + c * x - s * y - a.pose[0], b.pose[1] + s * x + c * y - a.pose[1]
                ca, sa = math.cos(a.pose[2]), math.sin(a.pose[2])
                deepest = max(deepest, 0.4 - max(abs(ca * px + sa * py), abs(ca * py - sa * px)))
            energies.append(
                sum(
                    0.5 * r.config.mass * (r.vel[0] ** 2 + r.vel[1] ** 2) + 0.5 * r.config.inertia[2] * r.rate[2] ** 2
                    for r in (a, b)
                )
            )
        reduced, stiffness = 55.0 * 40.0 / 95.0, 0.5 * BUMPER_STIFFNESS * 0.6 * (1.0 if heading == 0.0 else 0.5)
        assert deepest < 1.5 * speed * math.sqrt(reduced / stiffness)
        assert np.diff(energies).max() < 1.0, "and no energy comes of it"
        assert 55.0 * a.vel[0] + 40.0 * b.vel[0] == pytest.approx(momentum, rel=0.01)


def test_a_robot_at_a_wall_does_not_change_another_robots_path():
    """One robot leans on a wall or stands still, 20 m from the other: the step length does not depend on contacts."""

    def path(pressing):
        with field((6.0, 4.0, 0.0), (28.5, 4.0, 0.0)) as match:
            rows = []
            for tick in range(200):
                t = tick * DT
                drive(match.robots[0], 2.0 * math.sin(t), math.cos(2.0 * t), heading=math.sin(1.7 * t))
                drive(match.robots[1], *((2.0, 0.5) if pressing else (0.0, 0.0)))
                match.tick()
                rows.append((*match.robots[0].chassis.pose, *match.robots[0].chassis.vel))
            return rows

    assert np.array(path(True)) == pytest.approx(np.array(path(False)), abs=1e-5)


# --- loads and ramps --------------------------------------------------------------------------------------------------


def test_wheel_loads_balance_the_weight_and_the_push_of_the_wall():
    """F z / L moves between the axles: the wall pushes at z = 0.15 m, the middle of the bumpers."""
    wall = FieldElement(name="low wall", shape=Box((0.3, 6.0, 1.0)), position=np.array([4.0, 4.0, 0.5]), surface=WALL)
    with field((3.0, 4.0, 0.0), elements=[wall]) as match:
        (robot,) = match.robots
        for _ in range(100):
            drive(robot, 0.5, 0.0)
            match.tick()
        loads = robot.chassis.normal_loads
        push = float(robot.drive.wheel_forces.sum(axis=0)[0])
        assert push > 100.0
        assert sum(loads) == pytest.approx(robot.config.body.mass * GRAVITY, rel=1e-6)
        rear = [load for load, (x, _) in zip(loads, robot.config.body.wheel_positions, strict=True) if x < 0.0]
        moment = (2.0 * sum(rear) - sum(loads)) * 0.5 * 0.53
        assert moment == pytest.approx(push * 0.15, rel=0.05)


@pytest.mark.parametrize("speed", [1.0, 1.5])
def test_a_robot_that_coasts_up_a_bump_returns_at_nearly_its_speed(speed):
    """Without tires and brakes, only the impact of front wheels at the foot of the ramp loses speed: 12 % at most."""
    height, depth = inches(6.513), inches(44.4)
    points = np.array([(x, y, z) for y in (-5.0, 5.0) for x, z in ((0.0, 0.0), (depth, 0.0), (depth / 2, height))])
    with PhysicsWorld() as world:
        world.add_static("bump", Hull(points), (1.0, 0.0, 0.0), surface=replace(WALL, friction=0.3), drivable=True)
        chassis = ChassisSimulation(world, ChassisConfig())
        world.set_velocity(chassis.row, (speed, 0.0, 0.0))
        chassis.read()
        motion = Motion(world, robots=[LoneChassis(chassis)])
        for _ in range(250):
            motion.tick(DT)
            if chassis.pose[0] < 0.0:
                break
        assert 0.88 * speed < -chassis.vel[0] < speed


# --- tilted robots ----------------------------------------------------------------------------------------------------


def test_a_bar_above_the_bumpers_stops_the_frame():
    """A bar at 0.4 m passes over bumpers of 0.25 m and meets a frame of 0.5 m; the robot leans back until it balances.

    The rear wheels then push with W tan b, where b is the angle from the bar to the rear wheels: about 12 degrees.
    """
    arm = FieldElement(name="arm", shape=Box((0.2, 6.0, 0.2)), position=np.array([4.0, 4.0, 0.4]), surface=WALL)
    with field((3.0, 4.0, 0.0), elements=[arm]) as match:
        (robot,) = match.robots
        for _ in range(100):
            drive(robot, 1.0, 0.0)
            match.tick()
        lean = abs(robot.chassis.roll_pitch_yaw[1])
        frame = robot.chassis.pose[0] + 0.5 * 0.8 - robot.config.body.bumper_thickness
        assert frame - 0.4 * math.sin(lean) == pytest.approx(3.9, abs=0.02)
        assert math.radians(9.0) < lean < math.radians(13.0)
