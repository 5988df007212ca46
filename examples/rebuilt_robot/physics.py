"""The simulated field around this robot; only `robotpy sim` and `robotpy test` load it."""

from dataclasses import replace

import ntcore
from constants import PIECE_CAMERA, START_BLUE, TAG_CAMERAS

from simcore import (
    CameraConfig,
    CameraMount,
    CameraTables,
    Match,
    NetworkTablesSink,
    PiecePipeline,
    RobotEntry,
    RobotPhysics,
    SwerveDrivetrainSim,
    TalonFXMotorSim,
    find_game,
    limelight_type,
    run_variation,
    swerve_config,
)
from simcore.robotcode.makers.phoenix6.talon_motor import MotorType

FRONT_RIGHT, FRONT_LEFT = TAG_CAMERAS
CAMERAS = (
    CameraConfig(
        name=FRONT_RIGHT,
        type=limelight_type("LL4"),
        mount=CameraMount(x=0.28, y=-0.24, z=0.35, pitch_deg=-20.0, yaw_deg=-15.0),
    ),
    CameraConfig(
        name=FRONT_LEFT,
        type=limelight_type("LL3"),
        mount=CameraMount(x=0.28, y=0.24, z=0.35, pitch_deg=-20.0, yaw_deg=15.0),
    ),
    CameraConfig(
        name=PIECE_CAMERA,
        type=limelight_type("LL3"),
        mount=CameraMount(x=-0.30, z=0.48, pitch_deg=25.0, yaw_deg=180.0),
        pipelines=(PiecePipeline(piece_class="fuel", near=0.2, far=4.0),),
        frame_rate=5.0,
    ),
)


class PhysicsEngine(RobotPhysics):
    """REBUILT with this robot on it."""

    def __init__(self, physics_controller, robot) -> None:
        r = robot.container
        tables = ntcore.NetworkTableInstance.getDefault()
        game = find_game("rebuilt")
        build = replace(game.robot(), drivetrain=swerve_config(r.drivetrain), cameras=CAMERAS)
        start = (START_BLUE.X(), START_BLUE.Y(), START_BLUE.rotation().radians())
        variation = run_variation()  # which of many runs this is
        match = Match(
            variation.game(game),
            robots=[RobotEntry(config=variation.robot(build), start=start)],
            seed=variation.seed,
            scatter=variation.scatter,
            practice=True,
            sinks=[NetworkTablesSink(tables)],
            network=CameraTables(tables),
        )
        simulated = match.robots[0]
        shooter, hood, feeder, spindexer, deploy, roller = simulated.mechanisms.values()
        motors = [
            TalonFXMotorSim(
                r.shooter.leaderSimMotor,
                shooter,
                followers=r.shooter.followerSimMotors,
                opposed=(1, 2),
            ),
            TalonFXMotorSim(
                r.hood.hoodSimMotor,
                hood,
                zero_at=hood.position,
                motor_type=MotorType.KRAKEN_X44,
            ),
            TalonFXMotorSim(r.feeder.feederSimMotor, feeder),
            TalonFXMotorSim(r.spindexer.spindexerSimMotor, spindexer),
            TalonFXMotorSim(r.intake.deploySimMotor, deploy),
            TalonFXMotorSim(r.intake.rollerSimMotor, roller),
        ]
        drivetrain = SwerveDrivetrainSim(r.drivetrain, simulated.drive)
        super().__init__(physics_controller, robot, match=match, drivetrain=drivetrain, motors=motors)
