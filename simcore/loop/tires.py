"""Tire forces: motion of chassis, wheels and drive motors in one implicit step.

The unknowns are the chassis velocity u = (vx, vy, omega) and the speed w of every drive shaft. For each wheel, with
unit vectors along (l) and across (t) the wheel and the contact velocity v_l = a_l u, v_t = a_t u:

    slip          s = (r w - v_l, -v_t)
    tire force    F = c s,         c = mu N / max(|s|, s0)        Coulomb friction, linear below the small slip s0
    shaft         J (w - w_old) / h = T(mean w) - r sum F_l       T: motor, limits, gears, friction (motor.py)
    chassis       M (u - u_old) / h = sum A^T (F + rolling drag)  M: effective mass below the center of mass

The equations use the slip and the robot axes at the end of the step (backward Euler). The solution is therefore stable
for any h, J and s0, and tires that hold leave no slip. Forces act in the axes at the middle of the step, and the motor
model uses the mean speed of the shaft (`end_weight`).

A tread with a grain q (mu across over mu along) has a friction ellipse. The equations also hold for an ellipse with
q s_t as the slip across and F_t / q as the force across: F = (c s_l, q c q s_t).

For a given c the shaft speeds are linear in u. Elimination of the shaft speeds leaves a symmetric 3 x 3 system. The
first c is from the slip of the last step. Up to `ROUNDS` corrections follow. The force only has to fall to mu N, so the
slip grows by the wheel's own compliance times |F| - mu N. Finally `step_tires` limits every force to the friction
circle. The same limited forces move the chassis and the shafts, so every force has a reaction and is at most mu N.
"""

from __future__ import annotations

import math

from simcore.loop.compiled import compiled, inner
from simcore.loop.motor import LOCKED, line_in_force, solve_limited, torque_line, within
from simcore.loop.robot_state import Records
from simcore.loop.shaft import accumulate, set_step

__all__ = ["share_loads", "step_tires"]

ROUNDS = 4
_SLIDE = 0.05
"""Slip above which a robot's tires count as sliding [m/s]."""
_TOLERANCE = 0.1
"""Relative change of a sliding wheel's slip below which the rounds end [-]; the friction circle limits the force."""
_NEARLY = 0.9
"""Fraction of the grip above which a sliding tire gets the full grip [-], because the force lags behind the slip."""
_SAME_PLACE = 1e-6
"""Mean square distance of contacts from their center below which the contacts are one point [m^2]."""


@compiled
def share_loads(wheels: Records, first: int, last: int, force_z: float, want_x: float, want_y: float) -> None:
    """Distribute a vertical force and the moments about the center of mass over the wheels, and set `wheels.load`.

        sum N_i = F,   sum N_i x_i = want_x,   sum N_i y_i = want_y

    For more than three wheels, the function finds the solution with the smallest sum of squared loads, as for identical
    springs under all wheels. A wheel that would need a negative load lifts off instead. Lowered middle wheels carry the
    load alone, or together with the wheels at the end toward which the load leans.

    Args:
        wheels: Records of all wheels.
        first: Index of the robot's first wheel.
        last: Index after the robot's last wheel.
        force_z: Vertical force F [N].
        want_x: Sum of N_i x_i, x forward from the center of mass [N m].
        want_y: Sum of N_i y_i, y to the left from the center of mass [N m].
    """
    rear = math.inf
    front = -math.inf
    for k in range(first, last):
        wheel = wheels[k]
        wheel.load = 0.0
        if wheel.model.is_lowered:
            rear = min(rear, wheel.model.x)
            front = max(front, wheel.model.x)
    if force_z <= 0.0:
        return
    if rear <= front:  # the robot has lowered wheels
        lean = want_x / force_z
        if lean > front:
            low, high = front, math.inf
        elif lean < rear:
            low, high = -math.inf, rear
        else:
            low, high = rear, front
    else:
        low, high = -math.inf, math.inf
    for k in range(first, last):  # `along` marks wheels that may carry load
        wheel = wheels[k]
        is_candidate = low <= wheel.model.x <= high
        if is_candidate and -math.inf < low and high < math.inf and wheel.model.is_lowered == 0:
            is_candidate = False
        wheel.along = 1.0 if is_candidate else 0.0
    while True:
        n = 0.0
        mean_x = 0.0
        mean_y = 0.0
        for k in range(first, last):
            wheel = wheels[k]
            n += wheel.along
            mean_x += wheel.along * wheel.model.x
            mean_y += wheel.along * wheel.model.y
        if n == 0.0:
            return
        mean_x /= n
        mean_y /= n
        xx = 0.0
        yy = 0.0
        xy = 0.0
        for k in range(first, last):
            wheel = wheels[k]
            dx = wheel.model.x - mean_x
            dy = wheel.model.y - mean_y
            xx += wheel.along * dx * dx
            yy += wheel.along * dy * dy
            xy += wheel.along * dx * dy
        det = xx * yy - xy * xy
        spread = xx + yy
        a = 0.0  # inverse of ((xx, xy), (xy, yy)), or the pseudo-inverse
        b = 0.0
        c = 0.0
        if spread >= n * _SAME_PLACE:
            if det > 1e-9 * spread * spread:
                a = yy / det
                b = -xy / det
                c = xx / det
            else:  # contacts on one line support only the moment along the line
                a = xx / (spread * spread)
                b = xy / (spread * spread)
                c = yy / (spread * spread)
        more_x = want_x - mean_x * force_z
        more_y = want_y - mean_y * force_z
        slope_x = a * more_x + b * more_y
        slope_y = b * more_x + c * more_y
        lowest = -1e-12 * force_z
        out = -1
        for k in range(first, last):
            wheel = wheels[k]
            if wheel.along > 0.0:
                model = wheel.model
                wheel.load = force_z / n + slope_x * (model.x - mean_x) + slope_y * (model.y - mean_y)
                if wheel.load < lowest:
                    lowest = wheel.load
                    out = k
        if out < 0:
            break
        wheels[out].along = 0.0  # the wheel lifts off; at least one stays, as the sum is F > 0
        wheels[out].load = 0.0
    for k in range(first, last):
        wheels[k].load = max(0.0, wheels[k].load)


