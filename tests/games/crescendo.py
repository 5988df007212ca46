"""CRESCENDO (2024) in short: notes come from the source and are shot into the speaker, on their way up, or the amp.

Dimensions are those of FieldConstants.java of team 6328's public code of 2024, where a comment names nothing else.
Climbing, the trap, the coopertition bonus and fouls are left out. What this game had to work around:

- A speaker's opening looks down and to the field, and its inside is above it. `ShotOpening` takes an inside that lies
  below or behind its plane, and `ShotTask` balls only: the zones have no opening, so `simcore shots` has no table for
  this game. Scripts aim at the middle of the opening by `solve_shot`.
- A script's robot shoots at one elevation: each auto has settings of its own.
- Elements are boxes, cylinders and balls along the axes: the subwoofer is two steps instead of a slope, and the source
  is no chute; its note drops into the corner of the field.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from crates import gearbox

from simcore.geometry.symmetry import FieldSymmetry
from simcore.geometry.zones import BoxZone
from simcore.match.clock import MatchClock, Phase
from simcore.match.game import (
    Auto,
    FieldDefinition,
    Game,
    GameOption,
    PieceSupply,
    RobotEntry,
    Rules,
    StagedPieces,
    for_both_alliances,
)
from simcore.match.human_actions import Feeder
from simcore.match.scoring import Alliance, ScoreEvent, ScoringZone
from simcore.match.scripted import ScriptedRobot, ScriptSettings, Steps
from simcore.physics.field import FieldBoundary, FieldElement, box_element
from simcore.physics.shapes import Cylinder, torus
from simcore.pieces.aerodynamics import Aerodynamics
from simcore.pieces.intake import IntakeConfig, IntakeZone
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.launch import LaunchParameters
from simcore.pieces.pool import PieceStatus
from simcore.pieces.shooter import ShooterConfig
from simcore.pieces.storage import StorageConfig
from simcore.robot.mechanisms import ArmConfig, FlywheelConfig, RollerConfig
from simcore.robot.robot_config import MechanismConfig, RobotConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.units import degrees, inches

SIZE = (inches(651.223), inches(323.277))
SYMMETRY = FieldSymmetry("mirror", SIZE)
ALLIANCES: tuple[Alliance, Alliance] = ("blue", "red")
HUMAN_PLAYERS = "human_players"

# a foam ring of 14 in outside, 10 in inside and 2 in thick, 8.3 oz
NOTE = GamePieceConfig(
    name="Note",
    shape=torus(ring_radius=inches(6.0), tube_radius=inches(1.0)),
    mass=0.235,
    friction=0.9,  # estimate
    restitution=0.4,  # estimate
    aerodynamics=Aerodynamics(),
    color="#f08020",
)

SPEAKER_Y = 0.5 * (inches(238.815) + inches(197.765))
OPENING_WIDTH = inches(238.815) - inches(197.765)
OPENING_DEPTH = inches(18.055)
LOW_EDGE, HIGH_EDGE = inches(78.324), inches(83.091)
"""Of the opening, at the wall and in front [m]."""
SPEAKER_TOP = inches(98.0)  # estimate
SPEAKER = (0.5 * OPENING_DEPTH, SPEAKER_Y, 0.5 * (LOW_EDGE + HIGH_EDGE))
"""Middle of the blue speaker's opening [m]."""
AMP_X, AMP_WIDTH = inches(72.455), inches(24.0)
AMP_BOTTOM, AMP_TOP = inches(26.0), inches(44.0)
SUBWOOFER_X = inches(36.125)
SOURCE = (SIZE[0] - 0.65, 0.65, 0.5)  # estimate: where its notes leave the chute, blue's at the red end [m]
WING_NOTES = tuple((inches(114.0), 0.5 * SIZE[1] + inches(57.0) * k) for k in range(3))
CENTER_NOTES = tuple((0.5 * SIZE[0], 0.5 * SIZE[1] + inches(66.0) * k) for k in range(-2, 3))
STAGE_LEGS = ((3.25, 4.11), (5.6, 5.58), (5.6, 2.64))  # estimate: off a drawing; the note stands free
WING_X = inches(229.201)
STOCK = 20  # notes of each source; estimate

_AMPLIFIED = 10.0  # [s] after the button was pressed, or
_AMPLIFIED_NOTES = 4  # notes in the speaker
_FEED_PERIOD = 1.5  # [s], estimate
_FEED_SPEED = 1.2  # [m/s], estimate
_FEED_REACH = 2.4  # [m] from the source to the middle of a robot that waits


