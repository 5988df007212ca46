from ntcore import NetworkTableInstance
from phoenix6 import SignalLogger, swerve
from wpilib import Color, Color8Bit, Mechanism2d, SmartDashboard
from wpimath.geometry import Pose2d
from wpimath.kinematics import ChassisSpeeds, SwerveModulePosition, SwerveModuleState


class Telemetry:
    """Telemetry of the drivetrain, 250 times a second on its odometry thread."""

    def __init__(self, max_speed: float) -> None:
        self.max_speed = max_speed
        SignalLogger.start()
        table = NetworkTableInstance.getDefault().getTable("DriveState")
        self.pose = table.getStructTopic("Pose", Pose2d).publish()
        self.speeds = table.getStructTopic("Speeds", ChassisSpeeds).publish()
        self.states = table.getStructArrayTopic("ModuleStates", SwerveModuleState).publish()
        self.targets = table.getStructArrayTopic("ModuleTargets", SwerveModuleState).publish()
        self.positions = table.getStructArrayTopic("ModulePositions", SwerveModulePosition).publish()
        self.frequency = table.getDoubleTopic("OdometryFrequency").publish()
        self.timestamp = table.getDoubleTopic("Timestamp").publish()
        self.kind = NetworkTableInstance.getDefault().getStringTopic("/Pose/.type").publish()
        self.field = NetworkTableInstance.getDefault().getDoubleArrayTopic("/Pose/robotPose").publish()
        self.arrows = []
        for k in range(4):
            drawing = Mechanism2d(1, 1)
            root = drawing.getRoot("Root", 0.5, 0.5)
            self.arrows.append(root.appendLigament("Speed", 0.5, 0, 0, Color8Bit(Color.kWhite)))
            SmartDashboard.putData(f"Module {k}", drawing)

    def telemeterize(self, state: swerve.SwerveDrivetrain.SwerveDriveState) -> None:
        self.pose.set(state.pose)
        self.speeds.set(state.speeds)
        self.states.set(state.module_states)
        self.positions.set(state.module_positions)
        self.targets.set(state.module_targets)
        self.timestamp.set(state.timestamp)
        self.frequency.set(1.0 / state.odometry_period)
        SignalLogger.write_struct("DriveState/Pose", Pose2d, state.pose)
        SignalLogger.write_struct("DriveState/Speeds", ChassisSpeeds, state.speeds)
        SignalLogger.write_struct_array("DriveState/ModuleStates", SwerveModuleState, state.module_states)
        SignalLogger.write_struct_array("DriveState/ModuleTargets", SwerveModuleState, state.module_targets)
        SignalLogger.write_struct_array("DriveState/ModulePositions", SwerveModulePosition, state.module_positions)
        SignalLogger.write_double("DriveState/OdometryPeriod", state.odometry_period, "seconds")
        self.kind.set("Field2d")
        self.field.set([state.pose.x, state.pose.y, state.pose.rotation().degrees()])
        for arrow, module in zip(self.arrows, state.module_states, strict=True):
            arrow.setAngle(module.angle.degrees())
            arrow.setLength(module.speed / (2 * self.max_speed))
