"""Devices with equal ids on two buses are separate, and a lookup by id finds the device on its own bus."""

import pytest


@pytest.fixture
def on(bench):
    """Return a function that makes a device on a bus, with a configuration."""
    from phoenix6 import CANBus

    def make(bus, cls, number, **settings):
        bench.bus = CANBus(bus)
        return bench.device(cls, number, **settings)

    return make


def test_two_motors_with_equal_ids_on_two_buses_move_independently(bench, on):
    from phoenix6 import configs, controls

    own, far = on("rio", "TalonFX", 3, slot0__k_p=1.5), on("canivore", "TalonFX", 3, slot0__k_p=9.0)
    for talon in (own, far):
        bench.spin(talon)
    bench.run(1.0, lambda: (own.set_control(controls.VoltageOut(3.0)), far.set_control(controls.VoltageOut(-2.0))))
    assert own.get_motor_voltage().value == pytest.approx(3.0) and far.get_motor_voltage().value == pytest.approx(-2.0)
    assert own.get_position().value > 5.0 and far.get_position().value < -3.0
    for talon, gain in ((own, 1.5), (far, 9.0)):
        slot = configs.Slot0Configs()
        assert talon.configurator.refresh(slot).is_ok() and slot.k_p == gain


def test_the_name_rio_means_the_roborios_bus(bench, on):
    from phoenix6 import controls

    one, same = on("rio", "TalonFX", 3), on("", "TalonFX", 3)
    bench.run(0.2, lambda: one.set_control(controls.VoltageOut(3.0)))
    assert same.get_motor_voltage().value == pytest.approx(3.0)


def test_a_follower_follows_only_a_leader_on_its_own_bus(bench, on):
    from phoenix6 import controls, signals

    lead, decoy = on("rio", "TalonFX", 3), on("canivore", "TalonFX", 4)
    near, far = on("rio", "TalonFX", 5), on("canivore", "TalonFX", 5)
    follow = controls.Follower(3, signals.MotorAlignmentValue.ALIGNED)

    def loop():
        lead.set_control(controls.VoltageOut(4.0))
        decoy.set_control(controls.VoltageOut(1.0))
        near.set_control(follow)
        far.set_control(follow)

    bench.run(0.2, loop)
    assert near.get_motor_voltage().value == pytest.approx(4.0)
    assert far.get_motor_voltage().value == 0.0


def test_a_remote_encoder_is_looked_up_on_the_controllers_bus(bench, on):
    from phoenix6 import signals

    fused = {
        "feedback__feedback_sensor_source": signals.FeedbackSensorSourceValue.FUSED_CANCODER,
        "feedback__feedback_remote_sensor_id": 7,
    }
    near, far = on("rio", "CANcoder", 7), on("canivore", "CANcoder", 7)
    talons = on("rio", "TalonFX", 3, **fused), on("canivore", "TalonFX", 3, **fused)
    near.sim_state.set_raw_position(0.125)
    far.sim_state.set_raw_position(-0.25)
    bench.run(0.1)
    assert [t.get_position().value for t in talons] == pytest.approx([0.125, -0.25], abs=1e-3)


def test_devices_with_equal_ids_on_two_buses_are_separate(bench, on):
    gyros = [on(bus, "Pigeon2", 1) for bus in ("rio", "canivore")]
    ranges = [on(bus, "CANrange", 1) for bus in ("rio", "canivore")]
    small = [on(bus, "TalonFXS", 1) for bus in ("rio", "canivore")]
    for k, (gyro, ranger, talon) in enumerate(zip(gyros, ranges, small, strict=True), 1):
        gyro.sim_state.set_raw_yaw(10.0 * k)
        ranger.sim_state.set_distance(0.5 * k)
        talon.sim_state.set_raw_rotor_position(3.0 * k)
    bench.run(0.1)
    assert [gyro.get_yaw().value for gyro in gyros] == pytest.approx([10.0, 20.0])
    assert [one.get_distance().value for one in ranges] == pytest.approx([0.5, 1.0])
    assert [talon.get_rotor_position().value for talon in small] == pytest.approx([3.0, 6.0])


def test_physics_and_a_teams_own_simulation_reach_the_device_on_the_right_bus(bench, on):
    from simcore.quantities import DeviceAddress
    from simcore.robotcode.makers.phoenix6.built_devices import watch_simulations
    from simcore.robotcode.makers.phoenix6.sensor_ports import sim_state_of

    own, far = on("rio", "TalonFX", 3), on("canivore", "TalonFX", 3)
    asked = []
    watch_simulations(lambda key: asked.append(key) is None and key[1].bus == "canivore")
    sim_state_of(own).write_rotor(2.0, 0.0)
    own.sim_state.set_raw_rotor_position(9.0)  # dropped: physics owns this device
    far.sim_state.set_raw_rotor_position(5.0)
    watch_simulations(lambda key: True)
    bench.run(0.1)
    assert [t.get_rotor_position().value for t in (own, far)] == [2.0, 5.0]
    assert asked == [("TalonFX", DeviceAddress(3)), ("TalonFX", DeviceAddress(3, "canivore"))]
