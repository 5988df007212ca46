"""What contacts come to on every engine, beside theory where it has a closed form: `python scripts/contact_figures.py`.

Each scene is a match on a bare carpet; the column "apart" is the difference of the two engines over the larger figure.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from importlib.util import find_spec

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table
from scipy.spatial import cKDTree

from simcore.match.game import PieceSupply
from simcore.match.match import Match
from simcore.physics.contact_law import CARPET, POLYCARBONATE, WALL
from simcore.physics.field import FieldElement
from simcore.physics.shapes import Box, Hull, Sphere
from simcore.pieces.kinds import GamePieceConfig
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.robot_config import RobotConfig
from simcore.units import GRAVITY, TICK, inches

RADIUS = 0.075
FUEL = GamePieceConfig(name="Fuel", shape=Sphere(RADIUS), mass=0.215, friction=0.8, restitution=0.55)
HALF = 0.4
"""Of the robot's bumpers [m]."""

Figures = dict[str, tuple[float, float | None]]
"""Measured, and by theory, by name."""


def _robot_speed(match: Match) -> float:
    return math.hypot(*match.robots[0].chassis.vel[:2])


def sleepers(engine: str) -> Figures:
    """A robot with 0.7, 1.5 and 2.4 m/s into 12 x 5 sleeping fuel: way in 2.6 s, and its slowest instant."""
    found: Figures = {}
    for speed in (0.7, 1.5, 2.4):
        with Match.bare(start=(2.0, 4.0, 0.0), pieces=[PieceSupply(FUEL, 60)], engine=engine) as match:
            robot = match.robots[0]
            first = 2.0 + HALF + 1.2 * speed
            places = [(first + 0.152 * i, 4.0 + 0.152 * (j - 5.5), RADIUS) for i in range(5) for j in range(12)]
            match.pieces.spawn("Fuel", np.array(places))
            robot.drive.set_chassis_speeds(speed, 0.0, 0.0)
            slowest, start = math.inf, 0.0
            for tick in range(round(3.6 / TICK)):
                match.tick()
                if tick == round(1.0 / TICK):
                    start = robot.chassis.pos[0]
                if tick > round(1.0 / TICK):
                    slowest = min(slowest, _robot_speed(match))
            found[f"{speed} m/s, way [m]"] = (robot.chassis.pos[0] - start, None)
            found[f"{speed} m/s, slowest [m/s]"] = (slowest, None)
    return found


def rows(engine: str) -> Figures:
    """A ball with 1, 3 and 6 m/s into a row of five that sleep: momentum of all and speed of the last after 0.1 s."""
    found: Figures = {}
    for e in (0.3, 1.0):
        kind = GamePieceConfig(name="Ball", shape=Sphere(RADIUS), mass=0.215, friction=0.0, restitution=math.sqrt(e))
        for speed in (1.0, 3.0, 6.0):
            with Match.bare(start=(14.0, 7.0, 0.0), pieces=[PieceSupply(kind, 6)], engine=engine) as match:
                row = match.pieces.spawn("Ball", np.array([(4.0 + 0.152 * i, 4.0, RADIUS) for i in range(5)]))
                shot = match.pieces.spawn("Ball", np.array([(3.7, 4.0, RADIUS)]))
                match.play(0.2)
                match.pieces.push(shot, np.array([[speed, 0.0, 0.0]]))
                match.play(TICK * math.ceil((0.3 / speed + 0.1) / TICK))
                vel = match.pieces.state.vel[:, 0]
                last = speed * ((1.0 + e) / 2.0) ** 5
                found[f"e {e}, {speed} m/s, momentum"] = (float(vel.sum()), speed)
                found[f"e {e}, {speed} m/s, last [m/s]"] = (float(vel[row[-1]]), last if e == 1.0 else None)
                if e == 1.0:
                    found[f"e {e}, {speed} m/s, first [m/s]"] = (float(vel[shot[0]]), 0.0)
    return found


