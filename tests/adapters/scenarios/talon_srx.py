"""Talon SRX and Victor SPX: beside CTRE's own simulation, on a mechanism beside closed forms, and as a tank drive."""

from __future__ import annotations

import json
import math
import time

import hal
import wpilib.drive
from wpilib.simulation import DriverStationSim, pauseTiming, stepTiming
from wpimath.system.plant import DCMotor

from simcore.devices.makers import device_of, maker_of, watch_makers

watch_makers()

import phoenix5  # noqa: E402
from phoenix5 import ControlMode, DemandType, FeedbackDevice, InvertType, NeutralMode  # noqa: E402

from simcore import Match, RobotConfig, TankConfig  # noqa: E402
from simcore.devices.motor_ports import ShaftPorts  # noqa: E402
from simcore.phoenix5.built_talons import record_of  # noqa: E402
from simcore.phoenix5.ctre5_maker import MAKER  # noqa: E402
from simcore.phoenix5.talon_loop import TalonLoop  # noqa: E402
from simcore.phoenix5.talon_srx_motor import TalonSRXMotorSim  # noqa: E402
from simcore.robot.dc_motor import motor  # noqa: E402
from simcore.robot.gearbox import GearboxConfig  # noqa: E402
from simcore.robot.mechanisms import ShaftSim  # noqa: E402
from simcore.robotpy.connected_devices import ConnectedDevices  # noqa: E402

DT = 0.005
CIM = DCMotor.CIM(1)
numbers = iter(range(1, 60))


def srx():
    return phoenix5.WPI_TalonSRX(next(numbers))


def enable(on=True):
    DriverStationSim.setDsAttached(True)
    DriverStationSim.setEnabled(on)
    DriverStationSim.notifyNewData()


def beside_ctre():
    """Outputs for sensors at rest: CTRE's simulation, on its own clock, and ours."""
    talon = srx()
    sim = talon.getSimCollection()

    def wait(seconds):
        end = time.perf_counter() + seconds
        while time.perf_counter() < end:
            hal.simPeriodicBefore()
            DriverStationSim.notifyNewData()
            sim.setBusVoltage(12.0)
            time.sleep(0.005)

    talon.configFactoryDefault()
    talon.configSelectedFeedbackSensor(FeedbackDevice.QuadEncoder)
    talon.config_kP(0, 0.2)
    talon.config_kF(1, 0.1)
    talon.config_kP(1, 0.2)
    sim.setQuadratureRawPosition(500)
    sim.setQuadratureVelocity(100)
    wait(0.3)

    def saturate(volts):
        talon.configVoltageCompSaturation(volts)
        talon.enableVoltageCompensation(volts > 0.0)

    cases = {
        "percent": lambda: talon.set(0.7),
        "percent by mode": lambda: talon.set(ControlMode.PercentOutput, -0.3),
        "deadband": lambda: talon.set(0.03),
        "volts": lambda: talon.setVoltage(6.0),
        "compensated": lambda: (saturate(10.0), talon.set(0.5)),
        "position": lambda: (saturate(0.0), talon.set(ControlMode.Position, 4000.0)),
        "velocity": lambda: (talon.selectProfileSlot(1, 0), talon.set(ControlMode.Velocity, 2000.0)),
        "peak": lambda: (talon.configPeakOutputForward(0.4), talon.set(0.9)),
        "soft limit": lambda: (
            talon.configForwardSoftLimitThreshold(400.0),
            talon.configForwardSoftLimitEnable(True),
        ),
        "neutral": lambda: talon.stopMotor(),
    }
    rows = {}
    for name, act in cases.items():
        act()
        wait(0.25)
        record, loop = record_of(talon), TalonLoop()
        loop.config = record.configuration()
        ours = loop.run(1, record.demand(talon), 500.0, 100.0, 0.0, 12.0)
        rows[name] = (talon.getMotorOutputPercent(), ours)
    return rows


def run(motors, seconds, supply=12.0):
    for _ in range(round(seconds / DT)):
        for each in motors:
            each.update(DT, supply)


def gearbox(gearing=1.0, motors=1):
    return GearboxConfig(motor=CIM, motors=motors, gearing=gearing)


