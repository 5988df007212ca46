"""CRATES, a fictional second game: a small mirrored field with boxes, crates to place and balls to shoot.

The game uses public parts of simcore only, so that laws of every game can be tested on more than one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import product

import numpy as np

from simcore.channel import Channel
from simcore.match.clock import MatchClock, Phase
from simcore.match.game import Auto, FieldDefinition, Game, GameOption, PieceSupply, RobotEntry, Rules, StagedPieces
from simcore.match.scoring import Alliance, ScoreEvent, ScoringZone
from simcore.match.scripted import ScriptedRobot, ScriptSettings, Steps
from simcore.pieces.aerodynamics import Aerodynamics
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.launch import LaunchParameters
from simcore.pieces.pool import PieceStatus
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.intake import IntakeConfig, IntakeZone
from simcore.robot.mechanisms import ArmConfig, FlywheelConfig, RollerConfig
from simcore.robot.placer import PlacerConfig
from simcore.robot.robot_config import MechanismConfig, RobotConfig
from simcore.robot.shooter import ShooterConfig
from simcore.robot.storage import StorageConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.units import degrees
from simcore.world.field import FieldBoundary, FieldElement
from simcore.world.linkage import Joint
from simcore.world.shapes import Box, Sphere
from simcore.world.symmetry import FieldSymmetry
from simcore.world.zones import BoxZone

SIZE = (12.0, 6.0)
SYMMETRY = FieldSymmetry("mirror", SIZE)
BALL = GamePieceConfig(name="Ball", shape=Sphere(0.11), mass=0.25, aerodynamics=Aerodynamics())
CRATE = GamePieceConfig(name="Crate", shape=Box((0.36, 0.30, 0.24)), mass=1.5, friction=0.6, restitution=0.2)
ALLIANCES: tuple[Alliance, Alliance] = ("blue", "red")
HUMAN_PLAYER = "human_player"
ARM = 0.65  # [m]
SLOT = (0.2, 3.0, 1.5)
"""Center of the blue goal's slot [m]."""

_TABLE = {  # name: smallest corner, largest corner [m]
    "goal_base": ((0.0, 2.4, 0.0), (0.4, 3.6, 1.2)),
    "goal_roof": ((0.0, 2.4, 2.0), (0.4, 3.6, 2.1)),
    "goal_right": ((0.0, 2.3, 0.0), (0.4, 2.4, 2.1)),
    "goal_left": ((0.0, 3.6, 0.0), (0.4, 3.7, 2.1)),
    "dock": ((0.0, 4.4, 0.0), (0.5, 5.6, 0.5)),
}
_ZONES = {  # name: smallest corner, largest corner [m], kind of piece, points
    "Goal": ((0.0, 2.4, 1.2), (0.4, 3.6, 2.0), BALL.name, 2),
    "Dock": ((0.0, 4.4, 0.5), (0.5, 5.6, 0.75), CRATE.name, 5),
}


def _flipped(low: Sequence[float], high: Sequence[float], alliance: Alliance) -> tuple[np.ndarray, np.ndarray]:
    corners = np.array([low, high])
    corners = SYMMETRY.flip_points(corners) if alliance == "red" else corners
    return corners.min(axis=0), corners.max(axis=0)


def _elements() -> Iterator[FieldElement]:
    yield from FieldBoundary(length=SIZE[0], width=SIZE[1], side_height=0.5, end_height=2.0).elements()
    for alliance, (name, corners) in product(ALLIANCES, _TABLE.items()):
        low, high = _flipped(*corners, alliance)
        box = Box(tuple((high - low).tolist()))
        yield FieldElement(name=f"{alliance}_{name}", shape=box, position=(low + high) / 2)


def _zones() -> Iterator[ScoringZone]:
    for alliance, (name, (*corners, kind, points)) in product(ALLIANCES, _ZONES.items()):
        zone = BoxZone(*(tuple(corner.tolist()) for corner in _flipped(*corners, alliance)))
        name = f"{alliance.capitalize()}{name}"
        yield ScoringZone(name=name, alliance=alliance, zone=zone, points=points, kinds=(kind,))


FIELD = FieldDefinition(size=SIZE, symmetry=SYMMETRY, elements=tuple(_elements()))