def bounces(engine: str) -> Figures:
    """Balls that hit the carpet obliquely with spin: speed along it afterwards."""
    found: Figures = {}
    ball = GamePieceConfig(name="Ball", shape=Sphere(RADIUS), mass=0.215, friction=0.8, restitution=0.9)
    for along, down, spin in ((6.0, -2.0, 0.0), (3.0, -4.0, -100.0), (8.0, -3.0, -150.0)):
        for phase in (0.0, 0.35, 0.7):
            with Match.bare(start=(14.0, 7.0, 0.0), pieces=[PieceSupply(ball, 1)], engine=engine) as match:
                height = RADIUS - down * (0.1 + phase * TICK)
                match.pieces.stage("Ball", 1)
                slot = np.array([0])
                match.pieces.hold(slot, 0)
                start = -math.sqrt(max(down * down - 2.0 * GRAVITY * (height - RADIUS), 0.0))
                match.pieces.launch(0, (3.0, 4.0, height), (along, 0.0, start), (0.0, spin, 0.0), slot=0)
                for _ in range(40):
                    match.tick()
                    if match.pieces.state.vel[0, 2] > 0.0:
                        break
                match.tick()
                vel = match.pieces.state.vel[0]
                slip, grip = along - RADIUS * spin, 0.8 * CARPET.friction * (1.0 + 0.9 * CARPET.restitution) * -down
                vx = along - math.copysign(min(grip, 2.0 / 7.0 * abs(slip)), slip)  # it slides, or leaves rolling
                name = f"({along:.0f}, {down:.0f}) m/s, {spin:.0f} rad/s, phase {phase}"
                found[f"{name}, along [m/s]"] = (float(vel[0]), vx)
    return found


def block_on_slope(engine: str) -> Figures:
    """A crate on a slope of 20 degrees with friction 0.2: acceleration g (sin - mu cos)."""
    slope = math.radians(20.0)
    crate = GamePieceConfig(name="Crate", shape=Box((0.3, 0.3, 0.2)), mass=2.0, friction=1.0, restitution=0.0)
    ramp = CARPET.__class__(name="ramp", friction=0.2, restitution=0.0)
    length, rise = 6.0, 6.0 * math.tan(slope)
    points = np.array([(x, y, z) for y in (-1.0, 1.0) for x, z in ((0.0, 0.0), (length, 0.0), (0.0, rise))])
    element = FieldElement(name="slope", shape=Hull(points), position=np.array([4.0, 4.0, 0.0]), surface=ramp)
    with Match.bare(start=(14.0, 7.0, 0.0), pieces=[PieceSupply(crate, 1)], elements=[element], engine=engine) as match:
        turn = (0.0, math.sin(slope / 2.0), 0.0, math.cos(slope / 2.0))
        up = 0.1 + 1e-4
        place = (4.5 + up * math.sin(slope), 4.0, rise - 0.5 * math.tan(slope) + up * math.cos(slope))
        slot = match.pieces.spawn("Crate", np.array([place]), np.array([turn]))[0]
        match.play(0.2)
        speed = math.hypot(*match.pieces.state.vel[slot])
        match.play(0.6)
        gained = math.hypot(*match.pieces.state.vel[slot]) - speed
    return {"acceleration [m/s^2]": (gained / 0.6, GRAVITY * (math.sin(slope) - 0.2 * math.cos(slope)))}


def pins(engine: str) -> Figures:
    """A robot that presses 1, 6 and 24 fuel against a wall: how far its bumper is held off, and the deepest center."""
    found: Figures = {}
    wall = FieldElement(name="face", shape=Box((0.3, 8.0, 2.0)), position=np.array([5.15, 4.0, 1.0]), surface=WALL)
    for deep, wide in ((1, 1), (2, 3), (6, 4)):
        places = [
            (4.9 - 0.153 * i, 4.0 + 0.153 * (j - (wide - 1) / 2), RADIUS) for i in range(deep) for j in range(wide)
        ]
        start = (min(x for x, _, _ in places) - RADIUS - HALF - 0.5, 4.0, 0.0)
        with Match.bare(start=start, pieces=[PieceSupply(FUEL, 24)], elements=[wall], engine=engine) as match:
            match.pieces.spawn("Fuel", np.array(places))
            match.robots[0].drive.set_chassis_speeds(1.5, 0.0, 0.0)
            deepest = 0.0
            for _ in range(round(4.0 / TICK)):
                match.tick()
                here = match.pieces.on_field()
                deepest = max(deepest, float(match.pieces.state.pos[here, 0].max()))
            found[f"{deep * wide} fuel, held off [mm]"] = (1e3 * (5.0 - match.robots[0].chassis.pos[0] - HALF), None)
            found[f"{deep * wide} fuel, center to wall [mm]"] = (1e3 * (5.0 - deepest), None)
    return found


