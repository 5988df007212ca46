"""Right to write a device on the real device simulation: claims, foreign writes, and released guesses."""

from __future__ import annotations

import json
import logging
import os
import sys
import time
from types import SimpleNamespace

import hal
from phoenix6 import configs, controls, hardware, signals, unmanaged

from simcore.quantities import DeviceAddress
from simcore.robot_file.robot_settings import RobotSettings
from simcore.robotcode.makers.phoenix6.ctre_maker import MAKER
from simcore.robotcode.makers.phoenix6.sensor_ports import own_writer
from simcore.robotcode.program.motor_controllers import BuiltDevice
from simcore.robotcode.program.ownership import Ownership
from simcore.robotcode.sim.device_assignment import DeviceAssignment, short_names


def reads(device: hardware.TalonFX, rotations: float) -> bool:
    """Return whether the device reads a rotor position within a second."""
    signal = device.get_rotor_position()
    for _ in range(50):
        time.sleep(0.02)
        if abs(signal.refresh().value - rotations) < 0.01:
            return True
    return False


def main() -> None:
    logging.basicConfig(stream=sys.stdout, level=logging.INFO)
    unmanaged.set_phoenix_diagnostics_start_time(-1)
    hal.initialize(500, 0)
    ownership = Ownership()
    MAKER.watch_simulations(ownership.may_write)
    ours, theirs = hardware.TalonFX(1), hardware.TalonFX(2)
    ownership.claim(("TalonFX", DeviceAddress(1)), "drivetrain")
    own_writer(ours.sim_state, "set_raw_rotor_position")(5.0)
    for _ in range(200):
        ours.sim_state.set_raw_rotor_position(9.0)
    theirs.sim_state.set_raw_rotor_position(9.0)
    said = {
        "lateness_ms": 0.0,
        "ours": reads(ours, 5.0),
        "theirs": reads(theirs, 9.0),
        "foreign": short_names(sorted(ownership.foreign)),
    }

    lead, follower, lone = hardware.TalonFX(10), hardware.TalonFX(11), hardware.TalonFX(12)
    opposed = signals.MotorAlignmentValue.OPPOSED
    follower.set_control(controls.Follower(10, opposed))
    config = configs.TalonFXConfiguration()
    config.feedback.sensor_to_mechanism_ratio = 4.0
    config.slot0.k_v, config.slot0.k_a, config.slot0.k_s = 0.5, 0.1, 0.2
    lead.configurator.apply(config)
    lone.set_control(controls.Follower(99, opposed))  # the leader does not exist
    devices = [d for d in MAKER.built() if d.address.number >= 10]
    groups = MAKER.groups(devices)
    said["groups"] = [str(g) for g in groups]
    said["opposed"] = list(groups[0].opposed)
    mechanism = MAKER.guess(groups[0]).mechanism
    said["time_constant"] = mechanism.time_constant
    # kS alone does not turn the motor, a little more does
    mechanism.set_volts(0.19)
    mechanism.step(0.1, 12.0)
    still = mechanism.velocity
    mechanism.set_volts(0.25)
    mechanism.step(0.1, 12.0)
    said["friction"] = [still, mechanism.velocity]

    steps: list[str] = []
    physics = SimpleNamespace(add_motor=lambda m: steps.append("add"), remove_motor=lambda m: steps.append("remove"))
    robot = SimpleNamespace(add_estimated_mechanism=lambda m: None, remove_estimated_mechanism=lambda m: None)
    assignment = DeviceAssignment(physics, robot, ownership, RobotSettings(), [("TalonFX", DeviceAddress(1))])
    for _ in range(6):
        assignment.after_tick()
    said["taken"] = list(steps)
    said["owners"] = [assignment.drivetrain, short_names(assignment.foreign), assignment.guessed]
    follower.sim_state.set_rotor_velocity(3.0)
    assignment.after_tick()
    said["given_back"] = steps[len(said["taken"]) :]
    said["guessed_after"] = assignment.guessed
    assert all(isinstance(d, BuiltDevice) for d in devices)
    print(json.dumps(said), flush=True)
    os._exit(0)


if __name__ == "__main__":
    main()
