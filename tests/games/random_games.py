"""Random games: robots of any build that are carried, reset and driven, pieces released anywhere, laws at every tick.

`python tests/games/random_games.py FIRST COUNT [engine]` plays COUNT seeds from FIRST on and prints broken laws.
"""

from __future__ import annotations

import logging
import math
import sys
from dataclasses import replace

import numpy as np

from games.rebuilt import REBUILT
from games.reefscape import REEFSCAPE
from simcore.errors import SimcoreError
from simcore.loop.battery import open_voltage
from simcore.loop.contact import foam_force
from simcore.match.game import RobotEntry
from simcore.match.match import Match
from simcore.pieces.pool import ON_FIELD, PieceStatus
from simcore.robot.battery import BatteryConfig
from simcore.robot.chassis_config import BUMPER_STIFFNESS, ChassisConfig
from simcore.robot.dc_motor import motor
from simcore.robot.fixed_wheel_config import MecanumConfig, TankConfig
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import ArmConfig, FlywheelConfig, RollerConfig
from simcore.robot.robot_config import RobotConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.world.footprints import corners
from simcore.world.rotation import rotate, rotate_back
from simcore.world.shapes import mass_properties

G = 9.80665
_SETTLES = 10  # ticks after an action by people, in which pieces and robots may still yield
_WINDOW = 8  # ticks; bumpers and foam return their energy within 0.1 s
_PUSH = 3.0  # largest push of a robot over its weight, with all tires against a wall and a hit on top
_SLACK = 0.02  # [m]; a robot may be placed this deep in something
_JOULES = 0.3  # [J]; see `Watch.require_energy`


class Broken(AssertionError):
    """Error: a law is broken."""


