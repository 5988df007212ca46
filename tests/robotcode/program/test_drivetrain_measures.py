"""Dimensions of a drivetrain: sources, guesses and reported contradictions."""

import json
import math
from dataclasses import replace
from unittest.mock import MagicMock

import pytest
from each_case import each

from simcore.quantities import DeviceAddress
from simcore.robot_file.drivetrain_table import DrivetrainSettings
from simcore.robot_file.robot_settings import RobotSettings
from simcore.robotcode.program.drivetrain_measures import complete_measures, in_meters
from simcore.robotcode.program.drivetrain_model import drivetrain_config
from simcore.robotcode.program.found_drivetrain import FoundDrivetrain, FoundWheel, Measure, guesses
from simcore.robotcode.program.motor_controllers import BuiltDevice
from simcore.robotcode.program.project_settings import project_measures

PLACES = ((0.3, 0.3), (0.3, -0.3), (-0.3, 0.3), (-0.3, -0.3))
SPARK = BuiltDevice("SPARK MAX", DeviceAddress(1), None)
MOTORS = {"drive_motor": Measure("NEO", "usual", is_guess=True), "steer_motor": Measure("NEO", "usual", is_guess=True)}
PATHPLANNER = {
    "robotMass": 61.0,
    "robotMOI": 5.2,
    "driveWheelRadius": 0.048,
    "driveGearing": 5.9,
    "wheelCOF": 1.4,
    "driveMotorType": "vortex",
    **{f"{c}Module{a}": s * 0.3 for c, sx, sy in (("fl", 1, 1), ("fr", 1, -1), ("bl", -1, 1), ("br", -1, -1))
       for a, s in (("X", sx), ("Y", sy))},
}  # fmt: skip


def swerve(way: float | None, *, wired: bool = False, **measures: Measure) -> FoundDrivetrain:
    encoder = SPARK if wired else None
    wheels = tuple(
        FoundWheel(name=f"m{k}", place=p, motors=(SPARK,), steer=SPARK, encoder=encoder) for k, p in enumerate(PLACES)
    )
    own = {} if way is None else {"meters_per_rotor_turn": Measure(way, "positions")}
    return FoundDrivetrain(kind="swerve", wheels=wheels, measures={**MOTORS, **own, **measures})


@pytest.fixture
def planned(tmp_path):
    """Return a function that writes PathPlanner's settings into a project."""

    def write(**changed):
        path = tmp_path / "deploy" / "pathplanner"
        path.mkdir(parents=True, exist_ok=True)
        (path / "settings.json").write_text(json.dumps({**PATHPLANNER, **changed}))
        return tmp_path

    return write


def test_a_maxswerve_module_is_recognized_by_its_ratio(tmp_path):
    """It has pi 3 in / 4.71 m a turn and an encoder wired to the steer motor: REV's wheels, gears and NEO 550."""
    found = complete_measures(swerve(math.pi * 0.0762 / 4.71, wired=True), RobotSettings(), tmp_path)
    assert found.measure("wheel_radius") == pytest.approx(0.0381) and found.measure("drive_gearing") == pytest.approx(
        4.71
    )
    assert found.measure("steer_motor") == "NEO 550" and found.measure("steer_gearing") == pytest.approx(
        46.42, abs=0.01
    )
    assert found.measures["wheel_radius"].is_guess


def test_wheel_radius_and_gearing_give_the_distance_per_motor_turn_in_the_program(tmp_path):
    found = complete_measures(swerve(0.05), RobotSettings(), tmp_path)
    assert math.tau * found.measure("wheel_radius") / found.measure("drive_gearing") == pytest.approx(0.05)


@each(("unit", "size"), [("inches", 0.0254), ("centimeters", 0.01), ("millimeters", 0.001)])
def test_a_tank_drive_may_count_distance_in_another_unit(tmp_path, unit, size):
    """Wheels are 6 in at 8.45:1; the unit follows from the usual speed of robots."""
    way = math.tau * 0.0762 / 8.45
    found = replace(swerve(way / size), kind="tank")
    known = complete_measures(found, RobotSettings(), tmp_path)
    assert math.tau * known.measure("wheel_radius") / known.measure("drive_gearing") == pytest.approx(way)
    assert known.differences == () and f"in {unit}" in known.measures["drive_gearing"].source