def _elements() -> Iterator[FieldElement]:
    """Walls; speakers' cheeks, roof and front over the opening, subwoofers, legs of the stages."""
    yield from FieldBoundary(length=SIZE[0], width=SIZE[1], side_height=inches(20.0), end_height=LOW_EDGE).elements()
    right, left, depth, wall = SPEAKER_Y - 0.5 * OPENING_WIDTH, SPEAKER_Y + 0.5 * OPENING_WIDTH, OPENING_DEPTH, 0.03
    blue = [
        box_element("speaker_right", (0.0, right - wall, LOW_EDGE), (depth, right, SPEAKER_TOP)),
        box_element("speaker_left", (0.0, left, LOW_EDGE), (depth, left + wall, SPEAKER_TOP)),
        box_element("speaker_roof", (0.0, right, SPEAKER_TOP), (depth, left, SPEAKER_TOP + wall)),
        box_element("speaker_front", (depth, right, HIGH_EDGE), (depth + wall, left, SPEAKER_TOP)),
        box_element("speaker_back", (-wall, right, LOW_EDGE), (0.0, left, SPEAKER_TOP)),
        box_element("subwoofer_low", (0.0, right, 0.0), (SUBWOOFER_X, left, 0.2)),
        box_element("subwoofer_high", (0.0, right, 0.2), (0.4, left, 0.9)),
    ]
    leg = Cylinder(radius=0.15, height=1.9)
    blue += [
        FieldElement(name=f"stage_leg_{number}", shape=leg, position=np.array([x, y, 0.95]))
        for number, (x, y) in enumerate(STAGE_LEGS)
    ]
    yield from for_both_alliances(blue, SYMMETRY)


FIELD = FieldDefinition(size=SIZE, symmetry=SYMMETRY, elements=tuple(_elements()))


def _zones() -> Iterator[ScoringZone]:
    """Speaker and amp; they take notes on their way up, too."""
    right, left = SPEAKER_Y - 0.5 * OPENING_WIDTH, SPEAKER_Y + 0.5 * OPENING_WIDTH
    boxes = {
        "Speaker": ((0.0, right, SPEAKER[2]), (OPENING_DEPTH, left, SPEAKER_TOP), 2),
        "Amp": ((AMP_X - 0.5 * AMP_WIDTH, SIZE[1], AMP_BOTTOM), (AMP_X + 0.5 * AMP_WIDTH, SIZE[1] + 0.3, AMP_TOP), 1),
    }
    for alliance in ALLIANCES:
        for name, (low, high, points) in boxes.items():
            corners = np.array([low, high])
            corners = SYMMETRY.flip_points(corners) if alliance == "red" else corners
            zone = BoxZone(tuple(corners.min(axis=0).tolist()), tuple(corners.max(axis=0).tolist()))
            yield ScoringZone(
                name=f"{alliance.capitalize()}{name}", alliance=alliance, zone=zone, points=points, downward=False
            )


def staging(rng: np.random.Generator, entries: Sequence[RobotEntry]) -> list[StagedPieces]:
    """Three notes in each wing and five on the center line, laid by hand; the rest waits at the sources."""
    del entries
    lying = NOTE.rest_height
    wing = np.array([(x, y, lying) for x, y in WING_NOTES])
    rows = [np.array([(x, y, lying) for x, y in CENTER_NOTES]), wing, SYMMETRY.flip_points(wing)]
    some = [StagedPieces(kind=NOTE.name, off_field=2 * STOCK)]
    for number, row in enumerate(rows):
        laid = row + np.column_stack((rng.uniform(-0.005, 0.005, (len(row), 2)), np.zeros(len(row))))
        if number == 2:
            laid = SYMMETRY.flip_points(SYMMETRY.flip_points(row) + (laid - row))
        some.append(StagedPieces(kind=NOTE.name, positions=laid))
    return some


