"""A headset on a robot that tracks its own motion, as QuestNav's does: it knows where it is since it was told once."""

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

_LONGEST_GAP = 1.0  # [s]; after a longer one the missed frames are not made up for
_BATTERY_LIFE = 7200.0  # [s]; estimate, +-30 %: a Quest 3S with its displays off
_STILL = 0.05  # [m]; a robot that is so near to where it was has not moved
_PLAUSIBLE = 1.0  # [m]; a headset farther from the robot's center than this is on no legal robot


@dataclass(frozen=True, slots=True, kw_only=True)
class QuestConfig:
    """A Meta Quest with the QuestNav app.

    Noise and drift are estimates, +-50 %: QuestNav's examples trust a pose to 2 cm and 2 degrees after a whole match.
    """

    mount: CameraMount | None = None
    """Where it sits; None: as robot code's first pose reset implies, see `QuestHeadset.reset`."""
    frame_rate: float = 100.0
    """Poses a second [1/s], as QuestNav's documentation says."""
    position_noise: float = 0.002
    """Of each pose, in each direction, standard deviation [m]."""
    angle_noise_deg: float = 0.05
    position_drift: float = 0.02
    """How far x and y wander in 150 s, standard deviation [m]."""
    yaw_drift_deg: float = 1.0
    """How far yaw wanders in 150 s, standard deviation [deg]."""

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
    """One pose."""

    number: int
    """Counts up by one."""
    time: float
    """When it was taken, and sent: the headset predicts its pose to the present. Simulated [s]."""
    position: Vector
    """Of the headset, in the frame that it was last told; before, in that of its start [m]."""
    attitude: Quaternion


@dataclass(slots=True)
class PoseReset:
    """Robot code tells the headset where it is."""

    position: Vector
    attitude: Quaternion


class HeadsetPort(Protocol):
    """What a headset speaks to robot code through."""

    def read(self) -> Sequence[PoseReset]:
        """Pose resets since the last call, oldest first."""
        ...

    def publish(self, frames: Sequence[QuestFrame], battery_percent: int) -> None:
        """Send poses, oldest first, and how the headset does."""
        ...

    def close(self) -> None:
        """Withdraw all topics."""
        ...


class QuestHeadset:
    """Tracks a robot's motion.

    Args:
        config: What it is.
        rng: For its noise and drift.
        robot: Number of the robot that carries it.
        ports: Where it publishes and listens.
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
        """Where it sits, as far as anybody has said."""
        self._assumed = CameraMount()  # as long as nobody has said
        self.last: QuestFrame | None = None
        self.resets = 0
        """How often robot code has told it where it is."""
        self._rng = rng
        self._period = 1.0 / config.frame_rate
        self._next = float(rng.uniform(0.0, self._period))
        self._number = 0
        self._frame: tuple[Vector, Quaternion] | None = None  # from field to the frame it reports in
        self._waiting: list[PoseReset] = []  # for the first pose of the robot
        self._last_reset: tuple[PoseReset, Vector] | None = None  # and where the robot then stood
        self._has_derived_mount = False  # of that reset
        self._drift = np.zeros(3)  # x, y [m], yaw [rad] since the last reset
        # A random walk grows with the square root of time.
        walk = math.sqrt(self._period / 150.0)
        drift = (config.position_drift, config.position_drift, math.radians(config.yaw_drift_deg))
        self._step = walk * np.array(drift)

    def listen(self, time: float, history: PoseHistory) -> None:
        """Take pose resets that robot code has sent by now [s]."""
        for port in self.ports:
            self._waiting += port.read()
        self._take_resets(time, history)

    def _take_resets(self, time: float, history: PoseHistory) -> None:
        """Take the resets that have waited, as soon as it is known where the robot stands."""
        if len(history):
            waiting, self._waiting = self._waiting, []
            for reset in waiting:
                self.reset(reset, *history.at(time))

    def reset(self, told: PoseReset, robot_pos: Vector, robot_quat: Quaternion) -> None:
        """Take what robot code says as the truth; from here on poses are relative to it.

        Without a mount in its config the headset takes the one that makes the told pose true, if that is on a robot:
        robot code works it out from where it believes the robot to be and where it has mounted the headset. If it is
        not, the headset is taken for in the middle of the robot, turned as told, until a reset does better.

        Args:
            told: Pose of the headset on the field, as robot code believes.
            robot_pos: Where the robot truly is [m].
            robot_quat: Its attitude.
        """
        self.resets += 1
        self._last_reset = told, robot_pos
        self._has_derived_mount = False
        if self.mount is None:
            apart = [told.position[k] - robot_pos[k] for k in range(3)]
            x, y, z = rotate_back(robot_quat, apart)
            inverse = (-robot_quat[0], -robot_quat[1], -robot_quat[2], robot_quat[3])
            roll, pitch, yaw = (math.degrees(angle) for angle in rpy(multiply(inverse, told.attitude)))
            if math.hypot(x, y, z) <= _PLAUSIBLE:
                self.mount = CameraMount(x=x, y=y, z=z, roll_deg=roll, pitch_deg=pitch, yaw_deg=yaw)
                self._has_derived_mount = True
            else:  # robot code errs about the place; how the headset is turned it probably knows
                height = z if abs(z) <= _PLAUSIBLE else 0.0
                self._assumed = CameraMount(z=height, roll_deg=roll, pitch_deg=pitch, yaw_deg=yaw)
        self._drift[:] = 0.0
        self._frame = _frame_to(told.position, told.attitude, *self._pose(robot_pos, robot_quat))

    def move_start(self, old_pos: Vector, robot_pos: Vector, robot_quat: Quaternion) -> None:
        """Let the robot have stood elsewhere when it was last told its pose, if it has not moved since.

        For a match that puts a robot where its auto begins after robot code has set poses for that place. Where the
        robot has moved since the last reset, the headset reports the way on which it is carried.

        Args:
            old_pos: Where the robot was until now [m].
            robot_pos: Where it is now [m].
            robot_quat: Its attitude there.
        """
        if self._last_reset is not None and math.dist(old_pos, self._last_reset[1]) < _STILL:
            if self._has_derived_mount:
                self.mount = None
            self.resets -= 1
            self.reset(self._last_reset[0], robot_pos, robot_quat)

    def update(self, time: float, history: PoseHistory) -> list[QuestFrame]:
        """Take the poses that are due by now, and publish them.

        Args:
            time: Now, simulated [s].
            history: Of the robot that carries it.
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
        if self._frame is None:  # nobody has told it where it is: its own start is its origin
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


def _frame_to(told_pos: Vector, told_quat: Quaternion, pos: Vector, quat: Quaternion) -> tuple[Vector, Quaternion]:
    """The transform that takes a pose of the field to what it was told to be."""
    x, y, z, w = quat
    turn = multiply(told_quat, (-x, -y, -z, w))
    rx, ry, rz = rotate(turn, pos)
    return (told_pos[0] - rx, told_pos[1] - ry, told_pos[2] - rz), turn
