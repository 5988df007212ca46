"""A drivetrain on the swerve model, without a field: an S of 4 m, and steps of every drive request.

Argument: `real` (CTRE's simulation, on the wall clock) or `simulated`. Prints the true path and the responses.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable

import hal
import numpy as np
from wpilib import DriverStation
from wpilib.simulation import DriverStationSim, RoboRioSim

IS_REAL = sys.argv[1] == "real"
if not IS_REAL:
    from simcore.robotpy.simulated_phoenix import install_simulated_phoenix

    PHOENIX = install_simulated_phoenix()

from dataclasses import replace

from phoenix6 import configs, hardware, signals, swerve, unmanaged
from phoenix6.swerve import SwerveModule, requests
from wpimath.geometry import Pose2d, Rotation2d
from wpimath.kinematics import ChassisSpeeds

import simcore.phoenix6.swerve as adapter
from simcore.robot.battery import Battery
from simcore.robot.swerve_drive import SwerveDrive
from simcore.testing.benches import DriveBench

DT = 0.005
INCH = 0.0254
VELOCITY = SwerveModule.DriveRequestType.VELOCITY
OPEN = SwerveModule.DriveRequestType.OPEN_LOOP_VOLTAGE
DELAYS = (0.0, 0.002, 0.004, 0.006, 0.008)
"""Where wheels must turn, what happens depends on when the request meets the encoders' frames, which come every 10 ms.
On the wall clock that is chance; simulated, every delay takes its turn [s]."""
WHEELS = 0.1
"""Where wheels stand before they must turn to the left [rad]."""
EXPO = SwerveModule.SteerRequestType.MOTION_MAGIC_EXPO


def build(output: swerve.ClosedLoopOutputType) -> swerve.SwerveDrivetrain:
    is_torque = output == swerve.ClosedLoopOutputType.TORQUE_CURRENT_FOC
    steer = (
        configs.Slot0Configs()
        .with_k_p(100)
        .with_k_d(0.5)
        .with_k_s(0.1)
        .with_k_v(1.66)
        .with_static_feedforward_sign(signals.StaticFeedforwardSignValue.USE_CLOSED_LOOP_SIGN)
    )
    drive = configs.Slot0Configs().with_k_p(5.0).with_k_s(3.0) if is_torque else None
    steer_configs = configs.TalonFXConfiguration()
    steer_configs.current_limits.stator_current_limit = 60
    steer_configs.current_limits.stator_current_limit_enable = True
    factory = (
        swerve.SwerveModuleConstantsFactory()
        .with_drive_motor_gear_ratio(6.746)
        .with_steer_motor_gear_ratio(21.43)
        .with_coupling_gear_ratio(3.571)
        .with_wheel_radius(2 * INCH)
        .with_steer_motor_gains(steer)
        .with_drive_motor_gains(drive or configs.Slot0Configs().with_k_p(0.1).with_k_v(0.124))
        .with_drive_motor_closed_loop_output(output)
        .with_slip_current(50.0)  # below what spins the wheels: spinning wheels are chance, also on the real clock
        .with_speed_at12_volts(4.69)
        .with_feedback_source(swerve.SteerFeedbackType.FUSED_CANCODER)
        .with_drive_motor_initial_configs(configs.TalonFXConfiguration())
        .with_steer_motor_initial_configs(steer_configs)
        .with_encoder_initial_configs(configs.CANcoderConfiguration())
    )
    corners = enumerate(((11, 11), (11, -11), (-11, 11), (-11, -11)))
    modules = [
        factory.create_module_constants(2 * k + 2, 2 * k + 1, k, 0.1 * k, x * INCH, y * INCH, k % 2 == 1, True, False)
        for k, (x, y) in corners
    ]
    constants = swerve.SwerveDrivetrainConstants().with_can_bus_name("rio").with_pigeon2_id(0)
    return swerve.SwerveDrivetrain(hardware.TalonFX, hardware.TalonFX, hardware.CANcoder, constants, modules)


class Bench:
    """One robot on flat carpet, its devices read and written every 5 ms."""

    def __init__(self, output: swerve.ClosedLoopOutputType) -> None:
        self.robot = build(output)
        config = adapter.swerve_config(self.robot)
        recorded = tuple(replace(m, drive_friction_volts=0.1) for m in config.modules)  # with which the real one ran
        self.drive = SwerveDrive(replace(config, modules=recorded), battery=Battery())
        self.body = DriveBench(self.drive)
        self.devices = adapter.SwerveDrivetrainSim(self.robot, self.drive)
        self.late: list[float] = []
        self.run(0.5)

    def run(self, seconds: float, each: Callable[[], None] = lambda: None, every: int = 4) -> None:
        begin = time.perf_counter()
        for k in range(round(seconds / DT)):
            if IS_REAL:
                due = begin + k * DT
                rest = due - time.perf_counter()
                if rest > 0.0:
                    time.sleep(rest)
                self.late.append(time.perf_counter() - due)
            self.devices.read(self.drive.battery.voltage)
            self.body.step(DT)
            body = self.body
            self.devices.write(body.yaw, 0.0, 0.0, (0.0, 0.0, body.omega))
            if not IS_REAL:
                PHOENIX.step(DT)
            if k % every == every - 1:
                each()
        if IS_REAL:  # the last step takes its time as well
            time.sleep(max(begin + round(seconds / DT) * DT - time.perf_counter(), 0.0))

    def stop(self, wheels: float = 0.0) -> None:
        """At rest, wheels ahead or turned by an angle [rad]: where each step starts."""
        self.robot.set_control(requests.SwerveDriveBrake())
        self.run(0.5)
        self.robot.set_control(requests.PointWheelsAt().with_module_direction(Rotation2d(wheels)))
        self.run(0.4)
        self.drive.reset(angles=[wheels] * 4)
        self.body.reset()
        self.run(0.3)
        self.robot.reset_pose(Pose2d())
        self.run(0.1)


def s_curve(bench: Bench) -> list[list[float]]:
    """2 m/s ahead, first to the left, then to the right: 4 m in 2.4 s."""
    bench.stop()
    path: list[list[float]] = []
    request = requests.ApplyRobotSpeeds().with_drive_request_type(VELOCITY)

    def note() -> None:
        pose = bench.robot.get_state().pose
        path.append([bench.body.x, bench.body.y, bench.body.yaw, pose.X(), pose.Y()])

    for k in range(24):
        speed = 2.0 * min(1.0, (k + 1) / 5, (24 - k) / 5)
        bench.robot.set_control(request.with_speeds(ChassisSpeeds(speed, 0.0, 1.2 if k < 12 else -1.2)))
        bench.run(0.1, note)
    bench.robot.set_control(request.with_speeds(ChassisSpeeds()))
    bench.run(0.4, note)
    return path


def response(
    bench: Bench, request: object, what: Callable[[DriveBench], float], *, wheels: float = 0.0, delay: float = 0.0
) -> list[float]:
    """Time to 90 % of the end [s], largest value over the end, end.

    From wheels turned by an angle [rad], and with a delay of the request, simulated only [s].
    """
    bench.stop(wheels)
    if not IS_REAL:
        PHOENIX.step(delay)
    rows: list[float] = []
    bench.robot.set_control(request)
    bench.run(1.2, lambda: rows.append(what(bench.body)), every=1)
    if not IS_REAL:
        PHOENIX.step(0.010 - delay)
    y = np.array(rows)
    end = float(y[-20:].mean())
    reached = np.flatnonzero(np.abs(y) >= 0.9 * abs(end))
    return [float(reached[0] + 1) * DT, float(np.abs(y).max() / abs(end)), end]


def mean_response(
    bench: Bench, request: object, what: Callable[[DriveBench], float], *, wheels: float = 0.0, turns: bool = False
) -> list[float]:
    """The same, simulated the mean over all delays where wheels must turn first."""
    delays = (0.0,) if IS_REAL or not turns else DELAYS
    return np.mean([response(bench, request, what, wheels=wheels, delay=d) for d in delays], axis=0).tolist()


def main() -> None:
    unmanaged.set_phoenix_diagnostics_start_time(-1)
    hal.initialize(500, 0)
    RoboRioSim.setVInVoltage(12.0)
    DriverStationSim.setDsAttached(True)
    DriverStationSim.setEnabled(True)
    DriverStationSim.notifyNewData()
    DriverStation.refreshData()
    bench = Bench(swerve.ClosedLoopOutputType.VOLTAGE)
    path = s_curve(bench)

    def ahead(body: DriveBench) -> float:
        return body.vx

    def left(body: DriveBench) -> float:
        return body.vy

    def spin(body: DriveBench) -> float:
        return body.omega

    def heading(body: DriveBench) -> float:
        return body.yaw

    centric, robot_centric = requests.FieldCentric, requests.RobotCentric
    facing = requests.FieldCentricFacingAngle().with_heading_pid(6.0, 0.0, 0.0).with_drive_request_type(VELOCITY)
    table = {
        "FieldCentric 2 m/s": (centric().with_velocity_x(2).with_drive_request_type(VELOCITY), ahead),
        "FieldCentric 2 m/s, 12 V scale": (centric().with_velocity_x(2).with_drive_request_type(OPEN), ahead),
        "FieldCentric 1.5 m/s left": (centric().with_velocity_y(1.5).with_drive_request_type(VELOCITY), left),
        "RobotCentric 3 rad/s": (robot_centric().with_rotational_rate(3).with_drive_request_type(VELOCITY), spin),
        "RobotCentric 1.5 m/s left, steer profile": (
            robot_centric().with_velocity_y(1.5).with_drive_request_type(VELOCITY).with_steer_request_type(EXPO),
            left,
        ),
        "ApplyRobotSpeeds 2 m/s": (
            requests.ApplyRobotSpeeds().with_speeds(ChassisSpeeds(2, 0, 0)).with_drive_request_type(VELOCITY),
            ahead,
        ),
        "ApplyFieldSpeeds 1 m/s, 25 N a wheel fed forward": (
            requests.ApplyFieldSpeeds()
            .with_speeds(ChassisSpeeds(1, 0, 0))
            .with_wheel_force_feedforwards_x([25.0] * 4)
            .with_wheel_force_feedforwards_y([0.0] * 4)
            .with_drive_request_type(VELOCITY),
            ahead,
        ),
        "FieldCentricFacingAngle 1 rad": (facing.with_target_direction(Rotation2d(1.0)), heading),
        "SysIdSwerveTranslation 4 V": (requests.SysIdSwerveTranslation().with_volts(4.0), ahead),
        "SysIdSwerveRotation 2 rad/s": (requests.SysIdSwerveRotation().with_rotational_rate(2.0), spin),
    }
    # From 0.1 rad all wheels know which way to turn to the left; from 0 each one tosses a coin, and the robot's way of
    # getting there differs by 45 ms.
    responses = {
        name: mean_response(
            bench, request, what, wheels=WHEELS if what is left else 0.0, turns=what is left or what is spin
        )
        for name, (request, what) in table.items()
    }
    late = bench.late
    bench.robot.close()
    torque = Bench(swerve.ClosedLoopOutputType.TORQUE_CURRENT_FOC)
    request = centric().with_velocity_x(2).with_drive_request_type(VELOCITY)
    responses["FieldCentric 2 m/s, torque current"] = response(torque, request, ahead)
    late += torque.late
    lateness = 1e3 * float(np.percentile(late, 99)) if late else 0.0
    print(json.dumps({"lateness_ms": lateness, "path": path, "responses": responses}), flush=True)
    os._exit(0)


if __name__ == "__main__":
    main()