class CrescendoRules(Rules):
    """Points by phase, the amplified speaker, and human players at the sources and at the amp's button."""

    def start(self) -> None:
        waiting = np.nonzero(self.match.pieces.state.status == PieceStatus.STAGED)[0].tolist()
        half = len(waiting) // 2
        slots = {"blue": waiting[:half], "red": waiting[half:]}
        self.sources = {alliance: Feeder(self.match, slots[alliance]) for alliance in ALLIANCES}
        self.start_mode("auto")

    def start_mode(self, mode: str) -> None:
        if mode == "auto":
            self.in_amp = dict.fromkeys(ALLIANCES, 0)
            self.until = dict.fromkeys(ALLIANCES, -math.inf)
            self.left = dict.fromkeys(ALLIANCES, 0)

    def is_amplified(self, alliance: Alliance) -> bool:
        """Whether notes in a speaker are worth more."""
        return self.left[alliance] > 0 and self.match.time < self.until[alliance]

    def before_tick(self) -> None:
        """Human players push the button as soon as they may, and put a note in where a robot without one waits."""
        if not self.match.timer.is_enabled:
            return
        for alliance in ALLIANCES:
            is_teleop = self.match.timer.phase.mode == "teleop"
            if is_teleop and self.in_amp[alliance] >= 2 and not self.is_amplified(alliance):
                self.in_amp = {**self.in_amp, alliance: self.in_amp[alliance] - 2}
                self.until = {**self.until, alliance: self.match.time + _AMPLIFIED}
                self.left = {**self.left, alliance: _AMPLIFIED_NOTES}
            if HUMAN_PLAYERS in self.match.options:
                self._feed(alliance)

    def _feed(self, alliance: Alliance) -> None:
        feeder = self.sources[alliance]
        if not (feeder.stock and feeder.is_due(_FEED_PERIOD)):
            return
        place, way = np.array([SOURCE]), _FEED_SPEED * math.sqrt(0.5) * np.array([[-1.0, 1.0, 0.0]])
        if alliance == "red":
            place, way = SYMMETRY.flip_points(place), SYMMETRY.flip_vectors(way)
        on_field = self.match.pieces.state.pos[self.match.pieces.on_field()]
        if (np.linalg.norm(on_field[:, :2] - place[0, :2], axis=1) < 1.5).any():
            return
        for robot, owner in zip(self.match.robots, self.match.alliances, strict=True):
            x, y, _ = robot.chassis.pose
            away = math.hypot(x - place[0, 0], y - place[0, 1])
            if owner == alliance and not robot.held and away < _FEED_REACH:
                feeder.put(place[0], velocity=way[0])
                return

    def worth(self, zone: ScoringZone) -> int:
        if self.match.timer.phase.mode == "auto":
            return 5 if zone.name.endswith("Speaker") else 2
        return 5 if zone.name.endswith("Speaker") and self.is_amplified(zone.alliance) else zone.points

    def scored(self, event: ScoreEvent) -> None:
        """Count notes for the amplification."""
        alliance = event.alliance
        if event.zone.endswith("Amp"):
            self.in_amp = {**self.in_amp, alliance: min(2, self.in_amp[alliance] + 1)}
        elif self.is_amplified(alliance):
            self.left = {**self.left, alliance: self.left[alliance] - 1}

    def end(self) -> None:
        """A point for each robot that is parked at its stage."""
        for robot, alliance in zip(self.match.robots, self.match.alliances, strict=True):
            x, y, yaw = robot.chassis.pose
            x, y, _ = (x, y, yaw) if alliance == "blue" else SYMMETRY.flip_pose(x, y, yaw)
            if STAGE_LEGS[0][0] < x < WING_X and abs(y - STAGE_LEGS[0][1]) < 0.5 * (x - STAGE_LEGS[0][0]):
                self.match.tracker.add(alliance, 1)

    def breakdown(self) -> Mapping[str, int]:
        return {f"{alliance.capitalize()}AmpNotes": self.in_amp[alliance] for alliance in ALLIANCES}

    def telemetry(self) -> Mapping[str, float | int | bool | str]:
        state: dict[str, float | int | bool | str] = {}
        for alliance in ALLIANCES:
            state[f"Sim/Crescendo/{alliance.capitalize()}Amplified"] = self.is_amplified(alliance)
            state[f"Sim/Crescendo/{alliance.capitalize()}Source"] = self.sources[alliance].stock
        return state


def crescendo_robot() -> RobotConfig:
    """52 kg; shoots ahead by two wheels under a tilting hood, takes notes in behind, holds one."""
    module = SwerveModuleConfig(x=0.0, y=0.0, drive_stator_limit=70.0, steer_stator_limit=40.0)
    mechanisms: dict[str, MechanismConfig] = {
        "intake": RollerConfig(gearbox=gearbox(3.0), inertia=0.001, radius=0.025),
        "wheels": FlywheelConfig(gearbox=gearbox(1.0, motors=2), inertia=0.008),
        "feeder": RollerConfig(gearbox=gearbox(4.0), inertia=0.002, radius=0.025),
        "pivot": ArmConfig(
            gearbox=gearbox(90.0, limit=40.0), inertia=0.4, mass=4.0, center_of_mass=0.2, min_angle=degrees(25.0),
            max_angle=degrees(65.0), start_angle=degrees(60.0)),
    }  # fmt: skip
    behind = IntakeZone(x_min=-0.62, x_max=-0.38, y_min=-0.30, y_max=0.30, z_max=0.25)
    shooter = ShooterConfig(
        wheels=("wheels",), wheel_radius=0.05, exit_efficiency=0.48, elevation=0.0, hood="pivot",
        elevation_per_hood=1.0, gate=("feeder",), launch=LaunchParameters(height=0.5, forward=0.1), shot_rate=3.0,
    )  # fmt: skip
    return RobotConfig(
        drivetrain=SwerveConfig.square(0.55, module, mass=52.0, bumper=0.8),
        bumper=(0.8, 0.8),
        mechanisms=mechanisms,
        intakes=(IntakeConfig(zone=behind, roller="intake"),),
        storage=StorageConfig(capacity=1, low=(-0.2, -0.2, 0.2), high=(0.2, 0.2, 0.6)),
        shooters=(shooter,),
    )


