import logging

from games.rebuilt import REBUILT
from simcore import Match, RobotConfig, RobotEntry, RobotPhysics, SwerveDrivetrainSim, part_of, swerve_config
from simcore.robot.chassis_config import ChassisConfig

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
        build = RobotConfig(chassis=body, drivetrain=config)
        # along the near edge of the neutral zone, with nothing in the way for 5 m
        match = Match(REBUILT, robots=[RobotEntry(config=build, start=(2.0, 1.0, 1.5708), preload=0)])
        self.field = physics_controller.field
        devices = SwerveDrivetrainSim(drivetrain, match.robots[0].drive)
        super().__init__(physics_controller, robot, match=match, drivetrain=devices)
