"""The simulated field around this robot; only `robotpy sim` and `robotpy test` load it."""

import ntcore
from constants import PIECE_CAMERA, START_BLUE, TAG_CAMERAS
from games.rebuilt.sim import RebuiltConfig, RebuiltSim, RobotEntry

from games.rebuilt.robot import RebuiltRobotConfig
from simcore.phoenix6.swerve import SwerveDrivetrainSim, swerve_config
from simcore.phoenix6.talon_motor import MotorType, TalonFXMotorSim
from simcore.robotpy.physics import RobotPhysics
from simcore.telemetry.networktables_sink import NetworkTablesSink
from simcore.vision.camera import CameraConfig, CameraMount, PiecePipeline, limelight_type

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
        build = RebuiltRobotConfig(drivetrain=swerve_config(r.drivetrain), cameras=CAMERAS)
        start = (START_BLUE.X(), START_BLUE.Y(), START_BLUE.rotation().radians())
        game = RebuiltSim(
            RebuiltConfig(robots=(RobotEntry(config=build, pose=start),), hubs_always_active=True),
            sinks=[NetworkTablesSink(tables)],
            network=tables,
        )
        plant = game.robots[0]
        motors = [
            TalonFXMotorSim(
                r.shooter.leaderSimMotor,
                plant.shooter_wheels,
                followers=r.shooter.followerSimMotors,
                opposed=(1, 2),
            ),
            TalonFXMotorSim(
                r.hood.hoodSimMotor,
                plant.hood,
                zero_at=plant.hood.position,
                motor_type=MotorType.KRAKEN_X44,
            ),
            TalonFXMotorSim(r.feeder.feederSimMotor, plant.feeder),
            TalonFXMotorSim(r.spindexer.spindexerSimMotor, plant.spindexer),
            TalonFXMotorSim(r.intake.deploySimMotor, plant.deploy),
            TalonFXMotorSim(r.intake.rollerSimMotor, plant.roller),
        ]
        drivetrain = SwerveDrivetrainSim(r.drivetrain, plant.drive)
        super().__init__(physics_controller, robot, game=game, plant=plant, drivetrain=drivetrain, motors=motors)
