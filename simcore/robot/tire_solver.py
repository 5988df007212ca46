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

A tread with grain q (mu across over mu along) has its forces on an ellipse. With q s_t for the slip across and F_t / q
for the force across all of this holds: F = (c s_l, q c q s_t).

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

from simcore.errors import ConfigError
from simcore.geometry.rotation import Vector
from simcore.robot.drive_shaft import DriveShaft, ShaftStep, WheelContact

__all__ = ["TireSolver"]

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
        # Effective inverse mass at one contact, times the mass: 1 for one that slides alone, more when others do too.
        self._share = 0.5 + 0.5 * len(self.wheels)
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
        self._steps = [ShaftStep(g, s, self.wheels) for g, s in enumerate(self.shafts)]

    def set_mass(self, mass: float, yaw_inertia: float, positions: Sequence[tuple[float, float]]) -> None:
        """Go on with another mass [kg], yaw inertia [kg m^2] and wheel positions from the center of mass [m]."""
        self.mass, self.yaw_inertia = mass, yaw_inertia
        if any(w.x != x or w.y != y for w, (x, y) in zip(self.wheels, positions, strict=True)):
            self.wheels = tuple(replace(w, x=x, y=y) for w, (x, y) in zip(self.wheels, positions, strict=True))
            self._steps = [ShaftStep(g, s, self.wheels) for g, s in enumerate(self.shafts)]

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
        self._sums = (0.0, 0.0, 0.0)  # of the wheels' forces [N, N, N m]

    @property
    def is_at_rest(self) -> bool:
        """Whether no shaft turned or carried current in the last step, and no tire pushed or kept an old slip."""
        if self.is_sliding or any(self.shaft_speed) or any(self.shaft_current):
            return False
        if any(self.force_x) or any(self.force_y):
            return False
        return all(self.slip[wheel.row] <= shaft.s0 for shaft in self._steps for wheel in shaft.wheels)

    def step(
        self,
        h: float,
        velocity: Vector,
        loads: Sequence[float],
        volts: Sequence[float | None],
        limits: Sequence[float],
        bus_voltage: float,
    ) -> Vector:
        """Advance by `h` and return the change of the chassis velocity, robot axes in the MIDDLE of the step.

        Args:
            h: Time step [s].
            velocity: Of the center of mass before the step, with the outside forces of the step already added, in robot
                axes at the END of the step: forward, to the left, yaw rate [m/s, m/s, rad/s].
            loads: Normal load per wheel [N].
            volts: Wanted voltage per shaft [V]; None is an open circuit.
            limits: Stator limit in force, per shaft [A].
            bus_voltage: Of the battery, which no motor can exceed [V].
        """
        rh = 1.0 / h
        m_h = self.mass * rh
        j_h = self.yaw_inertia * rh
        vx, vy, omega = velocity
        before = (m_h, j_h, vx, vy, omega)
        n = len(self.slip)
        self.force_x = [0.0] * n
        self.force_y = [0.0] * n
        speed, slips = self.shaft_speed, self.slip
        is_slow = False
        for g, shaft in enumerate(self._steps):
            shaft.begin(rh, speed[g], volts[g], limits[g], bus_voltage, self.emf_offset[g], self.torque_offset[g])
            if shaft.touch(self.cos[g], self.sin[g], loads, slips, vx, vy, omega):
                is_slow = True
        sliding = False
        for count in range(_ROUNDS):
            after = self._move_chassis(before)
            if is_slow:
                for _ in range(_ROUNDS):
                    if not self._rescale_drag(after):
                        break
                    after = self._move_chassis(before)
            settled, sliding = self._move_shafts(after, self._share / m_h, count)
            if settled:
                break
        self.is_sliding = sliding and max(slips) > _SLIDE
        if sliding:
            self._limit_forces(after)
        self.shaft_current = [shaft.current for shaft in self._steps]
        self.shaft_volts = [shaft.volts for shaft in self._steps]
        speed[:] = [shaft.speed for shaft in self._steps]
        sum_x, sum_y, sum_n = self._sums
        return sum_x / m_h, sum_y / m_h, sum_n / j_h

    def _rescale_drag(self, after: Vector) -> bool:
        """Rolling drag at the chassis velocity of this round; whether it has changed."""
        ux, uy, uw = after
        changed = [s.rescale_drag(abs(s.cos * ux + s.sin * uy + s.arm * uw)) for s in self._steps]
        return True in changed

    def _move_chassis(self, before: tuple[float, float, float, float, float]) -> Vector:
        """Chassis velocity [m/s, m/s, rad/s] with the present slips, the shafts eliminated.

        M/h + sum A^T c A, less what the shafts yield, is assembled and solved. What c does across a wheel it does along
        as well, so that part is isotropic (it does not depend on the steer angle); the rest has a direction: the
        shaft's yielding, and with a grain what there is more along than across.

        Args:
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
        for shaft in self._steps:
            rc = rq = 0.0
            q2 = shaft.grain * shaft.grain
            for wheel in shaft.touching:
                c = wheel.grip / slips[wheel.row]
                rc += c
                c *= q2
                rq += c
                a13 -= c * wheel.y
                a23 += c * wheel.x
                a33 += c * wheel.r2
            a11 += rq
            a22 += rq
            more = rc - rq
            rc *= shaft.radius
            shaft.stiffness = rc
            share = rc / (shaft.inertia + shaft.t1 + shaft.radius * rc)
            e = shaft.drag + more - share * rc
            b = share * (shaft.push + shaft.t0)
            c_ = shaft.cos
            s_ = shaft.sin
            arm = shaft.arm
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

    def _move_shafts(self, after: Vector, compliance: float, count: int) -> tuple[bool, bool]:
        """Every shaft exactly, given the chassis; then the tire forces and, where a tire slides, a better slip.

        Args:
            after: Chassis velocity of this round.
            compliance: Effective inverse mass of the chassis at one contact, times 1/h.
            count: Rounds done.

        Returns:
            Whether slips and lines need no further round, and whether a tire slides.
        """
        ux, uy, uw = after
        slips = self.slip
        force_x, force_y = self.force_x, self.force_y
        settled = True
        sliding = False
        sum_x = sum_y = sum_n = 0.0
        for shaft in self._steps:
            c_ = shaft.cos
            s_ = shaft.sin
            radius = shaft.radius
            q = shaft.grain
            s0 = shaft.s0
            v_l = c_ * ux + s_ * uy + shaft.arm * uw
            last = shaft.speed
            stiff = shaft.stiffness
            t0, t1 = shaft.solve(shaft.inertia + radius * stiff, shaft.push + stiff * v_l)
            if (t0 != shaft.t0 or t1 != shaft.t1) and not shaft.meet(t0, t1, last):
                settled = False
            s_l = radius * shaft.speed - v_l
            c_mid = self.mid_cos[shaft.row]
            s_mid = self.mid_sin[shaft.row]
            drag = shaft.drag_at(v_l) if shaft.drag > 0.0 else 0.0
            excess_along = 0.0
            slides = None
            for wheel in shaft.touching:
                k = wheel.row
                x = wheel.x
                y = wheel.y
                grip = wheel.grip
                s_t = s_ * (ux - uw * y) - c_ * (uy + uw * x)
                slip = slips[k]
                c = grip / slip
                wheel.along = f_l = c * s_l
                wheel.across = f_t = c * q * s_t
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
                f_t *= q
                force_x[k] = f_x = c_mid * f_l - s_mid * f_t
                force_y[k] = f_y = s_mid * f_l + c_mid * f_t
                sum_x += f_x
                sum_y += f_y
                sum_n += x * f_y - y * f_x
            if slides is not None:
                # What the slip would be at the grip: the shaft yields to what all its contacts lose or gain together
                # (one of three that took it all for its own would swing between two wrong slips), the chassis to each
                # contact's share.
                excess_along *= radius * radius / (shaft.inertia + shaft.t1)
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

    def _limit_forces(self, after: Vector) -> None:
        """Put every force on its friction circle, exactly; the shafts then follow these same forces.

        Args:
            after: Chassis velocity of the last round.
        """
        ux, uy, uw = after
        force_x, force_y = self.force_x, self.force_y
        sum_x = sum_y = sum_n = 0.0
        for shaft in self._steps:
            moved = False
            push = shaft.push
            c_mid = self.mid_cos[shaft.row]
            s_mid = self.mid_sin[shaft.row]
            v_l = shaft.cos * ux + shaft.sin * uy + shaft.arm * uw
            drag = shaft.drag_at(v_l) if shaft.drag > 0.0 else 0.0
            for wheel in shaft.touching:
                k = wheel.row
                grip = wheel.grip
                f_l, f_t = wheel.along, wheel.across
                size = math.sqrt(f_l * f_l + f_t * f_t)
                # A sliding tire has all of its grip; within the tolerance of the rounds that may be a bit more.
                if size > grip or (self.slip[k] > shaft.s0 and size > 0.85 * grip):
                    f_l *= grip / size
                    f_t *= grip / size
                    moved = True
                push -= shaft.radius * f_l
                # Rolling drag comes out of the same grip: what the carpet passes on in all stays within mu N.
                if drag != 0.0:
                    f_l -= drag
                    total = math.sqrt(f_l * f_l + f_t * f_t)
                    if total > grip:
                        f_l *= grip / total
                        f_t *= grip / total
                f_t *= shaft.grain
                force_x[k] = f_x = c_mid * f_l - s_mid * f_t
                force_y[k] = f_y = s_mid * f_l + c_mid * f_t
                sum_x += f_x
                sum_y += f_y
                sum_n += wheel.x * f_y - wheel.y * f_x
            if moved:
                shaft.solve(shaft.inertia, push)
        self._sums = (sum_x, sum_y, sum_n)
