import measures
import wpilib
from magicbot import feedback, will_reset_to
from phoenix6 import swerve
from phoenix6.swerve import requests
from wpimath.geometry import Pose2d


class Drivetrain:
    """Keeps CTRE's drivetrain as a member; every loop applies what was asked for in it."""

    vx = will_reset_to(0.0)
    vy = will_reset_to(0.0)
    turn = will_reset_to(0.0)

    def __init__(self) -> None:
        self.phoenix = measures.build(swerve.SwerveDrivetrain, bus="rio", inverted_steer=True, coupling=3.57)
        self.request = requests.FieldCentric().with_forward_perspective(requests.ForwardPerspectiveValue.BLUE_ALLIANCE)

    def setup(self) -> None:
        self.phoenix.reset_pose(Pose2d(2.0, 1.2, 0.0))

    def go(self, vx: float, vy: float, turn: float) -> None:
        self.vx, self.vy, self.turn = vx, vy, turn

    def pose(self) -> Pose2d:
        return self.phoenix.get_state().pose

    @feedback
    def heading(self) -> float:
        return self.pose().rotation().degrees()

    def execute(self) -> None:
        if wpilib.DriverStation.isEnabled():
            self.phoenix.set_control(
                self.request.with_velocity_x(self.vx).with_velocity_y(self.vy).with_rotational_rate(self.turn)
            )