@inner
def step_tires(robot, body, shafts, wheels, h, bus, vx, vy, omega):
    """Advance the drive shafts by a step, and set the tire forces `wheels.force_x` and `wheels.force_y`.

    The given velocities include all forces of the step except the tire forces, and are in the robot axes at the END of
    the step.

    Args:
        robot: Record of the robot.
        body: Record of the robot's body.
        shafts: Records of all shafts; the robot's shafts with wheels come first.
        wheels: Records of all wheels.
        h: Time step [s].
        bus: Battery voltage [V].
        vx: Forward velocity of the point below the center of mass [m/s].
        vy: Velocity of this point to the left [m/s].
        omega: Yaw rate, counter-clockwise positive [rad/s].
    """
    first_shaft = robot.model.first_shaft
    n_shafts = robot.model.drive_shafts
    first_wheel = robot.model.first_wheel
    mass_x = robot.plan_mass[0] / h
    mass_y = robot.plan_mass[1] / h
    turn_h = body.model.inertia[2] / h
    # Effective inverse mass at one contact: 1/m for a wheel that slides alone, more if other wheels also slide.
    compliance = (0.5 + 0.5 * (robot.model.last_wheel - first_wheel)) / min(mass_x, mass_y)
    for g in range(first_shaft, first_shaft + n_shafts):
        _begin_shaft(shafts, g, h, bus)
        _touch(shafts, g, wheels, first_wheel, vx, vy, omega)
    ux = vx
    uy = vy
    uw = omega
    is_sliding = False
    for count in range(ROUNDS):
        ux, uy, uw = _move_chassis(
            shafts, first_shaft, n_shafts, wheels, first_wheel, mass_x, mass_y, turn_h, vx, vy, omega
        )
        for _ in range(ROUNDS):  # rolling drag of wheels that start to roll in this step
            changed = False
            for g in range(first_shaft, first_shaft + n_shafts):
                s = shafts[g]
                speed = abs(s.cos * ux + s.sin * uy + s.arm * uw)
                most = s.most_drag * s.touching
                drag = s.drag * speed
                if drag > 1.05 * most or (drag < 0.95 * most and speed > s.model.slip_speed):
                    s.drag = most / speed
                    changed = True
            if not changed:
                break
            ux, uy, uw = _move_chassis(
                shafts, first_shaft, n_shafts, wheels, first_wheel, mass_x, mass_y, turn_h, vx, vy, omega
            )
        settled = True
        is_sliding = False
        for g in range(first_shaft, first_shaft + n_shafts):
            one_settled, one_slides = _move_shaft(shafts, g, wheels, first_wheel, ux, uy, uw, compliance, count)
            settled = settled and one_settled
            is_sliding = is_sliding or one_slides
        if settled:
            break
    # Limit every force to the friction circle; then apply the same forces to the shafts.
    fastest = 0.0
    for g in range(first_shaft, first_shaft + n_shafts):
        s = shafts[g]
        model = s.model
        v_l = s.cos * ux + s.sin * uy + s.arm * uw
        drag = 0.0
        if s.drag > 0.0:
            drag = within(s.drag * v_l / s.touching, s.most_drag)
        has_changed = False
        total = 0.0
        for k in range(first_wheel + model.first, first_wheel + model.last):
            wheel = wheels[k]
            if wheel.grip <= 0.0:
                wheel.force_x = 0.0
                wheel.force_y = 0.0
                continue
            along = wheel.along
            across = wheel.across
            size = math.sqrt(along * along + across * across)
            if size > wheel.grip or (wheel.slip > s.s0 and size > _NEARLY * wheel.grip):
                along *= wheel.grip / size
                across *= wheel.grip / size
                has_changed = True
            total += along
            along -= drag
            size = math.sqrt(along * along + across * across)
            if size > wheel.grip:
                along *= wheel.grip / size
                across *= wheel.grip / size
            fastest = max(fastest, wheel.slip)
            across *= model.grain
            fx = s.cos * along - s.sin * across
            fy = s.sin * along + s.cos * across
            wheel.force_x = fx
            wheel.force_y = fy
        if has_changed:
            s.speed, s.current, s.volts, _, _ = solve_limited(
                model.inertia / h, s.push - model.radius * total, s.i0, s.i1, s.limit, s.line_emf, s.line_resistance,
                model.driving, model.driven, model.friction, s.emf_offset, s.before, s.power,
            )  # fmt: skip
        if s.is_open:
            s.volts = 0.0
        s.position += s.speed * h  # final speed, as for the pose of the robot
        accumulate(shafts, g, h, bus)
    robot.is_sliding = 1 if is_sliding and fastest > _SLIDE else 0


