"""Chassis, wheels and motors in one implicit step: the heart of the drivetrain.

Unknown are the chassis velocity u = (vx, vy, omega) and the speed w of every drive shaft. Per wheel, with unit vectors
along (l) and across (t) the wheel and its contact velocity v_l = a_l u, v_t = a_t u:

    slip          s = (r w - v_l, -v_t)
    tire force    F = c s,         c = mu N / max(|s|, s0)        Coulomb, made linear within the tiny slip s0
    shaft         J (w - w_old) / h = T(mean w) - r sum F_l       T: motor, limits, gears, friction (limited_motor.py)
    chassis       M (u - u_old) / h = sum A^T (F + rolling drag)

Slip is that at the end of the step, seen in the robot's axes of the end (backward Euler), so it is stable for any h, J
and s0, and tires that hold leave no slip. Forces act in the axes of the middle of the step, and the motor sees the mean
speed of its shaft (`end_weight`): where tires hold, the step is of second order.

For a given c the shafts are linear in u and are eliminated by hand; a symmetric 3 x 3 system is left. c is then
corrected with the slip that came out (Picard, with the wheel's own compliance B to speed it up: the force only has to
fall to mu N, so the slip grows by B (|F| - mu N)).
It starts from the last step's slip; mostly one round is enough (mean 1.0 to 1.4 measured), four are allowed. At last
every force is put on its friction circle, and chassis and shafts are moved by these same forces: no force without its
reaction, no wheel beyond mu N.

Plain floats on purpose: numpy needs about 1 us a call and there would be 100 of them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TypeAlias

from simcore.errors import ConfigError
from simcore.robot.drive_shaft import DriveShaft, WheelContact
from simcore.robot.limited_motor import (
    LOCKED,
    MotorConstants,
    end_weight,
    solve_shaft,
    solve_supply,
    torque_line,
    within,
)

__all__ = ["TireSolver"]

_Plan: TypeAlias = tuple[
    int,
    float,
    float,
    float,
    float,
    float,
    float,
    MotorConstants,
    tuple[tuple[int, float, float, float, float, float], ...],
]
"""Per shaft, the same in all steps; see `_planned`."""
_Contact: TypeAlias = tuple[int, float, float, float, float]
"""Of a wheel that touches: row, x, y, x^2 + y^2, grip mu N."""
_Row: TypeAlias = tuple[
    int,  # g: row of the shaft
    float,  # j: inertia / h
    float,  # push: j times the speed before the step, and the torque from elsewhere
    float,  # i0: current at standstill
    float,  # i1: its fall per shaft speed
    float,  # power: supply limit times bus voltage
    float,  # c_: cosine of the steer angle
    float,  # s_: its sine
    float,  # arm: of a force along the wheels about the center of mass
    float,  # radius
    float,  # s0: slip at which the tires begin to slide
    float,  # drag: rolling drag over speed
    float,  # most_drag: rolling drag of each of its wheels
    float,  # before: shaft speed before the step
    float,  # offset: back-EMF from elsewhere
    MotorConstants,
    list[_Contact],
]
"""Per shaft, the same in all rounds of a step. A tuple: reading attributes costs as much as the arithmetic."""

_ROUNDS, _FULL_ROUNDS = 6, 2
"""Rounds of a step, and how many of them take a new slip as it is. Later ones take the mean with the last, because two
rounds have swung from one side of the answer to the other. Of 10 000 sliding wheels in random steps of 5 ms, 10 are
left with less than 80 % of their grip; with four full rounds it was 100, and on shafts with three wheels 600."""
_SLIDE = 0.05
"""Slip of a tire that slides for good [m/s]."""
_TOLERANCE = 0.1
"""Relative change of a saturated wheel's slip that ends the rounds; its force is put on the circle anyway."""