def staging(rng: np.random.Generator, entries: Sequence[RobotEntry]) -> list[StagedPieces]:
    """Place four balls and two crates by hand on each side; four balls wait with the human player."""
    balls = np.array([(4.6, y, 0.11) for y in (2.4, 2.7, 3.0, 3.3)])
    crates = np.array([(3.6, 5.0, 0.12), (5.0, 5.2, 0.12)])
    some = [StagedPieces(kind=BALL.name, off_field=4)]
    for (kind, places), is_red in product(((BALL, balls), (CRATE, crates)), (False, True)):
        laid = places + np.column_stack((rng.uniform(-0.01, 0.01, (len(places), 2)), np.zeros(len(places))))
        some.append(StagedPieces(kind=kind.name, positions=SYMMETRY.flip_points(laid) if is_red else laid))
    return some


class CratesRules(Rules):
    """Rules: balls count double in auto, and one of the two kinds, drawn at random, is worth one point more."""

    def start(self) -> None:
        self.bonus = BALL.name if self.match.rules_rng.random() < 0.5 else CRATE.name
        self.auto = dict.fromkeys(ALLIANCES, 0)
        self.has_ended = False

    def start_mode(self, mode: str) -> None:
        if mode == "auto":
            self.auto, self.has_ended = dict.fromkeys(ALLIANCES, 0), False

    def before_tick(self) -> None:
        """Let a human player roll a ball in every 5 s of teleop, behind the goal of the first robot's alliance."""
        match = self.match
        if HUMAN_PLAYER in match.options and match.timer.phase.name == "teleop" and match.ticks % 250 == 0:
            slots = np.nonzero(match.pieces.state.status == PieceStatus.STAGED)[0][:1]
            place, way = np.array([[1.5, 1.0, 0.3]]), np.array([[1.0, 0.0, 0.0]])
            if match.entries[0].alliance == "red":
                place, way = SYMMETRY.flip_points(place), SYMMETRY.flip_vectors(way)
            match.pieces.release(slots, place[: len(slots)])
            match.pieces.push(slots, way[: len(slots)], flying=True)

    def worth(self, zone: ScoringZone) -> int:
        points = zone.points * (2 if self.match.timer.phase.name == "auto" and BALL.name in zone.kinds else 1)
        return points + (1 if self.bonus in zone.kinds else 0)

    def scored(self, event: ScoreEvent) -> None:
        if self.match.timer.phase.name == "auto":
            self.auto = {**self.auto, event.alliance: self.auto[event.alliance] + 1}

    def end(self) -> None:
        self.has_ended = True

    def game_data(self) -> str:
        return self.bonus[0]

    def breakdown(self) -> Mapping[str, int]:
        return {"BlueAutoPieces": self.auto["blue"], "RedAutoPieces": self.auto["red"]}

    channels = (
        Channel("Sim/Crates/Bonus", "string", lambda r: r.bonus, "whose bonus it is"),
        Channel("Sim/Crates/HasEnded", "boolean", lambda r: r.has_ended, "the last phase is over"),
        Channel("Sim/Crates/BallsWaiting", "int", lambda r: r.match.pieces.count(PieceStatus.STAGED), "balls to come"),
        Channel("Sim/Crates/CratesLeft", "int", lambda r: len(r.match.pieces.on_field(CRATE.name)), "crates"),
        Channel("Sim/Crates/Gravity", "double", lambda r: r.match.world.gravity, "downward", "m/s^2"),
    )


def gearbox(gearing: float, motors: int = 1, limit: float = 60.0) -> GearboxConfig:
    """Return a gearbox with Kraken X60 motors."""
    return GearboxConfig(motor=motor("Kraken X60"), motors=motors, gearing=gearing, stator_current_limit=limit)


