import math
from dataclasses import replace

from games.rebuilt import REBUILT
from simcore import Match, RobotEntry, RobotPhysics, SwerveDrivetrainSim, TalonFXMotorSim, swerve_config
from simcore.robot.battery import BatteryConfig
from simcore.robot.chassis_config import ChassisConfig


class PhysicsEngine(RobotPhysics):
    def __init__(self, physics_controller, robot):
        config = swerve_config(robot.drivetrain, wheel_cof=4.0)  # grip enough to stall the motors
        free = tuple(replace(m, drive_stator_limit=math.inf, drive_supply_limit=math.inf) for m in config.modules)
        body = ChassisConfig(
            wheel_radius=config.modules[0].wheel_radius, wheel_positions=tuple((m.x, m.y) for m in config.modules)
        )
        default = REBUILT.robot()
        wheels = default.mechanisms["shooter"]
        jammed = replace(wheels, gearbox=replace(wheels.gearbox, stator_current_limit=math.inf), inertia=5.0)
        build = replace(
            default,
            chassis=body,
            drivetrain=replace(config, modules=free),
            battery=BatteryConfig(reset_hold=0.1),  # or the roboRIO resets: 3 V are left for a heartbeat
            mechanisms={**default.mechanisms, "shooter": jammed},
        )
        # bumpers 5 cm from the alliance wall, looking at it
        match = Match(REBUILT, robots=[RobotEntry(config=build, start=(0.45, 2.2, math.pi))])
        simulated = match.robots[0]
        super().__init__(
            physics_controller,
            robot,
            match=match,
            drivetrain=SwerveDrivetrainSim(robot.drivetrain, simulated.drive),
            motors=[TalonFXMotorSim(robot.shooter, simulated.mechanisms["shooter"], followers=robot.followers)],
        )
