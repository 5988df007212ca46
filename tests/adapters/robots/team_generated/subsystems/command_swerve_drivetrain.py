import math
from collections.abc import Callable

from commands2 import Command, Subsystem
from commands2.sysid import SysIdRoutine
from generated.tuner_constants import TunerSwerveDrivetrain
from pathplannerlib.auto import AutoBuilder, RobotConfig
from pathplannerlib.controller import PIDConstants, PPHolonomicDriveController
from phoenix6 import SignalLogger, swerve, utils
from wpilib import DriverStation, Notifier, RobotController
from wpilib.sysid import SysIdRoutineLog
from wpimath.geometry import Pose2d, Rotation2d
from wpimath.kinematics import ChassisSpeeds


class CommandSwerveDrivetrain(Subsystem, TunerSwerveDrivetrain):
    _SIM_LOOP_PERIOD = 0.004

    def __init__(self, constants, arg0=None, arg1=None, arg2=None, arg3=None) -> None:
        Subsystem.__init__(self)
        TunerSwerveDrivetrain.__init__(self, constants, arg0, arg1, arg2, arg3)
        self._sim_notifier: Notifier | None = None
        self._has_applied_perspective = False
        self._path_request = swerve.requests.ApplyRobotSpeeds()
        translation = swerve.requests.SysIdSwerveTranslation()
        steer = swerve.requests.SysIdSwerveSteerGains()
        rotation = swerve.requests.SysIdSwerveRotation()
        self._routines = {
            "translation": self._routine(
                "SysIdTranslation_State", lambda volts: self.set_control(translation.with_volts(volts)), stepVoltage=4.0
            ),
            "steer": self._routine(
                "SysIdSteer_State", lambda volts: self.set_control(steer.with_volts(volts)), stepVoltage=7.0
            ),
            "rotation": self._routine(
                "SysIdRotation_State",
                lambda rate: (
                    (
                        self.set_control(rotation.with_rotational_rate(rate)),
                        SignalLogger.write_double("Rotational_Rate", rate),
                    )
                    and None
                ),
                rampRate=math.pi / 6,
                stepVoltage=math.pi,
            ),
        }
        self._routine_to_apply = self._routines["translation"]
        if utils.is_simulation():
            self._start_sim_thread()
        self._configure_auto_builder()

    def _routine(self, name: str, drive: Callable[[float], None], **settings: float) -> SysIdRoutine:
        def record(state) -> None:
            SignalLogger.write_string(name, SysIdRoutineLog.stateEnumToString(state))

        return SysIdRoutine(
            SysIdRoutine.Config(recordState=record, **settings), SysIdRoutine.Mechanism(drive, lambda log: None, self)
        )

    def _configure_auto_builder(self) -> None:
        AutoBuilder.configure(
            lambda: self.get_state().pose,
            self.reset_pose,
            lambda: self.get_state().speeds,
            lambda speeds, forces: self.set_control(
                self._path_request.with_speeds(ChassisSpeeds.discretize(speeds, 0.020))
                .with_wheel_force_feedforwards_x(forces.robotRelativeForcesXNewtons)
                .with_wheel_force_feedforwards_y(forces.robotRelativeForcesYNewtons)
            ),
            PPHolonomicDriveController(PIDConstants(10.0, 0.0, 0.0), PIDConstants(7.0, 0.0, 0.0)),
            RobotConfig.fromGUISettings(),
            lambda: (DriverStation.getAlliance() or DriverStation.Alliance.kBlue) == DriverStation.Alliance.kRed,
            self,
        )

    def apply_request(self, request: Callable[[], swerve.requests.SwerveRequest]) -> Command:
        return self.run(lambda: self.set_control(request()))

    def sys_id_quasistatic(self, direction: SysIdRoutine.Direction) -> Command:
        return self._routine_to_apply.quasistatic(direction)

    def sys_id_dynamic(self, direction: SysIdRoutine.Direction) -> Command:
        return self._routine_to_apply.dynamic(direction)

    def periodic(self) -> None:
        if not self._has_applied_perspective or DriverStation.isDisabled():
            alliance = DriverStation.getAlliance()
            if alliance is not None:
                is_red = alliance == DriverStation.Alliance.kRed
                self.set_operator_perspective_forward(Rotation2d.fromDegrees(180 if is_red else 0))
                self._has_applied_perspective = True

    def add_vision_measurement(self, pose: Pose2d, timestamp: float, deviations=None) -> None:
        TunerSwerveDrivetrain.add_vision_measurement(self, pose, utils.fpga_to_current_time(timestamp), deviations)

    def sample_pose_at(self, timestamp: float) -> Pose2d | None:
        return TunerSwerveDrivetrain.sample_pose_at(self, utils.fpga_to_current_time(timestamp))

    def _start_sim_thread(self) -> None:
        self._last_sim_time = utils.get_current_time_seconds()

        def step() -> None:
            now = utils.get_current_time_seconds()
            self.update_sim_state(now - self._last_sim_time, RobotController.getBatteryVoltage())
            self._last_sim_time = now

        self._sim_notifier = Notifier(step)
        self._sim_notifier.startPeriodic(self._SIM_LOOP_PERIOD)
