"""Motor requests and pose estimates of a drivetrain case by case, with the robot held still by hand.

Argument: `real` (CTRE's simulation, on the wall clock) or `simulated`. Prints one JSON object: case -> numbers.
"""

from __future__ import annotations

import json
import os
import sys
import time

import hal
from wpilib import DriverStation
from wpilib.simulation import DriverStationSim, RoboRioSim

IS_REAL = sys.argv[1] == "real"
if not IS_REAL:
    from simcore.robotcode.sim.simulated_phoenix import install_simulated_phoenix

    PHOENIX = install_simulated_phoenix()

from phoenix6 import StatusCode, configs, hardware, swerve, unmanaged, utils
from phoenix6.sim import ChassisReference
from phoenix6.swerve import SwerveModule, requests
from wpimath.geometry import Pose2d, Rotation2d, Translation2d
from wpimath.kinematics import ChassisSpeeds, SwerveModuleState

INCH = 0.0254
DRIVE, STEER, COUPLING, RADIUS = 6.746, 21.43, 3.571, 2 * INCH
VELOCITY = SwerveModule.DriveRequestType.VELOCITY
EXPO = SwerveModule.SteerRequestType.MOTION_MAGIC_EXPO
CASES: dict[str, list[float]] = {}


def now() -> float:
    return utils.get_current_time_seconds() if IS_REAL else PHOENIX.world.clock.now


def wait(seconds: float) -> None:
    if IS_REAL:
        time.sleep(seconds)
    else:
        for _ in range(round(seconds / 0.001)):
            PHOENIX.step(0.001)


def enable(on: bool = True) -> None:
    DriverStationSim.setDsAttached(True)
    DriverStationSim.setEnabled(on)
    DriverStationSim.notifyNewData()
    DriverStation.refreshData()


def build(output: swerve.ClosedLoopOutputType = swerve.ClosedLoopOutputType.VOLTAGE) -> swerve.SwerveDrivetrain:
    factory = (
        swerve.SwerveModuleConstantsFactory()
        .with_drive_motor_gear_ratio(DRIVE)
        .with_steer_motor_gear_ratio(STEER)
        .with_coupling_gear_ratio(COUPLING)
        .with_wheel_radius(RADIUS)
        .with_steer_motor_gains(configs.Slot0Configs())
        .with_drive_motor_gains(configs.Slot0Configs())
        .with_drive_motor_closed_loop_output(output)
        .with_steer_motor_closed_loop_output(output)
        .with_slip_current(120.0)
        .with_speed_at12_volts(4.69)
        .with_feedback_source(swerve.SteerFeedbackType.FUSED_CANCODER)
        .with_drive_motor_initial_configs(configs.TalonFXConfiguration())
        .with_steer_motor_initial_configs(configs.TalonFXConfiguration())
        .with_encoder_initial_configs(configs.CANcoderConfiguration())
    )
    corners = enumerate(((11, 11), (11, -11), (-11, 11), (-11, -11)))
    modules = [
        factory.create_module_constants(2 * k + 2, 2 * k + 1, k, 0.0, x * INCH, y * INCH, False, False, False)
        for k, (x, y) in corners
    ]
    constants = swerve.SwerveDrivetrainConstants().with_can_bus_name("rio").with_pigeon2_id(0)
    robot = swerve.SwerveDrivetrain(hardware.TalonFX, hardware.TalonFX, hardware.CANcoder, constants, modules)
    for module in robot.modules:
        for motor in (module.drive_motor, module.steer_motor):
            motor.sim_state.orientation = ChassisReference.COUNTER_CLOCKWISE_POSITIVE
            motor.sim_state.set_supply_voltage(12.0)
    return robot


def put(
    robot: swerve.SwerveDrivetrain, azimuth: float = 0.0, rate: float = 0.0, wheel: float = 0.0, yaw: float = 0.0
) -> None:
    """Set the angle of every module and wheel [rotations, 1/s], and of the gyro [deg]."""
    for module in robot.modules:
        module.encoder.sim_state.set_raw_position(azimuth)
        module.encoder.sim_state.set_velocity(rate)
        module.steer_motor.sim_state.set_raw_rotor_position(azimuth * STEER)
        module.steer_motor.sim_state.set_rotor_velocity(rate * STEER)
        module.drive_motor.sim_state.set_raw_rotor_position(wheel * DRIVE + azimuth * COUPLING)
        module.drive_motor.sim_state.set_rotor_velocity(rate * COUPLING)
    robot.pigeon2.sim_state.set_raw_yaw(yaw)


