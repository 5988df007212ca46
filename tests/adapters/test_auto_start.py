"""Start of an autonomous in robot tests: the robot's pose, and the pieces at a match start."""

from __future__ import annotations

from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

STARTING = Path(__file__).parent / "robots" / "starting"


def test_the_robot_and_the_pieces_are_at_their_start_poses_when_an_auto_begins(project_of):
    """At 1 m/s, an estimate may lag 2 cm, the travel of a tick, behind the true pose.

    The program takes 1 s to start; pyfrc allows only 2 s, too few on a busy computer.
    """
    code, said = project_of(STARTING)(
        """
import logging
import math

import pytest
from wpimath.geometry import Pose2d


def apart(sim):
    believed, true = sim.robot.drivetrain.get_state().pose, sim.pose
    return believed.translation().distance(true.translation())


def test_it(sim, caplog):
    caplog.set_level(logging.INFO, "simcore")
    sim.start()
    believed = sim.robot.drivetrain.get_state().pose
    assert (believed.X(), believed.Y()) == pytest.approx((3.0, 4.0), abs=1e-6)  # at rest, whatever encoders read first
    assert (sim.pose.X(), sim.pose.Y()) == pytest.approx((2.0, 1.2), abs=1e-3)  # the estimate was set, no robot moved

    sim.autonomous("left", seconds=0.2)
    assert apart(sim) < 0.02 and sim.pose.X() < 2.5 and sim.pose.Y() == pytest.approx(6.0, abs=0.02)
    assert "the auto begins at (2.50, 6.00) m, 180 deg" in caplog.text
    sim.run(0.2)  # a later reset moves only the estimate
    assert apart(sim) > 1.0
    before = sim.pose
    sim.teleop(seconds=0.1)
    assert sim.pose.translation().distance(before.translation()) < 0.3  # coasting, not carried

    for name, why in (("outside", "outside of the field"), ("in the hub", "inside of a field element")):
        sim.disable(seconds=0.5)
        before = sim.pose
        sim.autonomous(name, seconds=0.1)
        assert sim.pose.translation().distance(before.translation()) < 0.05
        assert why in caplog.text

    sim.disable(seconds=0.5)
    with pytest.raises(ValueError, match="outside of the field"):
        sim.place(40.0, 1.0)
    sim.autonomous("left", start=Pose2d(3.0, 2.0, 0.0), seconds=0.1)  # overrides the pose that the auto sets
    assert (sim.pose.X(), sim.pose.Y()) == pytest.approx((3.0, 2.0), abs=0.01)


def test_red(sim):
    sim.alliance("red")
    sim.autonomous("red", seconds=0.2)
    assert apart(sim) < 0.02 and sim.pose.X() == pytest.approx(14.0, abs=0.1)
    sim.disable(seconds=0.5)
    sim.physics.auto_start.starts = {"by name": (2.0, 6.0, 0.0)}
    sim.autonomous("by name", seconds=0.1)
    length, width = sim.match.game.field.size  # mirrored for red
    assert (sim.pose.X(), sim.pose.Y()) == pytest.approx((length - 2.0, width - 6.0), abs=0.01)
    sim.disable()
    sim.place(3.0, 1.0, math.pi / 2)
    sim.autonomous("by name", seconds=0.1)
    assert sim.pose.rotation().degrees() == pytest.approx(90.0, abs=1.0)


def test_another_alliance_while_disabled_begins_the_next_auto_on_its_own_side(sim):
    for alliance in ("blue", "red", "blue"):
        sim.alliance(alliance)
        sim.autonomous("own side", seconds=0.1)
        place, heading = ((14.041, 2.069), 0.0) if alliance == "red" else ((2.5, 6.0), 180.0)
        assert (sim.pose.X(), sim.pose.Y()) == pytest.approx(place, abs=0.01)
        assert abs(sim.pose.rotation().degrees()) == pytest.approx(heading, abs=0.5)
        assert apart(sim) < 0.01
        sim.disable(seconds=0.5)


def test_pieces_are_reset_for_a_later_auto(sim):
    sim.start()
    control, fuel = sim.physics.control, sim.pieces.on_field
    control.spawn("Fuel", [(8.0, 1.0)])
    sim.autonomous("red", seconds=0.1)
    assert sim.match.field_resets == 0 and sim.pieces.on_field == fuel + 1  # placed before any match was played
    sim.teleop(seconds=0.1)
    assert sim.match.field_resets == 0  # the match goes on
    sim.disable(seconds=0.1)
    sim.autonomous("red", seconds=0.1)
    assert sim.match.field_resets == 1 and sim.pieces.on_field == fuel
    sim.disable(seconds=0.1)
    control.reset_field()
    control.spawn("Fuel", [(8.0, 1.0)])
    sim.autonomous("red", seconds=0.1)
    assert sim.match.field_resets == 2 and sim.pieces.on_field == fuel + 1  # placed after people reset the field
""",
        command=("-m", "robotpy", "test", "--"),
        SLOW_START="1.0",
    )
    assert code == 0, said
