from games.rebuilt.sim import RebuiltConfig, RebuiltSim, RobotEntry

from games.rebuilt.robot import RebuiltRobotConfig
from simcore.phoenix6.swerve import SwerveDrivetrainSim, swerve_config
from simcore.robotpy.physics import RobotPhysics

MASS = 50.0  # with bumpers and battery [kg]
BUMPER = (0.86, 0.78)  # length and width over the bumpers [m]
START = (1.5, 0.64, 0.0)  # where it stands as blue: x, y [m], heading [rad]; the trench is ahead


class PhysicsEngine(RobotPhysics):
    def __init__(self, physics_controller, robot):
        drivetrain = swerve_config(robot.drivetrain, mass=MASS, bumper=BUMPER)
        build = RebuiltRobotConfig.around(drivetrain, bumper=BUMPER)
        robots = (RobotEntry(config=build, pose=START, preload=0),)
        game = RebuiltSim(RebuiltConfig(robots=robots, hubs_always_active=True))
        plant = game.robots[0]
        devices = SwerveDrivetrainSim(robot.drivetrain, plant.drive)
        super().__init__(physics_controller, robot, game=game, plant=plant, drivetrain=devices)