@inner
def _begin_shaft(shafts, g, h, bus):
    """Prepare a drive shaft for a step of h [s].

    The function linearizes motor current and torque in the shaft speed (see `torque_line`), and computes the terms that
    do not depend on the new speed: inertia / h times the old speed, plus the torque from the coupled shaft.
    """
    s = shafts[g]
    model = s.model
    set_step(shafts, g, h)
    s.before = s.speed
    s.power = s.request.supply_limit * bus
    emf = s.emf_offset
    resistance = model.winding
    volts = 0.0
    s.line_emf = s.weight * model.emf
    if not s.is_open:
        volts, resistance = line_in_force(
            s.wanted, bus, emf + model.emf * s.speed, s.limit, model.resistance, model.winding
        )
    s.line_resistance = resistance
    # The back-EMF at the mean speed is linear in the final speed; this is the constant part.
    s.emf_offset = emf + (model.emf - s.line_emf) * s.speed
    s.i0, s.i1, s.t0, s.t1 = torque_line(
        s.is_open == 1, volts, bus, s.emf_offset, s.speed, s.limit, s.power, s.line_emf, resistance,
        model.driving, model.driven, model.friction,
    )  # fmt: skip
    s.push = model.inertia / h * s.speed + s.torque_offset


@inner
def _touch(shafts, g, wheels, first_wheel, vx, vy, omega):
    """Compute grip, slip and rolling drag of the wheels on a drive shaft for a step.

    The rolling drag of a constant force is linearized: the force divided by the speed.
    """
    s = shafts[g]
    model = s.model
    s.s0 = abs(s.before * model.radius) * model.slip_ratio + model.slip_speed
    drag = 0.0
    count = 0
    s.arm = 0.0
    for k in range(first_wheel + model.first, first_wheel + model.last):
        wheel = wheels[k]
        wheel.grip = wheel.model.cof * wheel.load
        if wheel.grip > 0.0:
            drag += wheel.model.rolling * wheel.load
            wheel.slip = max(wheel.slip, s.s0)
            s.arm = wheel.model.x * s.sin - wheel.model.y * s.cos
            count += 1
    s.touching = count
    s.most_drag = drag / count if count else 0.0
    s.drag = drag / max(abs(s.cos * vx + s.sin * vy + s.arm * omega), model.slip_speed)


