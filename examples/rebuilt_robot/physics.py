"""The simulated field around this robot; only `robotpy sim` and `robotpy test` load it."""

import ntcore
from constants import START_BLUE

from games.rebuilt.robot import RebuiltRobotConfig
from games.rebuilt.sim import RebuiltConfig, RebuiltSim, RobotEntry
from simcore.phoenix6.motor import MotorType, TalonFXMotorSim
from simcore.phoenix6.swerve import SwerveDrivetrainSim, swerve_config
from simcore.robotpy.physics import RobotPhysics
from simcore.telemetry.networktables import NetworkTablesSink


class PhysicsEngine(RobotPhysics):
    """REBUILT with this robot on it."""

    def __init__(self, physics_controller, robot) -> None:
        r = robot.container
        build = RebuiltRobotConfig(drivetrain=swerve_config(r.drivetrain))
        start = (START_BLUE.X(), START_BLUE.Y(), START_BLUE.rotation().radians())
        game = RebuiltSim(
            RebuiltConfig(robots=(RobotEntry(config=build, pose=start),), hubs_always_active=True),
            sinks=[NetworkTablesSink(ntcore.NetworkTableInstance.getDefault())],
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
