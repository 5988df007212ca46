"""Gyros of every maker on a model that turns left at 1 rad/s, tilted: sign, scale, reset and rate."""

from __future__ import annotations

import math
from importlib.util import find_spec

import pytest

NAVX = ("navx", "navx-usb", "navx-i2c", "navx-created")
ADIS = ("ADIS16448_IMU", "ADIS16470_IMU")
PACKAGES = dict.fromkeys((*NAVX, "navx3"), "navx")
TOGETHER = (("navx", "navx-usb", "navx-i2c", *ADIS, "ADXRS450_Gyro", "AnalogGyro"), ("navx-created", "navx3"))
"""Gyros that can share a process: two on one port would be one device."""
CLOCKWISE = (*NAVX, "ADXRS450_Gyro", "AnalogGyro")
"""Gyros with clockwise-positive `getAngle`, as their makers document."""
PITCH, ROLL = math.degrees(0.1), math.degrees(-0.05)


@pytest.fixture(scope="module")
def rows(scenario):
    """Return a function that returns the readings of a gyro by its name."""
    shown: dict[str, dict] = {}

    def get(name: str) -> dict:
        package = PACKAGES.get(name, "wpilib")
        if find_spec(package) is None:
            pytest.skip(f"needs {package}: pip install .[{package}]")
        if name not in shown:
            names = next(names for names in TOGETHER if name in names)
            shown.update(scenario("gyros", *(n for n in names if find_spec(PACKAGES.get(n, "wpilib")))))
        return shown[name]

    return get


@pytest.mark.parametrize("name", [*NAVX, *ADIS, "ADXRS450_Gyro", "AnalogGyro"])
def test_a_gyro_keeps_its_makers_sign_after_a_reset(rows, name):
    shown = rows(name)["rows"]
    sign = -1.0 if name in CLOCKWISE else 1.0
    for moment, angle in (("start", 0.0), ("4 s", 4.0), ("reset", 0.0), ("1 s later", 1.0)):
        assert shown[moment]["getAngle"] == pytest.approx(sign * math.degrees(angle), abs=1e-6), moment
        if "rotation" in shown[moment]:  # always counter-clockwise positive
            assert shown[moment]["rotation"] == pytest.approx(angle, abs=1e-6), moment
    assert shown["4 s"]["getRate"] == pytest.approx(sign * math.degrees(1.0), abs=0.1)
    assert shown["start"]["getRate"] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("name", NAVX)
def test_a_navx_wraps_its_yaw_and_reports_tilt_according_to_its_manual(rows, name):
    """Nose down is negative pitch, right side down negative roll: pitch 0.1 rad, roll -0.05 rad in WPILib's axes."""
    shown = rows(name)["rows"]
    assert shown["4 s"]["getYaw"] == pytest.approx(360.0 - math.degrees(4.0))
    assert shown["4 s"]["getPitch"] == pytest.approx(-PITCH)
    assert shown["4 s"]["getRoll"] == pytest.approx(-ROLL)
    # a software reset leaves the quaternion
    assert shown["1 s later"]["yaw of rotation 3d"] == pytest.approx(5.0 - math.tau, abs=0.01)
    assert rows(name)["number"] == {"navx": 4, "navx-created": 4, "navx-usb": 2, "navx-i2c": 1}[name]


@pytest.mark.parametrize("name", ADIS)
def test_an_adis_reports_roll_about_its_x_axis_and_pitch_about_its_y_axis(rows, name):
    shown = rows(name)["rows"]["1 s later"]
    assert shown["getXComplementaryAngle"] == pytest.approx(ROLL)
    assert shown["getYComplementaryAngle"] == pytest.approx(PITCH)


def test_a_navx3_wraps_its_yaw_counter_clockwise_and_keeps_its_angle_over_a_reset(rows):
    shown = rows("navx3")["rows"]
    assert shown["4 s"]["getYaw"] == pytest.approx(math.degrees(4.0) - 360.0, abs=1e-4)
    assert shown["4 s"]["getPitch"] == pytest.approx(PITCH, abs=1e-5)
    assert shown["4 s"]["getRate"] == pytest.approx(math.degrees(1.0), abs=1e-4)
    assert shown["reset"]["getYaw"] == 0.0
    assert shown["1 s later"]["getYaw"] == pytest.approx(math.degrees(1.0), abs=1e-4)
    assert shown["1 s later"]["rotation"] == pytest.approx(1.0, abs=1e-6)
    assert shown["1 s later"]["getAngle"] == pytest.approx(math.degrees(5.0), abs=1e-4)