class Watch:
    """Check of all laws at every tick of a match."""

    def __init__(self, match: Match) -> None:
        self.match = match
        self.inside: set[int] = set()
        self.forget()

    def forget(self) -> None:
        """Allow time for settling after people have placed something."""
        self.since = 0
        self.driven = True
        self.energies: list[float] = []
        self.speeds: list[float] = []
        self.flights: list[float] = []
        self.here = np.zeros(0, dtype=bool)
        self.put: dict[int, tuple[float, float, float]] = {}

    def tick(self) -> None:
        self.match.tick()
        self.since += 1
        self.require_owners()
        self.require_numbers()
        self.require_batteries()
        self.require_room()
        self.require_energy()

    def fail(self, text: str) -> None:
        raise Broken(f"{self.match.time:.2f} s, {self.since} ticks after the last action: {text}")

    def require_owners(self) -> None:
        match, state = self.match, self.match.pieces.state
        if not match.count.is_conserved:
            self.fail(f"pieces lost or doubled: {match.count}")
        for robot in match.robots:
            held = np.nonzero((state.status == PieceStatus.HELD) & (state.holder == robot.number))[0]
            if sorted(robot.held) != held.tolist():
                self.fail(f"robot {robot.number} has {sorted(robot.held)}, pieces say {held.tolist()}")

    def require_numbers(self) -> None:
        state = self.match.pieces.state
        rows = [(*r.chassis.pos, *r.chassis.quat, *r.chassis.vel, *r.chassis.rate) for r in self.match.robots]
        if not (np.isfinite(state.pos).all() and np.isfinite(state.vel).all() and np.isfinite(rows).all()):
            self.fail("not finite")

    def require_batteries(self) -> None:
        """Check that regeneration raises the voltage above open circuit by at most current times resistance."""
        for robot in self.match.robots:
            battery, record = robot.battery, robot.battery.records
            most = open_voltage(record, 0) + max(0.0, -battery.current) * (
                float(record["model"]["resistance"][0]) + float(record["model"]["recovery_resistance"][0])
            )
            if battery.voltage > most + 0.01:
                self.fail(f"battery of robot {robot.number} has {battery.voltage:.2f} V, at most {most:.2f}")

    def require_room(self) -> None:
        """Check that pieces overlap the field no deeper than foam yields, and robots no deeper than bumpers yield."""
        match, pieces = self.match, self.match.pieces
        state, balls = pieces.state, pieces._balls
        fastest = max((r.chassis.speed for r in match.robots), default=0.0)
        self.speeds = [*self.speeds[1 - _WINDOW :], fastest]
        self.flights = [
            *self.flights[1 - _WINDOW :],
            float(np.linalg.norm(state.vel[pieces.awake], axis=1).max(initial=0.0)),
        ]
        fast = max(self.flights)
        deep = {slot: pieces._depth_now(slot) for slot in pieces.awake.tolist()}
        if self.since < _SETTLES:  # an overlap from placing takes time to resolve, or the piece is wedged
            self.inside |= {slot for slot, depth in deep.items() if depth > 0.1 * pieces.radius[slot]}
            return
        self.inside -= {slot for slot in self.inside if deep.get(slot, 1.0) < 0.02}
        push = max((_PUSH * r.chassis.distribution.mass * G for r in match.robots), default=0.0)
        hit = sum(0.5 * r.chassis.distribution.mass for r in match.robots) * max(self.speeds) ** 2
        for slot in pieces.awake.tolist():
            kind = pieces.types[state.kind[slot]]
            is_ball = bool(pieces._is_ball[slot])
            if is_ball and balls.hold[slot] > 0.0:
                continue
            depth = deep[slot]
            if is_ball:
                foam = balls.foam[slot].tolist()
                near = any(math.dist(r.chassis.pos, state.pos[slot]) < 3.0 for r in match.robots)
                energy = 0.5 * pieces.mass[slot] * max(fast, 1.0) ** 2 + (hit if near else 0.0)
                most = _deepest(foam, push if near else 40.0 * pieces.mass[slot] * G, energy) + 0.002
            else:
                most = 0.02 + 0.005 * fast + (0.02 if fastest > 0.0 else 0.0)
            if depth > most and slot not in self.inside:
                self.fail(
                    f"{kind.name} {slot} at {np.round(state.pos[slot], 3).tolist()} is {1000 * depth:.0f} mm deep, "
                    f"at most {1000 * most:.0f}"
                )
        for robot in match.robots:
            x, y, _ = robot.chassis.pos
            length, width = match.game.field.size
            if not (-0.1 < x < length + 0.1 and -0.1 < y < width + 0.1 and -0.1 < robot.chassis.pos[2] < 1.5):
                self.fail(f"robot {robot.number} is at {robot.chassis.pos}")
            for other in match.robots[: robot.number]:
                deep = _overlap(robot, other)
                mass = 1.0 / (1.0 / robot.chassis.distribution.mass + 1.0 / other.chassis.distribution.mass)
                corner = 0.5 * BUMPER_STIFFNESS * 0.1  # two bumpers in series, over the shortest side
                most = _SLACK + 2.0 * max(self.speeds) * math.sqrt(mass / corner) + push / corner
                if deep > most:
                    self.fail(
                        f"robots {other.number} and {robot.number} are {1000 * deep:.0f} mm in each other, "
                        f"at most {1000 * most:.0f}"
                    )

    def energy(self) -> float:
        """Return the energy of everything on the field, including wheels but not mechanisms [J]."""
        match, pieces = self.match, self.match.pieces
        state, balls = pieces.state, pieces._balls
        here = pieces.on_field()
        mass = pieces.mass[here]
        total = float(mass @ (G * state.pos[here, 2]))
        is_ball = pieces._is_ball[here]
        b = here[is_ball]
        total += float(pieces.mass[b] @ (0.5 * (state.vel[b] ** 2).sum(axis=1)))
        total += float((0.2 * pieces.mass[b] * pieces.radius[b] ** 2) @ (balls.spin[b] ** 2).sum(axis=1))
        for slot in here[~is_ball].tolist():
            if state.status[slot] in (PieceStatus.AWAKE, PieceStatus.IN_FLIGHT):
                v = np.array(match.world.engine.velocity(pieces.row(slot)))
                m, r = pieces.mass[slot], 0.5 * pieces.radius[slot]
                total += 0.5 * m * float((v[0] ** 2).sum() + r * r * (v[1] ** 2).sum())
        for robot in match.robots:
            c = robot.chassis
            m, _, inertia = c.distribution
            spin = np.array(c.robot_rate)
            z = c.pos[2] + rotate(c.quat, c.distribution.center)[2]
            total += m * G * z + 0.5 * m * float(np.array(c.vel) @ np.array(c.vel)) + 0.5 * float(inertia @ spin**2)
            shafts = robot.drive.shafts
            total += 0.5 * float(shafts["model"]["inertia"] @ shafts["speed"] ** 2)
            if robot.config.moving_masses:  # their height is in the robot's, their motion in the mechanisms
                total += sum(0.5 * one.inertia * one.velocity**2 for one in robot.mechanisms.values())
        for body in match.hanging:
            m, rate = body.config.mass, np.array(rotate_back(body.quat, body.rate))
            own, vel = np.diag(mass_properties(body.config.shape).inertia), np.array(body.velocity_at(body.pos))
            total += m * (G * body.pos[2] + 0.5 * float(vel @ vel) + 0.5 * float(own @ rate**2))
            total += 0.5 * body.config.spring * body.angle**2 if body.config.hinge else 0.0
        return total

    def require_energy(self) -> None:
        """Check that energy does not rise from 0.16 s after the last driving on, with allowance for springs.

        Tolerance: an engine step of 5 ms applies gravity half a step early, g^2 h / 2 per second and kilogram: 0.3 J a
        tick for 400 kg in free fall.
        """
        here = self.match.pieces.is_on_field
        if self.driven or not np.array_equal(here, self.here):
            self.energies = []
        self.here = here.copy()
        now = self.energy()
        if len(self.energies) == _WINDOW and self.since > _SETTLES:
            most = max(self.energies)
            if now > most + _JOULES:
                self.fail(f"energy grew by {now - most:.2f} J in a tick in which nobody drives")
        self.energies = [*self.energies[1 - _WINDOW :], now]