def forms():
    row = {}
    talon = srx()
    wheel = ShaftSim(gearbox(2.0), 0.02)
    sim = TalonSRXMotorSim(talon, wheel)
    talon.set(0.5)
    run([sim], 0.3)
    per_volt = wheel.gearbox.torque_per_amp / wheel.gearbox.resistance
    tau = 0.02 / (per_volt * wheel.gearbox.volts_per_speed)
    row["speed"] = wheel.velocity
    row["speed_expected"] = 6.0 / wheel.gearbox.volts_per_speed * (1.0 - math.exp(-0.3 / tau))
    row["units"] = [talon.getSelectedSensorPosition(), wheel.position / math.tau * 4096.0]
    row["rate"] = [talon.getSelectedSensorVelocity(), wheel.velocity / math.tau * 409.6]
    row["percent"] = [talon.getMotorOutputPercent(), talon.getMotorOutputVoltage(), talon.getBusVoltage()]
    talon.set(ControlMode.PercentOutput, 0.2, DemandType.ArbitraryFeedForward, 0.1)
    run([sim], 0.005)
    row["feed-forward"] = talon.getMotorOutputPercent()
    talon.setSelectedSensorPosition(100)
    row["set"] = [talon.getSelectedSensorPosition(), talon.getSensorCollection().getQuadraturePosition()]
    talon.setNeutralMode(NeutralMode.Coast)
    talon.stopMotor()
    before = wheel.velocity
    run([sim], 0.2)
    row["coasts"] = wheel.velocity / before
    talon.setNeutralMode(NeutralMode.Brake)
    run([sim], 0.2)
    row["brakes"] = [wheel.velocity / before, math.exp(-0.2 / tau)]

    stalled = srx()
    locked = ShaftSim(gearbox(), 0.01, lower_stop=-1e-6, upper_stop=1e-6)
    held = TalonSRXMotorSim(stalled, locked)
    stalled.set(0.5)
    run([held], 0.05)
    row["stall"] = [stalled.getStatorCurrent(), stalled.getSupplyCurrent()]
    stalled.configSupplyCurrentLimit(phoenix5.SupplyCurrentLimitConfiguration(True, 10.0, 15.0, 0.1))
    run([held], 0.05)
    row["before the limit"] = stalled.getSupplyCurrent()
    run([held], 0.2)
    row["limited"] = stalled.getSupplyCurrent()

    goal = srx()
    goal.configSelectedFeedbackSensor(FeedbackDevice.CTRE_MagEncoder_Relative)
    goal.setNeutralMode(NeutralMode.Brake)
    goal.config_kP(0, 0.4)
    goal.config_kD(0, 8.0)
    goal.configMotionCruiseVelocity(2048)  # 5 turns a second
    goal.configMotionAcceleration(4096)  # 10 turns a second in a second
    arm = TalonSRXMotorSim(goal, ShaftSim(gearbox(10.0), 0.02), reversed=True)
    goal.set(ControlMode.Position, 4096.0)
    run([arm], 2.0)
    row["position"] = [goal.getSelectedSensorPosition(), arm.mechanism.position, goal.getClosedLoopError()]
    goal.set(ControlMode.MotionMagic, 4096.0 * 6)
    profile = []
    for _ in range(4):
        run([arm], 0.5)
        profile.append(goal.getActiveTrajectoryPosition() / 4096.0)
    row["profile"] = profile
    row["profile end"] = goal.getSelectedSensorPosition() / 4096.0

    leader, follower = srx(), phoenix5.WPI_VictorSPX(next(numbers))
    follower.follow(leader)
    follower.setInverted(InvertType.OpposeMaster)
    ours = [d for d in MAKER.built() if d.hardware in (leader, follower)]
    group = MAKER.groups(ours)
    row["groups"] = [[str(d) for d in g.devices] for g in group]
    row["guess"] = str(MAKER.guess(group[0]))
    pair = TalonSRXMotorSim(leader, ShaftSim(gearbox(2.0, 2), 0.02), followers=[follower])
    leader.set(0.6)
    run([pair], 0.1)
    row["follower"] = [follower.getMotorOutputPercent(), leader.getMotorOutputPercent()]
    enable(False)
    stepTiming(0.02)
    run([pair], 0.02)
    row["disabled"] = leader.getMotorOutputPercent()
    enable()
    stepTiming(0.02)
    return row


def tank():
    """Forward until the wall stops it; C++ gives the motors their outputs."""
    left, right = srx(), srx()
    follower = phoenix5.WPI_VictorSPX(next(numbers))
    follower.follow(left)
    right.setInverted(True)
    for talon in (left, right):
        talon.setNeutralMode(NeutralMode.Brake)
    drive = wpilib.drive.DifferentialDrive(left, right)
    drive.setSafetyEnabled(False)
    config = TankConfig(motor=motor("CIM"), gearing=10.71, wheel_cof=1.1)
    row = {}
    with Match.bare(RobotConfig(drivetrain=config), start=(9.0, 4.0, 0.0)) as match:
        robot = match.robots[0]
        devices = [device_of(talon) for talon in (left, follower, right)]
        ports = [maker_of(d).motor_port(d) for d in devices]
        wheels = [maker_of(devices[k]).encoder_port(devices[k], ports[k]) for k in (0, 2)]
        sides = ShaftPorts(robot.drive, (ports[:2], ports[2:]), encoders=tuple(wheels))
        robot.connect(ConnectedDevices(robot, sides, []))

        def play(seconds, speed):
            for _ in range(round(seconds / 0.02)):
                drive.tankDrive(speed, speed, False)
                match.tick()

        per_unit = math.tau * config.wheel_radius / 4096.0
        play(1.5, 0.6)
        x, y, yaw = robot.chassis.pose[:3]
        row["straight"] = [float(x) - 9.0, float(y) - 4.0, float(yaw)]
        row["odometry"] = [talon.getSelectedSensorPosition() * per_unit for talon in (left, right)]
        row["follower"] = [follower.getMotorOutputPercent(), left.getMotorOutputPercent()]
        play(3.0, 0.35)
        row["at the wall"] = [float(robot.chassis.pose[0]), float(robot.drive.wheel_speeds()[0])]
        row["stall"] = [left.getStatorCurrent(), left.getMotorOutputVoltage(), CIM.R]
        row["currents"] = [left.getSupplyCurrent(), right.getStatorCurrent()]
    return row


def main():
    hal.initialize(500, 0)
    enable()
    ctre = beside_ctre()
    pauseTiming()
    enable()
    stepTiming(0.02)
    print(json.dumps({"lateness_ms": 0.0, "ctre": ctre, "forms": forms(), "tank": tank()}))


if __name__ == "__main__":
    main()
