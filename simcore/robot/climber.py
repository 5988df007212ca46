"""Climbers: a hook that a mechanism moves, and the rungs of the field that it can hang on.

A hook that comes down on a rung catches it. From then on the rung pushes the hook back as a stiff spring does, never
down; the push lifts the robot, and loads the mechanism through its gear. It lets go when the hook rises off the rung.
A rung of something that hangs goes with it, and is pulled as much as it pushes.
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

_STIFFNESS = 60_000.0  # [N/m]; estimate, +-50 %: a hook arm of aluminium gives about 1 cm under a robot's weight
_DAMPING = 2_500.0  # [N s/m]; estimate: the robot comes to rest within some tenths of a second
_GRIP = 0.3  # [-]; friction of a hook along a rung, steel on aluminium
_SPREAD = 3.0  # [m]; no hook is farther from the middle of its robot, in plan
_FAR = 0.5  # [m]; farther from all rungs than this and its reach, a hook meets none in the coming sub-step


@dataclass(frozen=True, slots=True, kw_only=True)
class Rung:
    """A straight bar of the field."""

    name: str
    start: Vector
    """One end, field frame [m]."""
    end: Vector
    """The other end [m]."""
    mount: str = ""
    """What hanging body it is part of; it is then where it is while that hangs at rest. Empty: it stays there."""
    alliance: Alliance | None = None
    """Whose it is; None: nobody's."""

    def __post_init__(self) -> None:
        require_fields(self, f"Rung {self.name!r}", start=(FIELD_PLACE,) * 3, end=(FIELD_PLACE,) * 3)
        if math.dist(self.start, self.end) < 1e-3:
            raise ConfigError(f"Rung {self.name!r}: its ends must differ, got {self.start} and {self.end}")

    def nearest(self, point: Vector) -> Vector:
        """The place on the bar that is nearest to a point [m]."""
        way = [b - a for a, b in zip(self.start, self.end, strict=True)]
        along = math.fsum((p - a) * w for p, a, w in zip(point, self.start, way, strict=True))
        share = min(1.0, max(0.0, along / math.fsum(w * w for w in way)))
        (x, y, z), (wx, wy, wz) = self.start, way
        return x + share * wx, y + share * wy, z + share * wz


@dataclass(frozen=True, slots=True, kw_only=True)
class ClimberConfig:
    """A hook and what moves it."""

    joints: tuple[Joint, ...]
    """From the robot to the hook; the last of them is the one that lifts."""
    offset: Vector = (0.0, 0.0, 0.0)
    """Of the hook's inside in the frame after the last joint [m]."""
    reach: float = 0.04
    """How far from the hook's inside a rung may be when it is caught [m]: half of the hook's mouth."""

    def __post_init__(self) -> None:
        require_fields(self, offset=(ROBOT_PLACE,) * 3, reach=ROBOT_LENGTH)
        if not self.joints:
            raise ConfigError("ClimberConfig: a climber needs at least one joint")

    @property
    def mechanism_names(self) -> tuple[str, ...]:
        """All mechanisms that it names."""
        return tuple(joint.mechanism for joint in self.joints)


class Climber:
    """One climber of a robot.

    Args:
        config: Hook and mechanism.
        mechanisms: Of the robot, by name.
        chassis: Of the robot.
        rungs: What it can hang on.
        mounts: Hanging bodies that rungs are parts of, by name.
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
        self._boxes: list[tuple[Rung, list[float], list[float]]] = []  # low and high corner of where a rung may be
        for rung in rungs:
            axes = list(zip(*self._reached(rung), strict=True))
            self._boxes.append((rung, [min(axis) - far for axis in axes], [max(axis) + far for axis in axes]))
        self.rung: Rung | None = None
        """What it hangs on."""

    def _reached(self, rung: Rung) -> list[Vector]:
        """Corners of where a rung may be, however it swings."""
        mount = self._mounts.get(rung.mount)
        if mount is None:
            return [rung.start, rung.end]
        x, y, z = mount.config.pivot
        far = max(math.dist(mount.config.pivot, end) for end in (rung.start, rung.end))
        return [(x - far, y - far, z - far), (x + far, y + far, z + far)]

    @property
    def is_near(self) -> bool:
        """Whether it hangs, or could catch a rung in the next sub-step; otherwise `push` need not be asked."""
        if self.rung is not None:
            return True
        c = self._chassis
        x, y, _ = c.pos
        for _, (ax, ay, _), (bx, by, _) in self._boxes:
            if ax - _SPREAD < x < bx + _SPREAD and ay - _SPREAD < y < by + _SPREAD:
                break
        else:
            return False  # without asking where the mechanism is
        pos, _ = part_pose(self.config.joints, self._mechanisms, self.config.offset)
        hook = [p + a for p, a in zip(c.pos, rotate(c.quat, pos), strict=True)]
        return any([_is_inside(hook, low, high) for _, low, high in self._boxes])

    def push(self, h: float) -> tuple[Vector, Vector]:
        """Load the mechanism, pull the rung, and say how it pushes the robot in the next sub-step.

        Args:
            h: Sub-step [s].

        Returns:
            Force [N] and torque about the center of mass [N m], field frame.
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
        """The place on a rung that is nearest to the hook [m]."""
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
        (x0, y0, _), (x1, y1, _), softer = self.rung.start, self.rung.end, 1.0
        mount = self._mounts.get(self.rung.mount)
        if mount is not None:
            (x0, y0, _), (x1, y1, _) = mount.from_rest(self.rung.start), mount.from_rest(self.rung.end)
            vel = minus(vel, mount.velocity_at(near))
            # Implicit Euler: a light body that is pulled as stiffly as a robot would jump from side to side.
            softer += mount.mobility_at(near) * h * (_DAMPING + _STIFFNESS * h)
            dx, dy = dx - vel[0] * h, dy - vel[1] * h
        up = _STIFFNESS * dz - _DAMPING * vel[2]
        if dz <= 0.0 or up <= 0.0:
            return (0.0, 0.0, 0.0)
        fx, fy = (_STIFFNESS * dx - _DAMPING * vel[0]) / softer, (_STIFFNESS * dy - _DAMPING * vel[1]) / softer
        size = math.hypot(fx, fy)
        if size > up:  # a hook that is pulled aside with more than its load slips over the rung
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
        """The torque that a force on the hook, robot frame [N], puts on the mechanism of the last joint [N m]."""
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
    """Whether a place is in a box [m]."""
    (x, y, z), (ax, ay, az), (bx, by, bz) = place, low, high
    return ax < x < bx and ay < y < by and az < z < bz
