"""Simulation of a QuestNav headset, which tracks a robot's motion and reports poses relative to the last pose reset."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from simcore.quantities import FRAME_RATE, NOISE_DEGREES, ROBOT_HEIGHT, require_fields
from simcore.vision.camera import CameraMount, camera_pose
from simcore.vision.heading import PoseHistory
from simcore.world.rotation import Quaternion, Vector, from_rpy, multiply, rotate, rotate_back, rpy

__all__ = ["HeadsetPort", "PoseReset", "QuestConfig", "QuestFrame", "QuestHeadset"]

_LONGEST_GAP = 1.0  # [s]; after a longer gap, missed frames are skipped
_BATTERY_LIFE = 7200.0  # [s]; estimate, +-30 %: a Quest 3S with displays off
_STILL = 0.05  # [m]; a robot this close to its last position counts as not moved
_PLAUSIBLE = 1.0  # [m]; largest distance of a headset from the center of a legal robot


@dataclass(frozen=True, slots=True, kw_only=True)
class QuestConfig:
    """Config of a Meta Quest with the QuestNav app.

    Noise and drift are estimates, +-50 %: QuestNav's examples assume 2 cm and 2 degrees after a whole match.
    """

    mount: CameraMount | None = None
    """Pose of the headset on the robot; None to derive the pose from the pose resets of robot code, as explained at
    `QuestHeadset.reset`."""
    frame_rate: float = 100.0
    """Number of published poses per second [1/s]. Source of the default: QuestNav's documentation."""
    position_noise: float = 0.002
    """Standard deviation of the position noise of each pose along each axis [m]."""
    angle_noise_deg: float = 0.05
    """Standard deviation of the angle noise of each pose about each axis [deg]."""
    position_drift: float = 0.02
    """Standard deviation of the position drift along x and along y after 150 s [m]."""
    yaw_drift_deg: float = 1.0
    """Standard deviation of the yaw drift after 150 s [deg]."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            frame_rate=FRAME_RATE,
            position_noise=ROBOT_HEIGHT,
            angle_noise_deg=NOISE_DEGREES,
            position_drift=ROBOT_HEIGHT,
            yaw_drift_deg=NOISE_DEGREES,
        )


@dataclass(slots=True)
class QuestFrame:
    """Published pose of a headset."""

    number: int
    """Number of the frame; the first frame has number 1."""
    time: float
    """Simulated time of the pose [s]. The model has no latency, because a headset publishes predicted poses."""
    position: Vector
    """Position in the frame that the last pose reset defines, or relative to the start pose before the first reset [m].
    """
    attitude: Quaternion
    """Attitude in the same frame as the position."""


@dataclass(slots=True)
class PoseReset:
    """Request of robot code to set the current pose of the headset, field frame [m]."""

    position: Vector
    attitude: Quaternion


class HeadsetPort(Protocol):
    """Connection between a headset and robot code."""

    def read(self) -> Sequence[PoseReset]:
        """Return the pose resets since the last call, oldest first."""
        ...

    def publish(self, frames: Sequence[QuestFrame], battery_percent: int) -> None:
        """Publish poses, oldest first, and the battery level [%]."""
        ...

    def close(self) -> None:
        """Unpublish all topics."""
        ...


class QuestHeadset:
    """Simulation of a QuestNav headset on a robot.

    Args:
        config: Config of the headset.
        rng: Random generator for noise and drift.
        robot: Number of the robot that carries the headset.
        ports: Connections to robot code; the headset publishes each pose on all ports.
    """

    def __init__(
        self,
        config: QuestConfig,
        rng: np.random.Generator,
        *,
        robot: int = 0,
        ports: Sequence[HeadsetPort] = (),
    ) -> None:
        self.config = config
        self.robot = robot
        self.ports = list(ports)
        self.mount = config.mount
        """Pose of the headset on the robot, from the config or derived from a pose reset; None while unknown."""
        self._assumed = CameraMount()  # used while `mount` is unknown
        self.last: QuestFrame | None = None
        self.resets = 0
        """Number of pose resets so far."""
        self._rng = rng
        self._period = 1.0 / config.frame_rate
        self._next = float(rng.uniform(0.0, self._period))
        self._number = 0
        self._frame: tuple[Vector, Quaternion] | None = None  # transform from the field to the frame of the last reset
        self._waiting: list[PoseReset] = []  # resets that wait for the robot's first pose
        self._last_reset: tuple[PoseReset, Vector] | None = None  # last reset, and the robot's position at its time
        self._has_derived_mount = False  # whether `mount` was derived from the last reset
        self._drift = np.zeros(3)  # x, y [m], yaw [rad] since the last reset
        # A random walk grows with the square root of time.
        walk = math.sqrt(self._period / 150.0)
        drift = (config.position_drift, config.position_drift, math.radians(config.yaw_drift_deg))
        self._step = walk * np.array(drift)

    def listen(self, time: float, history: PoseHistory) -> None:
        """Read all new pose resets of robot code, and apply the resets at the current time [s].

        Resets wait until the history contains a pose of the robot.
        """
        for port in self.ports:
            self._waiting += port.read()
        self._take_resets(time, history)

    def _take_resets(self, time: float, history: PoseHistory) -> None:
        """Apply the waiting resets at a time [s] if the history contains a pose of the robot."""
        if len(history):
            waiting, self._waiting = self._waiting, []
            for reset in waiting:
                self.reset(reset, *history.at(time))

    def reset(self, believed: PoseReset, robot_pos: Vector, robot_quat: Quaternion) -> None:
        """Set the current pose of the headset in the field frame; later poses are relative to this pose.

        Robot code computes the reset from a robot pose and a mount. A headset without a mount derives the mount for
        which the reset is correct. If the derived mount is over 1 m from the robot's center, the headset uses the
        derived rotation at the center of the robot, with the derived height if plausible, until a later reset gives a
        mount within 1 m.

        Args:
            believed: Pose of the headset, field frame, as assumed by robot code.
            robot_pos: True position of the robot, field frame [m].
            robot_quat: True attitude of the robot, field frame.
        """
        self.resets += 1
        self._last_reset = believed, robot_pos
        self._has_derived_mount = False
        if self.mount is None:
            apart = [believed.position[k] - robot_pos[k] for k in range(3)]
            x, y, z = rotate_back(robot_quat, apart)
            inverse = (-robot_quat[0], -robot_quat[1], -robot_quat[2], robot_quat[3])
            roll, pitch, yaw = (math.degrees(angle) for angle in rpy(multiply(inverse, believed.attitude)))
            if math.hypot(x, y, z) <= _PLAUSIBLE:
                self.mount = CameraMount(x=x, y=y, z=z, roll_deg=roll, pitch_deg=pitch, yaw_deg=yaw)
                self._has_derived_mount = True
            else:  # the position in robot code is wrong, but the rotation probably is right
                height = z if abs(z) <= _PLAUSIBLE else 0.0
                self._assumed = CameraMount(z=height, roll_deg=roll, pitch_deg=pitch, yaw_deg=yaw)
        self._drift[:] = 0.0
        self._frame = _frame_to(believed.position, believed.attitude, *self._pose(robot_pos, robot_quat))

    def move_start(self, old_pos: Vector, robot_pos: Vector, robot_quat: Quaternion) -> None:
        """Apply the last reset again at the robot's new pose, if the robot has not moved since the reset.

        A match calls this method after placing a robot at the start pose of an auto, because robot code may already
        have reset poses to this start pose. If the robot has moved since the reset, the headset reports the change of
        pose as motion.

        Args:
            old_pos: Position of the robot before the placement, field frame [m].
            robot_pos: Position of the robot after the placement, field frame [m].
            robot_quat: Attitude of the robot after the placement, field frame.
        """
        if self._last_reset is not None and math.dist(old_pos, self._last_reset[1]) < _STILL:
            if self._has_derived_mount:
                self.mount = None
            self.resets -= 1
            self.reset(self._last_reset[0], robot_pos, robot_quat)

    def update(self, time: float, history: PoseHistory) -> list[QuestFrame]:
        """Apply waiting resets, publish the due poses and the battery level, and return the poses, oldest first.

        Args:
            time: Current simulated time [s].
            history: Poses of the robot that carries the headset.
        """
        if time - self._next > _LONGEST_GAP:
            self._next += math.floor((time - self._next) / self._period) * self._period
        self._take_resets(time, history)
        frames: list[QuestFrame] = []
        while self._next <= time:
            frames.append(self._take(self._next, *history.at(self._next)))
            self._next += self._period
        if frames:
            self.last = frames[-1]
            battery = max(1, round(100.0 * (1.0 - time / _BATTERY_LIFE)))
            for port in self.ports:
                port.publish(frames, battery)
        return frames

    def close(self) -> None:
        """Close all ports."""
        for port in self.ports:
            port.close()

    def _pose(self, robot_pos: Vector, robot_quat: Quaternion) -> tuple[Vector, Quaternion]:
        mount = self.mount or self._assumed
        return camera_pose(robot_pos, robot_quat, mount.position, mount.rotation)

    def _take(self, time: float, robot_pos: Vector, robot_quat: Quaternion) -> QuestFrame:
        pos, quat = self._pose(robot_pos, robot_quat)
        if self._frame is None:  # before the first reset, the start pose is the origin
            self._frame = _frame_to((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), pos, quat)
        origin, turn = self._frame
        x, y, z = rotate(turn, pos)
        noise = self._rng.standard_normal(9).tolist()
        self._drift += self._step * noise[:3]
        dx, dy, dyaw = self._drift.tolist()
        size, angle = self.config.position_noise, math.radians(self.config.angle_noise_deg)
        wobble = from_rpy(angle * noise[6], angle * noise[7], angle * noise[8] + dyaw)
        self._number += 1
        return QuestFrame(
            self._number,
            time,
            (
                origin[0] + x + dx + size * noise[3],
                origin[1] + y + dy + size * noise[4],
                origin[2] + z + size * noise[5],
            ),
            multiply(wobble, multiply(turn, quat)),
        )


def _frame_to(
    believed_pos: Vector, believed_quat: Quaternion, pos: Vector, quat: Quaternion
) -> tuple[Vector, Quaternion]:
    """Compute the translation [m] and rotation that map a true pose to the pose that robot code assumes.

    Both poses of the headset are in the field frame.
    """
    x, y, z, w = quat
    turn = multiply(believed_quat, (-x, -y, -z, w))
    rx, ry, rz = rotate(turn, pos)
    return (believed_pos[0] - rx, believed_pos[1] - ry, believed_pos[2] - rz), turn
