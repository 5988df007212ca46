"""The drivetrain's own requests, as the numbers that native functions receive."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from simcore.phoenix6_emulator.emulated_module import EmulatedModule
from simcore.phoenix6_emulator.swerve_kinematics import Kinematics, desaturate, discretize

__all__ = ["Brake", "Centric", "DrivetrainRequest", "Idle", "Point", "RequestContext", "Speeds"]

_VELOCITY = 1  # of SwerveModule.DriveRequestType
_EXPO = 0  # of SwerveModule.SteerRequestType
_OPERATOR = 0  # of ForwardPerspectiveValue


@dataclass(slots=True)
class RequestContext:
    """What a request works on."""

    modules: Sequence[EmulatedModule]
    kinematics: Kinematics
    max_speed: float
    """At 12 V [m/s]."""
    period: float
    """Of the odometry [s]."""
    heading: float = 0.0
    """Of the estimated pose [rad]."""
    operator_forward: float = 0.0
    """The operator's forward direction, field frame [rad]."""


class DrivetrainRequest(Protocol):
    """Drives the modules, once a period."""

    def apply(self, context: RequestContext) -> None:
        """Send requests to the motors."""
        ...


@dataclass(frozen=True, slots=True)
class Idle:
    """Sends nothing; the motors' last requests time out."""

    def apply(self, context: RequestContext) -> None:
        """Send nothing."""


@dataclass(frozen=True, slots=True)
class Brake:
    """Wheels point to the center, as an X."""

    drive: int
    steer: int

    def apply(self, context: RequestContext) -> None:
        """Turn every wheel across the direction in which the robot could roll."""
        for module, (x, y) in zip(context.modules, context.kinematics.positions, strict=True):
            module.apply(
                0.0,
                math.atan2(y, x),
                closed_loop=self.drive == _VELOCITY,
                profiled=self.steer == _EXPO,
                period=context.period,
            )


@dataclass(frozen=True, slots=True)
class Point:
    """All wheels in one direction, without speed."""

    angle: float
    """Robot frame [rad]."""
    drive: int
    steer: int

    def apply(self, context: RequestContext) -> None:
        """Turn the wheels."""
        for module in context.modules:
            module.apply(
                0.0,
                self.angle,
                closed_loop=self.drive == _VELOCITY,
                profiled=self.steer == _EXPO,
                period=context.period,
            )


@dataclass(frozen=True, slots=True)
class Speeds:
    """ApplyRobotSpeeds (`is_field` False) and ApplyFieldSpeeds, with wheel forces fed forward in the same frame."""

    vx: float
    vy: float
    omega: float
    forces_x: tuple[float, ...]
    forces_y: tuple[float, ...]
    center_x: float
    center_y: float
    drive: int
    steer: int
    desaturate: bool
    perspective: int = 1
    is_field: bool = dataclasses.field(default=False, kw_only=True)

    def apply(self, context: RequestContext) -> None:
        """Send the modules' states."""
        states, turn = _module_states(self, context, self.vx, self.vy, self.omega)
        fx, fy = self.forces_x, self.forces_y
        for k, module in enumerate(context.modules):
            force = (fx[k] if k < len(fx) else 0.0, fy[k] if k < len(fy) else 0.0)
            if self.is_field and (fx or fy):
                force = _rotated(*force, turn)
            module.apply(
                *states[k],
                closed_loop=self.drive == _VELOCITY,
                profiled=self.steer == _EXPO,
                period=context.period,
                force_x=force[0],
                force_y=force[1],
            )


@dataclass(frozen=True, slots=True)
class Centric:
    """RobotCentric (`is_field` False) and FieldCentric: velocities from a driver, with deadbands."""

    vx: float
    vy: float
    omega: float
    deadband: float
    """[m/s]"""
    rotational_deadband: float
    """[rad/s]"""
    center_x: float
    center_y: float
    drive: int
    steer: int
    desaturate: bool
    perspective: int = 1
    is_field: bool = dataclasses.field(default=False, kw_only=True)

    def apply(self, context: RequestContext) -> None:
        """Send the modules' states."""
        vx, vy, omega = self.vx, self.vy, self.omega
        if math.hypot(vx, vy) < self.deadband:
            vx = vy = 0.0
        if abs(omega) < self.rotational_deadband:
            omega = 0.0
        states, _ = _module_states(self, context, vx, vy, omega)
        closed_loop, profiled = self.drive == _VELOCITY, self.steer == _EXPO
        for module, (speed, angle) in zip(context.modules, states, strict=True):
            module.apply(speed, angle, closed_loop=closed_loop, profiled=profiled, period=context.period)


def _module_states(
    request: Speeds | Centric, context: RequestContext, vx: float, vy: float, omega: float
) -> tuple[list[tuple[float, float]], float]:
    """Speed [m/s] and angle [rad] of every module for a velocity in the request's own axes [m/s, rad/s].

    And the angle between those axes and the robot's [rad]; 0 for a robot-centric request.
    """
    turn = 0.0
    if request.is_field:
        turn = -context.heading + (context.operator_forward if request.perspective == _OPERATOR else 0.0)
        vx, vy = _rotated(vx, vy, turn)
        vx, vy, omega = discretize(vx, vy, omega, context.period)
    states = context.kinematics.states(vx, vy, omega, request.center_x, request.center_y)
    if request.desaturate:
        states = desaturate(states, context.max_speed)
    return states, turn


def _rotated(x: float, y: float, angle: float) -> tuple[float, float]:
    c, s = math.cos(angle), math.sin(angle)
    return c * x - s * y, s * x + c * y
