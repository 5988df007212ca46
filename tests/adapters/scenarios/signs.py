"""Every combination of configured inversion and `reversed`: positive volts must raise the position in robot code."""

from __future__ import annotations

import itertools
import math

from phoenix6 import configs, controls, hardware, signals
from realtime import DT, Loop, enable, report, start
from wpilib import RobotController
from wpilib.simulation import RoboRioSim
from wpimath.system.plant import DCMotor

from simcore.loop.battery import draw
from simcore.robot.battery import Battery
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import FlywheelConfig, FlywheelSim
from simcore.robotcode.makers.phoenix6.sensor_ports import CANcoderSim, Pigeon2Sim
from simcore.robotcode.makers.phoenix6.talon_motor import TalonFXMotorSim, TalonPort


def main() -> None:
    start()
    rows = []
    for number, (clockwise, opposite) in enumerate(itertools.product((False, True), repeat=2)):
        device = hardware.TalonFX(number)
        config = configs.TalonFXConfiguration()
        config.motor_output.inverted = signals.InvertedValue(int(clockwise))
        device.configurator.apply(config, 0.2)
        wheel = FlywheelSim(
            FlywheelConfig(gearbox=GearboxConfig(motor=DCMotor.krakenX60FOC(1), gearing=2.0), inertia=0.002)
        )
        rows.append((device, TalonFXMotorSim(device, wheel, reversed=opposite), clockwise, opposite))
    battery = Battery()

    def step() -> None:
        draw(battery.records, 0, DT, sum(row[1].supply_current for row in rows), math.nan)
        RoboRioSim.setVInVoltage(battery.voltage)
        for _, adapter, *_ in rows:
            adapter.update(DT)

    loop = Loop(step)
    enable()
    loop.run(0.2)
    for device, *_ in rows:
        device.set_control(controls.VoltageOut(6.0))
    lowest = [99.0]
    loop.run(0.5, lambda _: lowest.append(RobotController.getBatteryVoltage()))
    turned = [
        {
            "clockwise": clockwise,
            "reversed": opposite,
            "volts": adapter.volts,
            "robot_rps": device.get_velocity().value,
            "robot_rotations": device.get_position().value,
            "sim_rps": adapter.mechanism.velocity / math.tau,
            "sim_rotations": adapter.mechanism.position / math.tau,
        }
        for device, adapter, clockwise, opposite in rows
    ]

    # limits of the device's model
    spare = hardware.TalonFX(30)
    port = TalonPort(spare, clockwise=False)
    port.write(20000.0, 170.0)
    port.set_supply(-1.0)
    loop.run(0.1)
    far = [spare.get_position().value, spare.get_velocity().value, spare.get_supply_voltage().value]

    # encoders and gyro
    angles = []
    for number, (inverted, offset) in enumerate(itertools.product((False, True), (0.0, 0.31))):
        encoder = hardware.CANcoder(number)
        settings = configs.CANcoderConfiguration()
        settings.magnet_sensor.sensor_direction = signals.SensorDirectionValue(int(inverted))
        settings.magnet_sensor.magnet_offset = offset
        encoder.configurator.apply(settings, 0.2)
        CANcoderSim(encoder).write(0.2 * math.tau, 0.5 * math.tau)
        loop.run(0.1)
        angles.append([encoder.get_absolute_position().value, encoder.get_velocity().value])
    pigeon = hardware.Pigeon2(1)
    gyro = Pigeon2Sim(pigeon)
    gyro.write(math.radians(1000.0), math.radians(10.0), math.radians(-5.0), (0.1, 0.2, 100.0))
    loop.run(0.1)
    report(
        loop,
        turned=turned,
        lowest_volts=min(lowest),
        far=far,
        encoders=angles,
        gyro=[s.value for s in (pigeon.get_yaw(), pigeon.get_pitch(), pigeon.get_roll())],
        rate_dps=pigeon.get_angular_velocity_z_world().value,
    )


if __name__ == "__main__":
    main()