def value(signal: object) -> float:
    signal.refresh()
    return float(signal.value)


def note(name: str, robot: swerve.SwerveDrivetrain) -> None:
    """Record the targets of all modules, the requests to module 0's motors and the control mode."""
    state = robot.get_state()
    row = [x for t in state.module_targets for x in (t.speed, t.angle.radians())]
    drive, steer = robot.modules[0].drive_motor, robot.modules[0].steer_motor
    mode = drive.get_control_mode()
    mode.refresh()
    is_closed = "VELOCITY" in mode.value.name
    row.append(value(drive.get_closed_loop_reference()) if is_closed else value(drive.get_motor_voltage()))
    row.append(value(steer.get_closed_loop_reference()))
    row.append(float(is_closed))
    CASES[name] = row


def believe(name: str, robot: swerve.SwerveDrivetrain) -> None:
    """Record pose, gyro and the travel of the first module."""
    state = robot.get_state()
    pose = state.pose
    CASES[name] = [
        *(pose.X(), pose.Y(), pose.rotation().radians()),
        state.raw_heading.radians(),
        state.module_positions[0].distance,
    ]


def ask(name: str, robot: swerve.SwerveDrivetrain, request: requests.SwerveRequest, seconds: float = 0.12) -> None:
    robot.set_control(request)
    wait(seconds)
    note(name, robot)


class Direct:
    """Request written in Python that gives all modules one module request."""

    def __init__(self, speed: float, angle: float, **fields: object) -> None:
        self.request = SwerveModule.ModuleRequest().with_state(SwerveModuleState(speed, Rotation2d(angle)))
        for field, what in fields.items():
            setattr(self.request, field, what)

    def apply(self, parameters: swerve.SwerveControlParameters, modules: list[SwerveModule]) -> StatusCode:
        for module in modules:
            module.apply(self.request)
        return StatusCode.OK


def modules(robot: swerve.SwerveDrivetrain) -> None:
    put(robot)
    for name, request in (
        ("1 m/s ahead, open loop", Direct(1.0, 0.0)),
        ("1 m/s ahead", Direct(1.0, 0.0, drive_request=VELOCITY)),
        ("0.5 rad to steer", Direct(1.0, 0.5, drive_request=VELOCITY)),
        ("0.5 rad to steer, open loop", Direct(1.0, 0.5)),
        ("2.5 rad: backwards", Direct(1.0, 2.5, drive_request=VELOCITY)),
        ("90 degrees to steer", Direct(1.0, 1.5707963, drive_request=VELOCITY)),
        ("standing, 1 rad", Direct(0.0, 1.0, drive_request=VELOCITY)),
        ("steered by a profile", Direct(1.0, 0.1, drive_request=VELOCITY, steer_request=EXPO)),
    ):
        ask(name, robot, request)
    put(robot, azimuth=1.5)
    ask("azimuth a turn and a half off", robot, Direct(1.0, 0.3, drive_request=VELOCITY))
    put(robot, rate=1.0)
    ask("azimuth turns, settled", robot, Direct(1.0, 0.0, drive_request=VELOCITY), 0.6)
    put(robot)
    wait(0.6)