@each(("unit", "size"), [("meters", 1.0), ("inches", 0.0254), ("millimeters", 0.001)])
@each("half", [0.25, 0.6])
def test_wheel_positions_are_converted_to_meters(unit, size, half):
    """Robots are 0.5 and 1.2 m wide, so wheels are 10 to 24 in or 250 to 600 mm off the center."""
    found = swerve(None)
    wheels = tuple(
        replace(wheel, place=tuple(math.copysign(half / size, c) for c in wheel.place)) for wheel in found.wheels
    )
    made = in_meters(replace(found, wheels=wheels))
    assert made.places[0] == pytest.approx((half, half)) and made.places[3] == pytest.approx((-half, -half))
    assert [unit in sentence for sentence in made.differences] == [True] * (unit != "meters")


def test_a_motor_with_and_without_foc_counts_as_one_model(planned):
    """FOC is a license and not a motor, so there is nothing to report."""
    for name, count in (("Kraken X60 FOC", 0), ("Kraken X44", 1)):
        said = swerve(None, drive_motor=Measure(name, "positions"))
        assert len(complete_measures(said, RobotSettings(), planned(driveMotorType="krakenX60")).differences) == count


def test_pathplanner_settings_override_an_implausible_distance_per_motor_turn(planned):
    """0.5 m a turn of the motor would be 47 m/s: it was not measured on the robot."""
    found = complete_measures(swerve(0.5), RobotSettings(), planned())
    assert (found.measure("drive_gearing"), found.measure("wheel_radius")) == (5.9, 0.048)
    assert any("odometry will be off by that much" in sentence for sentence in found.differences)


def test_pathplanner_settings_supply_values_that_the_program_lacks(planned):
    found = complete_measures(swerve(math.tau * 0.048 / 5.9), RobotSettings(), planned())
    assert [found.measure(n) for n in ("mass", "yaw_inertia", "wheel_cof", "wheel_radius")] == [61.0, 5.2, 1.4, 0.048]
    assert found.measure("drive_motor") == "NEO Vortex" and not found.measures["drive_motor"].is_guess
    assert found.differences == ()


def test_each_contradiction_is_reported_in_one_sentence(planned):
    folder = planned(driveGearing=6.75, flModuleX=0.35)
    found = complete_measures(swerve(math.tau * 0.048 / 5.9), RobotSettings(), folder)
    places, way = found.differences
    assert places == ("module positions in PathPlanner's settings differ by up to 0.050 m from those in the program")
    assert "a turn of a drive motor is 0.0447 m by wheel_radius 0.048 (PathPlanner's settings)" in way
    assert "but 0.0511 m by positions" in way


@pytest.mark.parametrize(("volts", "is_weak"), [(1.0, True), (11.4, False)])
def test_a_feed_forward_in_duty_cycle_is_reported(tmp_path, volts, is_weak):
    """MAXSwerve's velocityFF was 1 / free speed until REVLib 2026 took volts: 1 V where 12 V are needed."""
    found = swerve(0.05)
    found = replace(found, free_speed_volts=(Measure(volts, "SPARK MAX 11"),))
    known = complete_measures(found, RobotSettings(), tmp_path)
    assert [("SPARK MAX 11" in sentence and "1 V" in sentence) for sentence in known.differences] == [True] * is_weak


def test_the_robot_file_overrides_all_other_sources(planned):
    table = DrivetrainSettings(measures={"wheel_diameter": 0.1, "drive_motor": "Kraken X60"})
    settings = replace(RobotSettings(), drivetrain=table, mass=48.0, given=frozenset({"mass"}))
    found = complete_measures(swerve(None), settings, planned())
    assert (found.measure("wheel_radius"), found.measure("drive_motor"), found.measure("mass")) == (
        *(0.05, "Kraken X60"),
        48.0,
    )
    assert "mass is 48 (simcore.toml) but 61 (PathPlanner's settings)" in found.differences


def test_choreo_settings_are_read(tmp_path):
    folder = tmp_path / "deploy" / "choreo"
    folder.mkdir(parents=True)
    corner = {"x": {"exp": "11 in", "val": 0.2794}, "y": {"exp": "11 in", "val": 0.2794}}
    back = {"x": {"exp": "-11 in", "val": -0.2794}, "y": {"exp": "11 in", "val": 0.2794}}
    config = {"mass": {"exp": "150 lbs", "val": 68.0}, "inertia": {"val": 6.0}, "cof": {"val": 1.5},
              "frontLeft": corner, "backLeft": back, "radius": {"val": 0.0508}, "gearing": {"val": 6.75}}  # fmt: skip
    (folder / "auto.chor").write_text(json.dumps({"name": "auto", "config": config}))
    (measures,) = project_measures(tmp_path)
    assert {n: m.value for n, m in measures.items() if n != "places"} == {
        "mass": 68.0, "yaw_inertia": 6.0, "wheel_cof": 1.5, "wheel_radius": 0.0508, "drive_gearing": 6.75,
    }  # fmt: skip
    assert measures["places"].value[3] == (-0.2794, -0.2794)


