"""SPARKs on mechanisms in stepped time, compared with REVLib's `SparkSim.iterate` and with closed forms."""

from __future__ import annotations

import json
import math
import os

import hal
import rev
from wpilib.simulation import DriverStationSim, pauseTiming, stepTiming
from wpimath.system.plant import DCMotor

from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import ShaftSim
from simcore.robotcode.makers.revlib.rev_maker import MAKER
from simcore.robotcode.makers.revlib.spark_configuration import read_spark_configuration
from simcore.robotcode.makers.revlib.spark_loop import Command, SparkLoop
from simcore.robotcode.makers.revlib.spark_motor import SparkMotorSim

CT = rev.SparkLowLevel.ControlType
SLOT = rev.ClosedLoopSlot.kSlot0
DT = 0.005
NEO = DCMotor.NEO(1)
numbers = iter(range(1, 60))


def spark(setup=lambda c: None, cls=rev.SparkMax, number=None):
    made = cls(number or next(numbers), rev.SparkLowLevel.MotorType.kBrushless)
    config = rev.SparkMaxConfig() if cls is rev.SparkMax else rev.SparkFlexConfig()
    setup(config)
    made.configure(config, rev.ResetMode.kResetSafeParameters, rev.PersistMode.kPersistParameters)
    return made


def enable(on=True):
    DriverStationSim.setAutonomous(True)
    DriverStationSim.setEnabled(on)
    DriverStationSim.notifyNewData()
    stepTiming(0.02)


def neo(gearing=1.0, motors=1, motor=NEO):
    return GearboxConfig(motor=motor, motors=motors, gearing=gearing)


def run(motors, seconds, supply=12.0):
    for _ in range(round(seconds / DT)):
        for motor in motors:
            motor.update(DT, supply)


def beside_iterate():
    """Return the settled output of a mechanism at rest, from REVLib's model and from ours."""
    rows = {
        "proportional": (lambda c: c.closedLoop.pid(0.1, 0, 0), CT.kPosition, 1.5, 0.0, 12.0),
        "proportional at 10 V": (lambda c: c.closedLoop.pid(0.1, 0, 0), CT.kPosition, 1.5, 0.0, 10.0),
        "compensated": (
            lambda c: c.voltageCompensation(10).closedLoop.pid(0.1, 0, 0), CT.kPosition, 1.0, 0.0, 12.0,
        ),
        "wrapped": (
            lambda c: c.closedLoop.pid(0.1, 0, 0).positionWrappingEnabled(True).positionWrappingInputRange(0, 1),
            CT.kPosition, 0.9, 0.1, 12.0,
        ),
        "range": (lambda c: c.closedLoop.pid(1, 0, 0).outputRange(-0.3, 0.4), CT.kPosition, 5.0, 0.0, 12.0),
        "kV": (lambda c: c.closedLoop.feedForward.kV(0.001), CT.kVelocity, 1000.0, 0.0, 10.0),
        "kS": (lambda c: c.closedLoop.feedForward.kS(0.6), CT.kVelocity, -1000.0, 0.0, 12.0),
        "kS in position": (lambda c: c.closedLoop.feedForward.kS(0.6), CT.kPosition, -1.0, 0.0, 12.0),
        "kG": (lambda c: c.closedLoop.feedForward.kG(0.6), CT.kPosition, 0.0, 0.0, 12.0),
        "kCos": (lambda c: c.closedLoop.feedForward.kCos(0.6), CT.kPosition, 0.0, 0.0, 12.0),
        "soft limit": (
            lambda c: c.softLimit.forwardSoftLimit(1).forwardSoftLimitEnabled(True), CT.kDutyCycle, 0.5, 2.0, 12.0,
        ),
        "volts": (lambda c: None, CT.kVoltage, 3.0, 0.0, 10.0),
        "duty": (lambda c: c.voltageCompensation(8), CT.kDutyCycle, 0.5, 0.0, 10.0),
        "within the allowed error": (
            lambda c: c.closedLoop.pid(0.1, 0, 0).allowedClosedLoopError(0.5, SLOT), CT.kPosition, 0.3, 0.0, 12.0,
        ),
    }  # fmt: skip
    answer = {}
    for name, (setup, mode, setpoint, position, bus) in rows.items():
        made = spark(setup)
        sim, loop = rev.SparkMaxSim(made, NEO), SparkLoop(read_spark_configuration(made))
        sim.setPosition(position)
        made.getClosedLoopController().setSetpoint(setpoint, mode)
        for _ in range(300):  # its current limiter releases the output slowly
            sim.iterate(0.0, bus, 0.02)
        ours = loop.run(1, Command(mode.value, setpoint), position, 0.0, 0.0, bus)
        if name == "soft limit":  # which belongs to the output stage
            port = SparkMotorSim(made, ShaftSim(neo(), 0.001))
            made.getEncoder().setPosition(position)
            run([port], 0.01)
            ours = made.getAppliedOutput()
        answer[name] = [made.getAppliedOutput() if name != "soft limit" else 0.0, ours]
    return answer


