from games.rebuilt.sim import RebuiltConfig, RebuiltSim, RobotEntry
from games.rebuilt.tank import RebuiltTankConfig
from robot import PULSES, WHEEL_RADIUS
from wpilib import DriverStation

from simcore.robot.motor_ports import SuppliedMotor, TankPorts
from simcore.robot.tank_drive import TankConfig
from simcore.robotpy.physics import RobotPhysics
from simcore.robotpy.wpilib_ports import EncoderPort, GyroPort, PWMMotorPort


class PhysicsEngine(RobotPhysics):
    def __init__(self, physics_controller, robot):
        build = RebuiltTankConfig(tank=TankConfig(wheel_radius=WHEEL_RADIUS))
        game = RebuiltSim(RebuiltConfig(robots=(RobotEntry(config=build, pose=(2.0, 1.2, 1.5708)),)))
        plant = game.robots[0]
        right = robot.right
        devices = TankPorts(
            plant.drive,
            [PWMMotorPort(robot.left)],
            [SuppliedMotor(lambda: right.getVoltage() if DriverStation.isEnabled() else 0.0)],  # any maker's
            encoders=tuple(EncoderPort(e, pulses_per_turn=PULSES) for e in robot.encoders),
            gyro=GyroPort(robot.gyro),
        )
        super().__init__(physics_controller, robot, game=game, plant=plant, drivetrain=devices, pace_tests=False)
