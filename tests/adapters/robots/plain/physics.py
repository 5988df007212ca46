import logging

from games.rebuilt.sim import RebuiltConfig, RebuiltSim, RobotEntry

from games.rebuilt.robot import RebuiltRobotConfig
from simcore.phoenix6.swerve import SwerveDrivetrainSim, swerve_config
from simcore.robot.chassis_config import ChassisConfig
from simcore.robotpy.find import part_of
from simcore.robotpy.physics import RobotPhysics

logging.basicConfig()


class PhysicsEngine(RobotPhysics):
    def __init__(self, physics_controller, robot):
        drivetrain = part_of(robot, "drivetrain")
        config = swerve_config(drivetrain, mass=48.0, bumper=(0.9, 0.8))
        body = ChassisConfig(
            mass=48.0,
            bumper_length=0.9,
            wheel_radius=config.modules[0].wheel_radius,
            wheel_positions=tuple((m.x, m.y) for m in config.modules),
        )
        robot_config = RebuiltRobotConfig(chassis=body, drivetrain=config)
        # along the middle of the neutral zone's near edge, nothing in the way for 5 m
        game = RebuiltSim(RebuiltConfig(robots=(RobotEntry(config=robot_config, pose=(2.0, 1.0, 1.5708)),)))
        plant = game.robots[0]
        self.field = physics_controller.field
        devices = SwerveDrivetrainSim(drivetrain, plant.drive)
        super().__init__(physics_controller, robot, game=game, plant=plant, drivetrain=devices)
