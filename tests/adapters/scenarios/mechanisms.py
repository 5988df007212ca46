"""Closed loops of real TalonFX on simcore's mechanisms, compared with WPILib's simulations of the same plants."""

from __future__ import annotations

import math

from phoenix6 import configs, controls, hardware, signals
from phoenix6.sim import ChassisReference
from realtime import DT, Loop, enable, report, start
from wpilib.simulation import DCMotorSim, FlywheelSim, SingleJointedArmSim
from wpimath.system.plant import DCMotor, LinearSystemId

from simcore.robot import mechanisms
from simcore.robot.gearbox import GearboxConfig
from simcore.robotcode.makers.phoenix6.talon_motor import TalonFXMotorSim

CW = signals.InvertedValue.CLOCKWISE_POSITIVE
CCW = signals.InvertedValue.COUNTER_CLOCKWISE_POSITIVE
KRAKEN = DCMotor.krakenX60FOC(1)


def talon(number: int, *, inverted=CCW, neutral=signals.NeutralModeValue.BRAKE, **gains: float) -> hardware.TalonFX:
    device = hardware.TalonFX(number)
    config = configs.TalonFXConfiguration()
    config.motor_output.inverted = inverted
    config.motor_output.neutral_mode = neutral
    config.feedback.sensor_to_mechanism_ratio = gains.pop("sensor_to_mechanism_ratio", 1.0)
    if "cruise" in gains:
        config.motion_magic.motion_magic_cruise_velocity = gains.pop("cruise")
        config.motion_magic.motion_magic_acceleration = gains.pop("acceleration")
    for name, value in gains.items():
        setattr(config.slot0, name, value)
    assert device.configurator.apply(config, 0.2).is_ok()
    device.get_position().set_update_frequency(1000)
    device.get_velocity().set_update_frequency(1000)
    return device


class WpilibPlant:
    """Five steps of `TalonFXMotorSim.update` written out by hand, on a WPILib simulation."""

    def __init__(self, device: hardware.TalonFX, sim: object, position, velocity, gearing: float, inverted) -> None:
        self.device, self.sim, self.gearing = device, sim, gearing
        if inverted is CW:
            device.sim_state.orientation = ChassisReference.CLOCKWISE_POSITIVE
        self.position, self.velocity = position, velocity

    def update(self, dt: float) -> None:
        state = self.device.sim_state
        state.set_supply_voltage(12.0)
        self.sim.setInputVoltage(state.motor_voltage)
        self.sim.update(dt)
        state.set_raw_rotor_position(self.position(self.sim) * self.gearing / math.tau)
        state.set_rotor_velocity(self.velocity(self.sim) * self.gearing / math.tau)


def arm_reference(low: float, high: float) -> SingleJointedArmSim:
    # Heavier than a real hood: where the time constant is below some ms, WPILib's adaptive integrator (absolute error
    # 1e-6) loses 5 % of the distance at the right velocity: an error of the reference, not of ours.
    length = 1.5 * 2.0 / (1.2 * 0.12)  # WPILib models the arm as a rod, whose gravity acts as 1.5 g / length
    return SingleJointedArmSim(KRAKEN, 90.0, 2.0, length, low, high, True, low)


