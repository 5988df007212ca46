"""Phoenix 6 swerve with REV mechanisms, as CTRE's generator starts it.

Telemetry goes into the hoot log, a bus names a hoot file that does not exist, ids come from the deploy folder, and
mechanisms are in a package.
"""

import json
from pathlib import Path

import measures
import wpilib
from mechanisms.superstructure import Superstructure
from phoenix6 import CANBus, SignalLogger
from wpimath.geometry import Pose2d
from wpimath.kinematics import SwerveModuleState


class Robot(wpilib.TimedRobot):
    def robotInit(self) -> None:
        self.bus = CANBus("", "./logs/example.hoot")
        ids = json.loads((Path(wpilib.getDeployDirectory()) / "ids.json").read_text())
        self.drivetrain = measures.build()
        self.superstructure = Superstructure(ids)
        SignalLogger.start()
        self.drivetrain.register_telemetry(self.telemeterize)

    def telemeterize(self, state) -> None:
        SignalLogger.write_struct("DriveState/Pose", Pose2d, state.pose)
        SignalLogger.write_struct_array("DriveState/ModuleStates", SwerveModuleState, state.module_states)
        SignalLogger.write_double("DriveState/OdometryPeriod", state.odometry_period, "seconds")

    def _simulationPeriodic(self) -> None:
        self.superstructure.simulate()

    def teleopPeriodic(self) -> None:
        self.drivetrain.set_control(measures.driver_request())
        self.superstructure.run(wpilib.DriverStation.getStickButton(0, 1))

    def facts(self) -> dict:
        s = self.superstructure
        return {
            "shooter_rpm": s.shooter.getEncoder().getVelocity(),
            "hood_deg": s.hood.getAbsoluteEncoder().getPosition(),
            "intake_rpm": [m.getEncoder().getVelocity() for m in (s.intake, s.intake_follower)],
            "feeder_rps": s.feeder.get_velocity().value,
        }
