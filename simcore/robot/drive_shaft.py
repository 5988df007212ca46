"""Wheels on carpet and the driven shafts that turn them, and what they can do at 12 V on level ground."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from simcore.robot.limited_motor import LimitedMotor
from simcore.robot.wheel_config import WheelConfig
from simcore.units import plain_sum

__all__ = ["DriveShaft", "WheelContact", "free_speed", "launch_accel"]

NOMINAL_VOLTAGE = 12.0
"""What FRC figures are quoted at [V]."""


@dataclass(frozen=True, slots=True)
class WheelContact:
    """One wheel on the carpet."""

    x: float
    """From the center of mass, forward [m]."""
    y: float
    """From the center of mass, left [m]."""
    wheel_cof: float
    """Coefficient of friction [-]."""
    rolling_resistance: float
    """Drag per load [-]."""

    @staticmethod
    def of(wheel: WheelConfig, place: tuple[float, float]) -> WheelContact:
        """A wheel at its place from the center of mass [m]."""
        return WheelContact(*place, wheel_cof=wheel.wheel_cof, rolling_resistance=wheel.rolling_resistance)


@dataclass(frozen=True, slots=True)
class DriveShaft:
    """What turns together: the wheel of a swerve module, or all wheels of one side of a tank, one behind the other."""

    inertia: float
    """Of wheels, gears and rotors about the axle [kg m^2]."""
    motor: LimitedMotor
    radius: float
    """Of its wheels [m]."""
    slip_ratio: float
    """Slip per rolling speed at which the tires begin to slide [-]."""
    slip_speed: float
    """The same at standstill [m/s]."""
    wheels: tuple[int, ...]
    """Rows of its wheels."""
    grain: float = 1.0
    """Friction of its treads across over that along [-]."""

    @staticmethod
    def of(wheel: WheelConfig, *, inertia: float, motor: LimitedMotor, wheels: tuple[int, ...]) -> DriveShaft:
        """A shaft with wheels of one kind; see the fields."""
        return DriveShaft(
            inertia=inertia,
            motor=motor,
            radius=wheel.wheel_radius,
            slip_ratio=wheel.slip_ratio,
            slip_speed=wheel.slip_speed,
            wheels=wheels,
            grain=wheel.wheel_grain,
        )


def free_speed(shaft: DriveShaft, wheels: Sequence[WheelContact], loads: Sequence[float]) -> float:
    """Ground speed at which motor torque meets friction and rolling drag [m/s].

    Args:
        shaft: Motor, gears, wheel radius.
        wheels: All wheels of the robot.
        loads: On all wheels [N].
    """
    motor = shaft.motor
    drag = plain_sum([wheels[k].rolling_resistance * loads[k] for k in shaft.wheels]) * shaft.radius + motor.friction
    current = drag / motor.torque_driving
    return max(0.0, (NOMINAL_VOLTAGE - current * motor.resistance) / motor.emf * shaft.radius)


def launch_accel(
    shafts: Sequence[DriveShaft],
    wheels: Sequence[WheelContact],
    loads: Sequence[float],
    arms: Sequence[float],
    inertia: float,
) -> float:
    """Acceleration from rest, straight (arms 1, inertia = mass) or on the spot (arms = radii, inertia = yaw inertia).

    A shaft within its grip drags its own rotor and wheels along; one beyond it pushes with mu N and no more. Which
    is which depends on the acceleration itself, so shafts change sides until it agrees: at most once each.

    Args:
        shafts: All drive shafts.
        wheels: All wheels.
        loads: On the wheels [N].
        arms: Per shaft, what a force of 1 N does: 1 [-] or the distance from the center of mass [m].
        inertia: Mass [kg] or yaw inertia [kg m^2].
    """
    slipping = [False] * len(shafts)
    while True:
        push, heavy = 0.0, inertia
        drives = []
        for shaft, arm, slips in zip(shafts, arms, slipping, strict=True):
            motor = shaft.motor
            grip = plain_sum([wheels[k].wheel_cof * loads[k] for k in shaft.wheels])
            drag = plain_sum([wheels[k].rolling_resistance * loads[k] for k in shaft.wheels])
            current = min(motor.stator_limit, NOMINAL_VOLTAGE * motor.conductance)
            force = max(0.0, motor.torque_driving * current - motor.friction) / shaft.radius
            own = shaft.inertia / shaft.radius**2
            drives.append((force, own, grip))
            if slips:
                push += (grip - drag) * arm
            else:
                push += (force - drag) * arm
                heavy += own * arm * arm
        accel = max(0.0, push / heavy)
        beyond = [
            slips or force - own * arm * accel > grip
            for (force, own, grip), arm, slips in zip(drives, arms, slipping, strict=True)
        ]
        if beyond == slipping or math.isinf(accel):
            return accel
        slipping = beyond
