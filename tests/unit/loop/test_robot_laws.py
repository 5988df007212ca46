"""The robots' loop: battery and motors at one voltage, and bumpers against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from simcore.loop.battery import bus_voltage
from simcore.loop.robot_state import OUTLINE, PART, ROBOT, SHAFT, SPRING, STEP, WHEEL, records
from simcore.loop.robots import begin_robots, end_robots, move_robots
from simcore.physics.contact_law import BUMPER
from simcore.robot.battery import Battery, BatteryConfig
from simcore.robot.dc_motor import motor
from simcore.robot.wheel_config import LimitedMotor
from simcore.robot.wheeled_drive import set_motor
from simcore.units import GRAVITY

# --- battery and motors ---------------------------------------------------------------------------------------------

KRAKEN = LimitedMotor.of(motor("Kraken X60"), gearing=6.75, efficiency=0.9, friction_volts=0.1)


def bus_of(voltage, *, speed=0.0, limit=math.inf, other=0.0):
    """Bus voltage of a rested battery of 0.02 ohm with four Krakens at 12 V [V]."""
    battery = Battery(BatteryConfig(full_voltage=voltage, empty_voltage=0.0, resistance=0.02))
    shafts = records(SHAFT, 4)
    for k in range(4):
        set_motor(shafts[k : k + 1], KRAKEN)
    shafts["wanted"], shafts["limit"], shafts["speed"] = 12.0, limit, speed
    return bus_voltage(battery.records, 0, voltage, other, shafts, 0, 4)


def test_bus_voltage_of_four_stalled_krakens():
    """Motors at full duty are R/4: 13.5 V * (R/4) / (R/4 + 0.02)."""
    r4 = KRAKEN.resistance / 4
    assert bus_of(13.5) == pytest.approx(13.5 * r4 / (r4 + 0.02), abs=1e-3)


def test_bus_voltage_with_a_current_limit_is_constant_power():
    bus = bus_of(12.6, speed=3.0 / KRAKEN.emf, limit=60.0, other=10.0)
    power = 4 * 60.0 * (3.0 + 60.0 * KRAKEN.resistance)
    assert bus == pytest.approx(12.6 - 0.02 * (10.0 + power / bus), abs=1e-3)


def test_dead_battery_gives_zero():
    assert bus_of(0.0) == 0.0


# --- bumpers --------------------------------------------------------------------------------------------------------

MASS, STIFFNESS = 55.0, 1e6
INERTIA = MASS * 0.4**2
"""As if its mass were at its rim: the half of it is behind each corner [kg m^2]."""
WALL = [(1.0, -5.0), (2.0, -5.0), (2.0, 5.0), (1.0, 5.0)]


class Plane:
    """Robots of 55 kg and 0.8 x 0.8 m without wheels, and outlines, in a plane: no engine."""

    def __init__(self, robots, outlines=(), *, friction=0.0, restitution=0.0) -> None:
        n = len(robots)
        self.robots, self.parts, self.outlines = records(ROBOT, n), records(PART, n), records(OUTLINE, len(outlines))
        self.corners = np.array([corner for outline in outlines for corner in outline], float).reshape(-1, 2)
        self.normals = np.zeros_like(self.corners)
        for k, outline in enumerate(np.array(outlines, float)):
            along = np.roll(outline, -1, axis=0) - outline
            outward = np.column_stack((along[:, 1], -along[:, 0])) / np.linalg.norm(along, axis=1)[:, None]
            self.normals[4 * k : 4 * k + 4] = outward
            self.outlines[k : k + 1]["first"], self.outlines[k : k + 1]["last"] = 4 * k, 4 * k + 4
            for name, values in (("low", outline.min(axis=0)), ("high", outline.max(axis=0))):
                self.outlines[f"{name}_x"][k], self.outlines[f"{name}_y"][k] = values
        self.outlines["row"], self.outlines["top"] = np.arange(len(outlines)), 1.0
        # A pair's factor is the product.
        self.outlines["friction"], self.outlines["restitution"] = friction, restitution
        r, p = self.robots, self.parts
        r["row"], r["first_part"], r["last_part"] = np.arange(100, 100 + n), np.arange(n), np.arange(1, n + 1)
        r["mass"], r["inertia"], r["is_upright"], r["reach"] = MASS, INERTIA, 1, 0.6
        r["along"], r["aside"] = (1.0, 0.0), (0.0, 1.0)
        p["robot"], p["half_length"], p["half_width"], p["stiffness"] = np.arange(n), 0.4, 0.4, STIFFNESS
        p["top"] = p["high"] = 0.2
        p["friction"], p["restitution"] = (1.0, 1.0) if n == 1 else (math.sqrt(friction), math.sqrt(restitution))
        p["last_outline"] = len(outlines)
        for k, (place, velocity) in enumerate(robots):
            r["x"][k], r["y"][k], r["yaw"][k] = place
            r["vx"][k], r["vy"][k], r["omega"][k] = velocity
        self.springs = records(SPRING, 64 * n).reshape(n, 64)
        self.springs["stamp"] = -2
        self.clock = np.zeros(1, np.int64)

    def move(self, seconds=STEP) -> None:
        move_robots(
            *(self.robots, records(SHAFT, 0), records(WHEEL, 0), Battery().records, self.parts, self.outlines),
            *(self.corners, self.normals, np.zeros(len(self.corners), np.uint8), self.springs, self.clock, seconds),
        )

    @property
    def velocity(self):
        """Of all robots, shape (n, 3)."""
        return np.column_stack([self.robots[name] for name in ("vx", "vy", "omega")])

    @property
    def momentum(self):
        """Linear and angular about the origin."""
        r = self.robots
        turning = INERTIA * r["omega"] + MASS * (r["x"] * r["vy"] - r["y"] * r["vx"])
        return np.array([MASS * r["vx"].sum(), MASS * r["vy"].sum(), turning.sum()])

    @property
    def energy(self) -> float:
        return float((0.5 * np.array([MASS, MASS, INERTIA]) * self.velocity**2).sum())

    def move_until_parted(self) -> None:
        """Move until nothing touches any more after it has."""
        touched = False
        for _ in range(1000):
            self.move()
            is_touching = bool(self.robots["contact"].any())
            if touched and not is_touching:
                return
            touched = touched or is_touching
        raise AssertionError("they never touch, or never part")


@pytest.mark.parametrize("gap", [0.0, 0.0004, 0.0011, 0.0021])
@pytest.mark.parametrize(("restitution", "left"), [(0.0, 0.03), (0.1, 0.1), (0.2, 0.2), (0.6, 0.25)])
@pytest.mark.parametrize("speed", [0.5, 3.0])
def test_a_hit_leaves_the_restitution_of_the_pair(gap, restitution, left, speed):
    """Flat against a wall, at every phase of the hit within a step: spring and damper take 25 steps and more.

    No bumper gives back more than a quarter, and dampers beyond three times critical are not tried.
    """
    plane = Plane([((0.6 - gap * speed, 0.0, 0.0), (speed, 0.0, 0.0))], [WALL], restitution=restitution)
    plane.move_until_parted()
    vx, vy, omega = plane.velocity[0]
    assert -vx / speed == pytest.approx(left, abs=0.03)
    assert (vy, omega) == pytest.approx((0.0, 0.0), abs=1e-12)


@pytest.mark.parametrize(("along", "left"), [(2.0, 0.0), (6.0, 6.0 - 0.35 * 12.0), (-6.0, -6.0 + 0.35 * 12.0)])
def test_a_robot_that_leans_on_a_wall_stands_and_friction_holds_up_to_mu_n(along, left):
    """12 m/s^2 into the wall: 2 m/s^2 along it stick to the wall, of 6 m/s^2 it takes mu times 12."""
    plane = Plane(
        [((0.6 + MASS * 12.0 / (0.8 * STIFFNESS), 0.0, 0.0), (0.0, 0.0, 0.0))], [WALL], friction=0.35, restitution=0.2
    )
    plane.robots["drive"] = (12.0, along, 0.0)
    plane.move(0.5)
    vx, vy, omega = plane.velocity[0]
    assert vx == pytest.approx(0.0, abs=1e-6)
    # Until friction has its force, its spring gives way: by mu N / k.
    assert vy == pytest.approx(0.5 * left, abs=0.02)
    assert omega == pytest.approx(0.0, abs=1e-3), "the pressure goes to the front and holds the heading"
    assert abs(plane.robots["contact"][0, 1]) == pytest.approx(min(MASS * abs(along), 0.35 * MASS * 12.0), rel=0.02)


@settings(max_examples=50)
@given(
    yaw=st.floats(-0.7, 0.7),
    offset=st.floats(-0.7, 0.7),
    velocity=st.tuples(st.floats(1.0, 4.0), st.floats(-4.0, 4.0), st.floats(-8.0, 8.0)),
    friction=st.floats(0.0, 1.0),
    restitution=st.floats(0.0, BUMPER.restitution),
)
def test_two_robots_keep_momentum_and_gain_no_energy(yaw, offset, velocity, friction, restitution):
    """Momentum to rounding, at each step; as bumpers bounce, one of them against what bounces perfectly."""
    plane = Plane(
        [((0.0, 0.0, 0.0), velocity), ((1.15, offset, yaw), (-0.5, 0.3, 1.0))],
        friction=friction,
        restitution=restitution,
    )
    momentum, energy = plane.momentum, plane.energy
    for _ in range(300):
        plane.move()
        assert plane.momentum == pytest.approx(momentum, abs=1e-9)
        pushed = plane.robots["contact"][:, :2]
        assert pushed[0] == pytest.approx(-pushed[1], abs=1e-9)
    assert plane.energy <= energy * 1.0001


def test_a_seam_between_two_flush_walls_stops_nobody():
    """What lies ahead overlaps by less than 3 mm from the side; by 100 mm it stops what is behind a lever of 350 mm."""
    left = []
    for inner in (-0.398, -0.3):
        ahead = [(0.5, -1.0), (2.0, -1.0), (2.0, inner), (0.5, inner)]
        plane = Plane([((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))], [ahead])
        plane.move(0.2)
        left.append(plane.velocity[0, 0])
    assert left[0] == pytest.approx(1.0, abs=1e-3)
    assert left[1] < 1.0 - 1.0 / (1.0 + 0.35**2 / 0.4**2)


@pytest.mark.parametrize("ahead", [0.0, 0.15])
@pytest.mark.parametrize(("yaw", "stiffness"), [(0.0, 0.8), (math.pi / 4, 0.5 * 0.8 * math.sqrt(0.5))])
def test_bumpers_give_way_by_force_over_stiffness_and_length(yaw, stiffness, ahead):
    """Flat: d = m a / (k L), with both ends of the side; at a slant a corner alone, with half of what faces the wall.

    They are around the middle of the robot, wherever its center of mass is.
    """
    reach = 0.4 if yaw == 0.0 else 0.4 * math.sqrt(2.0)
    c, s = math.cos(yaw), math.sin(yaw)
    plane = Plane([((1.0 - reach + ahead, 0.0, yaw), (0.0, 0.0, 0.0))], [WALL], restitution=0.2)
    plane.robots["center_ahead"] = (c * ahead, -s * ahead)  # in its own axes, straight to the wall
    plane.robots["drive"] = (12.0, 0.0, 0.0)
    plane.move(1.0)
    depth = plane.robots["x"][0] - ahead + reach - 1.0
    assert depth == pytest.approx(MASS * 12.0 / (stiffness * STIFFNESS), rel=0.01)
    assert plane.robots["touches"][0, : plane.robots["touched"][0]].tolist() == [0]


# --- what the engine makes of a step --------------------------------------------------------------------------------


def in_the_air(*, vel=(0.0, 0.0, 0.0), rate=(0.0, 0.0, 0.0)):
    """One robot of 55 kg whose center of mass is 0.2 m above its underside, off the floor, as the engine has it."""
    robots = records(ROBOT)
    robots["mass"], robots["inertia"], robots["center"] = MASS, (3.0, 4.0, 5.0), (0.0, 0.0, 0.2)
    robots["half_base"], robots["is_enabled"] = 0.25, 1
    robots["seen"] = (0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, *vel, *rate)
    return robots


@pytest.mark.parametrize(("pull", "turn"), [(0.7, 5.0), (40.0, -900.0)])
def test_a_wall_pushes_back_with_no_more_than_a_tire_could_stand(pull, turn):
    """Tires expect the engine to do what it did in the last step, but no more than 1.5 g at any wheel."""
    h, most = 0.005, 1.5 * GRAVITY
    robots = in_the_air(vel=(-0.6 * pull * h, 0.8 * pull * h, 0.0), rate=(0.0, 0.0, turn * h))
    robots["h_before"] = h
    begin_robots(robots, records(PART, 0), GRAVITY)
    ax, ay, spin = robots["pull"][0].tolist()
    assert (ax, ay) == pytest.approx((-0.6 * min(pull, most), 0.8 * min(pull, most)))
    most_spin = most * MASS * 0.25 / 5.0
    assert spin == pytest.approx(max(-most_spin, min(most_spin, turn)))


def test_an_outside_force_acts_at_the_center_of_mass_and_tires_below_it():
    """The first turns nothing; a change v of the velocity by tires turns the robot by m v z / I."""
    h = 0.005
    robots = in_the_air()
    robots["force"] = (110.0, -55.0, 20.0)
    begin_robots(robots, records(PART, 0), GRAVITY)
    empty = records(SHAFT, 0), records(WHEEL, 0), Battery().records, records(PART, 0), records(OUTLINE, 0)
    nothing = np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0, np.uint8), records(SPRING, 64).reshape(1, 64)
    move_robots(robots, *empty, *nothing, np.zeros(1, np.int64), h)
    end_robots(robots, h, GRAVITY)
    vx, vy, vz, wx, wy, wz = (robots["given"] + robots["rest"])[0].tolist()
    assert (vx, vy, vz) == pytest.approx((h * 110.0 / MASS, -h * 55.0 / MASS, h * 20.0 / MASS))
    assert (wx, wy, wz) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    robots["end_change"] += (0.02, -0.03, 0.0)
    end_robots(robots, h, GRAVITY)
    wx, wy, _ = (robots["given"] + robots["rest"])[0, 3:].tolist()
    assert (wx, wy) == pytest.approx((-0.03 * MASS * 0.2 / 3.0, -0.02 * MASS * 0.2 / 4.0))
