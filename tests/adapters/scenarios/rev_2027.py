"""REVLib 2027 in stepped time: turns and RPM, and SimDevices named by port and id."""

from __future__ import annotations

import json
import math
import os

import hal
import rev
import wpilib
from wpilib.simulation import DriverStationSim, pause_timing, step_timing

from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import ShaftSim
from simcore.robotcode.makers.revlib.rev_maker import MAKER
from simcore.robotcode.makers.revlib.spark_motor import SparkMotorSim

CT = rev.SparkLowLevel.ControlType
DT = 0.005
PORT = wpilib.CANPort.CAN_S1
numbers = iter(range(1, 60))


def spark(setup=lambda c: None, cls=rev.SparkMax, port=PORT, number=None):
    made = cls(port, number or next(numbers), rev.SparkLowLevel.MotorType.BRUSHLESS)
    config = rev.SparkMaxConfig() if cls is rev.SparkMax else rev.SparkFlexConfig()
    setup(config)
    made.configure(config, rev.ResetMode.RESET_SAFE_PARAMETERS, rev.PersistMode.PERSIST_PARAMETERS)
    return made


def shaft(gearing, inertia, motors=1, **more):
    return ShaftSim(GearboxConfig(motor=motor("NEO"), motors=motors, gearing=gearing), inertia, **more)


def run(sim, seconds):
    for _ in range(round(seconds / DT)):
        sim.update(DT, 12.0)


def main():
    hal.initialize()
    pause_timing()
    DriverStationSim.set_ds_attached(True)
    DriverStationSim.set_robot_mode(hal.RobotMode.AUTONOMOUS)
    DriverStationSim.set_enabled(True)
    DriverStationSim.notify_new_data()
    step_timing(0.02)
    facts = {"lateness_ms": 0.0}

    turned = shaft(2.0, 0.004)
    made = spark(lambda c: c.smart_current_limit(200))
    sim = SparkMotorSim(made, turned)
    made.set_throttle(0.5)
    run(sim, 0.15)
    facts["speed"], facts["rpm"] = turned.velocity, made.get_encoder().get_velocity().get()
    facts["turns"], facts["shaft"] = made.get_encoder().get_position().get(), turned.position
    facts["expected"] = 6.0 / turned.gearbox.volts_per_speed * -math.expm1(-0.15 / turned.time_constant)

    azimuth = shaft(12.8, 0.004, position=math.radians(350.0))

    def on_absolute(c):
        c.inverted(True).closed_loop.set_feedback_sensor(rev.FeedbackSensor.ABSOLUTE_ENCODER).pid(2.0, 0, 0)
        c.closed_loop.position_wrapping_enabled(True)

    steer = spark(on_absolute, rev.SparkFlex)
    sim = SparkMotorSim(steer, azimuth, zero_at=math.radians(350.0))
    loop = steer.get_closed_loop_controller()
    loop.set_setpoint(20.0 / 360.0, CT.POSITION)
    run(sim, 1.0)
    facts["azimuth"] = [math.degrees(azimuth.position), 360.0 * steer.get_absolute_encoder().get_position().get()]

    centered = spark(lambda c: c.absolute_encoder.zero_centered(True))
    SparkMotorSim(centered, shaft(1.0, 0.01, position=math.radians(-30.0)))
    facts["centered"] = 360.0 * centered.get_absolute_encoder().get_position().get()

    def profiled(c):
        c.closed_loop.pid(0.5, 0, 0).allowed_closed_loop_error(0.05, rev.ClosedLoopSlot.SLOT0)
        c.closed_loop.max_motion.cruise_velocity(1200.0).max_acceleration(2400.0)

    slide = spark(profiled)
    sim = SparkMotorSim(slide, shaft(5.0, 0.005))
    loop = slide.get_closed_loop_controller()
    loop.set_setpoint(20.0, CT.MAX_MOTION_POSITION_CONTROL)
    track = []
    for _ in range(400):
        sim.update(DT, 12.0)
        track.append(loop.get_max_motion_setpoint_position().get())
    facts["profile"] = [track[round(t / DT) - 1] for t in (0.25, 0.75, 1.25, 2.0)]
    facts["arrived"] = [slide.get_encoder().get_position().get(), loop.is_at_setpoint().get()]

    lead = spark(lambda c: c.smart_current_limit(60))
    opposed = spark(lambda c: c.follow(lead, True))
    group = next(g for g in MAKER.groups(MAKER.built()) if g.leader.hardware is lead)
    facts["group"] = [len(group.followers), list(group.opposed)]
    sim = SparkMotorSim(lead, shaft(1.0, 0.005, motors=2), followers=[opposed], opposed=group.opposed)
    lead.set_throttle(0.25)
    run(sim, 1.0)
    facts["followed"] = [made.get_encoder().get_velocity().get() for made in (lead, opposed)]

    one, other = (spark(port=port, number=60) for port in (PORT, wpilib.CANPort.CAN_S2))
    stray = spark(lambda c: c.follow(one, False), port=wpilib.CANPort.CAN_S2, number=59)
    near = spark(lambda c: c.follow(one, False), number=59)
    sims = [SparkMotorSim(made, shaft(1.0, 0.005)) for made in (one, other)]
    one.set_throttle(0.5)
    other.set_throttle(-0.25)
    for sim in sims:
        run(sim, 0.5)
    facts["two buses"] = [made.get_encoder().get_position().get() for made in (one, other)]
    facts["devices"] = [str(MAKER.device_of(made)) for made in (one, other)]
    facts["groups"] = [str(g) for g in MAKER.groups([MAKER.device_of(made) for made in (one, other, stray, near)])]
    print(json.dumps(facts), flush=True)
    os._exit(0)  # whichever threads REVLib has started


main()
