"""Wheels on carpet and the driven shafts that turn them.

Their constants, what a step of the tire solver keeps of them, and what they can do at 12 V on level ground.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from simcore.robot.limited_motor import LOCKED, LimitedMotor, end_weight, solve_limited, torque_line
from simcore.robot.wheel_config import WheelConfig
from simcore.units import plain_sum

__all__ = ["DriveShaft", "ShaftStep", "WheelContact", "WheelStep", "free_speed", "launch_accel"]

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


class WheelStep:
    """One wheel of a shaft; axes are those of the wheel, along and across."""

    __slots__ = ("across", "along", "cof", "grip", "r2", "rolling", "row", "x", "y")

    def __init__(self, row: int, contact: WheelContact) -> None:
        self.row = row
        self.x = contact.x
        self.y = contact.y
        self.r2 = contact.x * contact.x + contact.y * contact.y
        self.cof = contact.wheel_cof
        self.rolling = contact.rolling_resistance
        self.grip = 0.0
        """mu N along the wheel in this step [N]."""
        self.along = 0.0
        """Force of this round, without rolling drag [N]."""
        self.across = 0.0
        """The same across, over the grain: on a circle with `along` [N]."""


class ShaftStep:
    """A drive shaft; `begin` starts a step, `solve` moves it by one round."""

    __slots__ = (
        "_conductance",
        "_constants",
        "_count",
        "_driven_rate",
        "_emf",
        "_floor",
        "_has_supply",
        "_inertia",
        "_motor",
        "_rh",
        "_slip_ratio",
        "_supply",
        "_touch_count",
        "arm",
        "before",
        "cos",
        "current",
        "drag",
        "grain",
        "i0",
        "i1",
        "inertia",
        "limit",
        "most_drag",
        "offset",
        "power",
        "push",
        "radius",
        "row",
        "s0",
        "sin",
        "speed",
        "stiffness",
        "t0",
        "t1",
        "touching",
        "volts",
        "wheels",
    )

    def __init__(self, row: int, shaft: DriveShaft, contacts: Sequence[WheelContact]) -> None:
        motor = shaft.motor
        self.row = row
        self.radius = shaft.radius
        self.grain = shaft.grain
        self.wheels = [WheelStep(k, contacts[k]) for k in shaft.wheels]
        self._inertia = shaft.inertia
        self._slip_ratio = shaft.slip_ratio
        self._floor = shaft.slip_speed
        self._motor = motor
        self._supply = motor.supply_limit
        self._has_supply = motor.winding != motor.resistance
        self._emf = motor.emf
        self._conductance = motor.conductance
        self._driven_rate = motor.torque_driven * motor.emf * motor.conductance / shaft.inertia
        self._rh = 0.0
        self._constants = (motor.emf, motor.resistance, motor.torque_driving, motor.torque_driven, motor.friction)
        self._count = len(self.wheels)
        self._touch_count = 0
        self.touching: list[WheelStep] = []
        """Wheels that carry a load in this step."""
        self.inertia = 0.0
        """Over h [N m s]."""
        self.push = 0.0
        """`inertia` times the speed before, and the torque from elsewhere [N m]."""
        self.i0 = self.i1 = 0.0  # current without limits: i0 - i1 w
        self.t0 = self.t1 = 0.0
        """Torque T = t0 - t1 w that the chassis is solved with [N m, N m s]."""
        self.limit = self.power = self.offset = self.before = 0.0
        self.cos = self.sin = self.arm = 0.0
        self.s0 = 0.0
        """Slip at which its tires begin to slide [m/s]."""
        self.drag = 0.0
        """Rolling drag over speed [N s/m]."""
        self.most_drag = 0.0
        """Rolling drag of each touching wheel [N]."""
        self.stiffness = 0.0
        """Of this round: radius times the sum of c."""
        self.speed = self.current = self.volts = 0.0

    def begin(
        self,
        rh: float,
        speed: float,
        volts: float | None,
        limit: float,
        bus: float,
        emf_offset: float,
        torque_offset: float,
    ) -> None:
        """Start a step: motor and inertia.

        Args:
            rh: 1 / h [1/s].
            speed: Before the step [rad/s].
            volts: Wanted [V]; None is an open circuit.
            limit: Stator limit in force [A].
            bus: Battery voltage [V].
            emf_offset: Back-EMF from elsewhere [V].
            torque_offset: Torque from elsewhere [N m].
        """
        if rh != self._rh:
            self._rh = rh
            weight = end_weight(1.0 / rh, self._driven_rate)
            self._constants = (weight * self._emf, *self._constants[1:])
            self.inertia = self._inertia * rh
        constants = self._constants
        self.before = self.speed = speed
        self.limit = limit
        self.power = power = self._supply * bus
        # Back-EMF of the mean speed, from that at the end of the step.
        self.offset = offset = emf_offset + (self._emf - constants[0]) * speed
        if self._has_supply and volts is not None:
            emf = emf_offset + self._emf * speed
            volts, resistance = self._motor.line_in_force(volts, bus, emf, limit)
            if resistance != constants[1]:
                self._constants = constants = (constants[0], resistance, *constants[2:])
                self._conductance = 1.0 / resistance
        self.i0, self.i1, self.t0, self.t1 = torque_line(
            volts, bus, offset, speed, limit, power, self._conductance, constants
        )
        self.push = self.inertia * speed + torque_offset

    def touch(
        self, c: float, s: float, loads: Sequence[float], slips: list[float], vx: float, vy: float, omega: float
    ) -> bool:
        """Start a step: wheels on the carpet, and their rolling drag, a constant force, as one over their speed.

        Args:
            c: Cosine of the steer angle.
            s: Its sine.
            loads: Of all wheels of the robot [N].
            slips: Of all wheels, raised to the least that counts [m/s].
            vx: Velocity of the chassis, forward [m/s].
            vy: To the left [m/s].
            omega: Yaw rate [rad/s].

        Returns:
            Whether they are so slow that the drag is not yet constant: as a coefficient it cannot push backwards.
        """
        self.cos, self.sin = c, s
        floor = self._floor
        rolling = self.before * self.radius
        self.s0 = s0 = (rolling if rolling > 0.0 else -rolling) * self._slip_ratio + floor
        drag = arm = 0.0
        count = 0
        for wheel in self.wheels:
            k = wheel.row
            load = loads[k]
            wheel.grip = grip = wheel.cof * load
            if grip > 0.0:
                drag += wheel.rolling * load
                if slips[k] < s0:
                    slips[k] = s0
                arm = wheel.x * s - wheel.y * c
                count += 1
        self.touching = self.wheels if count == self._count else [w for w in self.wheels if w.grip > 0.0]
        self._touch_count = count
        self.arm = arm
        v_l = c * vx + s * vy + arm * omega
        if v_l < 0.0:
            v_l = -v_l
        self.most_drag = drag / count if count else 0.0
        self.drag = drag / (v_l if v_l > floor else floor)
        return v_l < 100.0 * floor

    def rescale_drag(self, v_l: float) -> bool:
        """Keep it near its constant force for wheels that start to roll in this step; whether it has changed."""
        most = self.most_drag * self._touch_count
        drag = self.drag * v_l
        if drag > 1.05 * most or (drag < 0.95 * most and v_l > self._floor):
            self.drag = most / v_l
            return True
        return False

    def drag_at(self, v_l: float) -> float:
        """Rolling drag of each touching wheel at a speed along it [N]; there is one that touches."""
        drag, most = self.drag * v_l / self._touch_count, self.most_drag
        return most if drag > most else -most if drag < -most else drag

    def solve(self, stiffness: float, push: float) -> tuple[float, float]:
        """Speed, current and volts behind the motor's limits, exactly.

        Args:
            stiffness: k of k w = a + T(w) [N m s].
            push: a [N m].

        Returns:
            The torque line that holds there: t0 [N m], t1 [N m s].
        """
        self.speed, self.current, self.volts, t0, t1 = solve_limited(
            stiffness, push, self.i0, self.i1, self.limit, self._constants, self.offset, self.before, self.power
        )
        return t0, t1

    def meet(self, t0: float, t1: float, last_speed: float) -> bool:
        """Go on with another torque line than the chassis was solved with; whether it is as good as the same.

        A miss of a 50th of the grip does not matter.

        Args:
            t0: See `solve`.
            t1: See `solve`.
            last_speed: Of the round before [rad/s].
        """
        old0, old1 = self.t0, self.t1
        w = self.speed
        miss = t0 - old0 - (t1 - old1) * w
        is_met = True
        if t1 == LOCKED or old1 == LOCKED or abs(miss) > 0.02 * self.s0 * self.stiffness:
            is_met = False
            turned = w < 0.0 < last_speed or last_speed < 0.0 < w
            if turned and self._constants[4] > 0.0 and t1 != LOCKED:
                # The chassis made this shaft turn round, with friction that acted the other way: between the two,
                # friction may hold it. Without this try a braked robot rocked to and fro, for good.
                t0, t1 = 0.0, LOCKED
        self.t0, self.t1 = t0, t1
        return is_met


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