def drive_requests(robot: swerve.SwerveDrivetrain) -> None:
    put(robot, yaw=30.0)
    wait(0.1)
    field = requests.FieldCentric().with_velocity_x(1).with_velocity_y(0.5).with_drive_request_type(VELOCITY)
    field.with_rotational_rate(1.0)
    ask("field centric", robot, field)
    robot.set_operator_perspective_forward(Rotation2d(1.5707963))
    ask("field centric, operator at 90 degrees", robot, field)
    ask(
        "field centric, blue's perspective",
        robot,
        field.with_forward_perspective(requests.ForwardPerspectiveValue.BLUE_ALLIANCE),
    )
    speeds = ChassisSpeeds(1, 0.5, 6)
    field_speeds = requests.ApplyFieldSpeeds().with_speeds(speeds).with_drive_request_type(VELOCITY)
    ask("field speeds", robot, field_speeds)
    ask(
        "field speeds, operator's perspective",
        robot,
        field_speeds.with_forward_perspective(requests.ForwardPerspectiveValue.OPERATOR_PERSPECTIVE),
    )
    robot.set_operator_perspective_forward(Rotation2d(0))

    def ahead() -> requests.RobotCentric:
        request = requests.RobotCentric().with_velocity_x(1).with_velocity_y(0.5).with_rotational_rate(1.0)
        return request.with_drive_request_type(VELOCITY)

    ask("robot centric", robot, ahead())
    ask("robot centric, below the deadband", robot, ahead().with_deadband(1.2))
    ask("robot centric, below the rotational deadband", robot, ahead().with_rotational_deadband(1.2))
    ask("robot centric about a corner", robot, ahead().with_center_of_rotation(Translation2d(0.2, 0.1)))
    fast = ahead().with_velocity_x(5).with_velocity_y(0).with_rotational_rate(6.0)
    ask("robot centric, too fast", robot, fast)
    ask("robot centric, too fast and not desaturated", robot, fast.with_desaturate_wheel_speeds(False))
    ask("robot speeds", robot, requests.ApplyRobotSpeeds().with_speeds(speeds).with_drive_request_type(VELOCITY))
    ask("robot centric, standing: directions stay", robot, requests.RobotCentric().with_drive_request_type(VELOCITY))
    ask("wheels at 2.5 rad", robot, requests.PointWheelsAt().with_module_direction(Rotation2d(2.5)))
    ask("brake", robot, requests.SwerveDriveBrake().with_drive_request_type(VELOCITY))
    ask("brake, open loop", robot, requests.SwerveDriveBrake())
    facing = requests.FieldCentricFacingAngle().with_heading_pid(5.0, 0.0, 0.0).with_velocity_x(1)
    facing.with_target_direction(Rotation2d(1.0)).with_drive_request_type(VELOCITY)
    ask("facing 1 rad", robot, facing)
    turning = requests.RobotCentricFacingAngle().with_heading_pid(5.0, 0.0, 0.0).with_max_abs_rotational_rate(2.0)
    ask("facing 3 rad, at most 2 rad/s", robot, turning.with_target_direction(Rotation2d(3.0)))
    ask("SysId translation", robot, requests.SysIdSwerveTranslation().with_volts(1.0))
    ask("SysId rotation", robot, requests.SysIdSwerveRotation().with_rotational_rate(2.0))
    robot.set_control(requests.SysIdSwerveSteerGains().with_volts(1.0))
    wait(0.12)
    CASES["SysId steer"] = [value(robot.modules[0].steer_motor.get_motor_voltage())]
    ask("idle lets go", robot, requests.Idle(), 0.3)


def forces(robot: swerve.SwerveDrivetrain, unit: str) -> None:
    """Record every drive motor's feedforward for wheel forces in the request's own axes."""
    x, y = [25.0, 30.0, 35.0, 40.0], [10.0, -10.0, 5.0, 0.0]
    operator = requests.ForwardPerspectiveValue.OPERATOR_PERSPECTIVE
    field, own = requests.ApplyFieldSpeeds, requests.ApplyRobotSpeeds
    robot.set_operator_perspective_forward(Rotation2d(0.7))
    for name, request, heading, azimuth in (
        ("heading 0", field(), 0.0, 0.0),
        ("heading 1 rad", field(), 1.0, 0.0),
        ("heading 2.5 rad", field(), 2.5, 0.0),
        ("heading 2.5 rad, azimuths turned", field(), 2.5, 0.1),
        ("heading 1 rad, operator at 0.7 rad", field().with_forward_perspective(operator), 1.0, 0.0),
        ("robot's axes, heading 1 rad", own(), 1.0, 0.0),
    ):
        yaw = heading * 180.0 / 3.14159265358979
        put(robot, azimuth=azimuth, yaw=yaw)
        wait(0.1)
        request.with_speeds(ChassisSpeeds(1.0, 0.5, 0.5)).with_drive_request_type(VELOCITY)
        robot.set_control(request.with_wheel_force_feedforwards_x(x).with_wheel_force_feedforwards_y(y))
        wait(0.1)
        put(robot, azimuth=azimuth, wheel=0.001, yaw=yaw)  # CTRE computes its loops only while a rotor moves
        wait(0.1)
        CASES[f"forces fed forward, {unit}, {name}"] = [
            value(module.drive_motor.get_closed_loop_feed_forward()) for module in robot.modules
        ]
    robot.set_operator_perspective_forward(Rotation2d(0.0))
    put(robot)
    wait(0.1)