_CLOSE = ScriptSettings(
    feed_volts={"feeder": 8.0}, roller_volts=9.0, intake_x=-0.45, shot_elevation=degrees(62.0), acceleration=5.0
)
_FAR = replace(_CLOSE, shot_elevation=degrees(46.0))
_SUBWOOFER = (SUBWOOFER_X + 0.45, SPEAKER_Y, math.pi)


def _collect(robot: ScriptedRobot, note: tuple[float, float]) -> Steps:
    (x, y), around = note, 0.3
    robot.intake(True)
    yield from robot.drive_to(x - 0.9, y, math.pi, speed=3.0, timeout=2.5)
    yield from robot.collect_in((x - around, y - around), (x + around, y + around), aside=0.2, timeout=2.0, yaw=math.pi)
    robot.intake(False)


def wing(robot: ScriptedRobot) -> Steps:
    """Shoot the preload from the subwoofer, then two notes of the wing."""
    yield from robot.drive_to(*_SUBWOOFER, speed=3.0, timeout=2.0)
    yield from robot.shoot_until_empty(SPEAKER, timeout=3.0)
    for note in (WING_NOTES[1], WING_NOTES[2]):
        yield from _collect(robot, note)
        robot.spin_up(SPEAKER)
        yield from robot.drive_to(*_SUBWOOFER, speed=3.0, timeout=3.0)
        yield from robot.shoot_until_empty(SPEAKER, timeout=2.5)


def podium(robot: ScriptedRobot) -> Steps:
    """Shoot flat on the way up from where a note of the wing lies, take it in, and shoot it from there."""
    yield from robot.shoot_until_empty(SPEAKER, timeout=3.0)
    yield from _collect(robot, WING_NOTES[1])
    yield from robot.shoot_until_empty(SPEAKER, timeout=3.0)


def source(robot: ScriptedRobot) -> Steps:
    """Take a note from the source and shoot it from the wing."""
    x, y, _ = SOURCE
    robot.intake(True)
    yield from robot.wait(1.0)
    yield from robot.collect_in((x - 2.0, 0.0), (x + 0.4, y + 1.5), aside=0.5, timeout=6.0, yaw=math.pi)
    robot.intake(False)
    robot.spin_up(SPEAKER)
    yield from robot.drive_through([(11.0, 1.3), (5.8, 6.8), (2.4, SPEAKER_Y)], math.pi, speed=4.0, timeout=8.0)
    yield from robot.shoot_until_empty(SPEAKER, timeout=3.0)


AUTOS = {
    "wing": Auto(
        name="wing", summary="three notes from the subwoofer", controller=_CLOSE.controller(wing),
        start=(1.9, SPEAKER_Y, math.pi),
    ),
    "podium": Auto(
        name="podium", summary="two flat shots from the wing", controller=_FAR.controller(podium),
        start=(2.2, SPEAKER_Y, math.pi),
    ),
}  # fmt: skip
"""Those that play by the rules of auto; `source` is for teleop."""
SOURCE_CYCLE = _FAR.controller(source)

CRESCENDO = Game(
    name="crescendo", year=2024, field=FIELD, staging=staging, rules=CrescendoRules, robot=crescendo_robot,
    autos=AUTOS, preload=1, robots=6, zones=tuple(_zones()),
    starts=(_SUBWOOFER, (2.2, 7.0, math.pi), (1.6, 2.0, math.pi)),
    pieces=(PieceSupply(NOTE, 2 * STOCK + 11 + 6),),
    clock=MatchClock([Phase("auto", 15.0, "auto"), Phase("pause", 3.0, "disabled"), Phase("teleop", 135.0)]),
    options=(GameOption(name=HUMAN_PLAYERS, help="human players put notes in at the sources"),),
)  # fmt: skip
"""The whole game."""