def test_settings_that_are_not_json_are_ignored(tmp_path, caplog):
    path = tmp_path / "deploy" / "pathplanner"
    path.mkdir(parents=True)
    (path / "settings.json").write_text("{")
    assert project_measures(tmp_path) == [] and "is not read" in caplog.text


def test_an_implausible_distance_per_motor_turn_is_reported(tmp_path):
    """A NEO's 5676 rpm give 4.3 m/s, 13 without the wheel's circumference, and 0.17 with the gearing applied twice."""
    assert not any("m/s" in text for text in complete_measures(swerve(0.0455), RobotSettings(), tmp_path).differences)
    for way in (1.0 / 7.36, 0.0018):
        (text,) = complete_measures(swerve(way), RobotSettings(), tmp_path).differences
        assert f"{5676 / 60 * way:.3g} m/s at its free speed" in text and "circumference" in text


def test_a_conversion_factor_to_wheel_turns_is_not_read_as_meters(tmp_path):
    """1 / 8.45 m a turn would be 11 m/s; nothing is reported for a tank drive, whose odometry may multiply."""
    way = {"meters_per_rotor_turn": Measure(1.0 / 8.45, "conversion factor")}
    sides = tuple(FoundWheel(name=n, place=(0.0, y), motors=(SPARK,)) for n, y in (("left", 0.3), ("right", -0.3)))
    tank = FoundDrivetrain(kind="tank", wheels=sides, measures={**MOTORS, **way})
    for found in (tank, swerve(1.0 / 8.45)):
        done = complete_measures(found, RobotSettings(), tmp_path)
        assert done.measure("drive_gearing") == pytest.approx(8.45)
        assert done.measure("wheel_radius") == pytest.approx(0.0762 if found is tank else 0.0508)
        assert bool(done.differences) is (found is not tank)


@pytest.mark.parametrize(("said", "lowered"), [({}, (1, 4)), ({"dropped_center": False}, ())])
def test_a_tank_drive_has_a_dropped_center_unless_the_file_says_otherwise(said, lowered, tmp_path):
    hardware = MagicMock()  # read where REVLib is imported
    hardware.config_accessor.closed_loop.feed_forward.getk_s.return_value = 0.0
    motors = (replace(SPARK, hardware=hardware),)
    sides = tuple(FoundWheel(name=name, place=(0.0, y), motors=motors) for name, y in (("left", 0.3), ("right", -0.3)))
    found = FoundDrivetrain(kind="tank", wheels=sides, measures={"drive_motor": MOTORS["drive_motor"]})
    settings = RobotSettings(drivetrain=DrivetrainSettings(measures=said))
    config = drivetrain_config(complete_measures(found, settings, tmp_path), settings)
    assert config.lowered == lowered


@pytest.mark.parametrize("said", [None, False, True])
def test_the_forward_direction_is_a_guess_unless_the_file_gives_it(said, tmp_path):
    hardware = MagicMock()  # read where REVLib is imported
    hardware.config_accessor.closed_loop.feed_forward.getk_s.return_value = 0.0
    motors = (replace(SPARK, hardware=hardware),)
    sides = tuple(FoundWheel(name=name, place=(0.0, y), motors=motors) for name, y in (("left", 0.3), ("right", -0.3)))
    found = FoundDrivetrain(kind="tank", wheels=sides, measures={"drive_motor": MOTORS["drive_motor"]})
    table = DrivetrainSettings(measures={} if said is None else {"reversed": said})
    done = complete_measures(found, RobotSettings(drivetrain=table), tmp_path)
    assert [wheel.drive_sign for wheel in done.wheels] == [-1.0 if said else 1.0] * 2
    assert done.measures["reversed"].is_guess == (said is None)


def test_a_short_distance_per_motor_turn_means_smaller_wheels(tmp_path):
    """With usual wheels, 12 mm a turn would need 27:1, more than any gears; with wheels of 3 in it is 20:1."""
    found = complete_measures(swerve(0.012), RobotSettings(), tmp_path)
    assert found.measure("wheel_radius") == pytest.approx(0.0381) and found.measures["wheel_radius"].is_guess
    assert found.measure("drive_gearing") == pytest.approx(math.tau * 0.0381 / 0.012)
    assert "wheel_diameter 0.0762 (a common value)" in guesses(found), "as [drivetrain] has it"
