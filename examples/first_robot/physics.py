from simcore import Match, RobotConfig, RobotEntry, RobotPhysics, SwerveDrivetrainSim, find_game, swerve_config

MASS = 50.0  # with bumpers and battery [kg]
BUMPER = (0.86, 0.78)  # length and width over the bumpers [m]
START = (1.5, 0.64, 0.0)  # where it stands as blue: x, y [m], heading [rad]; the trench is ahead


class PhysicsEngine(RobotPhysics):
    def __init__(self, physics_controller, robot):
        drivetrain = swerve_config(robot.drivetrain, mass=MASS, bumper=BUMPER)
        build = RobotConfig(drivetrain=drivetrain, bumper=BUMPER)
        robots = [RobotEntry(config=build, start=START, preload=0)]
        match = Match(find_game("rebuilt"), robots=robots, practice=True)
        devices = SwerveDrivetrainSim(robot.drivetrain, match.robots[0].drive)
        super().__init__(physics_controller, robot, match=match, drivetrain=devices)
