"""Chassis, wheels and motors in one implicit step: the heart of the drivetrain.

Unknown are the chassis velocity u = (vx, vy, omega) and the speed w of every drive shaft. Per wheel, with unit vectors
along (l) and across (t) the wheel and the module's velocity v = A u:

    slip          s = (r w - v_l, -v_t)
    tire force    F = c s,         c = mu N / max(|s|, s0)        Coulomb, made linear within the tiny slip s0
    shaft         J (w - w_old) / h = T(w) - r sum F_l            T: motor, limits, gears, friction (electrical.py)
    chassis       M (u - u_old) / h = sum A^T (F + rolling drag)

This is backward Euler, so it is stable for any h, J and s0. For a given c the shafts are linear in u and are
eliminated by hand; a symmetric 3 x 3 system is left. c is then corrected with the slip that came out (Picard, with the
wheel's own compliance B to speed it up: the force only has to fall to mu N, so the slip grows by B (|F| - mu N)).
It starts from the last step's slip and needs one to four rounds. At last every force is put on its friction circle,
and chassis and shafts are moved by these same forces: no force without its reaction, no wheel beyond mu N.

Plain floats on purpose: for four wheels this loop takes 20 us, the same in numpy 110 us (call overhead).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from simcore.drivetrain.electrical import LOCKED, ShaftMotor, solve_limited, supply_bound

__all__ = ["DriveShaft", "TireSolver", "WheelContact"]

_ROUNDS = 4
_TOLERANCE = 0.05
"""Relative change of a saturated wheel's slip that ends the rounds; its force is on the circle anyway."""


@dataclass(frozen=True, slots=True)
class WheelContact:
    """One wheel on the carpet."""

    x: float
    """From the center of mass, forward [m]."""
    y: float
    """From the center of mass, left [m]."""
    radius: float
    """[m]"""
    tread: float
    """Coefficient of friction [-]."""
    rolling_resistance: float
    """Drag per load [-]."""
    slip_ratio: float
    """Slip per rolling speed at which the tire lets go [-]."""
    slip_speed: float
    """The same at standstill [m/s]."""


