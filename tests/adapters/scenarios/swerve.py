"""A real `SwerveDrivetrain` on the model and the engine: truth beside odometry. Argument: a seed for the inversions."""

from __future__ import annotations

import math
import sys

import numpy as np
from commands2 import Subsystem
from phoenix6 import configs, hardware, signals, swerve
from phoenix6.swerve import requests
from realtime import DT, Loop, enable, report, start
from wpimath.geometry import Pose2d, Rotation2d
from wpimath.kinematics import ChassisSpeeds

import simcore.phoenix6.swerve as adapter  # before the drivetrain is built, as a physics.py does
from simcore.devices.motor_ports import SwervePorts
from simcore.match.motion import Motion
from simcore.phoenix6.sensor_ports import CANcoderSim, Pigeon2Sim
from simcore.phoenix6.talon_motor import TalonPort
from simcore.physics.contact_law import WALL
from simcore.physics.shapes import Box
from simcore.physics.world import PhysicsWorld
from simcore.robot.battery import Battery
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.chassis_config import ChassisConfig
from simcore.robot.gyro import Gyro, gyro_config
from simcore.robot.swerve_drive import SwerveDrive
from simcore.testing.benches import LoneChassis
from simcore.units import GRAVITY

INCH = 0.0254
COUPLING = 50.0 / 14.0


class Drivetrain(Subsystem, swerve.SwerveDrivetrain):
    """Built as the generated class builds itself: trailing None included."""

    def __init__(self, constants, modules) -> None:
        Subsystem.__init__(self)
        swerve.SwerveDrivetrain.__init__(
            self, hardware.TalonFX, hardware.TalonFX, hardware.CANcoder, constants, modules, None, None, None
        )


def build(rng: np.random.Generator | None) -> Drivetrain:
    steer_gains = (
        configs.Slot0Configs()
        .with_k_p(100)
        .with_k_d(0.5)
        .with_k_s(0.1)
        .with_k_v(1.66)
        .with_static_feedforward_sign(signals.StaticFeedforwardSignValue.USE_CLOSED_LOOP_SIGN)
    )
    steer_configs = configs.TalonFXConfiguration()
    steer_configs.current_limits.stator_current_limit = 60
    steer_configs.current_limits.stator_current_limit_enable = True
    factory = (
        swerve.SwerveModuleConstantsFactory()
        .with_drive_motor_gear_ratio(6.746031746031747)
        .with_steer_motor_gear_ratio(21.428571428571427)
        .with_coupling_gear_ratio(COUPLING)
        .with_wheel_radius(2 * INCH)
        .with_steer_motor_gains(steer_gains)
        .with_drive_motor_gains(configs.Slot0Configs().with_k_p(0.1).with_k_v(0.124))
        .with_slip_current(120.0)
        .with_speed_at12_volts(4.69)
        .with_feedback_source(swerve.SteerFeedbackType.FUSED_CANCODER)
        .with_drive_motor_initial_configs(configs.TalonFXConfiguration())
        .with_steer_motor_initial_configs(steer_configs)
        .with_encoder_initial_configs(configs.CANcoderConfiguration())
    )
    modules = []
    for k, (x, y) in enumerate(((11, 11), (11, -11), (-11, 11), (-11, -11))):
        drive, steer, encoder = (k % 2 == 1, True, False) if rng is None else (bool(b) for b in rng.integers(0, 2, 3))
        offset = 0.1 * k if rng is None else float(rng.uniform(-0.5, 0.5))
        modules.append(
            factory.create_module_constants(2 * k + 2, 2 * k + 1, k, offset, x * INCH, y * INCH, drive, steer, encoder)
        )
    constants = swerve.SwerveDrivetrainConstants().with_can_bus_name("rio").with_pigeon2_id(0)
    return Drivetrain(constants, modules)


