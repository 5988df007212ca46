"""Pieces in scoring places: placed by physics, counted by level, knocked off, taken, stacked and lodged."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simcore import Match
from simcore.errors import ConfigError
from simcore.match.game import PieceSupply
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.pool import PieceStatus
from simcore.pieces.resting_places import RestingPlace
from simcore.robot.robot_config import RobotConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.world.contact_law import TerrainSurface
from simcore.world.field import FieldElement, box_element
from simcore.world.rotation import from_rpy
from simcore.world.shapes import Cylinder, Sphere, tube
from simcore.world.zones import CylinderZone

TUBE = GamePieceConfig(
    name="Tube", shape=tube(length=0.3, outer_radius=0.057, inner_radius=0.051), mass=0.65, friction=0.5
)
BALL = GamePieceConfig(name="Ball", shape=Sphere(0.2), mass=0.45, friction=0.7)
STEEL = TerrainSurface(name="steel", friction=0.5, restitution=0.3)
PIPE = FieldElement(name="pipe", shape=Cylinder(0.021, 0.8), position=np.array([6.0, 4.0, 0.6]), surface=STEEL)
COLLAR = FieldElement(name="collar", shape=Cylinder(0.07, 0.1), position=np.array([6.0, 4.0, 0.65]), surface=STEEL)
TABLE = box_element("table", (9.0, 3.0, 0.0), (10.0, 5.0, 0.4))
UPRIGHT = RestingPlace(
    name="pipe", level="High", zone=CylinderZone((6.0, 4.0), 0.06, 0.7, 1.1), capacity=1, kinds=("Tube",),
    axis=(0.0, 0.0, 1.0), max_tilt=math.radians(20.0),
)  # fmt: skip
FLAT = RestingPlace(name="table", level="Low", zone=CylinderZone((9.5, 4.0), 0.5, 0.4, 0.7))


def robot_config() -> RobotConfig:
    return RobotConfig(drivetrain=SwerveConfig.square(0.53, SwerveModuleConfig(x=0.0, y=0.0)))


class Watch:
    """Record the placed and removed pieces of a match."""

    def __init__(self, match: Match) -> None:
        self.placed: list[tuple[str, int]] = []
        self.removed: list[tuple[str, int, int]] = []
        match.rules.placed = lambda event: self.placed.append((event.place.name, event.slot))  # type: ignore[method-assign]
        match.rules.removed = lambda event: self.removed.append(  # type: ignore[method-assign]
            (event.place.name, event.slot, event.holder)
        )


def game_of(**more):
    return Match.bare(
        elements=(PIPE, COLLAR, TABLE),
        pieces=[PieceSupply(TUBE, 4), PieceSupply(BALL, 3)],
        places=(UPRIGHT, FLAT),
        start=(2.0, 1.0, 0.0),
        **more,
    )


def test_a_piece_at_rest_in_its_place_counts_until_it_is_knocked_off_or_taken():
    with game_of() as match:
        watch = Watch(match)
        on_pipe = int(match.pieces.spawn("Tube", np.array([[6.0, 4.0, 1.0]]))[0])
        lying = from_rpy(0.0, math.pi / 2, 0.0)
        on_table = match.pieces.spawn("Tube", np.array([[9.5, 4.0, 0.50]]), np.array([lying]))
        on_table = int(on_table[0])
        beside = int(match.pieces.spawn("Tube", np.array([[9.5, 5.6, 0.15]]))[0])
        match.tick()
        assert match.count.placed == 0, "they still move"
        match.play(2.0)
        assert sorted(watch.placed) == [("pipe", on_pipe), ("table", on_table)] and watch.removed == []
        places = match.pieces.places
        assert (places.count("pipe"), places.count(level="Low"), places.count()) == (1, 1, 2)
        assert match.pieces.state.status[[on_pipe, beside]].tolist() == [PieceStatus.PLACED, PieceStatus.ASLEEP]
        assert match.count.placed == 2 and match.count.is_conserved and not match.pieces.awake.size
        snapshot = match.snapshot()
        assert (snapshot.integers["Sim/Placed/High"], snapshot.integers["Sim/Placed/Low"]) == (1, 1)
        assert len(snapshot.pose_arrays["Sim/GamePieces/Tube"]) == 3, "what is placed is still shown"

        match.pieces.push(np.array([on_pipe]), np.array([[0.3, 0.0, 0.0]]))
        match.play(1.5)
        assert watch.removed == [], "shaken, it comes to rest again where it counts"
        assert match.pieces.state.status[on_pipe] == PieceStatus.PLACED and len(watch.placed) == 2

        match.pieces.push(np.array([on_table]), np.array([[0.0, 4.0, 1.0]]))
        match.play(1.5)
        assert watch.removed == [("table", on_table, -1)] and places.count("table") == 0
        match.pieces.hold(np.array([on_pipe]), 0)
        match.tick()
        assert watch.removed[1:] == [("pipe", on_pipe, 0)]
        assert match.count.is_conserved and match.count.held == 1 and match.count.placed == 0


def test_a_piece_put_inside_a_robot_moves_neither_and_can_be_pushed_once_it_is_outside():
    """The engine would throw a robot 1.5 m high."""
    with game_of() as match:
        robot = match.robots[0]
        slot = int(match.pieces.spawn("Tube", np.array([[2.1, 1.0, 0.25]]))[0])
        speeds = []
        for _ in range(50):
            match.tick()
            speeds.append(math.hypot(*robot.chassis.vel))
        assert max(speeds) < 0.01 and math.dist(robot.chassis.pos, (2.0, 1.0, 0.0)) < 1e-3
        place = match.pieces.state.pos[slot].copy()
        assert place[2] < 0.2 and math.dist(place[:2], (2.1, 1.0)) < 0.05, "on the carpet below the frame"
        for speed, ticks in ((-1.5, 60), (1.5, 60)):
            robot.drive.set_chassis_speeds(speed, 0.0, 0.0)
            match.play(ticks * 0.02)
            if speed < 0.0:
                assert robot.chassis.pos[0] < 0.9
                assert math.dist(match.pieces.state.pos[slot], place) < 0.01
        assert match.pieces.state.pos[slot, 0] > 2.2, "the bumpers push the piece"


def test_a_piece_does_not_count_in_a_full_place_or_misaligned_or_touching_a_robot():
    with game_of() as match:
        first, second = match.pieces.spawn("Tube", np.array([[6.0, 4.0, 0.86], [6.0, 4.0, 1.18]])).tolist()
        match.play(1.5)
        assert match.pieces.state.pos[second, 2] > 1.0, "on top of the first"
        assert match.pieces.places.slots("pipe").tolist() == [first]
    beside = RestingPlace(name="floor", zone=CylinderZone((8.8, 4.0), 0.5, 0.0, 0.5))
    tilted = RestingPlace(name="pipe", zone=CylinderZone((6.0, 4.0), 0.06, 0.7, 1.1), axis=(1.0, 0.0, 0.0))
    with Match.bare(
        elements=(PIPE, COLLAR, TABLE), pieces=[PieceSupply(TUBE, 2)], places=(beside, tilted), start=(8.2, 4.0, 0.0)
    ) as match:
        match.pieces.spawn("Tube", np.array([[6.0, 4.0, 0.9]]))
        slot = int(match.pieces.spawn("Tube", np.array([[8.8, 4.0, 0.15]]))[0])
        match.play(0.1)
        assert match.pieces.places.slots("floor").tolist() == [slot]
        match.robots[0].drive.set_volts([2.0] * 4, [0.0] * 4)
        match.play(2.0)
        assert match.pieces.robots_touching(slot), "held against the table"
        assert match.pieces.places.slots().tolist() == []
        match.robots[0].drive.set_volts([-2.0] * 4, [0.0] * 4)
        match.play(2.0)
        assert match.pieces.places.slots().tolist() == [slot], "the one on the pipe does not lie as it must"


def test_a_piece_staged_on_another_piece_sleeps_until_the_lower_piece_is_gone():
    with game_of() as match:
        under = match.pieces.spawn("Tube", np.array([[4.0, 4.0, 0.15]]))
        height = 0.3 + math.sqrt(0.2**2 - 0.051**2)
        over = int(match.pieces.spawn("Ball", np.array([[4.0, 4.0, height]]), resting=True)[0])
        match.play(0.5)
        assert not match.pieces.awake.size and match.pieces.state.pos[over, 2] == height
        match.pieces.hold(under, 0)
        match.play(2.0)
        assert match.pieces.state.pos[over, 2] == pytest.approx(0.2, abs=0.003)
        with pytest.raises(ConfigError, match="nothing to rest on"):
            match.pieces.spawn("Ball", np.array([[2.0, 6.0, 1.5]]), resting=True)
        with pytest.raises(ConfigError, match="lodged pieces come free at"):
            match.pieces.spawn("Ball", np.array([[2.0, 6.0, 1.5]]), lodged=0.0)


@pytest.mark.parametrize(("force", "comes_free"), [(60.0, False), (15.0, True)])
def test_a_lodged_piece_comes_free_at_its_configured_force(force, comes_free):
    """A hit by an equal ball at 0.25 m/s: v sqrt(k m / 2) with two springs in series is 37 N while it is held."""
    assert 0.25 * math.sqrt(0.5 * BALL.foam[0] * BALL.mass) == pytest.approx(37.5, rel=0.01)
    with game_of() as match:
        slot = int(match.pieces.spawn("Ball", np.array([[12.0, 4.0, 1.3]]), lodged=force)[0])
        match.play(0.4)
        assert not match.pieces.awake.size and match.pieces.state.pos[slot, 2] == 1.3
        other = match.pieces.spawn("Ball", np.array([[12.0 - 0.402, 4.0, 1.3 + 0.5 * 9.80665 * 0.008**2]]))
        match.pieces.push(other, np.array([[0.25, 0.0, 0.0]]))
        match.play(1.5)
        if comes_free:
            assert match.pieces.state.pos[slot, 2] == pytest.approx(0.2, abs=0.2)
        else:
            assert match.pieces.state.pos[slot].tolist() == [12.0, 4.0, 1.3]
        taken = match.pieces.spawn("Ball", np.array([[13.0, 4.0, 1.3]]), lodged=15.0)
        match.pieces.hold(taken, 0)
        match.pieces.launch(0, (13.0, 4.0, 1.3), (0.0, 0.0, 0.0), slot=int(taken[0]), flying=False)
        match.play(0.3)
        assert match.pieces.state.pos[taken[0], 2] < 1.1, "a robot took it out"


def test_invalid_places_are_refused():
    zone = FLAT.zone
    for words, what in (
        ("name must not be empty", {"name": ""}),
        ("capacity must be a whole number from 1", {"capacity": 0}),
        ("axis must be a unit vector", {"axis": (0.0, 0.0, 0.5)}),
        ("max_tilt must be a number above 0", {"max_tilt": 0.0}),
    ):
        with pytest.raises(ConfigError, match=words):
            RestingPlace(**{"name": "x", "zone": zone, **what})
    for words, places in (
        ("names of resting places must differ", (FLAT, FLAT)),
        ("no piece of kind", (RestingPlace(name="x", zone=zone, kinds=("Tub",)),)),
    ):
        with pytest.raises(ConfigError, match=words):
            Match.bare(pieces=[PieceSupply(TUBE, 1)], places=places)
