"""Repeated reads of configurations: on a busy computer a device may not answer at once."""

import pytest

from simcore.errors import ConfigError
from simcore.quantities import DeviceAddress


class Busy:
    """Configurator that times out for the first reads."""

    def __init__(self, configurator, failures):
        self.configurator, self.failures, self.asked = configurator, failures, []

    def refresh(self, config, timeout=0.05):
        from phoenix6 import StatusCode

        self.asked.append(timeout)
        if len(self.asked) <= self.failures:
            return StatusCode.RX_TIMEOUT
        return self.configurator.refresh(config, timeout)


class Device:
    def __init__(self, talon, failures):
        self.talon, self.configurator = talon, Busy(talon.configurator, failures)
        self.device_id = talon.device_id

    def __getattr__(self, name):
        return getattr(self.talon, name)


def group_of(device):
    from simcore.robotcode.program.motor_controllers import BuiltDevice, FollowerGroup

    return FollowerGroup(BuiltDevice("TalonFX", DeviceAddress(device.device_id), device))


def test_a_flywheel_is_guessed_even_if_the_first_configuration_reads_time_out(bench):
    from simcore.robotcode.makers.phoenix6.ctre_maker import MAKER

    device = Device(bench.talon(5, feedback__sensor_to_mechanism_ratio=1.5, slot0__k_s=0.12), 3)
    gearbox = MAKER.guess(group_of(device)).mechanism.gearbox
    assert gearbox.gearing == 1.5
    assert gearbox.friction_torque * gearbox.resistance / gearbox.torque_per_amp == pytest.approx(0.12, rel=1e-5)
    assert device.configurator.asked == sorted(device.configurator.asked) and len(device.configurator.asked) == 4


def test_the_error_names_a_device_that_does_not_answer(bench):
    from simcore.robotcode.makers.phoenix6.ctre_maker import MAKER
    from simcore.robotcode.makers.phoenix6.talon_motor import is_configured_clockwise

    device = Device(bench.talon(6), 99)
    with pytest.raises(ConfigError, match=r"6: could not read its configuration .RX_TIMEOUT, asked 5 times"):
        MAKER.guess(group_of(device))
    with pytest.raises(ConfigError, match="pass inverted=True or False"):
        is_configured_clockwise(device)


def test_default_friction_stops_a_coasting_mechanism(bench):
    """Without kS, friction is 0.2 V: from 12 V it coasts (12 - 0.2) / 0.2 times its time constant of 50 ms: 3 s."""
    from simcore.robotcode.makers.phoenix6.ctre_maker import MAKER

    shaft = MAKER.guess(group_of(bench.talon(7))).mechanism
    shaft.set_volts(12.0)
    shaft.step(2.0)
    shaft.coast()
    rest = shaft.inertia * shaft.velocity / shaft.gearbox.friction_torque
    assert rest == pytest.approx(0.05 * 11.8 / 0.2, rel=1e-3)
    shaft.step(rest * 0.999)
    assert shaft.velocity > 0.0
    shaft.step(rest * 0.002)
    assert shaft.velocity == 0.0
