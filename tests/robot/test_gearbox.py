"""Velocity and position controllers of mechanisms."""

import math

import pytest

from simcore.errors import ConfigError
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig, PositionController, VelocityController
from simcore.robot.mechanisms import ArmConfig, ArmSim, FlywheelConfig, FlywheelSim


def test_the_feedforward_alone_reaches_the_goal():
    """The ks compensates exactly for friction, so the final speed is the goal."""
    box = GearboxConfig(motor=motor("Kraken X60"), motors=4, gearing=24 / 36, friction_torque=0.2)
    wheel = FlywheelSim(FlywheelConfig(gearbox=box, inertia=0.01))
    control = VelocityController.for_gearbox(box)
    for _ in range(1000):
        wheel.set_volts(control.volts(300.0, wheel.velocity))
        wheel.step(0.02)
    assert wheel.velocity == pytest.approx(300.0, rel=1e-6)


def test_a_proportional_term_shortens_the_spin_up_of_a_flywheel():
    box = GearboxConfig(motor=motor("Kraken X60"), motors=4, gearing=24 / 36)

    def ticks(kp):
        wheel = FlywheelSim(FlywheelConfig(gearbox=box, inertia=0.02))
        control = VelocityController.for_gearbox(box, kp=kp)
        for tick in range(1000):
            wheel.set_volts(control.volts(300.0, wheel.velocity))
            wheel.step(0.02)
            if wheel.velocity > 297.0:
                return tick
        return math.inf

    assert ticks(0.05) < 0.7 * ticks(0.0)


def test_an_arm_reaches_its_angle_and_stays():
    box = GearboxConfig(motor=motor("Kraken X44"), gearing=50.0)
    arm = ArmSim(ArmConfig(gearbox=box, inertia=0.1, mass=2.0, center_of_mass=0.2, min_angle=0.0, max_angle=1.5))
    control = PositionController(kp=20.0, kd=0.5)
    for _ in range(100):
        arm.set_volts(control.volts(0.8, arm.position, arm.velocity, arm.holding_volts))
        arm.step(0.02)
    assert arm.position == pytest.approx(0.8, abs=1e-4)


def test_controllers_limit_their_output_to_the_maximum_voltage():
    assert VelocityController(kv=1.0, max_volts=9.0).volts(-100.0, 0.0) == -9.0
    assert PositionController(kp=100.0, max_volts=9.0).volts(1.0, 0.0, 0.0, 5.0) == 9.0


def test_invalid_gains_are_refused():
    with pytest.raises(ConfigError, match="kv"):
        VelocityController(kv=math.nan)
    with pytest.raises(ConfigError, match="max_volts"):
        PositionController(kp=1.0, max_volts=0.0)
