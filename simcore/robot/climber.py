"""Climbers: hooks, moved by mechanisms, that hang on rungs of the field.

A hook engages a rung by moving down onto the rung. The rung then pushes the hook like a stiff spring, never downward.
The force lifts the robot and loads the mechanism through the gears. A hook disengages by rising off the rung. A rung on
a hanging body moves with the body and passes the reaction force on to the body.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from simcore.errors import ConfigError
from simcore.quantities import FIELD_PLACE, ROBOT_LENGTH, ROBOT_PLACE, require_fields
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.mechanisms import ShaftSim
from simcore.typing import Alliance
from simcore.world.hanging import HangingBody
from simcore.world.linkage import Joint, part_pose, part_state, require_mechanisms
from simcore.world.rotation import Vector, minus, rotate, rotate_back

__all__ = ["Climber", "ClimberConfig", "Rung"]

_STIFFNESS = 60_000.0  # [N/m]; estimate, +-50 %: a hook arm of aluminum bends about 1 cm under a robot's weight
_DAMPING = 2_500.0  # [N s/m]; estimate: the robot comes to rest within a few tenths of a second
_GRIP = 0.3  # [-]; coefficient of friction of a hook along a rung, steel on aluminum
_SPREAD = 3.0  # [m]; largest horizontal distance of a hook from the center of the robot
_FAR = 0.5  # [m]; a hook farther than `reach` + 0.5 m from all rungs cannot engage a rung in the next sub-step


@dataclass(frozen=True, slots=True, kw_only=True)
class Rung:
    """Straight bar on the field on which climbers can hang."""

    name: str
    start: Vector
    """Position of the first end of the rung, field frame [m]."""
    end: Vector
    """Position of the second end of the rung, field frame [m]."""
    mount: str = ""
    """Name of the hanging body to which the rung is fixed; empty for a rung fixed to the field. `start` and `end` apply
    to the body at rest."""
    alliance: Alliance | None = None
    """Alliance that owns the rung; None for a neutral rung."""

    def __post_init__(self) -> None:
        require_fields(self, f"Rung {self.name!r}", start=(FIELD_PLACE,) * 3, end=(FIELD_PLACE,) * 3)
        if math.dist(self.start, self.end) < 1e-3:
            raise ConfigError(f"Rung {self.name!r}: its ends must differ, got {self.start} and {self.end}")

    def nearest(self, point: Vector) -> Vector:
        """Return the point on the rung at rest that is nearest to a given point, field frame [m]."""
        direction = [b - a for a, b in zip(self.start, self.end, strict=True)]
        along = math.fsum((p - a) * w for p, a, w in zip(point, self.start, direction, strict=True))
        share = min(1.0, max(0.0, along / math.fsum(w * w for w in direction)))
        (x, y, z), (wx, wy, wz) = self.start, direction
        return x + share * wx, y + share * wy, z + share * wz


@dataclass(frozen=True, slots=True, kw_only=True)
class ClimberConfig:
    """Config of a climber: a hook, and the joints that move the hook."""

    joints: tuple[Joint, ...]
    """Joints from the robot to the hook; the last joint lifts the robot."""
    offset: Vector = (0.0, 0.0, 0.0)
    """Position of the inside of the hook, in the frame after the last joint [m]."""
    reach: float = 0.04
    """Largest distance between a rung and the inside of the hook at which the hook engages [m]: half of the hook's
    opening."""

    def __post_init__(self) -> None:
        require_fields(self, offset=(ROBOT_PLACE,) * 3, reach=ROBOT_LENGTH)
        if not self.joints:
            raise ConfigError("ClimberConfig: a climber needs at least one joint")

    @property
    def mechanism_names(self) -> tuple[str, ...]:
        """Names of the mechanisms that the climber uses."""
        return tuple(joint.mechanism for joint in self.joints)


class Climber:
    """Climber of a robot: contact state of the hook, and forces between hook and rung.

    Args:
        config: Config of the climber.
        mechanisms: Mechanisms of the robot, by name.
        chassis: Chassis of the robot.
        rungs: Rungs on which the climber can hang.
        mounts: Hanging bodies with rungs, by name.

    Raises:
        UnknownNameError: If the config names a mechanism that the robot does not have.
    """

    def __init__(
        self,
        config: ClimberConfig,
        mechanisms: Mapping[str, ShaftSim],
        chassis: ChassisSimulation,
        rungs: Sequence[Rung],
        mounts: Mapping[str, HangingBody],
    ) -> None:
        require_mechanisms("a climber", config.mechanism_names, mechanisms)
        self.config = config
        self._mechanisms = mechanisms
        self._chassis = chassis
        self._mounts = mounts
        far = config.reach + _FAR
        self._boxes: list[tuple[Rung, list[float], list[float]]] = []  # boxes around the possible positions of rungs
        for rung in rungs:
            axes = list(zip(*self._reached(rung), strict=True))
            self._boxes.append((rung, [min(axis) - far for axis in axes], [max(axis) + far for axis in axes]))
        self.rung: Rung | None = None
        """Rung on which the hook hangs; None while the hook is free."""

    def _reached(self, rung: Rung) -> list[Vector]:
        """Return two opposite corners of the box that contains all positions of a rung, field frame [m]."""
        mount = self._mounts.get(rung.mount)
        if mount is None:
            return [rung.start, rung.end]
        x, y, z = mount.config.pivot
        far = max(math.dist(mount.config.pivot, end) for end in (rung.start, rung.end))
        return [(x - far, y - far, z - far), (x + far, y + far, z + far)]

    @property
    def is_near(self) -> bool:
        """Whether the hook hangs on a rung or could engage a rung in the next sub-step.

        If False, the caller can skip `push`.
        """
        if self.rung is not None:
            return True
        c = self._chassis
        x, y, _ = c.pos
        for _, (ax, ay, _), (bx, by, _) in self._boxes:
            if ax - _SPREAD < x < bx + _SPREAD and ay - _SPREAD < y < by + _SPREAD:
                break
        else:
            return False  # early, to avoid computing the pose of the hook
        pos, _ = part_pose(self.config.joints, self._mechanisms, self.config.offset)
        hook = [p + a for p, a in zip(c.pos, rotate(c.quat, pos), strict=True)]
        return any([_is_inside(hook, low, high) for _, low, high in self._boxes])

    def push(self, h: float) -> tuple[Vector, Vector]:
        """Engage or release a rung, and compute the force of the rung on the hook for the next sub-step.

        The method also applies the force to the mechanism of the last joint as a load torque, and applies the reaction
        force to a swinging rung.

        Args:
            h: Length of the sub-step [s].

        Returns:
            Force on the robot [N], and torque about the center of mass [N m], field frame.
        """
        c = self._chassis
        state = part_state(self.config.joints, self._mechanisms, self.config.offset)
        lever = rotate(c.quat, minus(state.pos, c.distribution.center))
        hook = tuple(p + a for p, a in zip(c.pos, rotate(c.quat, state.pos), strict=True))
        (lx, ly, lz), (wx, wy, wz) = lever, c.rate
        relative = rotate(c.quat, state.vel)
        vel = (
            c.vel[0] + wy * lz - wz * ly + relative[0],
            c.vel[1] + wz * lx - wx * lz + relative[1],
            c.vel[2] + wx * ly - wy * lx + relative[2],
        )
        force = self._force((hook[0], hook[1], hook[2]), vel, h)
        self._load(rotate_back(c.quat, force), state.pos)
        fx, fy, fz = force
        return force, (ly * fz - lz * fy, lz * fx - lx * fz, lx * fy - ly * fx)

    def _nearest(self, rung: Rung, hook: Vector) -> Vector:
        """Return the point on a rung at its current position that is nearest to the hook, field frame [m]."""
        mount = self._mounts.get(rung.mount)
        return rung.nearest(hook) if mount is None else mount.from_rest(rung.nearest(mount.to_rest(hook)))

    def _force(self, hook: Vector, vel: Vector, h: float) -> Vector:
        if self.rung is None and vel[2] < 0.0:
            for rung, low, high in self._boxes:
                if not _is_inside(hook, low, high):
                    continue
                near = self._nearest(rung, hook)
                if math.dist(near, hook) < self.config.reach and hook[2] > near[2]:
                    self.rung = rung
        if self.rung is None:
            return (0.0, 0.0, 0.0)
        near = self._nearest(self.rung, hook)
        dx, dy, dz = (n - p for n, p in zip(near, hook, strict=True))
        if -dz > self.config.reach or math.hypot(dx, dy) > 3.0 * self.config.reach:
            self.rung = None
            return (0.0, 0.0, 0.0)
        (x0, y0, _), (x1, y1, _), divisor = self.rung.start, self.rung.end, 1.0
        mount = self._mounts.get(self.rung.mount)
        if mount is not None:
            (x0, y0, _), (x1, y1, _) = mount.from_rest(self.rung.start), mount.from_rest(self.rung.end)
            vel = minus(vel, mount.velocity_at(near))
            # Implicit Euler, because a light body on such a stiff spring would oscillate with explicit steps.
            divisor += mount.mobility_at(near) * h * (_DAMPING + _STIFFNESS * h)
            dx, dy = dx - vel[0] * h, dy - vel[1] * h
        up = _STIFFNESS * dz - _DAMPING * vel[2]
        if dz <= 0.0 or up <= 0.0:
            return (0.0, 0.0, 0.0)
        fx, fy = (_STIFFNESS * dx - _DAMPING * vel[0]) / divisor, (_STIFFNESS * dy - _DAMPING * vel[1]) / divisor
        size = math.hypot(fx, fy)
        if size > up:  # a hook whose side force exceeds the vertical load slips over the rung
            fx, fy = fx * up / size, fy * up / size
        length = math.hypot(x1 - x0, y1 - y0)
        ax, ay = (x1 - x0) / length, (y1 - y0) / length
        slide = fx * ax + fy * ay
        kept = max(-_GRIP * up, min(_GRIP * up, slide))
        fx, fy = fx + (kept - slide) * ax, fy + (kept - slide) * ay
        if mount is not None:
            mount.pull(near, (-fx, -fy, -up))
        return fx, fy, up

    def _load(self, force: Vector, hook: Vector) -> None:
        """Set the load torque on the last joint's mechanism from a force on the hook.

        Args:
            force: Force on the hook, robot axes [N].
            hook: Position of the hook, robot frame [m].
        """
        joint = self.config.joints[-1]
        frame = part_state(self.config.joints[:-1], self._mechanisms, joint.origin)
        ax, ay, az = rotate(frame.quat, joint.axis)
        fx, fy, fz = force
        if joint.slides:
            effort = fx * ax + fy * ay + fz * az
        else:
            rx, ry, rz = (h - p for h, p in zip(hook, frame.pos, strict=True))
            effort = ax * (ry * fz - rz * fy) + ay * (rz * fx - rx * fz) + az * (rx * fy - ry * fx)
        self._mechanisms[joint.mechanism].set_load(effort * joint.ratio)


def _is_inside(place: Sequence[float], low: Sequence[float], high: Sequence[float]) -> bool:
    """Return whether a point is inside the box between the corners `low` and `high` [m]."""
    (x, y, z), (ax, ay, az), (bx, by, bz) = place, low, high
    return ax < x < bx and ay < y < by and az < z < bz