def closed_forms():
    """Measure spin-up at a duty cycle, stall at the current limit, coasting and braking."""
    shaft = ShaftSim(neo(gearing=2.0), 0.004)
    made = spark(lambda c: c.smartCurrentLimit(200))
    motor = SparkMotorSim(made, shaft)
    made.set(0.5)
    run([motor], 0.15)
    tau, end = shaft.time_constant, 6.0 / shaft.gearbox.volts_per_speed
    facts = {
        "speed": shaft.velocity,
        "speed_expected": end * -math.expm1(-0.15 / tau),
        "rpm": made.getEncoder().getVelocity(),
        "rotations": made.getEncoder().getPosition(),
        "shaft": shaft.position,
        "applied": made.getAppliedOutput(),
    }
    made.set(0.0)
    fast = shaft.velocity
    run([motor], 0.1)
    facts["coasts"] = shaft.velocity / fast
    config = rev.SparkMaxConfig()
    config.setIdleMode(rev.SparkBaseConfig.IdleMode.kBrake)
    no_reset, no_persist = rev.ResetMode.kNoResetSafeParameters, rev.PersistMode.kNoPersistParameters
    made.configure(config, no_reset, no_persist)
    run([motor], 0.1)
    facts["brakes"] = shaft.velocity / fast
    facts["brakes_expected"] = math.exp(-0.1 / tau)
    stalled = ShaftSim(neo(gearing=20.0), 0.1, lower_stop=0.0, upper_stop=1e-6)
    limited = spark(lambda c: c.smartCurrentLimit(40))
    motor = SparkMotorSim(limited, stalled)
    limited.setVoltage(12.0)
    run([motor], 0.2)
    facts["stall_amps"], facts["stall_volts"] = limited.getOutputCurrent(), 12.0 * limited.getAppliedOutput()
    enable(False)
    run([motor], 0.01)
    facts["disabled"] = limited.getAppliedOutput()
    enable()
    return facts


def loops():
    """Run closed loops of every kind on each sensor, and read back their values in robot code."""
    shaft = ShaftSim(neo(motor=DCMotor.neoVortex(1)), 0.002)
    kv = shaft.gearbox.volts_per_speed * math.tau / 60.0  # [V/rpm]

    def velocity(c):
        c.closedLoop.pid(0.0002, 0, 0).allowedClosedLoopError(20, SLOT).feedForward.kV(kv)

    wheel = spark(velocity, cls=rev.SparkFlex)
    flywheel = SparkMotorSim(wheel, shaft)
    wheel.getClosedLoopController().setSetpoint(3000.0, CT.kVelocity)
    early = wheel.getClosedLoopController().isAtSetpoint()
    run([flywheel], 3.0)
    late = wheel.getClosedLoopController().isAtSetpoint()
    facts = {"rpm": wheel.getEncoder().getVelocity(), "at_setpoint": [early, late]}

    def in_radians(c):
        c.inverted(True).encoder.positionConversionFactor(math.tau / 50).velocityConversionFactor(math.tau / 50 / 60)
        c.closedLoop.pid(1.0, 0, 0.0)

    arm = spark(in_radians)
    pivot = ShaftSim(neo(gearing=50.0), 0.05)
    motor = SparkMotorSim(arm, pivot)
    arm.getClosedLoopController().setSetpoint(1.2, CT.kPosition)
    run([motor], 1.5)
    facts["inverted"] = [pivot.position, arm.getEncoder().getPosition()]
    arm.getEncoder().setPosition(0.2)  # as if the shaft were at 0.2 rad
    run([motor], 1.5)
    facts["zeroed"] = [pivot.position, arm.getEncoder().getPosition()]

    def on_absolute(c):
        c.absoluteEncoder.positionConversionFactor(360.0).velocityConversionFactor(6.0)
        c.closedLoop.setFeedbackSensor(rev.FeedbackSensor.kAbsoluteEncoder).pid(0.02, 0, 0)

    turret = spark(on_absolute)
    table = ShaftSim(neo(gearing=30.0), 0.05, position=math.radians(20.0))
    motor = SparkMotorSim(turret, table, reversed=True, zero_at=math.radians(20.0), encoder_gearing=1.0)
    facts["absolute_at_first"] = turret.getAbsoluteEncoder().getPosition()
    turret.getClosedLoopController().setSetpoint(300.0, CT.kPosition)
    run([motor], 2.0)
    facts["absolute"] = [math.degrees(table.position), turret.getAbsoluteEncoder().getPosition()]

    def profiled(c):
        c.closedLoop.pid(0.5, 0, 0).allowedClosedLoopError(0.05, SLOT)
        c.closedLoop.maxMotion.cruiseVelocity(1200.0).maxAcceleration(2400.0)

    slide = spark(profiled)
    rack = ShaftSim(neo(gearing=5.0), 0.005)
    motor = SparkMotorSim(slide, rack)
    slide.getClosedLoopController().setSetpoint(20.0, CT.kMAXMotionPositionControl)
    track = []
    for _ in range(400):
        motor.update(DT, 12.0)
        track.append((slide.getEncoder().getPosition(), slide.getClosedLoopController().getMAXMotionSetpointPosition()))
    facts["profile"] = [track[round(t / DT) - 1] for t in (0.25, 0.75, 1.25, 2.0)]
    return facts