def _deepest(foam, push, energy):
    """Return the largest compression of a ball under a push [N] or by a hit of an energy [J] (m)."""
    depth, stored = 0.0, 0.0
    while True:
        force = foam_force(depth, *foam)
        stored += 0.001 * force
        if force > push and stored > energy:
            return depth
        depth += 0.001


def _overlap(one, other):
    """Return the overlap of two robots' bumpers [m]; 0 if their heights do not overlap."""
    a, b = one.chassis, other.chassis
    low = max(a.pos[2] + a.config.clearance, b.pos[2] + b.config.clearance)
    if low >= min(a.pos[2] + a.config.bumper_top, b.pos[2] + b.config.bumper_top):
        return 0.0
    if min(_up(a), _up(b)) < 0.9:
        return 0.0
    p, q = (corners(*c.pose, c.config.bumper_length, c.config.bumper_width) for c in (a, b))
    least = math.inf
    for yaw in (a.pose[2], b.pose[2]):
        for axis in ((math.cos(yaw), math.sin(yaw)), (-math.sin(yaw), math.cos(yaw))):
            s, t = p @ axis, q @ axis
            least = min(least, s.max() - t.min(), t.max() - s.min())
    return max(0.0, least)


def _up(chassis):
    x, y = chassis.quat[:2]
    return 1.0 - 2.0 * (x * x + y * y)


# --- robots ---------------------------------------------------------------------------------------------------------


def random_robot(rng) -> RobotConfig:
    """Draw a robot of any valid build."""
    while True:
        try:
            return _random_robot(rng)
        except SimcoreError:
            continue