def heaps(engine: str) -> Figures:
    """100 and 300 fuel fall into a bin of 0.6 and 0.9 m: height of the top, and the deepest overlap at rest."""
    found: Figures = {}
    for count, size in ((100, 0.6), (300, 0.9)):
        sides = [
            FieldElement(
                name=f"side {dx} {dy}",
                shape=Box((0.1, size + 0.2, 3.0) if dx else (size + 0.2, 0.1, 3.0)),
                position=np.array([4.0 + dx * (size / 2 + 0.05), 4.0 + dy * (size / 2 + 0.05), 1.5]),
                surface=WALL,
            )
            for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1))
        ]
        with Match.bare(
            start=(14.0, 7.0, 0.0), pieces=[PieceSupply(FUEL, count)], elements=sides, engine=engine
        ) as match:
            rng = np.random.default_rng(1)
            a_side = int((size - 2 * RADIUS) / 0.16) + 1
            spread = np.linspace(RADIUS + 0.005, size - RADIUS - 0.005, a_side) - size / 2
            places = []
            for number in range(count):
                layer, place = divmod(number, a_side * a_side)
                row, column = divmod(place, a_side)
                dx, dy = rng.uniform(-0.004, 0.004, 2)
                places.append((4.0 + spread[row] + dx, 4.0 + spread[column] + dy, RADIUS + 0.01 + 0.155 * layer))
            match.pieces.spawn("Fuel", np.array(places))
            match.play(8.0)
            pos = match.pieces.state.pos[match.pieces.on_field()]
            found[f"{count} fuel, mean height [mm]"] = (1e3 * float(pos[:, 2].mean()), None)
            found[f"{count} fuel, overlap [mm]"] = (1e3 * _overlap(pos), None)
            found[f"{count} fuel, awake"] = (float(len(match.pieces.awake)), 0.0)
    return found


def _overlap(pos: np.ndarray) -> float:
    """Deepest of two balls [m]."""
    pairs = cKDTree(pos).query_pairs(2 * RADIUS, output_type="ndarray")
    if not len(pairs):
        return 0.0
    return float((2 * RADIUS - np.linalg.norm(pos[pairs[:, 0]] - pos[pairs[:, 1]], axis=1)).max())


def ploughing(engine: str) -> Figures:
    """A robot with 3 m/s through 12 x 8 dense fuel: deepest overlap of two balls, and of a ball and the bumper."""
    with Match.bare(start=(2.0, 4.0, 0.0), pieces=[PieceSupply(FUEL, 96)], engine=engine) as match:
        robot = match.robots[0]
        places = [(4.0 + 0.152 * i, 4.0 + 0.152 * (j - 5.5), RADIUS) for i in range(8) for j in range(12)]
        match.pieces.spawn("Fuel", np.array(places))
        robot.drive.set_chassis_speeds(3.0, 0.0, 0.0)
        balls = bumper = 0.0
        for _ in range(round(1.6 / TICK)):
            match.tick()
            pos = match.pieces.state.pos[match.pieces.on_field()]
            balls = max(balls, _overlap(pos))
            x, y, yaw = robot.chassis.pose
            c, s = math.cos(yaw), math.sin(yaw)
            dx, dy = pos[:, 0] - x, pos[:, 1] - y
            out = np.maximum(np.abs(c * dx + s * dy), np.abs(c * dy - s * dx)) - HALF
            low = pos[:, 2] < 0.25
            bumper = max(bumper, float((RADIUS - out[low & (out > -0.05)]).max(initial=0.0)))
    return {"ball in ball [mm]": (1e3 * balls, None), "ball in bumper [mm]": (1e3 * bumper, None)}


def bump(engine: str) -> Figures:
    """A robot with 1 to 4 m/s over a bump: time to get across, highest point and steepest pitch."""
    height, depth = inches(6.513), inches(44.4)
    ends = [(-depth / 2, 0.0), (depth / 2, 0.0), (0.0, height)]
    points = np.array([(x, y, z) for y in (-3.0, 3.0) for x, z in ends])
    element = FieldElement(name="bump", shape=Hull(points), position=np.array([5.0, 4.0, 0.0]), surface=POLYCARBONATE)
    found: Figures = {}
    for speed in (1.0, 2.0, 3.0, 4.0):
        with Match.bare(start=(2.5, 4.0, 0.0), elements=[element], drivable=("bump",), engine=engine) as match:
            robot = match.robots[0]
            highest = pitch = 0.0
            ticks = 0
            while robot.chassis.pos[0] < 7.0 and ticks < 300:
                drift = robot.chassis.pose[2]
                robot.drive.set_chassis_speeds(speed, 0.0, -6.0 * drift)
                match.tick()
                ticks += 1
                highest = max(highest, robot.chassis.pos[2])
                pitch = max(pitch, abs(robot.chassis.roll_pitch_yaw[1]))
            found[f"{speed} m/s, time [s]"] = (ticks * TICK, None)
            found[f"{speed} m/s, highest [mm]"] = (1e3 * highest, None)
            found[f"{speed} m/s, pitch [deg]"] = (math.degrees(pitch), None)
    return found


