"""What this team had before: a model of the drivetrain without a field, and an intake that is slow as molasses."""

import measures
from phoenix6.swerve.sim_swerve_drivetrain import SimSwerveDrivetrain
from wpilib import RobotController

INTAKE_RPS_PER_VOLT = 0.25  # no motor of ours would do that


class PhysicsEngine:
    def __init__(self, physics_controller, robot):
        self.robot = robot
        d = robot.drivetrain
        self.model = SimSwerveDrivetrain(d.module_locations, d.pigeon2.sim_state, measures.modules())

    def update_sim(self, now, tm_diff):
        d = self.robot.drivetrain
        volts = RobotController.getBatteryVoltage()
        self.model.update(tm_diff, volts, list(d.modules))
        d.pigeon2.sim_state.add_yaw(1.0)  # a spinning robot, if anybody listened
        intake = self.robot.intake.sim_state
        intake.set_supply_voltage(volts)
        rps = -4.0 * INTAKE_RPS_PER_VOLT * intake.motor_voltage
        intake.set_rotor_velocity(-rps)
        intake.add_rotor_position(-rps * tm_diff)
