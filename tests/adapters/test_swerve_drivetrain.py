"""CTRE's `SwerveDrivetrain` on the model and the engine, with the real Phoenix 6 simulation in real time."""

from __future__ import annotations

import math

import pytest

pytestmark = [pytest.mark.slow, pytest.mark.realtime]


@pytest.fixture(scope="module", params=[(), ("1",), ("2", "bare")], ids=["generated", "random", "bare devices"])
def run(request, scenario):
    """Inversions and offsets as the generator writes them, and at random for drive, steer and encoder."""
    return scenario("swerve", *request.param)


def test_the_speed_that_the_drivetrain_reports_is_the_true_one(run):
    """Without skid wheels roll: 2 % of the speed, or 1 cm/s of noise across it."""
    for row in run["steady"]:
        true, told = row["seen"][:3], row["seen"][3:]
        size = math.hypot(true[0], true[1])
        assert math.dist(true[:2], told[:2]) < max(0.02 * size, 0.02), row
        assert told[2] == pytest.approx(true[2], rel=0.02, abs=0.02), row


def test_the_robot_does_what_robot_code_asks(run):
    """Open-loop voltage, 12 V for 4.69 m/s; friction and rolling resistance take the same volts of each wheel."""
    for row in run["steady"]:
        asked = row["asked"]
        share = share_of_speed(run, *asked)
        assert row["seen"][:3] == pytest.approx([share * one for one in asked], abs=0.02), row


def share_of_speed(run, vx, vy, omega):
    """Of what is asked, where the wheels' forces have no power: sum v_i (V_i - V_friction - k share v_i) = 0.

    Wheels roll on circles about one center, so all have the same share of their speeds.
    """
    speeds = [math.hypot(vx - omega * y, vy + omega * x) for x, y in run["wheels"]]
    volts = 12.0 / 4.69 - run["friction_volts"] * sum(speeds) / sum(v * v for v in speeds)
    return run["speed_per_volt"] * volts


def test_odometry_follows_an_s_curve(run):
    way = run["way"]
    assert way > 6.0
    assert math.dist(run["true_change"][:2], run["odometry_change"][:2]) < 0.02 * way
    assert run["odometry_change"][2] == pytest.approx(run["true_change"][2], abs=0.01)


def test_the_pigeon_counts_the_turns_that_were_made(run):
    """Within a control frame of the last tick; the model of this gyro has no error."""
    assert run["pigeon_deg"] == pytest.approx(run["true_yaw_deg"], abs=0.1)


def test_resetting_the_pose_moves_nothing_but_odometry(run):
    assert run["pose_after_reset"] == pytest.approx([3.0, 1.0, 0.5], abs=1e-3)
    assert run["odometry_after_reset"] == pytest.approx([7.0, -2.0, 1.0], abs=1e-3)


def test_a_wall_stops_the_robot_and_loads_its_motors(run):
    """The wall's face is at x = 12.9, the bumper 0.4 ahead of the center."""
    assert run["x_at_wall"] == pytest.approx(12.5, abs=0.02)
    assert run["amps_at_wall"] > 30.0


def test_a_disabled_robot_brakes_to_a_stop(run):
    assert run["speed_disabled"] < 0.01
    assert 12.0 < run["volts"] < 12.9


def test_mistakes_are_named(scenario):
    said = scenario("swerve_errors")
    assert "import simcore.phoenix6.swerve at the top of physics.py" in said["early"]
    assert "4 modules in the drivetrain" in said["fewer"] and "3 in the model" in said["fewer"]
    assert "module 3 drive_motor: TalonFX 1 is already module 0 drive_motor" in said["twice"]