@inner
def _move_chassis(shafts, first_shaft, n_shafts, wheels, first_wheel, mass_x, mass_y, turn_h, vx, vy, omega):
    """Return the chassis velocity [m/s, m/s, rad/s] for the present slips, and set the stiffness of the shafts.

    The velocity is the solution of the symmetric 3 x 3 system in the module's docstring. The matrix of the system is
    M/h + sum A^T c A, plus the rolling drag, minus the compliance of the shafts. The part of c that is equal along and
    across a wheel does not depend on the steer angle. All other terms act only along the wheel: the rolling drag, the
    compliance and, for a tread with grain, the excess of c along the wheel.
    """
    a11 = mass_x
    a22 = mass_y
    a33 = turn_h
    a12 = 0.0
    a13 = 0.0
    a23 = 0.0
    b1 = mass_x * vx
    b2 = mass_y * vy
    b3 = turn_h * omega
    for g in range(first_shaft, first_shaft + n_shafts):
        s = shafts[g]
        model = s.model
        rc = 0.0
        rq = 0.0
        for k in range(first_wheel + model.first, first_wheel + model.last):
            wheel = wheels[k]
            if wheel.grip > 0.0:
                c = wheel.grip / wheel.slip
                rc += c
                c *= model.grain * model.grain
                rq += c
                x = wheel.model.x
                y = wheel.model.y
                a13 -= c * y
                a23 += c * x
                a33 += c * (x * x + y * y)
        a11 += rq
        a22 += rq
        more = rc - rq
        rc *= model.radius
        s.stiffness = rc
        inertia = model.inertia / s.weighted
        share = rc / (inertia + s.t1 + model.radius * rc)
        e = s.drag + more - share * rc
        b = share * (s.push + s.t0)
        a11 += e * s.cos * s.cos
        a12 += e * s.cos * s.sin
        a13 += e * s.cos * s.arm
        a22 += e * s.sin * s.sin
        a23 += e * s.sin * s.arm
        a33 += e * s.arm * s.arm
        b1 += b * s.cos
        b2 += b * s.sin
        b3 += b * s.arm
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


@inner
def _move_shaft(shafts, g, wheels, first_wheel, ux, uy, uw, compliance, count):
    """Solve a shaft for a given chassis velocity, and update the tire forces and the slips of sliding tires.

    Returns:
        Whether slips and torque line have converged, and whether a tire slides.
    """
    s = shafts[g]
    model = s.model
    v_l = s.cos * ux + s.sin * uy + s.arm * uw
    last = s.speed
    inertia = model.inertia / s.weighted
    s.speed, s.current, s.volts, t0, t1 = solve_limited(
        inertia + model.radius * s.stiffness, s.push + s.stiffness * v_l, s.i0, s.i1, s.limit, s.line_emf,
        s.line_resistance, model.driving, model.driven, model.friction, s.emf_offset, s.before, s.power,
    )  # fmt: skip
    settled = True
    if t0 != s.t0 or t1 != s.t1:
        miss = t0 - s.t0 - (t1 - s.t1) * s.speed
        if t1 == LOCKED or s.t1 == LOCKED or abs(miss) > 0.02 * s.s0 * s.stiffness:
            settled = False
            turned = s.speed < 0.0 < last or last < 0.0 < s.speed
            if turned and model.friction > 0.0 and t1 != LOCKED:
                # The chassis reversed this shaft although friction acted in the other direction. Between the two
                # speeds, friction may hold the shaft.
                t0 = 0.0
                t1 = LOCKED
        s.t0 = t0
        s.t1 = t1
    is_sliding = False
    excess_along = 0.0
    slides = False
    rim = model.radius * s.speed - v_l
    for k in range(first_wheel + model.first, first_wheel + model.last):
        wheel = wheels[k]
        if wheel.grip <= 0.0:
            continue
        c = wheel.grip / wheel.slip
        wheel.along = c * rim
        wheel.across = c * model.grain * (s.sin * (ux - uw * wheel.model.y) - s.cos * (uy + uw * wheel.model.x))
        size = math.sqrt(wheel.along * wheel.along + wheel.across * wheel.across)
        if size > wheel.grip or wheel.slip > s.s0:
            slides = True
            if size > 0.0:
                excess_along += wheel.along / size * (size - wheel.grip)
    if slides:
        # Slip at which the force equals the grip. The shaft yields to the change of force of all its contacts together
        # (with only its own change a wheel of three would oscillate between two wrong slips), the chassis to the change
        # at each contact.
        excess_along *= model.radius * model.radius / (inertia + s.t1)
        for k in range(first_wheel + model.first, first_wheel + model.last):
            wheel = wheels[k]
            size = math.sqrt(wheel.along * wheel.along + wheel.across * wheel.across)
            if wheel.grip > 0.0 and (size > wheel.grip or wheel.slip > s.s0):
                share = wheel.along / size if size > 0.0 else 0.0
                excess = size - wheel.grip
                wanted = max(s.s0, size * wheel.slip / wheel.grip + share * excess_along + compliance * excess)
                if count > 1:
                    wanted = math.sqrt(wanted * wheel.slip)
                if abs(wanted - wheel.slip) > _TOLERANCE * wheel.slip:
                    settled = False
                wheel.slip = wanted
                if excess > 0.0 or wanted > s.s0:
                    is_sliding = True
    return settled, is_sliding
