"""The generated drivetrain subsystem, as CTRE's template has it."""

from collections.abc import Callable

from commands2 import Command, Subsystem
from phoenix6 import swerve, units, utils
from wpilib import DriverStation, Notifier, RobotController
from wpimath.geometry import Rotation2d


class CommandSwerveDrivetrain(Subsystem, swerve.SwerveDrivetrain):
    """Phoenix 6 SwerveDrivetrain as a subsystem."""

    _SIM_LOOP_PERIOD: units.second = 0.004

    def __init__(
        self, drive_motor_type, steer_motor_type, encoder_type, drivetrain_constants, modules, arg1=None, arg2=None
    ) -> None:
        Subsystem.__init__(self)
        swerve.SwerveDrivetrain.__init__(
            self, drive_motor_type, steer_motor_type, encoder_type, drivetrain_constants, modules, arg1, arg2
        )
        self._sim_notifier: Notifier | None = None
        self._last_sim_time: units.second = 0.0
        self._has_applied_operator_perspective = False
        if utils.is_simulation():
            self._start_sim_thread()

    def apply_request(self, request: Callable[[], swerve.requests.SwerveRequest]) -> Command:
        """A command that applies a request for as long as it runs."""
        return self.run(lambda: self.set_control(request()))

    def periodic(self) -> None:
        if not self._has_applied_operator_perspective or DriverStation.isDisabled():
            color = DriverStation.getAlliance()
            if color is not None:
                self.set_operator_perspective_forward(
                    Rotation2d.fromDegrees(180 if color == DriverStation.Alliance.kRed else 0)
                )
                self._has_applied_operator_perspective = True

    def _start_sim_thread(self) -> None:
        def _sim_periodic() -> None:
            now = utils.get_current_time_seconds()
            dt = now - self._last_sim_time
            self._last_sim_time = now
            self.update_sim_state(dt, RobotController.getBatteryVoltage())

        self._last_sim_time = utils.get_current_time_seconds()
        self._sim_notifier = Notifier(_sim_periodic)
        self._sim_notifier.startPeriodic(self._SIM_LOOP_PERIOD)
