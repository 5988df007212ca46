"""Measure the cost of simulated devices: 12 TalonFX, 4 CANcoder and a Pigeon 2, per 20 ms tick of the robot.

    python scripts/emulator_figures.py

Four steering loops on CANcoders, four velocity loops, two open loops and two profiles, all with new set points every
tick. Only the time inside `Emulator.step` counts: control loops, output stages and status frames.
"""

from __future__ import annotations

import argparse
import os
import statistics
import sys
import time

from phoenix6 import CANBus, configs, controls, hardware, signals, unmanaged

from simcore import season
from simcore.robotcode import emulator

BUDGET_MS = 1.0
TICKS = 300


def main() -> None:
    """Measure at 1 kHz and at 200 Hz, and print."""
    season.wpilib_simulation.pause_timing()
    world = emulator.install(delays=emulator.EnableDelays(enable=0.0, disable=0.0))
    bus = CANBus("rio")
    for k in range(4):
        hardware.CANcoder(k, bus)
    hardware.Pigeon2(0, bus)
    talons = [hardware.TalonFX(k, bus) for k in range(12)]
    for k, talon in enumerate(talons):
        config = configs.TalonFXConfiguration()
        config.slot0.with_k_p(50.0 if k < 4 else 0.2).with_k_v(0.12).with_k_s(0.1)
        config.motion_magic.with_motion_magic_cruise_velocity(10).with_motion_magic_acceleration(40)
        if k < 4:
            config.feedback.feedback_remote_sensor_id = k
            config.feedback.feedback_sensor_source = signals.FeedbackSensorSourceValue.FUSED_CANCODER
            config.feedback.rotor_to_sensor_ratio = 12.8
            config.closed_loop_general.continuous_wrap = True
        talon.configurator.apply(config)
    steer, wheel, volts = controls.PositionVoltage(0.0), controls.VelocityVoltage(0.0), controls.VoltageOut(0.0)
    magic = controls.MotionMagicVoltage(0.0)
    inside = [world.talon(k) for k in range(12)]
    for dt in (0.001, 0.005):
        spent = []
        for tick in range(TICKS):
            unmanaged.feed_enable(0.1)
            for k, talon in enumerate(talons):
                x = 0.01 * tick + k
                talon.set_control(
                    (steer.with_position(x), wheel.with_velocity(50 + x), volts.with_output(3 + 0.1 * x),
                     magic.with_position(x))[(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 3, 3)[k]]
                )  # fmt: skip
            took = 0.0
            for step in range(round(0.020 / dt)):
                for talon in inside:
                    talon.raw = 0.3 * tick + 0.01 * step
                    talon.rotor_rps = 40.0 + 0.1 * step
                begin = time.perf_counter()
                world.step(dt)
                took += time.perf_counter() - begin
            spent.append(1e3 * took)
        rate = round(1.0 / dt)
        middle, worst = statistics.median(spent), sorted(spent)[int(0.99 * TICKS)]
        loops = 12 * round(0.020 / dt)
        print(
            f"12 TalonFX, 4 CANcoder, Pigeon 2, stepped at {rate} Hz: {middle:.2f} ms per 20 ms tick "
            f"(p99 {worst:.2f} ms, {1e3 * middle / loops:.1f} us per motor and step; budget {BUDGET_MS:.1f} ms)"
        )


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__.partition("\n")[0]).parse_args()
    main()
    sys.stdout.flush()
    os._exit(0)  # without waiting for the HAL's threads
