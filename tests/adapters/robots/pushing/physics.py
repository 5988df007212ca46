import math
from dataclasses import replace

from games.rebuilt.sim import RebuiltConfig, RebuiltSim, RobotEntry

from simcore.phoenix6.swerve import SwerveDrivetrainSim, swerve_config
from simcore.phoenix6.talon_motor import TalonFXMotorSim
from simcore.robot.chassis_config import ChassisConfig
from simcore.robotpy.physics import RobotPhysics


class PhysicsEngine(RobotPhysics):
    def __init__(self, physics_controller, robot):
        config = swerve_config(robot.drivetrain, wheel_cof=4.0)  # grip enough to stall the motors
        free = tuple(replace(m, drive_stator_limit=math.inf, drive_supply_limit=math.inf) for m in config.modules)
        body = ChassisConfig(
            wheel_radius=config.modules[0].wheel_radius, wheel_positions=tuple((m.x, m.y) for m in config.modules)
        )
        wheels = RebuiltRobotConfig().shooter
        jammed = replace(wheels, gearbox=replace(wheels.gearbox, stator_current_limit=math.inf), inertia=5.0)
        build = RebuiltRobotConfig(chassis=body, drivetrain=replace(config, modules=free), shooter=jammed)
        # bumpers 5 cm from the alliance wall, looking at it
        game = RebuiltSim(RebuiltConfig(robots=(RobotEntry(config=build, pose=(0.45, 2.2, math.pi)),)))
        plant = game.robots[0]
        super().__init__(
            physics_controller,
            robot,
            game=game,
            plant=plant,
            drivetrain=SwerveDrivetrainSim(robot.drivetrain, plant.drive),
            motors=[TalonFXMotorSim(robot.shooter, plant.shooter_wheels, followers=robot.followers)],
        )
