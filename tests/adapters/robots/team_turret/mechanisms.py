import math
from collections.abc import Callable

import measures
from commands2 import Command, Subsystem
from phoenix6 import configs, controls, hardware, signals
from wpimath.geometry import Pose2d, Translation2d

ELEVATION, HEIGHT, METERS_PER_TURN = 65.0, 0.5, 0.308


class Intake(Subsystem):
    def __init__(self) -> None:
        super().__init__()
        self.roller = measures.talon(37, ratio=3.0)
        self.pivot = measures.talon(38, ratio=40.0, k_p=60.0, k_d=0.5)
        self.pivot.set_position(0.25)
        self.lights = hardware.CANdle(43)

    def take_in(self) -> Command:
        def out() -> None:
            self.pivot.set_control(controls.PositionVoltage(0.0))
            self.roller.set_control(controls.VoltageOut(8.0))

        def up() -> None:
            self.pivot.set_control(controls.PositionVoltage(0.25))
            self.roller.set_control(controls.NeutralOut())

        return self.runEnd(out, up)


class Turret(Subsystem):
    """Turns by odometry to the hub; upper and lower wheel of their own speed, hood fixed at its lower stop."""

    def __init__(self, pose: Callable[[], Pose2d], hub: Callable[[], Translation2d]) -> None:
        super().__init__()
        self.pose, self.hub = pose, hub
        self.lower = measures.talon(31, k_v=0.125, k_p=0.4)
        self.upper = measures.talon(32, k_v=0.125, k_p=0.4)
        self.encoder = hardware.CANcoder(33)
        self.turret = hardware.TalonFX(33)
        config = configs.TalonFXConfiguration()
        config.feedback.feedback_sensor_source = signals.FeedbackSensorSourceValue.FUSED_CANCODER
        config.feedback.feedback_remote_sensor_id = 33
        config.feedback.rotor_to_sensor_ratio = 20.0
        config.slot0.k_p, config.slot0.k_d = 60.0, 0.5
        self.turret.configurator.apply(config)
        self.hood = measures.talon(34, ratio=80.0, k_p=80.0)
        self.floor = measures.talon(35, ratio=3.0)
        self.kicker = measures.talon(36, ratio=2.0)
        self.range = hardware.CANrange(42)

    def distance(self) -> float:
        return self.hub().distance(self.pose().translation())

    def aim(self) -> None:
        pose = self.pose()
        way = self.hub() - pose.translation()
        turn = math.remainder(way.angle().radians() - pose.rotation().radians(), math.tau)
        self.turret.set_control(controls.PositionVoltage(turn / math.tau))
        self.hood.set_control(controls.PositionVoltage(0.0))

    def rest(self) -> Command:
        def run() -> None:
            self.aim()
            for motor in (self.lower, self.upper, self.floor, self.kicker):
                motor.set_control(controls.CoastOut())

        return self.run(run)

    def shoot(self) -> Command:
        def run() -> None:
            self.aim()
            rps = measures.shot_speed(self.distance() - 0.1, HEIGHT, ELEVATION) / METERS_PER_TURN
            lower, upper = 1.1 * rps, 0.9 * rps
            self.lower.set_control(controls.VelocityVoltage(lower))
            self.upper.set_control(controls.VelocityVoltage(upper))
            is_fast = abs(self.lower.get_velocity().value / lower - 1.0) < 0.04
            is_fast = is_fast and abs(self.upper.get_velocity().value / upper - 1.0) < 0.04
            aims = abs(self.turret.get_closed_loop_error().value) < 0.01
            for motor in (self.floor, self.kicker):
                motor.set_control(controls.VoltageOut(7.0 if is_fast and aims else 0.0))

        return self.run(run)


class BackShooter(Subsystem):
    def __init__(self) -> None:
        super().__init__()
        self.wheels = measures.talon(39, k_v=0.125, k_p=0.3)
        self.follower = hardware.TalonFX(40)
        self.follower.set_control(controls.Follower(39, signals.MotorAlignmentValue.OPPOSED))
        self.feeder = measures.talon(41, ratio=2.0)

    def shoot(self) -> Command:
        def run() -> None:
            self.wheels.set_control(controls.VelocityVoltage(40.0))
            self.feeder.set_control(controls.VoltageOut(6.0 if self.wheels.get_velocity().value > 38.0 else 0.0))

        def stop() -> None:
            self.wheels.set_control(controls.CoastOut())
            self.feeder.set_control(controls.NeutralOut())

        return self.runEnd(run, stop)
