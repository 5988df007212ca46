from collections.abc import Callable

from commands2 import Command, Subsystem
from commands2.sysid import SysIdRoutine
from phoenix6 import SignalLogger, swerve, utils
from wpilib import DriverStation, Notifier, RobotController
from wpilib.sysid import SysIdRoutineLog
from wpimath.geometry import Rotation2d


class CommandSwerveDrivetrain(Subsystem, swerve.SwerveDrivetrain):
    _SIM_LOOP_PERIOD = 0.004

    def __init__(self, drive, steer, encoder, constants, arg0=None, arg1=None, arg2=None, arg3=None) -> None:
        Subsystem.__init__(self)
        swerve.SwerveDrivetrain.__init__(self, drive, steer, encoder, constants, arg0, arg1, arg2, arg3)
        self._has_applied_perspective = False
        characterization = swerve.requests.SysIdSwerveTranslation()
        self._routine = SysIdRoutine(
            SysIdRoutine.Config(
                stepVoltage=4.0,
                recordState=lambda state: (
                    SignalLogger.write_string("SysIdTranslation_State", SysIdRoutineLog.stateEnumToString(state))
                    and None
                ),
            ),
            SysIdRoutine.Mechanism(
                lambda volts: self.set_control(characterization.with_volts(volts)), lambda log: None, self
            ),
        )
        if utils.is_simulation():
            self._start_sim_thread()

    def apply_request(self, request: Callable[[], swerve.requests.SwerveRequest]) -> Command:
        return self.run(lambda: self.set_control(request()))

    def sys_id_quasistatic(self, direction: SysIdRoutine.Direction) -> Command:
        return self._routine.quasistatic(direction)

    def sys_id_dynamic(self, direction: SysIdRoutine.Direction) -> Command:
        return self._routine.dynamic(direction)

    def periodic(self) -> None:
        if not self._has_applied_perspective or DriverStation.isDisabled():
            alliance = DriverStation.getAlliance()
            if alliance is not None:
                is_red = alliance == DriverStation.Alliance.kRed
                self.set_operator_perspective_forward(Rotation2d.fromDegrees(180 if is_red else 0))
                self._has_applied_perspective = True

    def _start_sim_thread(self) -> None:
        self._last_sim_time = utils.get_current_time_seconds()

        def step() -> None:
            now = utils.get_current_time_seconds()
            self.update_sim_state(now - self._last_sim_time, RobotController.getBatteryVoltage())
            self._last_sim_time = now

        self._sim_notifier = Notifier(step)
        self._sim_notifier.startPeriodic(self._SIM_LOOP_PERIOD)
