"""CANdi, CANrange and a TalonFXS with its own encoder, on the real device simulation."""

from __future__ import annotations

import math

from phoenix6 import configs, controls, hardware, signals
from realtime import Loop, enable, report, start

from simcore.errors import ConfigError
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import ArmConfig, ArmSim
from simcore.robotcode.makers.phoenix6.sensor_ports import CANdiEncoderSim, CANrangeSim
from simcore.robotcode.makers.phoenix6.talon_motor import MotorType, TalonFXMotorSim

TURN = math.tau


def message(call) -> str:
    try:
        call()
    except ConfigError as error:
        return str(error)
    return "no error"


def main() -> None:
    start()
    plain, turned = hardware.CANdi(1), hardware.CANdi(2)
    config = configs.CANdiConfiguration()
    config.pwm1.sensor_direction = True
    config.pwm1.absolute_sensor_offset = 0.15
    assert turned.configurator.apply(config, 0.2).is_ok()
    encoders = [CANdiEncoderSim(plain, 2), CANdiEncoderSim(turned, 1)]
    eye = hardware.CANrange(3)
    ranger = CANrangeSim(eye)

    lift = hardware.TalonFXS(4)
    settings = configs.TalonFXSConfiguration()
    settings.commutation.motor_arrangement = signals.MotorArrangementValue.MINION_JST
    settings.motor_output.inverted = signals.InvertedValue.CLOCKWISE_POSITIVE
    settings.external_feedback.external_feedback_sensor_source = signals.ExternalFeedbackSensorSourceValue.QUADRATURE
    settings.external_feedback.rotor_to_sensor_ratio = 10.0
    settings.external_feedback.sensor_to_mechanism_ratio = 4.0
    settings.slot0.k_p = 80.0
    settings.slot0.k_d = 1.0
    assert lift.configurator.apply(settings, 0.2).is_ok()
    gearbox = GearboxConfig(motor=motor("Minion"), gearing=40.0)
    arm = ArmSim(ArmConfig(gearbox=gearbox, inertia=0.1, mass=1.0, center_of_mass=0.2, min_angle=0.0, max_angle=2.0))
    port = TalonFXMotorSim(lift, arm, sensor_gearing=10.0)
    wrong_type = message(lambda: TalonFXMotorSim(lift, arm, motor_type=MotorType.KRAKEN_X44))
    wrong_pin = message(lambda: CANdiEncoderSim(plain, 3))
    too_near = message(lambda: ranger.write(-0.1))
    goal = controls.PositionVoltage(0.2)

    def each() -> None:
        lift.set_control(goal)
        port.update(0.005, 12.0)
        for encoder in encoders:
            encoder.write(0.3 * TURN, 0.5 * TURN)
        ranger.write(0.25)

    enable()
    loop = Loop(each)
    loop.run(1.5)
    report(
        loop,
        pwm=[plain.get_pwm2_position().value, turned.get_pwm1_position().value],
        pwm_velocity=[plain.get_pwm2_velocity().value, turned.get_pwm1_velocity().value],
        distance=eye.get_distance().value,
        arm=lift.get_position().value,
        true_arm=arm.position / TURN,
        wrong_type=wrong_type,
        wrong_pin=wrong_pin,
        too_near=too_near,
    )


if __name__ == "__main__":
    main()