def scrape(engine: str) -> Figures:
    """A robot that drives along the wall and into it, its heading held: way in 2 s, heading, tilt, wheels that lift."""
    found: Figures = {}
    for along, into in ((0.5, 0.1), (1.0, 0.5), (2.0, 0.3), (3.0, 1.0)):
        with Match.bare(start=(2.0, 0.45, 0.0), size=(18.0, 8.0), engine=engine) as match:
            robot, start = match.robots[0], 2.0
            turned = tilt = 0.0
            lifted = 0
            for _ in range(100):
                yaw = robot.chassis.pose[2]
                c, s = math.cos(yaw), math.sin(yaw)
                robot.drive.set_chassis_speeds(c * along - s * into, -s * along - c * into, -6.0 * yaw)
                match.tick()
                roll, pitch, yaw = robot.chassis.roll_pitch_yaw
                turned, tilt = max(turned, abs(yaw)), max(tilt, math.hypot(roll, pitch))
                lifted += not all(robot.chassis.touching)
            name = f"{along} m/s along, {into} into"
            found[f"{name}, way [m]"] = (robot.chassis.pos[0] - start, None)
            found[f"{name}, heading [deg]"] = (math.degrees(turned), None)
            found[f"{name}, tilt [deg]"] = (math.degrees(tilt), None)
            found[f"{name}, ticks with a wheel off"] = (float(lifted), 0.0)
    return found


def tank_scrape(engine: str) -> Figures:
    """A tank whose volts steer it into the wall beside it: way in 2 s, heading, tilt, wheels that lift."""
    found: Figures = {}
    for left, right in ((6.5, 6.0), (7.0, 6.0), (11.0, 10.0)):
        tank = RobotConfig(drivetrain=TankConfig(stator_limit=60.0))
        with Match.bare(start=(2.0, 0.41, 0.0), size=(18.0, 8.0), engine=engine, robot=tank) as match:
            robot = match.robots[0]
            turned = tilt = 0.0
            lifted = 0
            for _ in range(100):
                robot.drive.set_volts(left, right)
                match.tick()
                roll, pitch, yaw = robot.chassis.roll_pitch_yaw
                turned, tilt = max(turned, abs(yaw)), max(tilt, math.hypot(roll, pitch))
                lifted += not all(robot.chassis.touching)
            name = f"{left} and {right} V"
            found[f"{name}, way [m]"] = (robot.chassis.pos[0] - 2.0, None)
            found[f"{name}, heading [deg]"] = (math.degrees(turned), None)
            found[f"{name}, tilt [deg]"] = (math.degrees(tilt), None)
            found[f"{name}, ticks with a wheel off"] = (float(lifted), 0.0)
    return found


SCENES: dict[str, Callable[[str], Figures]] = {
    scene.__name__: scene
    for scene in (scrape, tank_scrape, sleepers, rows, bounces, block_on_slope, pins, heaps, ploughing, bump)
}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", nargs="*", help=f"default: all of {', '.join(SCENES)}")
    names = parser.parse_args().scene or list(SCENES)
    engines = [name for name, module in (("bullet", "pybullet"), ("mujoco", "mujoco")) if find_spec(module)]
    table = Table(*("scene", "figure", *engines, "theory", "apart [%]"), title="Contacts", title_justify="left")
    for name in names:
        found = [SCENES[name](engine) for engine in engines]
        for figure, (_, theory) in found[0].items():
            values = [one[figure][0] for one in found]
            largest = max(map(abs, values))
            apart = 100.0 * (max(values) - min(values)) / largest if largest > 1e-9 else 0.0
            table.add_row(
                *(name, escape(figure), *(f"{value:.3f}" for value in values)),
                *("" if theory is None else f"{theory:.3f}", f"{apart:.1f}"),
            )
    Console(width=120).print(table)


if __name__ == "__main__":
    main()
