"""A command-based robot that sees by PhotonVision: two cameras, multi-tag estimates into the drivetrain's filter, and
in simulation a VisionSystemSim of its own that it feeds with its own odometry. It believes to start 3 m away."""

import commands2
import measures
import wpilib
from commands2 import Subsystem
from commands2.button import CommandXboxController
from phoenix6 import swerve, utils
from phoenix6.swerve import requests
from vision import Vision
from wpimath.geometry import Pose2d


class Drive(Subsystem, swerve.SwerveDrivetrain):
    def __init__(self, *args) -> None:
        Subsystem.__init__(self)
        swerve.SwerveDrivetrain.__init__(self, *args)
        self.set_state_std_devs((0.1, 0.1, 0.1))

    def simulationPeriodic(self) -> None:
        self.update_sim_state(0.02, wpilib.RobotController.getBatteryVoltage())


class Robot(commands2.TimedCommandRobot):
    def robotInit(self) -> None:
        self.drive = measures.build(Drive, inverted_steer=True)
        self.drive.reset_pose(Pose2d(4.0, 3.4, 0.0))
        self.vision = Vision()
        self.pad = CommandXboxController(0)
        request = requests.RobotCentric().with_drive_request_type(swerve.SwerveModule.DriveRequestType.VELOCITY)
        pad = self.pad
        self.drive.setDefaultCommand(
            self.drive.run(
                lambda: self.drive.set_control(
                    request.with_velocity_x(-3.5 * pad.getLeftY())
                    .with_velocity_y(-3.5 * pad.getLeftX())
                    .with_rotational_rate(-3.5 * pad.getRightX())
                )
            )
        )

    def robotPeriodic(self) -> None:
        super().robotPeriodic()
        for pose, time, deviations in self.vision.measurements():
            self.drive.add_vision_measurement(pose, utils.fpga_to_current_time(time), deviations)

    def _simulationPeriodic(self) -> None:
        self.vision.simulate(self.drive.get_state().pose)

    def facts(self) -> dict:
        return {"estimates": self.vision.estimates}