def belief(robot: swerve.SwerveDrivetrain) -> None:
    put(robot)
    robot.set_operator_perspective_forward(Rotation2d(0))
    wait(0.2)

    def see(name: str, x: float, y: float, turn: float, age: float, deviations: object = None) -> None:
        robot.add_vision_measurement(Pose2d(x, y, Rotation2d(turn)), now() - age, deviations)
        wait(0.05)
        believe(name, robot)

    def reset(x: float, y: float, turn: float, then: float = 0.3) -> None:
        robot.reset_pose(Pose2d(x, y, Rotation2d(turn)))
        wait(then)

    reset(0, 0, 0)
    see("vision, standard trust", 1, 2, 0.5, 0.1)
    reset(0, 0, 0)
    see("vision, own trust", 1, 2, 0.5, 0.1, (0.1, 0.2, 0.3))
    see("vision, trust stays", 2, 1, 0.0, 0.05)
    robot.set_state_std_devs((0.5, 0.5, 0.5))
    reset(3, 4, 1.0)
    see("vision, axes in the robot's frame", 3.5, 3.0, 1.6, 0.1, (0.5, 0.1, 0.25))
    see("vision, older than the last one", 3.5, 3.0, 1.6, 0.25)
    reset(3, 4, 3.0)
    see("vision across half a turn", 3.5, 3.0, -3.0, 0.05, (0.5, 0.5, 0.5))
    reset(0, 0, 0.5)
    put(robot, wheel=2.0, yaw=60.0)
    wait(0.1)
    believe("one arc", robot)
    see("vision from before the move", 0.5, 0.2, 0.8, 0.3, (0.5, 0.1, 0.25))
    robot.set_vision_measurement_std_devs((0.5, 0.5, 0.5))
    reset(0, 0, 0, 0.5)
    see("vision much too old", 1, 0, 0, 5.0)
    pose = robot.sample_pose_at(now() - 0.3)
    assert pose is not None
    CASES["a pose of the past"] = [pose.X(), pose.Y(), pose.rotation().radians()]
    robot.reset_translation(Translation2d(5, 6))
    wait(0.05)
    believe("translation reset", robot)
    robot.reset_rotation(Rotation2d(1.0))
    wait(0.05)
    believe("rotation reset", robot)
    robot.set_operator_perspective_forward(Rotation2d(3.14159265))
    robot.seed_field_centric(Rotation2d(0.2))
    wait(0.05)
    believe("seeded", robot)
    robot.pigeon2.set_yaw(100.0)
    wait(0.1)
    believe("gyro set", robot)
    robot.tare_everything()
    wait(0.1)
    believe("tared", robot)
    put(robot, wheel=3.0, yaw=70.0)
    wait(0.1)
    believe("moved after the tare", robot)
    robot.odometry_thread.stop()
    put(robot, wheel=4.0, yaw=80.0)
    wait(0.1)
    believe("odometry stopped", robot)
    robot.odometry_thread.start()
    wait(0.1)
    believe("odometry goes on", robot)
    calls: list[float] = []
    robot.register_telemetry(lambda state: calls.append(state.timestamp))
    wait(0.4)
    CASES["telemetry per 0.4 s, odometry rate"] = [float(len(calls)), robot.get_odometry_frequency()]


def torque() -> None:
    robot = build(swerve.ClosedLoopOutputType.TORQUE_CURRENT_FOC)
    put(robot)
    wait(0.3)
    request = requests.RobotCentric().with_velocity_x(1).with_drive_request_type(VELOCITY)
    ask("torque current", robot, request)
    forces(robot, "A")
    enable(False)
    for module in robot.modules:
        module.drive_motor.sim_state.set_rotor_velocity(5.0)
    wait(0.4)
    CASES["torque current, disabled: rolls on"] = [value(robot.modules[0].drive_motor.get_torque_current())]
    robot.close()


def main() -> None:
    unmanaged.set_phoenix_diagnostics_start_time(-1)
    hal.initialize(500, 0)
    RoboRioSim.setVInVoltage(12.0)
    enable()
    robot = build()
    put(robot)
    wait(0.4)
    modules(robot)
    drive_requests(robot)
    forces(robot, "V")
    belief(robot)
    robot.close()
    torque()
    print(json.dumps({"lateness_ms": 0.0, "cases": CASES}), flush=True)
    os._exit(0)


if __name__ == "__main__":
    main()