def crates_robot() -> RobotConfig:
    """Build a robot of 45 kg with arm and claw in front, an intake at the back and a shooter with a fixed hood."""
    module = SwerveModuleConfig(x=0.0, y=0.0, drive_stator_limit=60.0, steer_stator_limit=40.0)
    mechanisms: dict[str, MechanismConfig] = {
        "arm": ArmConfig(
            gearbox=gearbox(60.0), inertia=0.8, mass=2.5, center_of_mass=0.4, min_angle=degrees(-35.0),
            max_angle=degrees(80.0), start_angle=degrees(60.0)),
        "claw": RollerConfig(gearbox=gearbox(8.0), inertia=0.002, radius=0.03),
        "intake": RollerConfig(gearbox=gearbox(3.0), inertia=0.001, radius=0.025),
        "wheels": FlywheelConfig(gearbox=gearbox(1.5, motors=2), inertia=0.01),
        "feeder": RollerConfig(gearbox=gearbox(4.0), inertia=0.002, radius=0.025),
    }  # fmt: skip
    # a parallel linkage keeps the piece in the claw level
    arm = Joint(mechanism="arm", axis=(0.0, -1.0, 0.0), origin=(0.0, 0.0, 0.45))
    claw = Joint(mechanism="arm", axis=(0.0, 1.0, 0.0), origin=(ARM, 0.0, 0.0))
    behind = IntakeZone(x_min=-0.55, x_max=-0.36, y_min=-0.30, y_max=0.30, z_max=0.25)
    grip = IntakeZone(x_min=-0.10, x_max=0.10, y_min=-0.15, y_max=0.15, z_max=0.10)
    shooter = ShooterConfig(
        wheels=("wheels",), wheel_radius=0.05, exit_efficiency=0.48, elevation=degrees(58.0), gate=("feeder",),
        launch=LaunchParameters(height=0.5, forward=0.1), shot_rate=4.0)  # fmt: skip
    return RobotConfig(
        drivetrain=SwerveConfig.square(0.5, module, mass=45.0, bumper=0.75),
        bumper=(0.75, 0.75),
        mechanisms=mechanisms,
        intakes=(IntakeConfig(zone=behind, roller="intake", kinds=(BALL.name,)),),
        storage=StorageConfig(capacity=5, low=(-0.3, -0.3, 0.1), high=(0.2, 0.3, 0.5)),
        shooters=(shooter,),
        placers=(PlacerConfig(joints=(arm, claw), roller="claw", kinds=(CRATE.name,), zone=grip),),
    )


_SETTINGS = ScriptSettings(feed_volts={"feeder": 8.0}, roller_volts=8.0, intake_x=-0.45)


def crate(robot: ScriptedRobot) -> Steps:
    """Take the nearest crate with the claw and put it on the dock."""
    here = robot.pose
    x, y, _ = min(
        robot.piece_positions(CRATE.name), key=lambda place: math.hypot(place[0] - here[0], place[1] - here[1])
    )
    reach, down = ARM * math.cos(degrees(-30.5)), degrees(-30.5)
    robot.set_position("arm", down)
    robot.set_volts("claw", 6.0)
    yield from robot.drive_to(x - reach - 0.3, y, 0.0, speed=2.0)
    yield from robot.drive_to(x - reach, y, 0.0, speed=0.8, timeout=1.5)
    yield from robot.wait(0.2)
    robot.set_position("arm", degrees(35.0))
    robot.set_volts("claw", 0.0)
    yield from robot.wait(0.4)
    yield from robot.drive_to(1.3, 5.0, math.pi, speed=2.0)
    yield from robot.drive_to(0.25 + ARM * math.cos(degrees(35.0)) + 0.15, 5.0, math.pi, speed=0.8, timeout=1.5)
    robot.set_position("arm", degrees(25.0))
    yield from robot.wait(0.3)
    robot.set_volts("claw", -6.0)
    yield from robot.wait(0.4)
    robot.set_volts("claw", 0.0)
    yield from robot.drive_to(2.0, 4.5, math.pi)


def balls(robot: ScriptedRobot) -> Steps:
    """Shoot the preloads, take in the balls of the robot's own side and shoot them."""
    yield from robot.shoot_until_empty(SLOT, timeout=3.0)
    robot.intake(True)
    yield from robot.collect_in((3.5, 2.0), (5.0, 3.7), aside=0.6, timeout=3.5, yaw=math.pi)
    robot.spin_up(SLOT)
    yield from robot.drive_to(2.8, 3.0, math.pi, speed=3.0)
    robot.intake(False)
    yield from robot.shoot_until_empty(SLOT, timeout=3.0)


AUTOS = {
    "crate": Auto(
        name="crate", summary="place a crate", controller=_SETTINGS.controller(crate), start=(2.2, 4.6, 0.0), preload=0
    ),
    "balls": Auto(
        name="balls", summary="shoot balls", controller=_SETTINGS.controller(balls), start=(2.8, 3.0, math.pi)
    ),
}

CRATES = Game(
    name="crates", year=1, field=FIELD, staging=staging, rules=CratesRules, robot=crates_robot, autos=AUTOS,
    preload=2, robots=4, zones=tuple(_zones()), starts=((2.2, 3.0, math.pi), (2.2, 4.6, 0.0)),
    pieces=(PieceSupply(BALL, 8 + 4 + 2 * 4), PieceSupply(CRATE, 4)),
    clock=MatchClock([Phase("auto", 10.0, "auto"), Phase("pause", 2.0, "disabled"), Phase("teleop", 88.0)]),
    options=(GameOption(name=HUMAN_PLAYER, help="a human player rolls balls into the field"),),
)  # fmt: skip
"""Complete game."""