def main() -> None:
    start()
    rng = np.random.default_rng(int(sys.argv[1])) if len(sys.argv) > 1 else None
    robot = build(rng)
    config = adapter.swerve_config(robot)
    body = ChassisConfig(wheel_positions=tuple((m.x, m.y) for m in config.modules))
    drive = SwerveDrive(config, battery=Battery())
    world = PhysicsWorld()
    world.add_static("wall", Box((0.2, 8.0, 1.0)), (13.0, 0.0, 0.5), surface=WALL)
    place = (3.0, 1.0, 0.5)
    chassis = ChassisSimulation(world, body, pose=place, drivetrain=drive)
    motion = Motion(world, robots=[LoneChassis(chassis)])
    gyro = Gyro(gyro_config("ideal"), np.random.default_rng(0))
    gyro.reset(yaw=place[2], true_yaw=place[2])
    if "bare" in sys.argv:  # by devices alone: inversions and offsets are asked of them
        sim = SwervePorts(
            drive,
            [TalonPort(m.drive_motor) for m in robot.modules],
            [TalonPort(m.steer_motor) for m in robot.modules],
            steer_encoders=[CANcoderSim(m.encoder) for m in robot.modules],
            gyro=Pigeon2Sim(robot.pigeon2),
        )
    else:
        sim = adapter.SwerveDrivetrainSim(robot, drive)
    amps = [0.0]
    module, load = config.modules[0], config.mass * GRAVITY / len(config.modules)
    shaft = module.limited_drive_motor
    drag = shaft.friction + module.rolling_resistance * load * module.wheel_radius  # of a wheel that rolls [N m]

    def step() -> None:
        sim.read(drive.battery.voltage)
        motion.tick(DT)
        roll, pitch, yaw = chassis.roll_pitch_yaw
        gyro.step(DT, yaw, pitch, roll, chassis.robot_rate)
        sim.write(gyro.yaw, gyro.pitch, gyro.roll, gyro.rates)
        if "bare" not in sys.argv:
            robot.update_sim_state(DT, 12.0)  # what the generated class's Notifier calls: must do nothing

    def velocity(vx: float, vy: float, omega: float) -> None:
        robot.set_control(requests.ApplyRobotSpeeds().with_speeds(ChassisSpeeds(vx, vy, omega)))

    def odometry() -> tuple[float, float, float]:
        pose = robot.get_state().pose
        return pose.X(), pose.Y(), pose.rotation().radians()

    loop = Loop(step)
    enable()
    loop.run(0.3)
    robot.reset_pose(Pose2d(7.0, -2.0, Rotation2d(1.0)))  # odometry's affair; the robot stays where it is
    loop.run(0.1)
    results: dict[str, object] = {"pose_after_reset": chassis.pose, "odometry_after_reset": odometry()}

    # steady speeds, truth beside get_state().speeds
    steady = []
    for vx, vy, omega in ((1.5, 0.0, 0.0), (0.0, -1.2, 0.0), (-1.0, 0.8, 1.0), (0.0, 0.0, 4.0)):
        velocity(vx, vy, omega)
        loop.run(0.6)
        rows: list[list[float]] = []

        def watch(_: float, rows: list[list[float]] = rows) -> None:
            s = robot.get_state().speeds
            rows.append([*chassis.ground_velocity, s.vx, s.vy, s.omega])

        loop.run(0.3, watch)
        steady.append({"asked": [vx, vy, omega], "seen": np.mean(rows, axis=0).tolist()})
    results["steady"] = steady
    results["wheels"] = config.wheel_positions
    results["speed_per_volt"] = module.wheel_radius / shaft.emf
    results["friction_volts"] = drag / shaft.torque_driving * shaft.winding
    velocity(0.0, 0.0, 0.0)
    loop.run(0.6)

    # an S of about 6 m; odometry's change of pose against the true one, each in its own start's frame
    def relative(start, end):
        dx, dy, c, s = end[0] - start[0], end[1] - start[1], math.cos(start[2]), math.sin(start[2])
        return [c * dx + s * dy, c * dy - s * dx, math.remainder(end[2] - start[2], math.tau)]

    true_start, odometry_start = chassis.pose, odometry()
    way = [0.0]
    last = [chassis.pose]

    def along(_: float) -> None:
        way[0] += math.dist(last[0][:2], chassis.pose[:2])
        last[0] = chassis.pose

    for k in range(24):
        velocity(2.0 * min(1.0, (k + 1) / 5), 0.0, 1.0 if k < 12 else -1.0)
        loop.run(0.15, along)
    velocity(0.0, 0.0, 0.0)
    loop.run(0.7, along)
    loop.run(0.1)
    results["way"] = way[0]
    results["true_change"] = relative(true_start, chassis.pose)
    results["odometry_change"] = relative(odometry_start, odometry())
    results["pigeon_deg"] = robot.pigeon2.get_yaw().value
    results["true_yaw_deg"] = math.degrees(gyro.yaw - place[2])
    results["angles_deg"] = [math.degrees(a) for a in drive.steer_angles]

    # toward +x into the wall: odometry must not claim to go on by more than the wheels slip
    robot.set_control(
        requests.FieldCentric()
        .with_velocity_x(2.5 * math.cos(_yaw_gap(robot, chassis)))
        .with_velocity_y(2.5 * math.sin(_yaw_gap(robot, chassis)))
    )
    loop.run(3.5, lambda _: amps.append(max(abs(a) for a in drive.drive_motors.current)))
    results["x_at_wall"] = chassis.pose[0]
    results["yaw_at_wall"] = chassis.pose[2]
    results["amps_at_wall"] = amps[-1]
    enable(False)
    loop.run(0.5)
    results["speed_disabled"] = chassis.speed
    results["volts"] = drive.battery.voltage
    world.close()
    report(loop, **results)


def _yaw_gap(robot: Drivetrain, chassis: ChassisSimulation) -> float:
    """How far odometry's axes are turned against the field's."""
    return robot.get_state().pose.rotation().radians() - chassis.pose[2]


if __name__ == "__main__":
    main()
