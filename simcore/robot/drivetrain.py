"""What moves a robot on wheels, for a chassis in the world and for one on a plane."""

from __future__ import annotations

from typing import Protocol

from simcore.geometry.rotation import Vector
from simcore.robot.wheel_loads import LoadTransfer, WheeledRobot

__all__ = ["Drivetrain"]


class Drivetrain(Protocol):
    """What moves a chassis: tire forces from motors, seen from the robot frame."""

    @property
    def robot(self) -> WheeledRobot:
        """Mass, center of mass and where the wheels are."""
        ...

    @property
    def normal_loads(self) -> list[float]:
        """Load of each wheel, averaged over the last `step` [N]."""
        ...

    def set_mass_properties(self, mass: float, yaw_inertia: float, center_of_mass: Vector) -> None:
        """What the robot weighs from the next step on [kg, kg m^2, m]; `robot` gives it from then on."""
        ...

    @property
    def mean_change(self) -> tuple[float, float, float]:
        """Mean over the last `step` of what the tires had changed until then [m/s, m/s, rad/s]."""
        ...

    @property
    def change(self) -> tuple[float, float, float]:
        """Of the velocity by tire forces, in the present step until now [m/s, m/s, rad/s]."""
        ...

    def begin_step(
        self,
        h: float,
        vx: float,
        vy: float,
        omega: float,
        normal_loads: LoadTransfer,
        ax: float = 0.0,
        ay: float = 0.0,
        alpha: float = 0.0,
        *,
        may_rest: bool = True,
    ) -> list[float]:
        """Begin a step of h [s]; returns the lengths of the parts that `advance` is called for [s].

        Args:
            h: Step [s].
            vx: Velocity over ground of the point on the carpet under the center of mass, forward [m/s].
            vy: The same, to the left [m/s].
            omega: Yaw rate [rad/s].
            normal_loads: Load of each wheel, which follows what the tires do within the step.
            ax: Acceleration that the world will add by itself (a slope, a wall that pushes back), forward [m/s^2].
            ay: The same, to the left [m/s^2].
            alpha: The same for the yaw rate [rad/s^2].
            may_rest: Whether one part is enough for a robot in which nothing moves.
        """
        ...

    def advance(self, h: float) -> None:
        """Wheels and motors in the next part of the step, h [s] long."""
        ...
