"""What `simcore check` finds in the robot of REBUILT after one mistake each."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from games.rebuilt import REBUILT
from games.reefscape import REEFSCAPE
from games.reefscape.robot import reefscape_robot
from simcore.geometry.linkage import Joint
from simcore.pieces.hopper import HopperConfig
from simcore.pieces.intake import IntakeZone
from simcore.robot.climber import ClimberConfig
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import ElevatorConfig
from simcore.robot_file.mechanism_runs import CodeView, run_mechanism
from simcore.robot_file.robot_findings import findings, run_findings, shot_reach
from simcore.units import GRAVITY

ROBOT = REBUILT.robot()


def found(robot=ROBOT, game=REBUILT, **codes):
    return [finding.text for finding in findings(robot, game=game, codes=codes) if finding.is_wrong]


def with_intake(**change):
    zone = IntakeZone(**{"x_min": -0.5, "x_max": -0.35, "y_min": -0.3, "y_max": 0.3, "z_max": 0.2, **change})
    return replace(ROBOT, intakes=(replace(ROBOT.intakes[0], zone=zone, stretch=None, deploy=None),))


def with_shooter(**change):
    launch = {key: change.pop(key) for key in ("height", "forward", "heading", "pivot_x") if key in change}
    (shooter,) = ROBOT.shooters
    return replace(ROBOT, shooters=(replace(shooter, launch=replace(shooter.launch, **launch), **change),))


def with_climber(height, mass=2.0, gearing=60.0):
    lift = ElevatorConfig(
        gearbox=GearboxConfig(motor=motor("Kraken X60"), gearing=gearing, stator_current_limit=60.0),
        carriage_mass=mass, drum_radius=0.02, max_height=height,
    )  # fmt: skip
    joint = Joint(mechanism="lift", axis=(0.0, 0.0, 1.0), origin=(0.0, 0.0, 0.3), slides=True, ratio=0.02)
    return replace(
        ROBOT, mechanisms={**ROBOT.mechanisms, "lift": lift}, climbers=(ClimberConfig(joints=(joint,)),)
    )  # fmt: skip


def test_nothing_is_wrong_with_the_robot_of_the_game():
    assert found() == [] and found(with_intake()) == [] and found(with_climber(0.5)) == []


def test_more_fuel_than_the_hopper_has_space_for_is_a_note():
    notes = [finding.text for finding in findings(ROBOT, game=REBUILT, codes={})]
    assert not any("do not fit" in note for note in notes)
    flat = replace(ROBOT, storage=replace(ROBOT.storage, high=(0.17, 0.30, 0.50)))
    (note,) = (f for f in findings(flat, game=REBUILT, codes={}) if "do not fit" in f.text)
    assert "storage: 50 Fuel do not fit in its room of 0.53 x 0.60 x 0.32 m, 21 do" in note.text and not note.is_wrong
    fits = replace(flat, storage=replace(flat.storage, capacity=21))
    assert not any("do not fit" in f.text for f in findings(fits, game=REBUILT, codes={}))


def test_an_outlet_that_jams_or_lets_nothing_out_is_told():
    for width, height, said, is_wrong in (
        (0.4, None, "", False), (0.24, None, "its outlet is 1.6 Fuel wide: below 2 two of them can jam it", False),
        (0.14, None, "its outlet is smaller than a Fuel: none comes out", True),
        (0.4, 0.1, "its outlet is smaller than a Fuel: none comes out", True),
    ):  # fmt: skip
        with_hopper = replace(ROBOT.storage, hopper=HopperConfig(outlet_width=width, outlet_height=height))
        notes = [f for f in findings(replace(ROBOT, storage=with_hopper), game=REBUILT, codes={}) if "outlet" in f.text]
        assert [(f.text, f.is_wrong) for f in notes] == ([(f"storage: {said}", is_wrong)] if said else [])


def test_a_tube_passes_the_outlet_of_a_hopper_as_the_ball_around_it():
    robot = reefscape_robot()
    for width, said in (
        (0.33, []),
        (0.2, ["storage: its outlet is smaller than a Coral, which counts as a ball of 0.32 m in it: none comes out"]),
    ):
        narrow = replace(robot, storage=replace(robot.storage, hopper=HopperConfig(outlet_width=width)))
        assert [text for text in found(narrow, REEFSCAPE) if "outlet" in text] == said


@pytest.mark.parametrize(
    ("robot", "said"),
    [
        (with_intake(x_min=-0.38, x_max=-0.2), "intake 1 is inside of the bumpers, which no piece passes"),
        (with_intake(x_min=0.3, x_max=0.45), "intake 1 ends 50 mm before the bumpers; the middle of a piece that"),
        (with_intake(z_max=0.05), "intake 1 ends 0.05 m above the floor; the middle of a piece there is at 0.075 m"),
        (with_shooter(forward=0.55), "shooter 1: its muzzle is 150 mm outside of the robot, at (0.55, 0.08) m"),
        (with_shooter(forward=0.45, heading=math.pi), "at (-0.45, -0.08) m"),
        (with_shooter(wheel_radius=0.005), "shooter 1 reaches nothing: at 12 V pieces leave at 2.3 m/s"),
        (with_shooter(min_wheel_speed=1000.0), "shooter 1 never throws: its wheels turn 150.8 times a second at 12 V"),
        (with_shooter(elevation_per_hood=1.0), "shooter 1 shoots at 130 to 175 deg over the hood's travel"),
        (with_climber(0.3), "climber 1 reaches no rung: its hook comes to 0.60 m, and the lowest rung is at 0.69 m"),
        (with_climber(0.5, gearing=5.0), "climber 1 cannot lift the robot: lift pulls with"),
    ],
)
def test_a_mistake_is_named(robot, said):
    assert any(said in text for text in found(robot)), found(robot)


def test_the_program_s_current_limit_counts():
    (text,) = found(hood=CodeView(stator_limit=0.5))
    assert text.startswith("hood cannot hold itself: its weight needs ") and text.endswith("at their limit of 0.5 A")


def test_without_a_game_only_the_robot_is_looked_at():
    assert found(with_intake(z_max=0.05), game=None) == []
    texts = [finding.text for finding in findings(with_climber(0.5), game=replace(REBUILT, field=replace(
        REBUILT.field, rungs=())), codes={})]  # fmt: skip
    assert texts == ["a climber finds nothing in REBUILT: its field has no rungs"]


def test_a_shooter_s_reach_is_that_of_the_throw_in_a_vacuum():
    """v = 12 V free speed times rim and efficiency; h + v^2 / 2g straight up, v^2 / g at 45 degrees."""
    reach = shot_reach(ROBOT.shooters[0], ROBOT)
    speed = ROBOT.mechanisms["shooter"].gearbox.free_speed(12.0) * 0.05 * 0.49
    assert reach.speed == pytest.approx(speed)
    assert reach.elevations == pytest.approx((math.radians(45.0), math.radians(90.0)))
    assert reach.rise == pytest.approx(0.55 + speed**2 / (2.0 * GRAVITY))
    assert reach.distance == pytest.approx(speed**2 / GRAVITY)


def test_soft_limits_and_ratios_that_do_not_fit():
    rack = ROBOT.mechanisms["intake_deploy"]

    def said(**code):
        run = run_mechanism("rack", rack, code=CodeView(**{"reading": 0.0, "ratio": 10.0, **code}))
        return [finding.text for finding in run_findings([run])]

    assert said() == []
    (crossed,) = said(lower_limit=2.0, upper_limit=1.0)
    assert crossed == "rack: its forward soft limit (1) is not above its reverse one (2): it cannot move"
    (beyond,) = said(upper_limit=-0.5)
    assert beyond == "rack starts beyond its forward soft limit: the code reads 0 turns and allows -0.5"
    (ratio,) = said(ratio=12.5)
    assert ratio.endswith("divides the rotor's turns by 12.5: it reads 0.8 turns per turn of the mechanism")
