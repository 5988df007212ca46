from robot import PULSES, WHEEL_RADIUS
from wpilib import DriverStation

from games.rebuilt import REBUILT
from simcore import Match, RobotConfig, RobotEntry, RobotPhysics, TankConfig
from simcore.robotcode.program.motor_ports import ShaftPorts, SuppliedMotor
from simcore.robotcode.sim.wpilib_ports import EncoderPort, PWMMotorPort, WPILibGyroPort


class PhysicsEngine(RobotPhysics):
    def __init__(self, physics_controller, robot):
        build = RobotConfig(drivetrain=TankConfig(wheel_radius=WHEEL_RADIUS), bumper=(0.9, 0.8))
        match = Match(REBUILT, robots=[RobotEntry(config=build, start=(2.0, 1.2, 1.5708), preload=0)])
        right = robot.right
        devices = ShaftPorts(
            match.robots[0].drive,
            (
                [PWMMotorPort(robot.left)],
                [SuppliedMotor(lambda: right.getVoltage() if DriverStation.isEnabled() else 0.0)],  # any maker's
            ),
            encoders=tuple(EncoderPort(e, pulses_per_turn=PULSES) for e in robot.encoders),
            gyro=WPILibGyroPort(robot.gyro),
        )
        super().__init__(physics_controller, robot, match=match, drivetrain=devices, pace_tests=False)
