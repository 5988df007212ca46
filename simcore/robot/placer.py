"""Placers: grippers that hold and release one game piece, such as a claw at the end of an arm or elevator.

A held piece moves with the placer. At the release, the piece has the position and velocity of the placer; the world
simulates the motion after the release.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from simcore.errors import ConfigError
from simcore.quantities import ATTITUDE, ROBOT_PLACE, TURN_RATE, require_fields
from simcore.robot.intake import IntakeZone, StoppedMotion, on_part
from simcore.typing import BoolArray, FloatArray
from simcore.world.linkage import Joint, PartState, part_pose, part_state, require_mechanisms
from simcore.world.rotation import IDENTITY, Quaternion, Vector, matrix, multiply

__all__ = ["Placer", "PlacerConfig"]


@dataclass(frozen=True, slots=True, kw_only=True)
class PlacerConfig:
    """Config of a placer: a holder for one piece, moved by mechanisms."""

    joints: tuple[Joint, ...]
    """Joints from the robot to the holder."""
    offset: Vector = (0.0, 0.0, 0.0)
    """Center of the held piece in the frame after the last joint [m]."""
    attitude: Quaternion = IDENTITY
    """Attitude of the held piece in the frame after the last joint, quaternion x, y, z, w."""
    roller: str
    """Name of the mechanism that takes and releases pieces: rollers, or the jaw of a claw."""
    take_speed: float = math.tau
    """Forward speed of the roller above which the placer takes a piece [rad/s]."""
    release_speed: float = math.tau
    """Backward speed of the roller above which the placer releases the piece [rad/s]."""
    passes_through: bool = False
    """Whether the placer also releases the piece when the roller stops and then turns forward faster than
    `release_speed`."""
    zone: IntakeZone
    """Zone in which the placer takes a piece, in the frame after the last joint."""
    from_storage: bool = False
    """Whether the placer also takes pieces from a storage."""
    storage: str = ""
    """Name of the storage that supplies pieces; empty for the robot's first storage."""
    handover: Vector | None = None
    """Handover point of the storage, robot frame [m]. The placer takes a piece from the storage while the zone contains
    this point; None if the placer takes pieces from the storage at any position."""
    kinds: tuple[str, ...] = ()
    """Kinds of pieces that the placer takes; empty for all kinds."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            offset=(ROBOT_PLACE,) * 3,
            take_speed=TURN_RATE,
            release_speed=TURN_RATE,
            attitude=ATTITUDE,
            handover=(ROBOT_PLACE,) * 3,
        )
        if self.handover is not None and not self.from_storage:
            raise ConfigError("PlacerConfig: handover is where a storage hands over pieces; set from_storage, too")

    @property
    def mechanism_names(self) -> tuple[str, ...]:
        """Names of the mechanisms that the placer uses."""
        return (self.roller, *(joint.mechanism for joint in self.joints))


class Placer:
    """Placer of a robot, which holds at most one piece.

    Args:
        config: Config of the placer.
        mechanisms: Mechanisms of the robot, by name.

    Raises:
        UnknownNameError: If the config names a mechanism that the robot does not have.
    """

    def __init__(self, config: PlacerConfig, mechanisms: Mapping[str, StoppedMotion]) -> None:
        require_mechanisms("a placer", config.mechanism_names, mechanisms)
        self.config = config
        self._mechanisms = mechanisms
        self.piece: int | None = None
        """Slot of the held piece; None if the placer is empty."""
        self._has_stopped = True

    @property
    def takes(self) -> bool:
        """Whether the placer is empty and the roller turns forward faster than `take_speed`.

        With `passes_through`, the roller must also have been slow since the last take or release; see `note_roller`.
        """
        if self.piece is not None or (self.config.passes_through and not self._has_stopped):
            return False
        return self._mechanisms[self.config.roller].velocity > self.config.take_speed

    @property
    def is_at_handover(self) -> bool:
        """Whether the placer uses a storage and is at a position for the handover; see `PlacerConfig.handover`."""
        place = self.config.handover
        return self.config.from_storage and (place is None or bool(self.captured(np.array([place]))[0]))

    @property
    def releases(self) -> bool:
        """Whether the placer holds a piece and the roller turns fast enough in a direction that releases the piece."""
        if self.piece is None:
            return False
        velocity = self._mechanisms[self.config.roller].velocity
        if self.config.passes_through and self._has_stopped and velocity > self.config.release_speed:
            return True
        return velocity < -self.config.release_speed

    def note_roller(self) -> None:
        """Record if the roller is slower than `take_speed` and `release_speed`; call this method once per tick."""
        slow = min(self.config.take_speed, self.config.release_speed)
        if abs(self._mechanisms[self.config.roller].velocity) < slow:
            self._has_stopped = True

    def take(self, slot: int) -> None:
        """Hold the piece in slot `slot` of the piece pool from now on."""
        self.piece = slot
        self._has_stopped = False

    def let_go(self) -> int:
        """Empty the placer, and return the slot of the released piece."""
        assert self.piece is not None
        slot, self.piece = self.piece, None
        self._has_stopped = False
        return slot

    @property
    def around(self) -> tuple[Vector, Vector, float]:
        """Bounding sphere of the zone: previous center, current center and radius, robot frame [m].

        The previous center is equal to the current center, because a placer does not test the paths of pieces.
        """
        middle, radius = self.config.zone.ball
        now = on_part(part_pose(self.config.joints, self._mechanisms), middle)
        return now, now, radius

    def captured(self, pos_robot: FloatArray) -> BoolArray:
        """Return whether each piece is in the zone, regardless of the roller.

        Args:
            pos_robot: Centers of the pieces, robot frame [m], shape (n, 3).

        Returns:
            Mask, shape (n,).
        """
        pos, quat = part_pose(self.config.joints, self._mechanisms)
        return self.config.zone.contains((pos_robot - np.array(pos)) @ matrix(quat))

    def held_state(self) -> PartState:
        """Return the pose and motion of a held piece in the robot frame, relative to the robot."""
        state = part_state(self.config.joints, self._mechanisms, self.config.offset)
        return state._replace(quat=multiply(state.quat, self.config.attitude))
