"""Hopper of a robot on the engine: its mass moves with the pieces, whole autos shoot from it and no piece is lost."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from games.rebuilt import REBUILT
from games.rebuilt.fuel import FUEL
from games.rebuilt.robot import rebuilt_robot
from games.reefscape import REEFSCAPE
from games.reefscape.robot import reefscape_robot
from simcore.errors import UnknownNameError
from simcore.match.game import PieceSupply, RobotEntry
from simcore.match.match import Match
from simcore.match.runner import play_auto
from simcore.robot.hopper import HopperConfig
from simcore.robot.robot_config import RobotConfig

pytestmark = pytest.mark.engines("bullet")


def robot(**config) -> RobotConfig:
    base = rebuilt_robot()
    return replace(base, storage=replace(base.storage, hopper=HopperConfig(**config)))


WIDE = robot(outlet_width=0.45, belt="spindexer", belt_travel=0.1, funnel=0.5)
"""Robot with an outlet three diameters wide, which balls do not bridge."""


def center(match) -> np.ndarray:
    """Return the mean position of the held pieces, robot frame [m]."""
    one = match.robots[0]
    return one.held_poses(match.pieces.radius)[:, :3].mean(axis=0)


def test_pieces_slide_to_the_rear_and_shift_the_robots_center_of_mass():
    """At every tick, mass and center equal the sum over the body and the pieces; shifts below 2 mm are ignored."""
    with Match.bare(WIDE, pieces=(PieceSupply(FUEL, 12),)) as match:
        one = match.robots[0]
        for number in range(12):
            match.pieces.spawn("Fuel", (8.0 + 0.2 * number, 7.0, 0.075))
        slots = match.pieces.on_field("Fuel")
        match.pieces.hold(slots, 0)
        one.storage.add(slots.tolist())
        match.play(1.0)
        at_rest, whole, body = center(match)[0], one.chassis.distribution.center[0], WIDE.whole
        for tick in range(40):
            one.drive.set_volts([min(12.0, 1.0 + 0.3 * tick)] * 4, [0.0] * 4)
            match.tick()
            told, mass = one.chassis.distribution, body.mass + 12 * FUEL.mass
            assert told.mass == pytest.approx(mass)
            place = (body.mass * np.array(body.center) + 12 * FUEL.mass * center(match)) / mass
            assert np.abs(np.array(told.center) - place).max() < 0.012, "a tick later"
        assert center(match)[0] < at_rest - 0.03
        assert one.chassis.distribution.center[0] < whole - 12 * FUEL.mass * 0.025 / (body.mass + 12 * FUEL.mass)


def test_a_robot_shoots_and_scores_a_whole_auto_from_its_hopper():
    run = play_auto(REBUILT, "depot", seed=1, robot=WIDE, on_tick=_require_conserved)
    with run.match:
        assert len(run.match.record.shots) >= 25 and run.match.score.blue >= 25
        assert _places_are_inside(run.match)


def test_equal_seeds_give_equal_runs():
    digests = set()
    for _ in range(2):
        run = play_auto(REBUILT, "depot", seed=3, robot=WIDE, seconds=4.0)
        run.match.close()
        digests.add(run.report.digest)
    assert len(digests) == 1


def _require_conserved(match) -> None:
    assert match.count.is_conserved


def _places_are_inside(match) -> bool:
    storage = match.robots[0].config.storage
    places = match.robots[0].held_poses(match.pieces.radius)[:, :3]
    return bool((places >= storage.low).all() and (places <= storage.high).all())


def test_a_narrow_outlet_jams_with_a_warning_and_the_robot_keeps_fuel(caplog):
    narrow = robot(outlet_width=0.2, belt="spindexer", belt_travel=0.1, funnel=0.5)
    run = play_auto(REBUILT, "depot", seed=0, robot=narrow, on_tick=_require_conserved)
    with run.match:
        assert len(run.match.record.shots) < 20 and run.match.robots[0].held
    told = [record for record in caplog.records if "jam the outlet of its hopper" in record.getMessage()]
    assert 1 <= len(told) <= 1 + len(run.match.record.shots)


def test_a_field_reset_restores_preloads_and_warns_of_the_next_jam(caplog):
    """Preloads occupy the slots that jammed before, but at other places."""
    narrow = robot(outlet_width=0.2, belt="spindexer", belt_travel=0.01, funnel=0.5)
    with Match(REBUILT, robots=(RobotEntry(config=narrow),)) as match:
        storage = match.robots[0].storage
        match.tick()
        slots, places = list(storage.pieces), storage.hopper.pos
        for _ in range(2):
            match.play(3.0, controllers=[lambda one, time: one.mechanisms["spindexer"].set_volts(8.0)])
            assert storage.hopper.is_jammed
            match.control.reset_field()
            match.tick()
            assert storage.pieces == slots and not storage.hopper.is_jammed
            assert np.abs(storage.hopper.pos - places).max() < 0.01, "a tick of the belt"
    assert len([one for one in caplog.records if "jam the outlet" in one.getMessage()]) == 2


def test_each_of_two_hoppers_warns_of_its_own_jam(caplog):
    """Both hoppers share one belt, and no shooter runs."""
    base = robot(outlet_width=0.2, belt="spindexer", belt_travel=0.01, funnel=0.5)
    room = replace(base.storage, name="a", capacity=8)
    two = replace(
        base,
        storage=room, more_storages=(replace(room, name="b"),),
        intakes=tuple(replace(one, storage="a") for one in base.intakes),
        shooters=tuple(replace(one, storage="a") for one in base.shooters),
    )  # fmt: skip
    with Match.bare(two, pieces=(PieceSupply(FUEL, 16),)) as match:
        for number in range(16):
            match.pieces.spawn("Fuel", (8.0 + 0.2 * number, 7.0, 0.075))
        slots = match.pieces.on_field("Fuel")
        match.pieces.hold(slots, 0)
        for storage, some in zip(match.robots[0].storages, (slots[:8], slots[8:]), strict=True):
            storage.add(some.tolist())
        match.play(4.0, controllers=[lambda one, time: one.mechanisms["spindexer"].set_volts(8.0)])
        assert all(storage.hopper.is_jammed for storage in match.robots[0].storages)
    told = [one.getMessage().partition("jam the ")[2] for one in caplog.records]
    assert sorted(filter(None, told)) == ["outlet of its hopper 'a'", "outlet of its hopper 'b'"]


def test_a_claw_that_takes_a_piece_out_of_a_hopper_ends_the_jam():
    base = reefscape_robot()
    claws = replace(base, storage=replace(base.storage, hopper=HopperConfig(outlet_width=0.4, slope=0.2)))
    jams = []

    def note(match) -> None:
        if not jams:
            match.flow._is_jammed.add((0, ""))
        jams.append(len(match.flow._is_jammed))

    play_auto(REEFSCAPE, "three_l4", seed=0, robot=claws, seconds=2.0, on_tick=note).match.close()
    assert jams[0] == 1 and jams[-1] == 0


def test_the_error_names_an_unknown_belt():
    with pytest.raises(UnknownNameError, match="for a hopper"):
        robot(outlet_width=0.3, belt="spindxer")
