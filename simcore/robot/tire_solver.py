"""Chassis, wheels and motors in one implicit step: the heart of the drivetrain.

Unknown are the chassis velocity u = (vx, vy, omega) and the speed w of every drive shaft. Per wheel, with unit vectors
along (l) and across (t) the wheel and its contact velocity v_l = a_l u, v_t = a_t u:

    slip          s = (r w - v_l, -v_t)
    tire force    F = c s,         c = mu N / max(|s|, s0)        Coulomb, made linear within the tiny slip s0
    shaft         J (w - w_old) / h = T(w) - r sum F_l            T: motor, limits, gears, friction (limited_motor.py)
    chassis       M (u - u_old) / h = sum A^T (F + rolling drag)

This is backward Euler, so it is stable for any h, J and s0. For a given c the shafts are linear in u and are
eliminated by hand; a symmetric 3 x 3 system is left. c is then corrected with the slip that came out (Picard, with the
wheel's own compliance B to speed it up: the force only has to fall to mu N, so the slip grows by B (|F| - mu N)).
It starts from the last step's slip; mostly one round is enough (mean 1.0 to 1.4 measured), four are allowed. At last
every force is put on its friction circle, and chassis and shafts are moved by these same forces: no force without its
reaction, no wheel beyond mu N.

Plain floats on purpose: numpy needs about 1 us a call and there would be 100 of them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from simcore.errors import ConfigError
from simcore.robot.drive_shaft import DriveShaft, WheelContact
from simcore.robot.limited_motor import LOCKED, solve_shaft, solve_supply, supply_line

__all__ = ["TireSolver"]

_ROUNDS, _FULL_ROUNDS = 6, 2
"""Rounds of a step, and how many of them take a new slip as it is. Later ones take the mean with the last, because two
rounds have swung from one side of the answer to the other. Of 10 000 sliding wheels in random steps of 5 ms, 10 are
left with less than 80 % of their grip; with four full rounds it was 100, and on shafts with three wheels 600."""
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
        self.torque_offset: Sequence[float] = [0.0] * len(self.shafts)
        """Torque on the shaft from elsewhere [N m]."""
        for s in self.shafts:
            if len({self.wheels[k].y for k in s.wheels}) > 1:
                raise ConfigError("a drive shaft's wheels must stand one behind the other, at the same y")
        # Attribute reads, twenty a wheel and step, cost as much as the arithmetic: everything in tuples. With forces
        # finished in the same pass unless a tire slides, four wheels took 23 us and take 13 us a step.
        self._plan = [
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
        """Advance by `h` and return the chassis velocity after it, robot axes.

        Args:
            h: Time step [s].
            vx: Velocity of the center of mass, forward, with the outside forces of this step already added [m/s].
            vy: To the left [m/s].
            omega: Yaw rate [rad/s].
            loads: Normal load per wheel [N].
            volts: Wanted voltage per shaft [V]; None is an open circuit.
            limits: Stator limit in force, per shaft [A].
            bus_voltage: Of the battery, which no motor can exceed [V].
        """
        speed = self.shaft_speed
        slips = self.slip
        cos, sin = self.cos, self.sin
        emf_offset, torque_offset = self.emf_offset, self.torque_offset
        rh = 1.0 / h
        m_h = self.mass * rh
        j_h = self.yaw_inertia * rh
        chassis_compliance = self._share / m_h
        force_x = self.force_x = [0.0] * len(slips)
        force_y = self.force_y = [0.0] * len(slips)

        # Per shaft: the torque line at the present speed. Per wheel: grip, slip scale, slip of the last step.
        work = []
        lines = []
        for g, inertia, radius, ratio, floor, conductance, supply, constants, row in self._plan:
            emf, resistance, driving, driven, friction = constants
            w = speed[g]
            v = volts[g]
            power = supply * bus_voltage
            i0 = i1 = t0 = t1 = 0.0
            if v is not None:
                if v > bus_voltage:
                    v = bus_voltage
                elif v < -bus_voltage:
                    v = -bus_voltage
                limit = limits[g]
                i0 = (v - emf_offset[g]) * conductance
                i1 = emf * conductance
                i = i0 - i1 * w
                f = driving if i * w >= 0.0 else driven
                p = v * i
                if p > power or p < -power:
                    t0, t1 = supply_line(emf_offset[g] + emf * w, emf, w, resistance, power, i, p)
                    i = t0 - t1 * w
                    t0 *= f
                    t1 *= f
                else:
                    t0 = f * i0
                    t1 = f * i1
                if i > limit:
                    t0 = f * limit
                    t1 = 0.0
                elif i < -limit:
                    t0 = -f * limit
                    t1 = 0.0
            if w > 0.0:
                t0 -= friction
            elif w < 0.0:
                t0 += friction
            elif t0 > friction:
                t0 -= friction
            elif t0 < -friction:
                t0 += friction
            else:
                t0 = 0.0
                t1 = LOCKED
            lines.append((t0, t1))
            rolling = w * radius
            s0 = (rolling if rolling > 0.0 else -rolling) * ratio + floor
            c_ = cos[g]
            s_ = sin[g]
            drag = 0.0
            contacts = []
            arm = 0.0
            for k, x, y, r2, tread, resistance_ in row:
                load = loads[k]
                grip = tread * load
                if grip <= 0.0:
                    continue
                drag += resistance_ * load
                if slips[k] < s0:
                    slips[k] = s0
                arm = x * s_ - y * c_
                contacts.append((k, x, y, r2, grip))
            v_l = c_ * vx + s_ * vy + arm * omega
            # Rolling drag is a constant force while the wheel rolls; as a coefficient it cannot push backwards.
            drag /= max(v_l, -v_l, floor)
            j = inertia * rh
            work.append(
                (g, j, j * w + torque_offset[g], i0, i1, power, c_, s_, arm, radius, s0, drag, constants, contacts)
            )

        new_speed = speed[:]
        ux, uy, uw = vx, vy, omega
        sum_x = sum_y = sum_n = 0.0
        sliding = False
        forces: list[tuple[float, float]] = []
        current = self.shaft_current = self.shaft_current[:]
        volts_out = self.shaft_volts = self.shaft_volts[:]
        for count in range(_ROUNDS):
            # Assemble M/h + sum A^T c A, less what the shafts give way. Across and along a wheel c is the same, so
            # its part is isotropic (it does not depend on the steer angle); only the shaft's give has a direction.
            a11 = a22 = m_h
            a33 = j_h
            a12 = a13 = a23 = 0.0
            b1 = m_h * vx
            b2 = m_h * vy
            b3 = j_h * omega
            stiffness = []
            for g, j, push, _, _, _, c_, s_, arm, radius, _, drag, _, contacts in work:
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
                give = rc / (j + t1 + radius * rc)
                e = drag - give * rc
                b = give * (push + t0)
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
            # Solve it: L D L^T by hand.
            l21 = a12 / a11
            l31 = a13 / a11
            d2 = a22 - l21 * a12
            e23 = a23 - l21 * a13
            l32 = e23 / d2
            y2 = b2 - l21 * b1
            uw = (b3 - l31 * b1 - l32 * y2) / (a33 - l31 * a13 - l32 * e23)
            uy = y2 / d2 - l32 * uw
            ux = b1 / a11 - l21 * uy - l31 * uw

            # Every shaft exactly, given the chassis; then the tire forces and, where a tire slides, a better slip.
            settled = True
            sliding = False
            forces = []
            sum_x = sum_y = sum_n = 0.0
            for g, j, push, i0, i1, power, c_, s_, arm, radius, s0, drag, constants, contacts in work:
                emf, resistance, driving, driven, friction = constants
                v_l = c_ * ux + s_ * uy + arm * uw
                rc = stiffness[g]
                stiff = j + radius * rc
                push += rc * v_l
                w, i, t0, t1 = solve_shaft(stiff, push, i0, i1, limits[g], driving, driven, friction)
                v = emf_offset[g] + emf * w + i * resistance
                if v * i > power or v * i < -power:
                    w, i, t0, t1 = solve_supply(
                        stiff, push, i, v * i, limits[g], constants, emf_offset[g], speed[g], power
                    )
                    v = emf_offset[g] + emf * w + i * resistance
                old0, old1 = lines[g]
                if t0 != old0 or t1 != old1:
                    # The torque that the chassis was solved with was another one; a 50th of the grip does not matter.
                    miss = t0 - old0 - (t1 - old1) * w
                    if t1 == LOCKED or old1 == LOCKED or abs(miss) > 0.02 * s0 * rc:
                        settled = False
                    lines[g] = (t0, t1)
                new_speed[g] = w
                current[g] = i
                volts_out[g] = v
                s_l = radius * w - v_l
                if drag > 0.0:
                    drag *= v_l / len(contacts)
                loose = 0.0
                slides = []
                for k, x, y, _, grip in contacts:
                    s_t = s_ * (ux - uw * y) - c_ * (uy + uw * x)
                    slip = slips[k]
                    c = grip / slip
                    f_l = c * s_l
                    f_t = c * s_t
                    forces.append((f_l, f_t))
                    f2 = f_l * f_l + f_t * f_t
                    if f2 > grip * grip or slip > s0:
                        size = math.sqrt(f2)
                        along = f_l / size if size > 0.0 else 0.0
                        loose += along * (size - grip)
                        slides.append((k, slip, size / c, along, size - grip))
                    if drag != 0.0:
                        f_l -= drag
                        if f_l * f_l + f_t * f_t > grip * grip:
                            sliding = True
                    force_x[k] = f_x = c_ * f_l - s_ * f_t
                    force_y[k] = f_y = s_ * f_l + c_ * f_t
                    sum_x += f_x
                    sum_y += f_y
                    sum_n += x * f_y - y * f_x
                if slides:
                    # What the slip would be at the grip: the shaft gives way to what all its contacts lose or gain
                    # together (one of three that took it all for its own would swing between two wrong slips), the
                    # chassis to each contact's share.
                    loose *= radius * radius / (j + t1)
                    for k, slip, found, along, excess in slides:
                        wanted = found + along * loose + chassis_compliance * excess
                        if wanted < s0:
                            wanted = s0
                        if count >= _FULL_ROUNDS:
                            wanted = math.sqrt(wanted * slip)
                        if abs(wanted - slip) > _TOLERANCE * slip:
                            settled = False
                        slips[k] = wanted
                        if excess > 0.0 or wanted > s0:
                            sliding = True
            if settled:
                break

        if sliding:
            # On the circle, exactly; the shafts then follow these same forces, and so does the chassis.
            sum_x = sum_y = sum_n = 0.0
            at = 0
            for g, j, push, i0, i1, power, c_, s_, arm, radius, s0, drag, constants, contacts in work:
                emf, resistance, driving, driven, friction = constants
                moved = False
                if drag > 0.0:
                    drag *= (c_ * ux + s_ * uy + arm * uw) / len(contacts)
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
                    force_x[k] = f_x = c_ * f_l - s_ * f_t
                    force_y[k] = f_y = s_ * f_l + c_ * f_t
                    sum_x += f_x
                    sum_y += f_y
                    sum_n += x * f_y - y * f_x
                if moved:
                    w, i, _, _ = solve_shaft(j, push, i0, i1, limits[g], driving, driven, friction)
                    v = emf_offset[g] + emf * w + i * resistance
                    if v * i > power or v * i < -power:
                        w, i, _, _ = solve_supply(
                            j, push, i, v * i, limits[g], constants, emf_offset[g], speed[g], power
                        )
                        v = emf_offset[g] + emf * w + i * resistance
                    new_speed[g] = w
                    current[g] = i
                    volts_out[g] = v
        speed[:] = new_speed
        return vx + sum_x / m_h, vy + sum_y / m_h, omega + sum_n / j_h