def _random_robot(rng):
    length, width = rng.uniform(0.5, 1.0, 2)
    mass, height = float(rng.uniform(15.0, 68.0)), float(rng.uniform(0.26, 1.2))
    x, y, z = rng.uniform(-0.15, 0.15), rng.uniform(-0.1, 0.1), rng.uniform(0.08, 0.5)
    settings = {"mass": mass, "yaw_inertia": mass * (length**2 + width**2) / 12.0 * float(rng.uniform(0.6, 1.3))}
    kind = rng.integers(3)
    if kind == 0:
        module = SwerveModuleConfig(x=0.0, y=0.0, drive_gearing=float(rng.uniform(5.0, 9.0)))
        square = SwerveConfig.square(float(min(length, width) - 0.2), module)
        drivetrain = replace(square, center_of_mass=(float(x), float(y), float(z)), **settings)
    else:
        drivetrain = (TankConfig, MecanumConfig)[kind - 1](
            motor=motor(str(rng.choice(["NEO", "CIM", "Kraken X60"]))),
            center_of_mass=(float(x), float(y), float(z)),
            **settings,
        )
    body = ChassisConfig.around(drivetrain, bumper=(float(length), float(width)))
    body = replace(body, height=max(height, body.bumper_top))
    mechanisms = {}
    limits = [{}, {"stator_current_limit": 40.0}][rng.integers(2)]
    box = GearboxConfig(motor=motor("Kraken X60"), gearing=float(rng.uniform(1.0, 30.0)), **limits)
    for name in "abc"[: rng.integers(4)]:
        mechanisms[name] = [
            FlywheelConfig(gearbox=box, inertia=float(rng.uniform(0.0005, 0.02))),
            RollerConfig(gearbox=box, inertia=0.001, radius=0.03),
            ArmConfig(gearbox=box, inertia=0.2, mass=3.0, center_of_mass=0.3, min_angle=-1.0, max_angle=1.5),
        ][rng.integers(3)]
    return RobotConfig(
        drivetrain=drivetrain,
        bumper=(float(length), float(width)),
        chassis=body,
        mechanisms=mechanisms,
        battery=BatteryConfig(initial_charge=float(rng.uniform(0.3, 1.0))),
    )


# --- actions of people ------------------------------------------------------------------------------------------------


def somewhere(match, rng):
    """Draw a pose anywhere, next to a robot, or next to the elements in the middle of the field."""
    length, width = match.game.field.size
    x, y = rng.uniform(0.3, length - 0.3), rng.uniform(0.3, width - 0.3)
    choice = rng.integers(4)
    if choice == 0 and match.robots:
        other = match.robots[rng.integers(len(match.robots))].chassis.pos
        x, y = np.clip(other[:2] + rng.uniform(-1.2, 1.2, 2), 0.3, (length - 0.3, width - 0.3))
    elif choice == 1:
        x = 0.5 * length + rng.uniform(-1.3, 1.3)
    return float(x), float(y), float(rng.uniform(-math.pi, math.pi))


def drive(match, rng, share=1.0):
    """Command voltages of any size."""
    robot = match.robots[rng.integers(len(match.robots))]
    drivetrain = robot.drive
    volts = rng.uniform(-12.0, 12.0) * np.ones(len(robot.config.drivetrain.positions))
    if rng.random() < 0.4:
        volts = rng.uniform(-12.0, 12.0, len(volts))
    if isinstance(robot.config.drivetrain, SwerveConfig):
        drivetrain.set_volts(volts.tolist(), rng.uniform(-4.0, 4.0, len(volts)).tolist())
    elif isinstance(robot.config.drivetrain, MecanumConfig):
        drivetrain.set_volts(volts.tolist())
    else:
        drivetrain.set_volts(*volts[:2].tolist())
    for mechanism in robot.mechanisms.values():
        mechanism.set_volts(float(rng.uniform(-12.0, 12.0)))


def stop(match):
    """Stop all drives."""
    for robot in match.robots:
        kind = robot.config.drivetrain
        if isinstance(kind, SwerveConfig):
            n = len(kind.positions)
            robot.drive.set_volts([0.0] * n, [0.0] * n)
        elif isinstance(kind, MecanumConfig):
            robot.drive.set_volts([0.0] * 4)
        else:
            robot.drive.set_volts(0.0, 0.0)
        for mechanism in robot.mechanisms.values():
            mechanism.set_volts(0.0)


