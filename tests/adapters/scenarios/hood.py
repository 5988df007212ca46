"""The example's hood on two real TalonFX, one told of gravity and one not: who holds 42.2 degrees?

Ten times as heavy, so that the 0.01 V in which the device gives its voltage do not show.
"""

from __future__ import annotations

import math
from dataclasses import replace

from phoenix6 import configs, controls, hardware, signals
from realtime import DT, Loop, enable, report, start

from games.rebuilt.robot import MECHANISMS
from simcore.phoenix6.talon_motor import MotorType, TalonFXMotorSim
from simcore.robot.mechanisms import ArmSim

STEP = 1.0 / 2048.0  # turn; a position request goes out cut to whole steps, downwards
GOAL = 240 * STEP * math.tau  # 42.2 degrees
KP = 50.0  # V per turn; soft, so that what gravity does can be seen


HEAVY = replace(MECHANISMS["hood"], mass=12.0, inertia=0.5)


def hood(number: int, k_g: float) -> tuple[hardware.TalonFX, TalonFXMotorSim]:
    plant = replace(HEAVY, start_angle=GOAL)
    config = configs.TalonFXConfiguration()
    config.motor_output.inverted = signals.InvertedValue.CLOCKWISE_POSITIVE
    config.feedback.sensor_to_mechanism_ratio = plant.gearbox.gearing
    config.slot0.k_p = KP
    config.slot0.k_g = k_g
    config.slot0.gravity_type = signals.GravityTypeValue.ARM_COSINE
    device = hardware.TalonFX(number)
    assert device.configurator.apply(config, 0.2).is_ok()
    sim = TalonFXMotorSim(device, ArmSim(plant), motor_type=MotorType.KRAKEN_X44)
    return device, sim


def main() -> None:
    start()
    level = HEAVY.gearbox.holding_volts(HEAVY.mass * HEAVY.gravity * HEAVY.center_of_mass)
    pairs = {"without": hood(1, 0.0), "with": hood(2, level)}

    def step() -> None:
        for _, sim in pairs.values():
            sim.update(DT)

    loop = Loop(step)
    enable()
    for device, _ in pairs.values():
        device.set_control(controls.PositionVoltage(240.5 * STEP))
    loop.run(2.5)
    report(
        loop,
        goal_deg=math.degrees(GOAL),
        kp=KP,
        level_volts=level,
        end_deg={name: math.degrees(sim.mechanism.position) for name, (_, sim) in pairs.items()},
        told_deg={name: 360.0 * device.get_position().value for name, (device, _) in pairs.items()},
    )


if __name__ == "__main__":
    main()
