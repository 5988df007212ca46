"""pyfrc's physics as the team wrote it: an intake by its motor's simulated state, a gyro, and a drawn robot."""

import random

import measures
from phoenix6.swerve.sim_swerve_drivetrain import SimSwerveDrivetrain
from pyfrc.physics.core import PhysicsInterface
from wpilib import RobotController
from wpilib.simulation import DCMotorSim
from wpimath.system.plant import DCMotor, LinearSystemId


class PhysicsEngine:
    def __init__(self, physics_controller: PhysicsInterface, robot) -> None:
        self.controller, self.robot = physics_controller, robot
        drivetrain = robot.drivetrain
        self.model = SimSwerveDrivetrain(
            drivetrain.module_locations, drivetrain.pigeon2.sim_state, measures.modules(coupling=3.57)
        )
        gearbox = DCMotor.krakenX60(1)
        self.intake = DCMotorSim(LinearSystemId.DCMotorSystem(gearbox, 0.02, 4.0), gearbox)

    def update_sim(self, now: float, tm_diff: float) -> None:
        volts = RobotController.getBatteryVoltage()
        self.model.update(tm_diff, volts, list(self.robot.drivetrain.modules))
        state = self.robot.intake.sim_state
        state.set_supply_voltage(volts)
        self.intake.setInputVoltage(state.motor_voltage + random.gauss(0.0, 0.01))
        self.intake.update(tm_diff)
        state.set_raw_rotor_position(4.0 * self.intake.getAngularPositionRotations())
        state.set_rotor_velocity(4.0 * self.intake.getAngularVelocity() / 6.283185307)
        self.controller.field.setRobotPose(self.robot.drivetrain.get_state().pose)