def carry(match, rng):
    number = int(rng.integers(len(match.robots)))
    pose = somewhere(match, rng)
    [lambda: match.carry_to(number, pose), lambda: match.robots[number].reset(pose),
     lambda: match.control.place_robot(pose, number)][rng.integers(3)]()  # fmt: skip


def release(match, rng):
    """Release some pieces anywhere, even inside elements, and throw them."""
    pieces = match.pieces
    free = np.nonzero(np.isin(pieces.state.status, (PieceStatus.STAGED, PieceStatus.SCORED, *ON_FIELD)))[0]
    slots = rng.choice(free, size=min(len(free), int(rng.integers(1, 6))), replace=False)
    length, width = match.game.field.size
    places = np.column_stack(
        [rng.uniform(0, length, len(slots)), rng.uniform(0, width, len(slots)), rng.uniform(0.06, 2.5, len(slots))]
    )
    pieces.release(slots, places)
    if rng.random() < 0.5:
        pieces.push(slots, rng.uniform(-12.0, 12.0, (len(slots), 3)), flying=bool(rng.random() < 0.5))


def field(match, rng):
    control = match.control
    place = somewhere(match, rng)[:2]
    kind = match.pieces.types[0].name
    [control.reset_field, lambda: control.spawn(kind, [place] * 3),
     lambda: control.start_auto(str(rng.choice(list(match.game.autos))), int(rng.integers(len(match.robots)))),
     lambda: match.set_alliance(int(rng.integers(len(match.robots))), str(rng.choice(["red", "blue"]))),
     lambda: match.start_mode("teleop")][rng.integers(5)]()  # fmt: skip


def play(seed: int, engine: str = "bullet", seconds: float = 6.0, tell=None):
    """Play a random game; return its digest and the final poses of the robots."""
    rng = np.random.default_rng(seed)
    game = (REBUILT, REEFSCAPE)[seed % 2]
    while True:
        entries = []
        for _ in range(rng.integers(1, 7)):
            alliance = str(rng.choice(["blue", "red"]))
            length, width = game.field.size
            start = (float(rng.uniform(0.6, length - 0.6)), float(rng.uniform(0.6, width - 0.6)),
                     float(rng.uniform(-math.pi, math.pi)))  # fmt: skip
            config = random_robot(rng) if rng.random() < 0.8 else None
            entries.append(RobotEntry(alliance=alliance, start=start, preload=0, config=config))
        try:
            match = Match(game, robots=entries, seed=seed, engine=engine)
            break
        except SimcoreError:
            continue
    with match:
        watch = Watch(match)
        while match.time < seconds:
            try:
                action = [carry, carry, release, field, drive, drive][rng.integers(6)]
                action(match, rng)
                if tell:
                    tell(f"{match.time:.2f} {action.__name__}")
            except SimcoreError:
                pass
            watch.forget()
            for _ in range(int(rng.integers(1, 30))):
                if rng.random() < 0.1:
                    drive(match, rng)
                watch.tick()
            stop(match)
            for robot in match.robots:
                match.set_controller(robot.number, None)
            watch.driven = False
            for _ in range(int(rng.integers(5, 30))):
                watch.tick()
            watch.driven = True
        return match.digest.hexdigest(), [
            (r.number, round(_up(r.chassis), 2)) for r in match.robots if _up(r.chassis) < 0.5
        ]


if __name__ == "__main__":
    logging.disable(50)
    first, count = int(sys.argv[1]), int(sys.argv[2])
    for seed in range(first, first + count):
        for engine in sys.argv[3:] or ("bullet",):
            try:
                _, fallen = play(seed, engine)
                print(seed, engine, "holds", f"fallen: {fallen}" if fallen else "", flush=True)
            except Exception as error:
                print(seed, engine, type(error).__name__, str(error)[:300], flush=True)
