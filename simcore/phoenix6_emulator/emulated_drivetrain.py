"""The drivetrain behind `SwerveDrivetrain`: odometry, estimate and control, once a period of simulated time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from simcore.errors import ConfigError
from simcore.phoenix6_emulator.drivetrain_requests import DrivetrainRequest, Idle, RequestContext
from simcore.phoenix6_emulator.emulated_module import EmulatedModule, ModuleConstants, ModuleDevices
from simcore.phoenix6_emulator.pose_estimator import PoseEstimator
from simcore.phoenix6_emulator.swerve_kinematics import Kinematics, Pose, wrap

__all__ = ["DEFAULT_HZ", "DrivetrainConstants", "DrivetrainState", "EmulatedDrivetrain", "YawSensor"]

DEFAULT_HZ = 250.0
"""Odometry on CAN FD, which every simulated bus is [Hz]."""


class YawSensor(Protocol):
    """The Pigeon 2."""

    def yaw(self) -> float:
        """As robot code reads it, carried on to the present, continuous [rad]."""
        ...


@dataclass(frozen=True, slots=True)
class DrivetrainConstants:
    """What the modules have in common."""

    can_bus: str
    pigeon_id: int


@dataclass(frozen=True, slots=True, kw_only=True)
class DrivetrainState:
    """What `SwerveDriveState` shows, at the end of one period."""

    pose: Pose
    speeds: tuple[float, float, float]
    """Robot frame [m/s, m/s, rad/s]."""
    states: list[tuple[float, float]]
    """Speed [m/s] and angle [rad] of each module."""
    targets: list[tuple[float, float]]
    positions: list[tuple[float, float]]
    """Travel [m] and angle [rad] of each module."""
    raw_heading: float
    """What the gyro shows [rad]."""
    timestamp: float
    """[s]"""
    period: float
    """[s]"""
    samples: int


class EmulatedDrivetrain:
    """One swerve drive.

    Args:
        constants: What the modules share.
        modules: Their constants.
        hz: How often odometry and control run; 0 for 250 Hz.

    Raises:
        ConfigError: No modules, or a frequency that is not within 1..1000 Hz.
    """

    def __init__(
        self, constants: DrivetrainConstants, modules: Sequence[ModuleConstants], hz: float = DEFAULT_HZ
    ) -> None:
        if not modules:
            raise ConfigError("SwerveDrivetrain: wants at least one module, got none")
        hz = hz or DEFAULT_HZ
        if not 1.0 <= hz <= 1000.0:
            raise ConfigError(f"SwerveDrivetrain: odometry_update_frequency must be 1..1000 Hz, got {hz}")
        self.constants = constants
        self.module_constants = tuple(modules)
        self.hz = hz
        self.period = 1.0 / hz
        self.estimator = PoseEstimator()
        self.kinematics = Kinematics([(m.x, m.y) for m in modules])
        self.modules: list[EmulatedModule] = []
        self.request: DrivetrainRequest = Idle()
        self.on_state: Callable[[DrivetrainState], None] | None = None
        """Called at the end of each period."""
        self.is_running = False
        """Whether the odometry thread runs."""
        self.now = 0.0
        """Of the last sample [s]."""
        self.chassis_speeds = (0.0, 0.0, 0.0)
        """From the modules, robot frame [m/s, m/s, rad/s]."""
        self.context = RequestContext(self.modules, self.kinematics, modules[0].speed_at_12_volts, self.period)
        self._gyro: YawSensor | None = None
        self._heading = 0.0
        self._samples = 0

    def start(self, devices: Sequence[ModuleDevices], gyro: YawSensor) -> None:
        """Begin odometry from the present readings of wheels and gyro."""
        if not self.modules:
            self.modules.extend(EmulatedModule(c, d) for c, d in zip(self.module_constants, devices, strict=True))
            self._gyro = gyro
            yaw = self._refresh()
            self.estimator.reset((0.0, 0.0, 0.0), yaw)
        self.is_running = True

    def stop(self) -> None:
        """Halt odometry and control; after `start` the travel meanwhile counts as one move."""
        self.is_running = False

    @property
    def operator_forward(self) -> float:
        """The operator's forward direction, field frame [rad]."""
        return self.context.operator_forward

    @operator_forward.setter
    def operator_forward(self, direction: float) -> None:
        self.context.operator_forward = direction

    def update(self, now: float) -> None:
        """One period: read, estimate, control, report.

        Args:
            now: Simulated time [s].
        """
        if not self.is_running or self._gyro is None:
            return
        yaw = self._gyro.yaw()
        modules = self.modules
        travels = [(m.refresh(), m) for m in modules]
        dx, dy, _ = self.kinematics.chassis([(d * m.cos, d * m.sin) for d, m in travels])
        estimator = self.estimator
        estimator.update(now, dx, dy, yaw)
        self.now = now
        self.chassis_speeds = self.kinematics.chassis([(m.speed * m.cos, m.speed * m.sin) for m in modules])
        self.context.heading = estimator.pose[2]
        self.request.apply(self.context)
        self._heading = yaw
        self._samples += 1
        if self.on_state is not None:
            self.on_state(self.state)

    @property
    def state(self) -> DrivetrainState:
        """Everything that robot code can read."""
        modules = self.modules
        none = [(0.0, 0.0)] * len(self.module_constants)
        return DrivetrainState(
            pose=self.estimator.pose,
            speeds=self.chassis_speeds,
            states=[(m.speed, m.angle) for m in modules] or none,
            targets=[m.target for m in modules] or none,
            positions=[(m.distance, m.angle) for m in modules] or none,
            raw_heading=self._heading,
            timestamp=self.now,
            period=self.period,
            samples=self._samples,
        )

    # --- resets ---------------------------------------------------------------------------------------------------

    def reset_pose(self, pose: Pose) -> None:
        """Set the pose."""
        self.estimator.reset((pose[0], pose[1], wrap(pose[2])), self._yaw())

    def reset_translation(self, x: float, y: float) -> None:
        """Set the position; the estimated heading stays."""
        self.reset_pose((x, y, self.estimator.pose[2]))

    def reset_rotation(self, heading: float) -> None:
        """Set the heading [rad]; the estimated position stays."""
        x, y, _ = self.estimator.pose
        self.reset_pose((x, y, heading))

    def seed_field_centric(self, heading: float) -> None:
        """Set the heading relative to the operator's forward direction [rad]."""
        self.reset_rotation(heading + self.operator_forward)

    def tare_everything(self) -> None:
        """Set travels and pose to zero; the gyro keeps its reading."""
        for module in self.modules:
            module.zero()
        yaw = self._refresh() if self.modules else 0.0
        self.estimator.reset((0.0, 0.0, 0.0), yaw)

    def add_vision(self, pose: Pose, time: float, std_devs: Sequence[float] | None = None) -> None:
        """Add a camera's measurement of the pose at `time` [s]."""
        self.estimator.add_vision(pose, time, std_devs)

    # --- inside ---------------------------------------------------------------------------------------------------

    def _yaw(self) -> float:
        return 0.0 if self._gyro is None else self._gyro.yaw()

    def _refresh(self) -> float:
        """Read the wheels as the start of the next move; returns the gyro's reading [rad]."""
        for module in self.modules:
            module.refresh()
        return self._yaw()
