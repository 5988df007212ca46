"""CHARGED UP (2023): cones on poles, cubes on shelves, links of three nodes, and charge stations that tip.

The file is a whole game with a claw, built from public parts of simcore only. Sizes and points come from the 2023 game
manual; estimates are marked and not in the manual.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import product

import numpy as np

from simcore.match.clock import MatchClock, Phase
from simcore.match.game import (
    Auto,
    FieldDefinition,
    Game,
    PieceSupply,
    RobotEntry,
    Rules,
    StagedPieces,
    for_both_alliances,
)
from simcore.match.scoring import Alliance
from simcore.match.scripted import ScriptedRobot, ScriptSettings, Steps
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.resting_places import PlaceEvent, RestingPlace
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.intake import IntakeZone
from simcore.robot.mechanisms import ArmConfig, RollerConfig
from simcore.robot.placer import PlacerConfig
from simcore.robot.robot_config import RobotConfig
from simcore.robot.storage import StorageConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.units import degrees, inches
from simcore.world.field import FieldBoundary, FieldElement, box_element, slope_element
from simcore.world.hanging import HangingConfig
from simcore.world.linkage import Joint
from simcore.world.shapes import Box, Cylinder, hollow_cone
from simcore.world.symmetry import FieldSymmetry
from simcore.world.zones import BoxZone

SIZE = (inches(651.25), inches(315.5))
SYMMETRY = FieldSymmetry("mirror", SIZE)
ALLIANCES: tuple[Alliance, Alliance] = ("blue", "red")

# --- pieces -----------------------------------------------------------------------------------------------------------

CONE = GamePieceConfig(
    name="Cone",
    shape=hollow_cone(
        height=inches(12.8125),
        bottom_radius=inches(3.3),
        top_radius=inches(0.875),
        wall=inches(0.2),
        foot=inches(8.375),
    ),
    mass=0.653,
    friction=0.6,
    restitution=0.2,
)
CUBE = GamePieceConfig(  # inflated: the cube yields by some millimeters to its neighbor; stiffness is an estimate
    name="Cube", shape=Box((inches(9.5),) * 3), mass=0.071, friction=0.7, restitution=0.4, stiffness=1500.0
)

# --- field ------------------------------------------------------------------------------------------------------------

GRID_DEPTH = inches(54.25)
COLUMNS = tuple(inches(20.19 + 22.0 * number) for number in range(9))
"""y of each column of nodes; the middle one of three is for cubes [m]."""
POLES = {"Mid": (GRID_DEPTH - inches(22.75), inches(34.0)), "Top": (GRID_DEPTH - inches(39.75), inches(46.0))}
"""x and height of each pole [m]."""
SHELVES = {"Mid": inches(23.5), "Top": inches(35.5)}
"""Height of each shelf, around the x of the poles [m]."""
POLE_RADIUS, SHELF = 0.012, (0.43, 0.45)  # estimates: thin enough for the cone above; depth and width
STATION = (3.9, 2.748)
"""Center of a charge station [m]; x is an estimate."""
HALF, WIDE, PLATE, LEVEL, RAMP = 0.6, inches(97.25), 0.04, inches(9.125), 0.6
"""Half length, half width, thickness, height when level, and length of each ramp of a charge station [m]."""
RISE = 0.04  # height of the platform's center of mass above the hinge; estimate
LEVEL_WITHIN = degrees(2.5)


def _grid() -> Iterator[FieldElement]:
    for number, y in enumerate(COLUMNS):
        is_cube = number % 3 == 1
        for row, (x, height) in POLES.items():
            if is_cube:
                low, high = (x - 0.5 * SHELF[0], y - 0.5 * SHELF[1], 0.0), (x + 0.5 * SHELF[0], y + 0.5 * SHELF[1])
                yield box_element(f"shelf_{row}_{number}", low, (*high, SHELVES[row]))
            else:
                place = np.array([x, y, 0.5 * height])
                yield FieldElement(name=f"pole_{row}_{number}", shape=Cylinder(POLE_RADIUS, height), position=place)


def _station() -> Iterator[FieldElement]:
    """Return the ramps up to the level platform, and supports for the tipped platform."""
    (x, y), gap = STATION, 0.02
    right, left, top = y - 0.5 * WIDE, y + 0.5 * WIDE, LEVEL - 0.015
    near, far = HALF + gap, HALF + gap + RAMP
    yield slope_element("ramp_near", (x - far, right, 0.0), (x - near, left, top), "+x")
    yield slope_element("ramp_far", (x + near, right, 0.0), (x + far, left, top), "-x")
    for name, middle in (("near", x - 0.5), ("far", x + 0.5)):
        yield box_element(f"ramp_stop_{name}", (middle - 0.05, right, 0.0), (middle + 0.05, left, 0.08))


def _platforms() -> Iterator[HangingConfig]:
    for alliance in ALLIANCES:
        ((x, y, z),) = SYMMETRY.points_of(alliance, (*STATION, LEVEL - 0.5 * PLATE - RISE))
        yield HangingConfig(
            name=f"{alliance}_station",
            shape=Box((2.0 * HALF, WIDE, PLATE)),
            mass=60.0,  # estimate, like spring and damping
            pivot=(x, y, z),
            drop=-RISE,
            hinge="y",
            spring=700.0,
            damping=3.0,
            alliance=alliance,
            drivable=True,
        )


FIELD = FieldDefinition(
    size=SIZE,
    symmetry=SYMMETRY,
    elements=(
        *FieldBoundary(length=SIZE[0], width=SIZE[1], side_height=inches(20.0), end_height=2.0).elements(),
        *for_both_alliances((*_grid(), *_station()), SYMMETRY),
    ),
    drivable=("*_ramp_*",),
    hanging=tuple(_platforms()),
)


def _places() -> Iterator[RestingPlace]:
    """Return the 27 nodes of each alliance, row by row; a level is a row, in the order of its columns."""
    for alliance, row, (number, y) in product(ALLIANCES, ("Low", "Mid", "Top"), enumerate(COLUMNS)):
        half = inches(11.0)
        if row == "Low":
            box = ((GRID_DEPTH - 0.40, y - half, 0.0), (GRID_DEPTH, y + half, 0.4))
        elif number % 3 == 1:
            x, floor = POLES[row][0], SHELVES[row]
            box = ((x - 0.3, y - half, floor), (x + 0.3, y + half, floor + 0.3))
        else:
            x, height = POLES[row]
            box = ((x - 0.06, y - 0.06, height - 0.35), (x + 0.06, y + 0.06, height))
        kinds = () if row == "Low" else (CUBE.name,) if number % 3 == 1 else (CONE.name,)
        side = alliance.capitalize()
        yield RestingPlace(
            name=f"{side} {row} {number + 1}",
            level=f"{side}{row}",
            alliance=alliance,
            zone=BoxZone(*SYMMETRY.box_of(alliance, *box)),
            capacity=1,
            kinds=kinds,
        )


# --- staging ----------------------------------------------------------------------------------------------------------


def staging(rng: np.random.Generator, entries: Sequence[RobotEntry]) -> list[StagedPieces]:
    """Place four pieces on the marks of each half, cones or cubes at random; the rest wait at the substations."""
    marks = [(inches(278.0), inches(36.19 + 48.0 * number)) for number in range(4)]
    found, used = [], {CONE.name: 0, CUBE.name: 0}
    is_cone = rng.random(4) < 0.5
    for kind, wanted in ((CONE, is_cone), (CUBE, ~is_cone)):
        blue = np.array([(*mark, kind.rest_height) for mark, is_wanted in zip(marks, wanted, strict=True) if is_wanted])
        if len(blue):
            found.append(StagedPieces(kind=kind.name, positions=np.vstack((blue, SYMMETRY.flip_points(blue)))))
            used[kind.name] = 2 * len(blue)
    return [*found, *(StagedPieces(kind=name, off_field=10 - count) for name, count in used.items())]


# --- rules ------------------------------------------------------------------------------------------------------------

NODE_POINTS = {"Low": (3, 2), "Mid": (4, 3), "Top": (6, 5)}
"""Points of a node in auto and in teleop."""
LINK, STATION_POINTS = 5, {"auto": (8, 12), "teleop": (6, 10)}
"""Points for a docked and for an engaged robot."""


def links(row: Sequence[int]) -> int:
    """Return triples of adjacent filled nodes; no node is in two triples."""
    found = run = 0
    for count in row:
        run = run + 1 if count else 0
        if run == 3:
            found, run = found + 1, 0
    return found


class ChargedUpRules(Rules):
    """Rules: nodes count while pieces stay, links follow from nodes, and stations are judged as auto and match end."""

    def start(self) -> None:
        self.worth_of: dict[int, tuple[Alliance, int]] = {}
        self.links = dict.fromkeys(ALLIANCES, 0)
        self.station = dict.fromkeys(ALLIANCES, 0)
        self._was_auto = False

    def placed(self, event: PlaceEvent) -> None:
        alliance, row = event.place.alliance, event.place.name.split()[1]
        assert alliance is not None
        points = NODE_POINTS[row][0 if self.match.timer.phase.name == "auto" else 1]
        self.worth_of[event.slot] = alliance, points
        self.match.tracker.add(alliance, points)
        self._count_links()

    def removed(self, event: PlaceEvent) -> None:
        alliance, points = self.worth_of.pop(event.slot)
        self.match.tracker.add(alliance, -points)
        self._count_links()

    def after_tick(self) -> None:
        is_auto = self.match.timer.phase.name == "auto"
        if self._was_auto and not is_auto:
            self._judge_stations("auto")
        self._was_auto = is_auto

    def end(self) -> None:
        self._judge_stations("teleop")

    def breakdown(self) -> Mapping[str, int]:
        found = {f"{side.capitalize()}Links": count for side, count in self.links.items()}
        return found | {f"{side.capitalize()}Station": points for side, points in self.station.items()}

    def _count_links(self) -> None:
        counts = self.match.pieces.places.counts()
        for alliance in ALLIANCES:
            side = alliance.capitalize()
            now = sum(links(counts[f"{side}{row}"].tolist()) for row in NODE_POINTS)
            self.match.tracker.add(alliance, LINK * (now - self.links[alliance]))
            self.links[alliance] = now

    def _judge_stations(self, phase: str) -> None:
        """Judge robots that touch their station and nothing below: docked, or engaged on a level station."""
        match = self.match
        for body in match.hanging:
            alliance = body.config.alliance
            assert alliance is not None
            docked = [
                robot.number
                for robot in match.robots
                if match.alliances[robot.number] == alliance
                and (robot.number, body.config.name) in match.contacts.hanging
                and not match.contacts.elements(robot.number)
            ]
            is_level = abs(body.angle) < LEVEL_WITHIN
            count = min(1, len(docked)) if phase == "auto" else len(docked)
            points = count * STATION_POINTS[phase][1 if is_level else 0]
            match.tracker.add(alliance, points)
            self.station[alliance] += points


# --- robot ------------------------------------------------------------------------------------------------------------

ARM, SHOULDER = 1.05, 0.55
"""Length of the arm, and height of the arm joint [m]."""


def charged_up_robot() -> RobotConfig:
    """Build a robot of 45 kg whose arm carries a claw that stays level."""
    gearbox = GearboxConfig(motor=motor("Kraken X60"), gearing=100.0, stator_current_limit=60.0)
    rollers = GearboxConfig(motor=motor("Kraken X60"), gearing=8.0, stator_current_limit=40.0)
    module = SwerveModuleConfig(x=0.0, y=0.0, drive_stator_limit=80.0, steer_stator_limit=40.0)
    arm = Joint(mechanism="arm", axis=(0.0, -1.0, 0.0), origin=(0.0, 0.0, SHOULDER))
    level = Joint(mechanism="arm", axis=(0.0, 1.0, 0.0), origin=(ARM, 0.0, 0.0))
    grip = IntakeZone(x_min=-0.15, x_max=0.15, y_min=-0.2, y_max=0.2, z_min=-0.15, z_max=0.15)
    return RobotConfig(
        drivetrain=SwerveConfig.square(0.5, module, mass=45.0, bumper=0.75),
        bumper=(0.75, 0.75),
        mechanisms={
            "arm": ArmConfig(
                gearbox=gearbox, inertia=1.2, mass=3.0, center_of_mass=0.5, min_angle=degrees(-40.0),
                max_angle=degrees(85.0), start_angle=degrees(80.0)),
            "claw": RollerConfig(gearbox=rollers, inertia=0.002, radius=0.03),
        },
        storage=StorageConfig(capacity=1, low=(-0.2, -0.2, 0.3), high=(0.2, 0.2, 0.7)),
        placers=(PlacerConfig(joints=(arm, level), roller="claw", zone=grip, from_storage=True),),
    )  # fmt: skip


# --- autos ------------------------------------------------------------------------------------------------------------

_SETTINGS = ScriptSettings(acceleration=3.0)


def angle_for(height: float) -> float:
    """Return the angle of the arm [rad] that brings the claw to a height [m]."""
    return math.asin((height - SHOULDER) / ARM)


def put_on_pole(robot: ScriptedRobot, row: str, column: int) -> Steps:
    """Bring the claw over a pole and release the cone."""
    (x, height), y = POLES[row], COLUMNS[column]
    over = angle_for(height + 0.16)
    robot.set_volts("claw", 6.0)  # takes the preload
    robot.set_position("arm", degrees(75.0))
    yield from robot.wait(0.3)
    robot.set_volts("claw", 0.0)
    reach = x + ARM * math.cos(over)
    yield from robot.drive_to(reach + 0.2, y, math.pi, speed=1.5, tolerance=0.02)
    robot.set_position("arm", over)
    yield from robot.wait(1.0)
    yield from robot.drive_to(reach, y, math.pi, speed=0.5, tolerance=0.004, timeout=2.0)
    yield from robot.wait(0.5)
    robot.set_volts("claw", -8.0)
    yield from robot.wait(0.4)
    robot.set_volts("claw", 0.0)


def cone(robot: ScriptedRobot) -> Steps:
    """Put the preloaded cone on a pole of the middle row and back off."""
    yield from put_on_pole(robot, "Mid", 3)
    yield from robot.drive_to(2.2, COLUMNS[3], math.pi, speed=1.0)
    robot.set_position("arm", degrees(80.0))


def balance(robot: ScriptedRobot) -> Steps:
    """Drive onto the charge station, which tips, and stop where the platform is level."""
    robot.set_position("arm", degrees(80.0))
    x, y = STATION
    yield from robot.drive_to(x, y, 0.0, speed=1.2, tolerance=0.01, timeout=8.0)
    while True:
        yield from robot.drive_to(x, y, 0.0, speed=0.4, tolerance=0.01, timeout=1.0)
        yield


AUTOS = {
    "cone": Auto(
        name="cone", summary="a cone on a pole", controller=_SETTINGS.controller(cone), start=(2.1, COLUMNS[3], math.pi)
    ),
    "balance": Auto(
        name="balance",
        summary="dock and engage",
        controller=_SETTINGS.controller(balance),
        start=(2.0, STATION[1], 0.0),
    ),
}

CHARGED_UP = Game(
    name="charged_up",
    year=2023,
    field=FIELD,
    staging=staging,
    rules=ChargedUpRules,
    robot=charged_up_robot,
    autos=AUTOS,
    preload=1,
    places=tuple(_places()),
    starts=((2.1, COLUMNS[3], math.pi), (2.1, COLUMNS[0], math.pi), (2.1, COLUMNS[7], math.pi)),
    pieces=(PieceSupply(CONE, 10 + 6), PieceSupply(CUBE, 10)),
    clock=MatchClock([Phase("auto", 15.0, "auto"), Phase("pause", 3.0, "disabled"), Phase("teleop", 135.0)]),
)
"""Complete game."""