@dataclass(frozen=True, slots=True)
class DriveShaft:
    """What turns together: one wheel of a swerve module, or all wheels of one side of a tank."""

    inertia: float
    """Of wheels, gears and rotors about the axle [kg m^2]."""
    motor: ShaftMotor
    wheels: tuple[int, ...]
    """Rows of its wheels."""


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
        self.shaft_speed = [0.0] * len(self.shafts)
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
        self._geometry = [(w.x, w.y, w.x * w.x + w.y * w.y, w.tread, w.slip_ratio, w.slip_speed) for w in self.wheels]
        self._motor = [
            (m.conductance, m.emf, m.torque_driving, m.torque_driven, m.friction, m.supply_limit)
            for m in (s.motor for s in self.shafts)
        ]

    def step(
        self,
        h: float,
        vx: float,
        vy: float,
        omega: float,
        loads: Sequence[float],
        cos: Sequence[float],
        sin: Sequence[float],
        volts: Sequence[float | None],
        emf_offset: Sequence[float],
        torque_offset: Sequence[float],
        limits: Sequence[float],
        bus_voltage: float,
    ) -> tuple[float, float, float]:
        """Advance by `h` and return the chassis velocity after it, robot axes.

        Args:
            h: Time step [s].
            vx: Velocity of the center of mass, forward, with the outside forces of this step already added [m/s].
            vy: To the left [m/s].
            omega: Yaw rate [rad/s].
            loads: Normal load per wheel [N].
            cos: Of the steer angles, per wheel.
            sin: Of the steer angles, per wheel.
            volts: Applied voltage per shaft, at most the bus voltage [V]; None is an open circuit.
            emf_offset: Back-EMF from elsewhere, per shaft (azimuth coupling) [V].
            torque_offset: Torque on the shaft from elsewhere [N m].
            limits: Stator limit in force, per shaft [A].
            bus_voltage: For the supply limit [V].
        """
        wheels = self.wheels
        geometry = self._geometry
        speed = self.shaft_speed
        slips = self.slip
        current = self.shaft_current
        n_shafts = len(speed)
        rh = 1.0 / h
        m_h = self.mass * rh
        j_h = self.yaw_inertia * rh

        # Per wheel: capacity mu N, slip scale s0, warm-started slip. Per shaft: the torque line at the present speed.
        grip: list[float] = []
        scale: list[float] = []
        n = 0
        for _, _, _, mu, _, _ in geometry:
            load = loads[n]
            grip.append(mu * load if load > 0.0 else 0.0)
            n += 1
        scale = [0.0] * n
        i0s = [0.0] * n_shafts
        i1s = [0.0] * n_shafts
        t0s = [0.0] * n_shafts
        t1s = [0.0] * n_shafts
        for g in range(n_shafts):
            shaft = self.shafts[g]
            conductance, emf, driving, driven, friction, supply = self._motor[g]
            limit = limits[g]
            w = speed[g]
            v = volts[g]
            if v is not None:
                i0 = (v - emf_offset[g]) * conductance
                i1 = emf * conductance
                i = i0 - i1 * w
                power = supply * bus_voltage
                if v * i > power or -v * i > power:
                    e = emf_offset[g] + emf * w
                    i0, i1 = supply_bound(e, emf, w, shaft.motor.resistance, power, i)
                    i = i0 - i1 * w
                i0s[g] = i0
                i1s[g] = i1
                f = driving if i * w >= 0.0 else driven
                if i > limit:
                    t0 = f * limit
                    t1 = 0.0
                elif i < -limit:
                    t0 = -f * limit
                    t1 = 0.0
                else:
                    t0 = f * i0
                    t1 = f * i1
            else:
                t0 = t1 = i = 0.0
            if w > 0.0:
                t0 -= friction
            elif w < 0.0:
                t0 += friction
            elif -friction <= t0 <= friction:
                t0 = 0.0
                t1 = LOCKED
            elif t0 > 0.0:
                t0 -= friction
            else:
                t0 += friction
            t0s[g] = t0
            t1s[g] = t1
            for k in shaft.wheels:
                s0 = abs(w) * wheels[k].radius * geometry[k][4] + geometry[k][5]
                scale[k] = s0
                if slips[k] < s0:
                    slips[k] = s0

        drags = [0.0] * n  # rolling drag per rolling speed
        fl = [0.0] * n
        ft = [0.0] * n
        size = [0.0] * n
        new_speed = speed[:]
        ux = vx
        uy = vy
        uw = omega
        for _ in range(_ROUNDS):
            # Assemble M/h + sum A^T c A, less what the shafts give way, for the 3 x 3 system.
            a11 = a22 = m_h
            a33 = j_h
            a12 = a13 = a23 = 0.0
            b1 = m_h * vx
            b2 = m_h * vy
            b3 = j_h * omega
            for g in range(n_shafts):
                shaft = self.shafts[g]
                d = shaft.inertia * rh + t1s[g]
                q1 = q2 = q3 = 0.0
                for k in shaft.wheels:
                    load_grip = grip[k]
                    if load_grip <= 0.0:
                        continue
                    x, y, r2, _, _, _ = geometry[k]
                    c_, s_ = cos[k], sin[k]
                    p = x * s_ - y * c_
                    c = load_grip / slips[k]
                    a11 += c
                    a22 += c
                    a13 -= c * y
                    a23 += c * x
                    a33 += c * r2
                    r = wheels[k].radius
                    d += r * r * c
                    rc = r * c
                    q1 += rc * c_
                    q2 += rc * s_
                    q3 += rc * p
                    drag = wheels[k].rolling_resistance * loads[k]
                    if drag > 0.0:
                        v_l = c_ * ux + s_ * uy + p * uw
                        drag /= max(abs(v_l), geometry[k][5])
                        drags[k] = drag
                        dc = drag * c_
                        ds = drag * s_
                        a11 += dc * c_
                        a12 += dc * s_
                        a22 += ds * s_
                        a13 += dc * p
                        a23 += ds * p
                        a33 += drag * p * p
                give = 1.0 / d
                e = (shaft.inertia * rh * speed[g] + t0s[g] + torque_offset[g]) * give
                b1 += q1 * e
                b2 += q2 * e
                b3 += q3 * e
                g1 = q1 * give
                g2 = q2 * give
                a11 -= g1 * q1
                a12 -= g1 * q2
                a13 -= g1 * q3
                a22 -= g2 * q2
                a23 -= g2 * q3
                a33 -= q3 * give * q3
            # Solve it: L D L^T by hand.
            l21 = a12 / a11
            l31 = a13 / a11
            d2 = a22 - l21 * a12
            e23 = a23 - l21 * a13
            l32 = e23 / d2
            d3 = a33 - l31 * a13 - l32 * e23
            y2 = b2 - l21 * b1
            y3 = b3 - l31 * b1 - l32 * y2
            uw = y3 / d3
            uy = y2 / d2 - l32 * uw
            ux = b1 / a11 - l21 * uy - l31 * uw

            # Every shaft exactly, given the chassis; then the tire forces and a better slip.
            settled = True
            for g in range(n_shafts):
                shaft = self.shafts[g]
                j = shaft.inertia * rh
                stiff = j
                push = j * speed[g] + torque_offset[g]
                for k in shaft.wheels:
                    if grip[k] <= 0.0:
                        fl[k] = ft[k] = size[k] = 0.0
                        continue
                    x, y, _, _, _, _ = geometry[k]
                    c_, s_ = cos[k], sin[k]
                    px = ux - uw * y
                    py = uy + uw * x
                    v_l = c_ * px + s_ * py
                    fl[k] = v_l  # kept until the shaft speed is known
                    ft[k] = s_ * px - c_ * py
                    rc = wheels[k].radius * grip[k] / slips[k]
                    stiff += wheels[k].radius * rc
                    push += rc * v_l
                w, i, t0, t1 = solve_limited(
                    *(shaft.motor, stiff, push, i0s[g], i1s[g], limits[g], shaft.motor.friction),
                    *(emf_offset[g], speed[g], shaft.motor.supply_limit * bus_voltage),
                )
                if abs(t1 - t1s[g]) > 1e-9 or abs(t0 - t0s[g]) > 0.05 * abs(t0) + 1e-3:
                    settled = False
                t0s[g] = t0
                t1s[g] = t1
                new_speed[g] = w
                current[g] = i
                for k in shaft.wheels:
                    most = grip[k]
                    if most <= 0.0:
                        continue
                    radius = wheels[k].radius
                    slip = slips[k]
                    c = most / slip
                    s_l = radius * w - fl[k]
                    s_t = ft[k]
                    fl[k] = f_l = c * s_l
                    ft[k] = f_t = c * s_t
                    f2 = f_l * f_l + f_t * f_t
                    size[k] = f = math.sqrt(f2)
                    if f2 > 0.0:
                        # Own compliance of this contact along the force: wheel and its share of the chassis.
                        b = 1.5 / m_h + radius * radius / (j + t1) * f_l * f_l / f2
                        wanted = f / c + b * (f - most)
                        s0 = scale[k]
                        if wanted < s0:
                            wanted = s0
                    else:
                        wanted = scale[k]
                    if abs(wanted - slip) > _TOLERANCE * slip:
                        settled = False
                    slips[k] = wanted
            if settled:
                break

        # On the circle, exactly; then move shafts and chassis with the same forces.
        sum_x = sum_y = sum_n = 0.0
        force_x = self.force_x
        force_y = self.force_y
        for g in range(n_shafts):
            shaft = self.shafts[g]
            j = shaft.inertia * rh
            push = j * speed[g] + torque_offset[g]
            changed = False
            for k in shaft.wheels:
                most = grip[k]
                if most <= 0.0:
                    force_x[k] = force_y[k] = 0.0
                    continue
                f_l = fl[k]
                f_t = ft[k]
                if size[k] > most:
                    shrink = most / size[k]
                    f_l *= shrink
                    f_t *= shrink
                    changed = True
                x, y, _, _, _, _ = geometry[k]
                c_, s_ = cos[k], sin[k]
                push -= wheels[k].radius * f_l
                # Rolling drag comes out of the same grip: what the carpet passes on in all stays within mu N.
                if drags[k] > 0.0:
                    f_l -= drags[k] * (c_ * (ux - uw * y) + s_ * (uy + uw * x))
                    total = f_l * f_l + f_t * f_t
                    if total > most * most:
                        shrink = most / math.sqrt(total)
                        f_l *= shrink
                        f_t *= shrink
                f_x = c_ * f_l - s_ * f_t
                f_y = s_ * f_l + c_ * f_t
                force_x[k] = f_x
                force_y[k] = f_y
                sum_x += f_x
                sum_y += f_y
                sum_n += x * f_y - y * f_x
            if changed:
                w, i, _, _ = solve_limited(
                    *(shaft.motor, j, push, i0s[g], i1s[g], limits[g], shaft.motor.friction),
                    *(emf_offset[g], speed[g], shaft.motor.supply_limit * bus_voltage),
                )
                new_speed[g] = w
                current[g] = i
            motor = shaft.motor
            self.shaft_volts[g] = emf_offset[g] + motor.emf * new_speed[g] + current[g] * motor.resistance
            speed[g] = new_speed[g]
        return vx + sum_x / m_h, vy + sum_y / m_h, omega + sum_n / j_h
