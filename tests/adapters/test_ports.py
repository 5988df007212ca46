"""A robot of PWM controllers, roboRIO sensors, pneumatics, a servo, a relay and lights, described by simcore.toml."""

from __future__ import annotations

from pathlib import Path

import pytest

PORTS = Path(__file__).parent / "robots" / "ports"

IN_SIMULATED_TIME = """
import math

import pytest

A, X = 1, 3
TICK = 0.02


def test_every_port_follows_the_file(sim, caplog):
    caplog.set_level("INFO", "simcore")
    robot, plant = sim.robot, sim.robot_sim.mechanisms
    stick = sim.joystick(0)
    sim.teleop()

    # the hood homes on its switch and then goes to its goal; its sensors agree with the true angle
    sim.run_until(lambda: robot.facts()["is_homed"], timeout=1.0)
    assert 5.0 <= math.degrees(plant["hood"].position) < 5.0 + 0.4 + 120.0 * 2 * TICK  # code reads it in its next loop
    sim.run(0.6)
    hood, facts = math.degrees(plant["hood"].position), robot.facts()
    assert facts["hood"] == pytest.approx(20.0, abs=0.1) and facts["hood_rate"] == pytest.approx(0.0, abs=0.1)
    pulse = 360.0 / 2048.0 / 4.0
    assert hood - 5.0 == pytest.approx(facts["hood"], abs=0.4 + pulse)  # reset in the last 0.4 degrees
    assert facts["absolute"] == pytest.approx(300.0 + hood, abs=1e-6)
    assert facts["analog"] == pytest.approx(0.9 - 2.0 * hood / 360.0, abs=1e-6)
    assert facts["pot"] == pytest.approx(100.0 * (0.5 + 4.0 * (hood - 5.0) / 40.0) / 5.0 - 10.0, abs=1e-6)
    assert math.degrees(plant["latch"].position) == pytest.approx(45.0, abs=0.3)  # pulses are whole microseconds

    # the cylinder takes its stroke time, both roller motors push the same way, and fuel breaks the beams
    assert facts["beams"] == (False, False) and not facts["is_near"] and facts["range"] == pytest.approx(0.42)
    assert not facts["is_out"]
    stick.press(A)
    stick.axis(1, 0.5)
    took = sim.run_until(lambda: plant["deploy"].extension == 0.2, timeout=1.0)
    assert took == pytest.approx(0.4, abs=2 * TICK)
    assert plant["roller"].velocity > 0.8 * plant["roller"].gearbox.free_speed(8.0)
    seen = set()
    passed = False
    for _ in range(80):
        before = sim.pieces.held
        sim.run(TICK)
        held, facts = sim.pieces.held, robot.facts()
        seen.add(held)
        passed = passed or facts["passes"]
        if held == before:  # code reads values that are one tick old, and of CAN sensors two ticks
            assert facts["beams"][0] == (held >= 1)
        if held >= 3 and facts["beams"] == (True, True):
            break
    assert max(seen) >= 3 and passed
    stick.axis(1, 0.0)
    sim.run(0.6)  # the rollers run on and take the fuel in front of them; the last one passes the beam for 0.2 s
    sim.run_until(lambda: not robot.facts()["passes"], timeout=1.0)
    facts = robot.facts()
    assert facts["is_out"] and facts["is_near"] and facts["range"] == pytest.approx(0.06, abs=1e-3)
    assert not facts["passes"]

    # telemetry has sensors and lights
    snapshot = sim.match.snapshot()
    sensors = {key.split("/")[-1]: on for key, on in snapshot.booleans.items() if "/Sensors/" in key}
    assert sensors == {
        "AnyFuel": True, "ThreeFuel": True, "Passing": False, "TwoFuel": True, "HoodDown": False, "DeployOut": True
    }
    assert snapshot.strings["Sim/Lights/CANdle40/Shows"] == "SolidColor 0-7 #00FF00, RainbowAnimation 8-37"
    assert snapshot.integer_arrays["Sim/Lights/CANdle40/Colors"].tolist() == [0x00FF00] * 8 + [-1] * 30
    assert snapshot.integer_arrays["Sim/Lights/AddressableLED7/Colors"].tolist() == [200] * 4

    # the relay feeds, and the beams clear with the last fuel; when disabled, PWM, relay and servo stop
    held = sim.pieces.held
    stick.release(A)
    stick.press(X)
    sim.run_until(lambda: sim.pieces.held == 0, timeout=1.0 + 0.2 * held)
    sim.run(2 * TICK)
    assert robot.facts()["beams"] == (False, False)
    assert plant["kicker"].velocity > 0.8 * plant["kicker"].gearbox.free_speed(12.0)
    assert math.degrees(plant["latch"].position) == pytest.approx(135.0, abs=0.3)
    assert plant["deploy"].extension == 0.0
    stick.press(A)
    sim.run(0.2)
    sim.disable(seconds=0.5)
    assert [plant[name].velocity for name in ("roller", "kicker", "latch")] == pytest.approx([0.0] * 3, abs=0.01)
    assert math.degrees(plant["latch"].position) == pytest.approx(135.0, abs=0.3)
    assert plant["deploy"].extension == 0.2  # a double solenoid stays, so the rod moves on
    assert sim.match.snapshot().strings["Sim/Lights/CANdle40/Shows"].startswith("SolidColor 0-7 #FF0000")

    said = " ".join(caplog.text.split())  # includes devices that nothing simulates
    for words in (
        "'roller': PWM 0 1",
        "'deploy': REVPH 1 Solenoid 0 1",
        "'hood encoder', encoder of 'hood': DIO 0 1",
        "lights CANdle 40, PWM 7 (AddressableLED): shown as Sim/Lights in telemetry",
        "not moved REVPH 1 Solenoid 2 (Solenoid), PWM 5 (VictorSP), DIO 9 (DigitalInput), Analog 3 (AnalogInput)",
    ):
        assert words in said, said
"""


@pytest.mark.slow
def test_every_port_of_a_described_robot_has_the_device_in_its_file(project_of):
    code, said = project_of(PORTS)(IN_SIMULATED_TIME, "-rP")
    assert code == 0, said