class TireSolver:
    """Moves a planar chassis on driven wheels by one step; keeps shaft speeds and the last slips."""

    def __init__(
        self, *, mass: float, yaw_inertia: float, wheels: Sequence[WheelContact], shafts: Sequence[DriveShaft]
    ) -> None:
        self.mass = mass
        self.yaw_inertia = yaw_inertia
        self.wheels = tuple(wheels)
        self.shafts = tuple(shafts)
        n = len(self.wheels)
        # Effective inverse mass at one contact, times the mass: 1 for one that slides alone, more when others do too.
        self._share = 0.5 + 0.5 * n
        self.rest([0.0] * len(self.shafts))
        self.cos: Sequence[float] = [1.0] * len(self.shafts)
        """Of the steer angle, per shaft; set before each step where wheels steer."""
        self.sin: Sequence[float] = [0.0] * len(self.shafts)
        """Of the steer angle, per shaft."""
        self.emf_offset: Sequence[float] = [0.0] * len(self.shafts)
        """Back-EMF from elsewhere, per shaft (azimuth coupling) [V]."""
        self.mid_cos: Sequence[float] = self.cos
        """Of the steer angle in the middle of the step, per shaft."""
        self.mid_sin: Sequence[float] = self.sin
        """Of the steer angle in the middle of the step, per shaft."""
        self.torque_offset: Sequence[float] = [0.0] * len(self.shafts)
        """Torque on the shaft from elsewhere [N m]."""
        for s in self.shafts:
            if len({self.wheels[k].y for k in s.wheels}) > 1:
                raise ConfigError("a drive shaft's wheels must stand one behind the other, at the same y")
        self._weighted = 0.0  # 1 / h that the weights are of
        self._end_weights: list[float] = []
        self._plan = self._planned()

    def set_mass(self, mass: float, yaw_inertia: float, positions: Sequence[tuple[float, float]]) -> None:
        """Go on with another mass [kg], yaw inertia [kg m^2] and wheel positions from the center of mass [m]."""
        self.mass, self.yaw_inertia = mass, yaw_inertia
        if any(w.x != x or w.y != y for w, (x, y) in zip(self.wheels, positions, strict=True)):
            self.wheels = tuple(replace(w, x=x, y=y) for w, (x, y) in zip(self.wheels, positions, strict=True))
            self._plan = self._planned()

    def _planned(self) -> list[_Plan]:
        # Attribute reads, twenty a wheel and step, cost as much as the arithmetic: everything in tuples. With forces
        # finished in the same pass unless a tire slides, four wheels took 23 us and take 13 us a step.
        return [
            (
                g,
                s.inertia,
                s.radius,
                s.slip_ratio,
                s.slip_speed,
                s.motor.conductance,
                s.motor.supply_limit,
                (s.motor.emf, s.motor.resistance, s.motor.torque_driving, s.motor.torque_driven, s.motor.friction),
                tuple(
                    (k, w.x, w.y, w.x * w.x + w.y * w.y, w.wheel_cof, w.rolling_resistance)
                    for k, w in ((k, self.wheels[k]) for k in s.wheels)
                ),
            )
            for g, s in enumerate(self.shafts)
        ]

    def rest(self, shaft_speed: list[float]) -> None:
        """Nothing slides, no current flows.

        Args:
            shaft_speed: Of every shaft [rad/s]; changed in place from here on.
        """
        n = len(self.wheels)
        self.shaft_speed = shaft_speed
        """[rad/s]"""
        self.shaft_current = [0.0] * len(self.shafts)
        """Stator current of each motor on the shaft in the last step [A]."""
        self.shaft_volts = [0.0] * len(self.shafts)
        """At the motor terminals in the last step [V]."""
        self.force_x = [0.0] * n
        """Ground on wheel, robot axes, last step [N]."""
        self.force_y = [0.0] * n
        self.slip = [0.0] * n
        """|slip| that makes the tire force of the last step [m/s]."""
        self.is_sliding = False
        """Whether some tire slid in the last step, faster than it does in rolling under load."""
        self._is_slow = False  # whether some wheel rolls so slowly that its rolling drag is not yet a constant force
        self._stiffness: list[float] = []  # per shaft, of this round: radius times the sum of c
        self._forces: list[tuple[float, float]] = []  # per contact, of this round: along and across the wheel [N]
        self._sums = (0.0, 0.0, 0.0)  # of the wheels' forces [N, N, N m]

    def step(
        self,
        h: float,
        vx: float,
        vy: float,
        omega: float,
        loads: Sequence[float],
        volts: Sequence[float | None],
        limits: Sequence[float],
        bus_voltage: float,
    ) -> tuple[float, float, float]:
        """Advance by `h` and return the change of the chassis velocity, robot axes in the MIDDLE of the step.

        Args:
            h: Time step [s].
            vx: Velocity of the center of mass before the step, with the outside forces of the step already added, in
                robot axes at the END of the step, forward [m/s].
            vy: To the left [m/s].
            omega: Yaw rate [rad/s].
            loads: Normal load per wheel [N].
            volts: Wanted voltage per shaft [V]; None is an open circuit.
            limits: Stator limit in force, per shaft [A].
            bus_voltage: Of the battery, which no motor can exceed [V].
        """
        rh = 1.0 / h
        m_h = self.mass * rh
        j_h = self.yaw_inertia * rh
        before = (m_h, j_h, vx, vy, omega)
        n = len(self.slip)
        self.force_x = [0.0] * n
        self.force_y = [0.0] * n
        self.shaft_current = self.shaft_current[:]
        self.shaft_volts = self.shaft_volts[:]
        new_speed = self.shaft_speed[:]
        lines: list[tuple[float, float]] = []
        rows = self._prepare(rh, vx, vy, omega, loads, volts, limits, bus_voltage, lines)
        sliding = False
        for count in range(_ROUNDS):
            after = self._move_chassis(rows, lines, before)
            if self._is_slow:
                for _ in range(_ROUNDS):
                    if not _rescale_drag(rows, after, self.shafts):
                        break
                    after = self._move_chassis(rows, lines, before)
            settled, sliding = self._move_shafts(rows, lines, after, limits, new_speed, self._share / m_h, count)
            if settled:
                break
        self.is_sliding = sliding and max(self.slip) > _SLIDE
        if sliding:
            self._limit_forces(rows, after, limits, new_speed)
        self.shaft_speed[:] = new_speed
        sum_x, sum_y, sum_n = self._sums
        return sum_x / m_h, sum_y / m_h, sum_n / j_h

    def _prepare(
        self,
        rh: float,
        vx: float,
        vy: float,
        omega: float,
        loads: Sequence[float],
        volts: Sequence[float | None],
        limits: Sequence[float],
        bus_voltage: float,
        lines: list[tuple[float, float]],
    ) -> list[_Row]:
        """What stays the same in all rounds, per shaft; grip, slip scale and the slip of the last step per wheel.

        Args:
            rh: 1 / h [1/s].
            vx: See `step`, as all others.
            vy: See `step`.
            omega: See `step`.
            loads: See `step`.
            volts: See `step`.
            limits: See `step`.
            bus_voltage: See `step`.
            lines: Written: the torque line of each shaft at its present speed.
        """
        speed, slips, cos, sin = self.shaft_speed, self.slip, self.cos, self.sin
        emf_offset, torque_offset = self.emf_offset, self.torque_offset
        rows: list[_Row] = []
        if rh != self._weighted:
            self._weighted = rh
            self._end_weights = [
                end_weight(1.0 / rh, s.motor.torque_driven * s.motor.emf * s.motor.conductance / s.inertia)
                for s in self.shafts
            ]
        weights = self._end_weights
        self._is_slow = False
        for g, inertia, radius, ratio, floor, conductance, supply, motor, wheels in self._plan:
            w = speed[g]
            power = supply * bus_voltage
            # Back-EMF of the mean speed, from that at the end of the step.
            emf, resistance, driving, driven, friction = motor
            emf_end = emf * weights[g]
            offset = emf_offset[g] + (emf - emf_end) * w
            constants = (emf_end, resistance, driving, driven, friction)
            i0, i1, t0, t1 = torque_line(volts[g], bus_voltage, offset, w, limits[g], power, conductance, constants)
            lines.append((t0, t1))
            rolling = w * radius
            s0 = (rolling if rolling > 0.0 else -rolling) * ratio + floor
            c_ = cos[g]
            s_ = sin[g]
            drag = 0.0
            contacts = []
            arm = 0.0
            for k, x, y, r2, wheel_cof, rolling_resistance in wheels:
                load = loads[k]
                grip = wheel_cof * load
                if grip <= 0.0:
                    continue
                drag += rolling_resistance * load
                if slips[k] < s0:
                    slips[k] = s0
                arm = x * s_ - y * c_
                contacts.append((k, x, y, r2, grip))
            # Rolling drag is a constant force while the wheel rolls; as a coefficient it cannot push backwards.
            v_l = c_ * vx + s_ * vy + arm * omega
            if v_l < 0.0:
                v_l = -v_l
            most_drag = drag / len(contacts) if contacts else 0.0
            if v_l < 100.0 * floor:
                self._is_slow = True
            drag /= v_l if v_l > floor else floor
            j = inertia * rh
            push = j * w + torque_offset[g]
            rows.append(
                (g, j, push, i0, i1, power, c_, s_, arm, radius, s0, drag, most_drag, w, offset, constants, contacts)
            )
        return rows

    def _move_chassis(
        self,
        rows: list[_Row],
        lines: list[tuple[float, float]],
        before: tuple[float, float, float, float, float],
    ) -> tuple[float, float, float]:
        """Chassis velocity [m/s, m/s, rad/s] with the present slips, the shafts eliminated.

        M/h + sum A^T c A, less what the shafts yield, is assembled and solved. Across and along a wheel c is the same,
        so its part is isotropic (it does not depend on the steer angle); only the shaft's part has a direction.

        Args:
            rows: Of `_prepare`.
            lines: Torque line of each shaft.
            before: m/h, J/h and the velocity before the step.
        """
        slips = self.slip
        m_h, j_h, vx, vy, omega = before
        a11 = a22 = m_h
        a33 = j_h
        a12 = a13 = a23 = 0.0
        b1 = m_h * vx
        b2 = m_h * vy
        b3 = j_h * omega
        stiffness = self._stiffness = []
        for g, j, push, _, _, _, c_, s_, arm, radius, _, drag, _, _, _, _, contacts in rows:
            t0, t1 = lines[g]
            rc = 0.0
            for k, x, y, r2, grip in contacts:
                c = grip / slips[k]
                rc += c
                a13 -= c * y
                a23 += c * x
                a33 += c * r2
            a11 += rc
            a22 += rc
            rc *= radius
            stiffness.append(rc)
            share = rc / (j + t1 + radius * rc)
            e = drag - share * rc
            b = share * (push + t0)
            ec = e * c_
            es = e * s_
            a11 += ec * c_
            a12 += ec * s_
            a13 += ec * arm
            a22 += es * s_
            a23 += es * arm
            a33 += e * arm * arm
            b1 += b * c_
            b2 += b * s_
            b3 += b * arm
        # L D L^T by hand.
        l21 = a12 / a11
        l31 = a13 / a11
        d2 = a22 - l21 * a12
        e23 = a23 - l21 * a13
        l32 = e23 / d2
        y2 = b2 - l21 * b1
        uw = (b3 - l31 * b1 - l32 * y2) / (a33 - l31 * a13 - l32 * e23)
        uy = y2 / d2 - l32 * uw
        return b1 / a11 - l21 * uy - l31 * uw, uy, uw

    def _move_shafts(
        self,
        rows: list[_Row],
        lines: list[tuple[float, float]],
        after: tuple[float, float, float],
        limits: Sequence[float],
        new_speed: list[float],
        compliance: float,
        count: int,
    ) -> tuple[bool, bool]:
        """Every shaft exactly, given the chassis; then the tire forces and, where a tire slides, a better slip.

        Args:
            rows: Of `_prepare`.
            lines: Torque lines that the chassis was solved with; changed to those that hold.
            after: Chassis velocity of this round.
            limits: See `step`.
            new_speed: Of the shafts; written [rad/s].
            compliance: Effective inverse mass of the chassis at one contact, times 1/h.
            count: Rounds done.

        Returns:
            Whether slips and lines need no further round, and whether a tire slides.
        """
        ux, uy, uw = after
        slips, stiffness = self.slip, self._stiffness
        current, volts = self.shaft_current, self.shaft_volts
        force_x, force_y = self.force_x, self.force_y
        mid_cos, mid_sin = self.mid_cos, self.mid_sin
        forces = self._forces = []
        settled = True
        sliding = False
        sum_x = sum_y = sum_n = 0.0
        for (
            g,
            j,
            push,
            i0,
            i1,
            power,
            c_,
            s_,
            arm,
            radius,
            s0,
            drag,
            most_drag,
            before,
            offset,
            constants,
            contacts,
        ) in rows:
            v_l = c_ * ux + s_ * uy + arm * uw
            rc = stiffness[g]
            emf, resistance, driving, driven, friction = constants
            stiff = j + radius * rc
            push += rc * v_l
            w, i, t0, t1 = solve_shaft(stiff, push, i0, i1, limits[g], driving, driven, friction)
            v = offset + emf * w + i * resistance
            if v * i > power or v * i < -power:
                w, i, t0, t1 = solve_supply(stiff, push, i, v * i, limits[g], constants, offset, before, power)
                v = offset + emf * w + i * resistance
            old0, old1 = lines[g]
            if t0 != old0 or t1 != old1:
                # The torque that the chassis was solved with was another one; a 50th of the grip does not matter.
                miss = t0 - old0 - (t1 - old1) * w
                if t1 == LOCKED or old1 == LOCKED or abs(miss) > 0.02 * s0 * rc:
                    settled = False
                    turned = w < 0.0 < new_speed[g] or new_speed[g] < 0.0 < w
                    if turned and friction > 0.0 and t1 != LOCKED:
                        # The chassis made this shaft turn round, with friction that acted the other way: between the
                        # two, friction may hold it. Without this try a braked robot rocked to and fro, for good.
                        t0, t1 = 0.0, LOCKED
                lines[g] = (t0, t1)
            new_speed[g] = w
            current[g] = i
            volts[g] = v
            s_l = radius * w - v_l
            c_mid = mid_cos[g]
            s_mid = mid_sin[g]
            if drag > 0.0:
                drag = within(drag * v_l / len(contacts), most_drag)
            excess_along = 0.0
            slides = None
            for k, x, y, _, grip in contacts:
                s_t = s_ * (ux - uw * y) - c_ * (uy + uw * x)
                slip = slips[k]
                c = grip / slip
                f_l = c * s_l
                f_t = c * s_t
                forces.append((f_l, f_t))
                across = f_t * f_t
                circle = grip * grip
                f2 = f_l * f_l + across
                if f2 > circle or slip > s0:
                    size = math.sqrt(f2)
                    along = f_l / size if size > 0.0 else 0.0
                    excess_along += along * (size - grip)
                    if slides is None:
                        slides = []
                    slides.append((k, slip, size / c, along, size - grip))
                if drag != 0.0:
                    f_l -= drag
                    if f_l * f_l + across > circle:
                        sliding = True
                force_x[k] = f_x = c_mid * f_l - s_mid * f_t
                force_y[k] = f_y = s_mid * f_l + c_mid * f_t
                sum_x += f_x
                sum_y += f_y
                sum_n += x * f_y - y * f_x
            if slides is not None:
                # What the slip would be at the grip: the shaft yields to what all its contacts lose or gain together
                # (one of three that took it all for its own would swing between two wrong slips), the chassis to each
                # contact's share.
                excess_along *= radius * radius / (j + t1)
                for k, slip, found, along, excess in slides:
                    wanted = found + along * excess_along + compliance * excess
                    if wanted < s0:
                        wanted = s0
                    if count >= _FULL_ROUNDS:
                        wanted = math.sqrt(wanted * slip)
                    if abs(wanted - slip) > _TOLERANCE * slip:
                        settled = False
                    slips[k] = wanted
                    if excess > 0.0 or wanted > s0:
                        sliding = True
        self._sums = (sum_x, sum_y, sum_n)
        return settled, sliding

    def _limit_forces(
        self,
        rows: list[_Row],
        after: tuple[float, float, float],
        limits: Sequence[float],
        new_speed: list[float],
    ) -> None:
        """Put every force on its friction circle, exactly; the shafts then follow these same forces.

        Args:
            rows: Of `_prepare`.
            after: Chassis velocity of the last round.
            limits: See `step`.
            new_speed: Of the shafts; written [rad/s].
        """
        ux, uy, uw = after
        slips, forces = self.slip, self._forces
        force_x, force_y = self.force_x, self.force_y
        mid_cos, mid_sin = self.mid_cos, self.mid_sin
        sum_x = sum_y = sum_n = 0.0
        at = 0
        for (
            g,
            j,
            push,
            i0,
            i1,
            power,
            c_,
            s_,
            arm,
            radius,
            s0,
            drag,
            most_drag,
            before,
            offset,
            constants,
            contacts,
        ) in rows:
            moved = False
            c_mid = mid_cos[g]
            s_mid = mid_sin[g]
            if drag > 0.0:
                drag = within(drag * (c_ * ux + s_ * uy + arm * uw) / len(contacts), most_drag)
            for k, x, y, _, grip in contacts:
                f_l, f_t = forces[at]
                at += 1
                size = math.sqrt(f_l * f_l + f_t * f_t)
                # A sliding tire has all of its grip; within the tolerance of the rounds that may be a bit more.
                if size > grip or (slips[k] > s0 and size > 0.85 * grip):
                    f_l *= grip / size
                    f_t *= grip / size
                    moved = True
                push -= radius * f_l
                # Rolling drag comes out of the same grip: what the carpet passes on in all stays within mu N.
                if drag != 0.0:
                    f_l -= drag
                    total = math.sqrt(f_l * f_l + f_t * f_t)
                    if total > grip:
                        f_l *= grip / total
                        f_t *= grip / total
                force_x[k] = f_x = c_mid * f_l - s_mid * f_t
                force_y[k] = f_y = s_mid * f_l + c_mid * f_t
                sum_x += f_x
                sum_y += f_y
                sum_n += x * f_y - y * f_x
            if moved:
                emf, resistance, driving, driven, friction = constants
                w, i, _, _ = solve_shaft(j, push, i0, i1, limits[g], driving, driven, friction)
                v = offset + emf * w + i * resistance
                if v * i > power or v * i < -power:
                    w, i, _, _ = solve_supply(j, push, i, v * i, limits[g], constants, offset, before, power)
                    v = offset + emf * w + i * resistance
                new_speed[g] = w
                self.shaft_current[g] = i
                self.shaft_volts[g] = v
        self._sums = (sum_x, sum_y, sum_n)


def _rescale_drag(rows: list[_Row], after: tuple[float, float, float], shafts: Sequence[DriveShaft]) -> bool:
    """Keep rolling drag near its constant force for wheels that have started to roll in this step.

    Args:
        rows: Of `_prepare`; changed.
        after: Chassis velocity of this round.
        shafts: All drive shafts.

    Returns:
        Whether something has changed.
    """
    ux, uy, uw = after
    has_changed = False
    for at, row in enumerate(rows):
        g, j, push, i0, i1, power, c_, s_, arm, radius, s0, drag, most_drag, w, offset, constants, contacts = row
        v_l = abs(c_ * ux + s_ * uy + arm * uw)
        most = most_drag * len(contacts)
        if drag * v_l > 1.05 * most or (drag * v_l < 0.95 * most and v_l > shafts[g].slip_speed):
            drag = most / v_l
            rows[at] = (
                g,
                j,
                push,
                i0,
                i1,
                power,
                c_,
                s_,
                arm,
                radius,
                s0,
                drag,
                most_drag,
                w,
                offset,
                constants,
                contacts,
            )
            has_changed = True
    return has_changed
