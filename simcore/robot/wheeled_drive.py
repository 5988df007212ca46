"""What every drivetrain on wheels shares: its step, seen from the chassis, and readings that are the same for all."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Generic, TypeVar

from simcore.errors import ConfigError
from simcore.robot.battery import Battery, BatteryConfig
from simcore.robot.encoders import EncoderCache
from simcore.robot.inner_steps import Forces, follow_frame, mean_forces
from simcore.robot.tire_solver import TireSolver
from simcore.robot.wheel_loads import WheeledRobot, normal_loads
from simcore.typing import FloatArray
from simcore.units import GRAVITY

__all__ = ["WheeledDrive"]

ConfigT = TypeVar("ConfigT", bound=WheeledRobot)


class WheeledDrive(ABC, Generic[ConfigT]):
    """Base of `SwerveDrive` and `TankDrive`: they say how motors turn wheels in `_inner`."""

    def __init__(self, config: ConfigT, *, battery: Battery | None, solver: TireSolver, shafts: int) -> None:
        """Take part in nobody's motion yet.

        Args:
            config: The robot.
            battery: Its battery; None is a stiff 12 V supply. The drive steps it: nobody else must.
            solver: Of its tires.
            shafts: Number of driven shafts with an encoder.
        """
        self.config = config
        self.battery = battery if battery is not None else Battery(BatteryConfig.stiff(12.0))
        self.other_current = 0.0
        """Drawn by everything but the drivetrain, set by the owner at any time [A]."""
        self.enabled = True
        """False: motors go to neutral, as a disabled robot's do."""
        self.time = 0.0
        """Simulated time since the reset [s]."""
        self.encoders = EncoderCache(shafts)
        """Readings at 250 Hz, a column per shaft; drain it once a tick."""
        self._solver = solver
        self._wheels = len(config.positions)
        self._static_loads = normal_loads(config, [True] * self._wheels, (0.0, 0.0, -GRAVITY))
        self._forces: Forces = []
        self._bus = self.battery.voltage

    def _rest(self, shaft_speed: list[float]) -> None:
        """Time at zero, battery rested, encoders empty; the solver moves `shaft_speed` in place from here on."""
        self.time = 0.0
        self._solver.shaft_speed = shaft_speed
        self._solver.shaft_current = [0.0] * len(shaft_speed)
        self._solver.slip = [0.0] * self._wheels
        self._forces = []
        self.battery.reset()
        self._bus = self.battery.voltage
        self.encoders.clear(0.0)

    def step(
        self,
        h: float,
        vx: float,
        vy: float,
        omega: float,
        normal_loads: Sequence[float] | None = None,
        ax: float = 0.0,
        ay: float = 0.0,
    ) -> tuple[float, float, float]:
        """Change of velocity that the tires make in `h` on a free planar body.

        All vectors are in the robot axes at the START of the step; the turn of the robot within the step is followed
        inside. It is force times time over mass, nothing else: add it to the field-frame velocity rotated by the yaw
        at the start of the step, and no term omega x v is needed.

        Args:
            h: Time step of the owner [s]; cut into parts of at most 5 ms.
            vx: Velocity of the center of mass that the chassis really has, forward [m/s].
            vy: To the left [m/s].
            omega: Yaw rate [rad/s].
            normal_loads: Per wheel [N], 0 off the ground; None is the robot at rest on level ground.
            ax: Acceleration that the owner will add itself in this step (gravity along a slope), forward [m/s^2].
                Knowing it, the tires hold a parked robot on a ramp without creeping. It is not in the result.
            ay: To the left [m/s^2].

        Returns:
            Change of vx, vy [m/s] and omega [rad/s].

        Raises:
            NonFiniteError: When an argument is not finite; nothing has changed.
            ConfigError: When there is not one load per wheel.
        """
        loads = self._static_loads if normal_loads is None else normal_loads
        if len(loads) != self._wheels:
            raise ConfigError(f"drivetrain step needs {self._wheels} normal loads, got {len(loads)}")
        result, self._forces = follow_frame(self._inner, self._solver, h, vx, vy, omega, loads, ax, ay)
        return result

    @abstractmethod
    def _inner(
        self, h: float, vx: float, vy: float, omega: float, loads: Sequence[float]
    ) -> tuple[float, float, float]:
        """One inner step: requests, battery, tires and wheels, encoders; the new velocity."""

    def wheel_loads(
        self, touching: Sequence[bool], gravity: Sequence[float], acceleration: Sequence[float]
    ) -> list[float]:
        """Load of each wheel [N] for `step`; see `simcore.robot.wheel_loads.normal_loads`."""
        return normal_loads(self.config, touching, gravity, acceleration)

    @property
    def robot(self) -> ConfigT:
        """The same as `config`, under the name that a chassis asks for."""
        return self.config

    @property
    def bus_voltage(self) -> float:
        """Battery voltage that the motors had in the last inner step [V]."""
        return self._bus

    @property
    def browned_out(self) -> bool:
        """Whether the roboRIO holds the outputs off."""
        return self.battery.browned_out

    @property
    def wheel_forces(self) -> FloatArray:
        """Ground on wheels, robot axes, averaged over the last `step` [N], shape (n, 2)."""
        return mean_forces(self._forces, self._wheels)