def sensors():
    """Read sensors on the data port, for swerve modules and brushed motors."""

    def azimuth(c, sensor, turn):
        own = c.absoluteEncoder if sensor == "Absolute" else c.analogSensor
        span = 1.0 if sensor == "Absolute" else 3.3
        own.positionConversionFactor(turn / span)
        names = {"Absolute": "kAbsoluteEncoder", "Analog": "kAnalogSensor"}
        c.closedLoop.setFeedbackSensor(getattr(rev.FeedbackSensor, names[sensor]))
        c.closedLoop.pid(2.0 / turn, 0, 0.0).positionWrappingEnabled(True).positionWrappingInputRange(0, turn)

    facts = {}
    for sensor in ("Absolute", "Analog"):
        made = spark(lambda c, sensor=sensor: azimuth(c, sensor, math.tau))
        shaft = ShaftSim(neo(gearing=12.8), 0.004, position=math.radians(350.0))
        motor = SparkMotorSim(made, shaft, zero_at=math.radians(350.0))
        made.getClosedLoopController().setSetpoint(math.radians(20.0), CT.kPosition)
        run([motor], 1.0)
        read = made.getAbsoluteEncoder() if sensor == "Absolute" else made.getAnalog()
        facts[sensor] = [math.degrees(shaft.position), math.degrees(read.getPosition())]
    facts["volts"] = made.getAnalog().getVoltage()

    centered = spark(lambda c: c.absoluteEncoder.zeroCentered(True).positionConversionFactor(360.0))
    SparkMotorSim(centered, ShaftSim(neo(), 0.01, position=math.radians(-30.0)))
    facts["centered"] = centered.getAbsoluteEncoder().getPosition()

    seeded = spark(lambda c: c.encoder.positionConversionFactor(0.5))
    seeded.getEncoder().setPosition(1.5)  # before physics exists, as from an absolute encoder
    turned = ShaftSim(neo(), 0.01)
    motor = SparkMotorSim(seeded, turned)
    turned.reset(position=math.tau)
    motor.write()
    facts["seeded"] = seeded.getEncoder().getPosition()

    brushed = rev.SparkMax(next(numbers), rev.SparkLowLevel.MotorType.kBrushed)
    wheel = ShaftSim(neo(gearing=10.0, motor=DCMotor.CIM(1)), 0.01, position=math.pi)
    motor = SparkMotorSim(brushed, wheel)
    wheel.reset(position=math.pi + 3.0 * math.tau)
    motor.write()
    facts["brushed"] = brushed.getEncoder().getPosition()
    return facts


def followers():
    lead = spark(lambda c: c.smartCurrentLimit(60))
    same = spark(lambda c: c.follow(lead.getDeviceId()))
    opposed = spark(lambda c: c.follow(lead.getDeviceId(), True))
    group = next(g for g in MAKER.groups(MAKER.built()) if g.leader.hardware is lead)
    shaft = ShaftSim(neo(motors=3), 0.005)
    motor = SparkMotorSim(lead, shaft, followers=[same, opposed], opposed=group.opposed)
    lead.set(0.25)
    run([motor], 1.0)
    return {
        "group": [[f.hardware.getDeviceId() - lead.getDeviceId() for f in group.followers], list(group.opposed)],
        "rpm": [made.getEncoder().getVelocity() for made in (lead, same, opposed)],
        "applied": [made.getAppliedOutput() for made in (lead, same, opposed)],
        "expected": 3.0 / shaft.gearbox.volts_per_speed * 60.0 / math.tau * -math.expm1(-1.0 / shaft.time_constant),
    }


def guesses():
    def arm(c):
        c.encoder.positionConversionFactor(math.tau / 60).velocityConversionFactor(math.tau / 3600)
        c.closedLoop.feedForward.kS(0.3).kCos(0.5)

    made = spark(arm, cls=rev.SparkFlex)
    group = next(g for g in MAKER.groups(MAKER.built()) if g.leader.hardware is made)
    guess = MAKER.guess(group)
    gearbox = guess.mechanism.gearbox
    return {
        "text": str(guess),
        "friction_volts": gearbox.friction_torque * gearbox.resistance / gearbox.torque_per_amp,
    }


def main():
    hal.initialize(500, 0)
    pauseTiming()
    enable()
    answer = {
        "lateness_ms": 0.0,
        "iterate": beside_iterate(),
        "forms": closed_forms(),
        "loops": loops(),
        "sensors": sensors(),
        "followers": followers(),
        "guess": guesses(),
    }
    print(json.dumps(answer), flush=True)
    os._exit(0)  # whichever threads REVLib has started


main()