def pairs() -> dict[str, tuple[hardware.TalonFX, object, hardware.TalonFX, object, object, str]]:
    """Return by mechanism: device and adapter, device and WPILib's plant, request, and the reading to watch."""
    made = {}

    def pair(name, number, ours, wpilib, position, velocity, gearing, request, watch, motors=1, **settings):
        a, b = talon(number, **settings), talon(number + 20, **settings)
        followers = [hardware.TalonFX(number + 40 + k) for k in range(motors - 1)]
        for k, follower in enumerate(followers):
            opposed = k == 1
            alignment = signals.MotorAlignmentValue.OPPOSED if opposed else signals.MotorAlignmentValue.ALIGNED
            follower.set_control(controls.Follower(number, alignment))
        adapter = TalonFXMotorSim(a, ours, followers=followers, opposed=[1] if motors > 2 else [])
        plant = WpilibPlant(b, wpilib, position, velocity, gearing, settings.get("inverted", CCW))
        made[name] = (a, adapter, b, plant, request, watch, followers)

    four = DCMotor.krakenX60FOC(4)
    box = GearboxConfig(motor=KRAKEN, motors=4, gearing=2 / 3)
    pair(
        "shooter",
        1,
        mechanisms.FlywheelSim(mechanisms.FlywheelConfig(gearbox=box, inertia=0.008)),
        FlywheelSim(LinearSystemId.flywheelSystem(four, 0.008, 2 / 3), four),
        lambda s: 0.0,
        lambda s: s.getAngularVelocity(),
        2 / 3,
        controls.VelocityVoltage(40.0),
        "velocity",
        motors=4,
        inverted=CW,
        k_v=0.124,
        k_p=0.2,
    )
    pair(
        "feeder",
        2,
        mechanisms.RollerSim(
            mechanisms.RollerConfig(gearbox=GearboxConfig(motor=KRAKEN, gearing=2.0), inertia=0.002, radius=0.025)
        ),
        DCMotorSim(LinearSystemId.DCMotorSystem(KRAKEN, 0.002, 2.0), KRAKEN),
        lambda s: s.getAngularPosition(),
        lambda s: s.getAngularVelocity(),
        2.0,
        controls.VelocityVoltage(50.0),
        "velocity",
        inverted=CW,
        k_v=0.124,
        k_p=0.1,
    )
    low, high = math.radians(20), math.radians(65)
    pair(
        "hood",
        3,
        mechanisms.ArmSim(
            mechanisms.ArmConfig(
                gearbox=GearboxConfig(motor=KRAKEN, gearing=90.0),
                inertia=2.0,
                mass=1.2,
                center_of_mass=0.12,
                min_angle=low,
                max_angle=high,
            )
        ),
        arm_reference(low, high),
        lambda s: s.getAngle(),
        lambda s: s.getVelocity(),
        90.0,
        controls.PositionVoltage(42.0 / 360.0),
        "position",
        inverted=CW,
        sensor_to_mechanism_ratio=90.0,
        k_p=120.0,
        k_d=4.0,
    )
    arm_config = mechanisms.ArmConfig(
        gearbox=GearboxConfig(motor=KRAKEN, gearing=90.0),
        inertia=2.0,
        mass=5.0,
        center_of_mass=0.3,
        min_angle=-1.0,
        max_angle=1.5,
    )
    pair(
        "arm",
        6,
        mechanisms.ArmSim(arm_config),
        SingleJointedArmSim(KRAKEN, 90.0, 2.0, 1.5 * 2.0 / (5.0 * 0.3), -1.0, 1.5, True, -1.0),
        lambda s: s.getAngle(),
        lambda s: s.getVelocity(),
        90.0,
        controls.MotionMagicVoltage(0.1),
        "position",
        sensor_to_mechanism_ratio=90.0,
        gravity_type=signals.GravityTypeValue.ARM_COSINE,
        k_g=arm_config.gearbox.holding_volts(5.0 * 9.80665 * 0.3),
        k_p=60.0,
        k_v=11.0,
        cruise=0.6,
        acceleration=3.0,
    )
    return made


def t90(trace: list[tuple[float, float]]) -> float:
    start, end = trace[0][1], trace[-1][1]
    goal = start + 0.9 * (end - start)
    return next(t for t, value in trace if (value - goal) * (end - start) >= 0.0)


def main() -> None:
    start()
    made = pairs()
    plants = [plant for row in made.values() for plant in (row[1], row[3])]

    def step() -> None:
        for plant in plants:
            plant.update(DT)

    loop = Loop(step)
    enable()
    # the first reading may be from before the frequency was set
    loop.run(0.3, lambda _: [d.get_position().value + d.get_velocity().value for r in made.values() for d in r[:3:2]])
    for ours, _, theirs, _, request, *_ in made.values():
        ours.set_control(request)
        theirs.set_control(request)
    traces: dict[str, tuple[list, list]] = {name: ([], []) for name in made}

    def watch(t: float) -> None:
        for name, (ours, _, theirs, _, _, what, _) in made.items():
            for trace, device in zip(traces[name], (ours, theirs), strict=True):
                signal = device.get_position() if what == "position" else device.get_velocity()
                trace.append((t, signal.value))

    loop.run(1.6, watch)
    results: dict[str, object] = {}
    for name, (a, b) in traces.items():
        results[name] = {
            "t90": t90(a),
            "t90_wpilib": t90(b),
            "end": a[-1][1],
            "end_wpilib": b[-1][1],
        }
    results["followers"] = [f.get_velocity().value for f in made["shooter"][-1]]
    hood = made["hood"][1]
    results["hood_deg"] = math.degrees(hood.mechanism.position)

    # neutral: a braked hood creeps down, an open circuit lets it fall
    hood_talon = made["hood"][0]
    hood_talon.set_control(controls.NeutralOut())
    loop.run(0.3)
    results["hood_after_brake_deg"] = math.degrees(hood.mechanism.position)
    hood_talon.set_control(controls.PositionVoltage(42.0 / 360.0))
    loop.run(0.5)
    hood_talon.set_control(controls.CoastOut())
    loop.run(0.3)
    results["hood_after_coast_deg"] = math.degrees(hood.mechanism.position)
    feeder = made["feeder"]
    feeder[0].set_control(controls.CoastOut())
    loop.run(0.3)
    results["feeder_after_coast_rps"] = feeder[0].get_velocity().value
    feeder[0].set_control(controls.VelocityVoltage(50.0))
    loop.run(0.3)
    enable(False)  # back to the configured neutral mode: brake
    loop.run(0.5)
    results["feeder_after_disable_rps"] = feeder[0].get_velocity().value
    report(loop, **results)


if __name__ == "__main__":
    main()
