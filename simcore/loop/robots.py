"""One time step of all robots and swinging bodies: motors, shafts, wheels, batteries, tires and bumpers.

`advance_robots` applies the forces of one step to the velocities of all robots and swinging bodies.
`simcore.loop.step` then advances the poses and applies the impulses of balls.
"""

from __future__ import annotations

import math

import numpy as np

from simcore.loop.battery import bus_voltage, draw
from simcore.loop.body import (
    UPRIGHT,
    apply_impulse,
    drift,
    rotate,
    rotate_back,
    touch_each_other,
    touch_field,
    touch_swinging,
    turned_rate,
    update_axes,
)
from simcore.loop.bumpers import place_parts, touch_outlines, touch_robots
from simcore.loop.compiled import compiled, inner
from simcore.loop.motor import within
from simcore.loop.robot_state import AZIMUTH, TARGET, WHEELS, Fleet, Records
from simcore.loop.shaft import begin_motor, control, open_circuit, turn
from simcore.loop.solids import Solids
from simcore.loop.swing import swing, touch_stops
from simcore.loop.tires import step_tires

__all__ = ["advance_robots", "begin_robots", "end_robots", "optimize", "settle"]

_SETTLES = 3.0  # time in which a robot settles on the ground [s]
_HELD_BACK = 0.99  # fraction of the velocity that a settling robot keeps after a step of 1 ms [-]


@inner
def begin_robots(fleet: Fleet, bodies: Records) -> int:
    """Check that the positions and velocities of robots are finite, and clear the sums of the last call.

    Returns:
        Index of a robot with a position or velocity that is not finite, -1 if all are finite.
    """
    for r in range(len(fleet.robots)):
        robot = fleet.robots[r]
        body = bodies[robot.model.body]
        total = 0.0
        for k in range(3):
            total += body.pos[k] + body.vel[k] + body.rate[k]
        if not math.isfinite(total):
            return r
        update_axes(body)
        for k in range(6):
            body.mean_twist[k] = 0.0
        robot.touched = 0
        for i in range(robot.model.first_shaft, robot.model.last_shaft):
            begin_motor(fleet.shafts, i)
        for k in range(robot.model.first_wheel, robot.model.last_wheel):
            fleet.wheels[k].mean_load = 0.0
            fleet.wheels[k].mean_x = 0.0
            fleet.wheels[k].mean_y = 0.0
    return -1


@inner
def end_robots(fleet: Fleet, h: float) -> None:
    """Divide the motor currents summed over a call by the duration h of the call [s], to get mean currents."""
    for r in range(len(fleet.robots)):
        model = fleet.robots[r].model
        for i in range(model.first_shaft, model.last_shaft):
            fleet.shafts[i].mean_current /= h
            fleet.shafts[i].mean_supply /= h


@compiled
def advance_robots(
    fleet: Fleet, bodies: Records, solids: Solids, has_floor: bool, gravity: float, h: float, part: float
):
    """Advance the velocities of robots and swinging bodies, and motors, shafts and batteries, by one step.

    `simcore.loop.step` advances the poses.

    Args:
        fleet: All robots.
        bodies: Records of all bodies.
        solids: Solids of the field and of bodies.
        has_floor: Whether there is a floor at z = 0.
        gravity: Gravitational acceleration, downward [m/s^2].
        h: Time step [s].
        part: Time step over the duration of the call [-].
    """
    n = len(fleet.robots)
    found = np.zeros((2, 7))
    fleet.clock[0] += 1
    has_swinging = False
    for b in range(len(bodies)):
        has_swinging = has_swinging or bodies[b].model.swings == 1
    for r in range(n):
        robot = fleet.robots[r]
        for k in range(3):
            robot.press[k] = 0.0
            robot.twist[k] = 0.0
            robot.shift[k] = 0.0
        robot.is_upright = 1 if bodies[robot.model.body].axes[2, 2] > UPRIGHT else 0
        if robot.is_upright:
            place_parts(fleet, r, bodies[robot.model.body])
    for r in range(n):
        robot = fleet.robots[r]
        body = bodies[robot.model.body]
        if robot.is_upright:
            touch_outlines(fleet, r, body, h, found)
        touch_field(fleet, r, bodies, solids, has_floor, h)
        if has_swinging:
            touch_swinging(fleet, r, bodies, solids, h)
        for q in range(r + 1, n):
            if _are_near(robot, fleet.robots[q], body, bodies[fleet.robots[q].model.body]):
                if _meet_in_plan(fleet, robot, fleet.robots[q]):
                    touch_robots(fleet, r, q, bodies, h, found)
                else:
                    touch_each_other(fleet, r, q, bodies, h)
    for b in range(len(bodies)):
        body = bodies[b]
        if body.model.swings:
            if body.is_awake:
                touch_stops(body, solids, has_floor, h)
                swing(body, gravity, h)
        elif body.is_active and not body.model.is_robot:
            for k in range(3):
                body.rate[k] += h * body.turn[k]
    for r in range(n):
        _kick(fleet, r, bodies, gravity, h, part)


@inner
def _are_near(robot, other, body, met):
    """Return whether the bounding circles of two robots around the centers of mass overlap in plan view."""
    dx = body.com[0] - met.com[0]
    dy = body.com[1] - met.com[1]
    far = robot.model.reach + other.model.reach
    if not (robot.is_upright and other.is_upright):
        far = body.model.reach + met.model.reach
    return dx * dx + dy * dy < far * far


@inner
def _meet_in_plan(fleet, robot, other):
    """Return whether two robots are upright and have bumpers or frames at a common height."""
    if not (robot.is_upright and other.is_upright):
        return False
    for a in range(robot.model.first_part, robot.model.last_part):
        for b in range(other.model.first_part, other.model.last_part):
            if max(fleet.parts[a].low, fleet.parts[b].low) < min(fleet.parts[a].high, fleet.parts[b].high):
                return True
    return False


@inner
def _control(robot, shafts, battery):
    """Compute the outputs of all motor controllers of a robot for a step.

    While the robot is disabled, drive and steer motors brake or coast as configured, and mechanisms are switched off.
    While the controllers are browned out, the circuits of drive and steer motors are open, and mechanisms are switched
    off.
    """
    for i in range(robot.model.first_shaft, robot.model.last_shaft):
        s = shafts[i]
        model = s.model
        is_drive = model.kind == WHEELS or model.kind == AZIMUTH
        s.emf_offset = 0.0
        s.torque_offset = 0.0
        if is_drive:
            if model.kind == WHEELS and model.partner >= 0:
                s.emf_offset = model.coupled_emf * shafts[robot.model.first_shaft + model.partner].speed
            s.limit = s.request.stator_limit
            if battery.is_off:
                s.is_open = 1
            elif not robot.request.is_enabled:
                s.is_open = 0 if s.request.brakes else 1
                s.wanted = 0.0
            elif s.request.mode == TARGET:
                s.is_open = 0
                _follow_target(shafts, i, robot.model.first_shaft)
            else:
                control(shafts, i, robot.bus, 0.0)
        else:
            if battery.is_off or not robot.request.is_enabled:
                open_circuit(shafts, i)
            control(shafts, i, model.rail if model.rail > 0.0 else robot.bus, model.emf * s.speed)


@inner
def optimize(speed: float, angle: float, present: float) -> tuple[float, float]:
    """Optimize a swerve module state: reverse the wheel if the steer error is more than a quarter turn.

    Args:
        speed: Requested wheel speed [m/s].
        angle: Requested steer angle [rad].
        present: Present steer angle, any number of turns [rad].

    Returns:
        Signed wheel speed, scaled by the cosine of the steer error so that a turning module does not scrub sideways
        [m/s], and steer error within -pi/2..pi/2 [rad].
    """
    error = angle - present
    error -= math.tau * math.floor(error / math.tau + 0.5)
    if error > 0.5 * math.pi:
        error -= math.pi
        speed = -speed
    elif error < -0.5 * math.pi:
        error += math.pi
        speed = -speed
    return speed * math.cos(error), error


@inner
def _follow_target(shafts, i, first_shaft):
    """Compute the voltage of the closed loop of a drive motor (wheel speed) or steer motor (angle), into `wanted`.

    If the voltage of a drive motor is zero and the motor is configured to coast, the function opens the circuit.
    """
    s = shafts[i]
    model = s.model
    if model.kind == AZIMUTH:
        _, error = optimize(0.0, s.request.value, s.position)
        s.wanted = model.kp * error + model.ks * within(model.ks_slope * error, 1.0)
        return
    speed = s.request.value
    turning = 0.0
    if model.partner >= 0:
        azimuth = shafts[first_shaft + model.partner]
        if azimuth.request.mode == TARGET:
            speed, _ = optimize(speed, azimuth.request.value, azimuth.position)
        turning = azimuth.speed
    s.wanted = (
        model.feedforward * speed
        + model.kp * (speed - s.speed * model.known_radius)
        + model.ks * within(model.ks_slope * speed, 1.0)
        + model.loop_coupled * turning
    )
    if s.wanted == 0.0 and not s.request.brakes:
        s.is_open = 1


@inner
def scrub(azimuth, wheel, least):
    """Return the dry friction [N m] and viscous drag [N m s/rad] of the carpet on a contact patch that is steered.

    Only dry friction mu N r resists the steering of a wheel at rest. Coulomb friction acts along the slip. If a rolling
    wheel already slips at a speed s, and steering at omega adds a speed r omega < s, only the fraction r omega / s of
    the friction resists the steering. As in a moving car, the steering of a rolling wheel therefore needs little
    torque, and scrub does not hold the steer angle.

    Args:
        azimuth: Record of the steer shaft.
        wheel: Record of the module's wheel.
        least: Slip of a wheel at rest [m/s].
    """
    radius = azimuth.model.scrub
    most = radius * wheel.model.cof * wheel.load
    slip = wheel.slip - least
    if radius * abs(azimuth.speed) < slip:
        return 0.0, most * radius / slip
    return most, 0.0


@inner
def _steer(robot, shafts, wheels, h, bus):
    """Advance the steer shafts and the mechanisms of a robot by one step of h [s].

    The function also sets the wheel direction, and the back-EMF and torque from the coupling of the steer shaft, for
    each wheel shaft of a swerve module.
    """
    for i in range(robot.model.first_shaft + robot.model.drive_shafts, robot.model.last_shaft):
        s = shafts[i]
        model = s.model
        if model.kind != AZIMUTH:
            turn(shafts, i, h, bus, 0.0, 0.0, 0.0)
            continue
        wheel_shaft = shafts[robot.model.first_shaft + model.partner]
        before = s.speed
        dry, drag = scrub(s, wheels[robot.model.first_wheel + wheel_shaft.model.first], wheel_shaft.model.slip_speed)
        turn(shafts, i, h, bus, dry, drag, model.coupling * wheel_shaft.current)
        wheel_shaft.emf_offset = wheel_shaft.model.coupled_emf * 0.5 * (before + s.speed)
        wheel_shaft.torque_offset = -wheel_shaft.model.coupled_inertia * (s.speed - before) / h
        wheel_shaft.cos = math.cos(s.position + model.zero)
        wheel_shaft.sin = math.sin(s.position + model.zero)


@inner
def _kick(fleet, r, bodies, gravity, h, part):
    """Apply the forces of a step of h [s] to the velocity of one robot, and advance motors, shafts and battery.

    The function applies all other forces before the tire forces. The tire forces depend on the velocity at the end of
    the step, and act at the contact points of the wheels.
    """
    robot = fleet.robots[r]
    model = robot.model
    body = bodies[model.body]
    robot.is_put = 0
    quat = body.quat
    mass = body.model.mass
    body.vel[0] += h * (robot.request.force[0] + robot.press[0]) / mass
    body.vel[1] += h * (robot.request.force[1] + robot.press[1]) / mass
    body.vel[2] += h * ((robot.request.force[2] + robot.press[2]) / mass - gravity)
    tx, ty, tz = rotate_back(
        quat,
        robot.request.torque[0] + robot.twist[0],
        robot.request.torque[1] + robot.twist[1],
        robot.request.torque[2] + robot.twist[2],
    )
    _, _, old_turn = rotate_back(quat, body.rate[0], body.rate[1], body.rate[2])
    wx, wy, wz = turned_rate(body, tx, ty, tz, h)
    if model.last_shaft > model.first_shaft:
        battery = fleet.batteries[r]
        _control(robot, fleet.shafts, battery)
        bus = bus_voltage(
            fleet.batteries,
            r,
            robot.bus,
            robot.request.other_current,
            fleet.shafts,
            model.first_shaft,
            model.last_shaft,
        )
        robot.bus = bus
        for k in range(model.last_wheel - model.first_wheel):
            fleet.wheels[model.first_wheel + k].load = fleet.points[model.first_point + k].load
        _steer(robot, fleet.shafts, fleet.wheels, h, bus)
        if model.drive_shafts:
            wx, wy, wz = _roll(fleet, robot, bodies, wx, wy, wz, old_turn, h, bus, part)
        supply = robot.request.other_current
        for i in range(model.first_shaft, model.last_shaft):
            supply += fleet.shafts[i].supply
        robot.time += h
        if draw(fleet.batteries, r, h, supply, bus):
            for i in range(model.first_shaft, model.last_shaft):
                fleet.shafts[i].noted_supply = fleet.shafts[i].supply
    robot.yaw_rate = wz
    body.rate[0], body.rate[1], body.rate[2] = rotate(quat, wx, wy, wz)


@inner
def _roll(fleet, robot, bodies, wx, wy, wz, old_turn, h, bus, part):
    """Apply the tire forces to a robot's velocity, and return the new angular velocity, robot axes [rad/s].

    The function also applies the reaction to the bodies under the wheels. The effective mass at the contacts is less
    than the robot's mass, because a tire force also tips the robot.
    """
    body = bodies[robot.model.body]
    quat = body.quat
    mass = body.model.mass
    inertia = body.model.inertia
    high = _height_above_contacts(fleet, robot, body)
    robot.plan_mass[0] = 1.0 / (1.0 / mass + high * high / inertia[1])
    robot.plan_mass[1] = 1.0 / (1.0 / mass + high * high / inertia[0])
    ground_x, ground_y, ground_turn = _ground_velocity(fleet, robot, bodies)
    vx, vy, _ = rotate_back(quat, body.vel[0], body.vel[1], body.vel[2])
    vx -= wy * high + ground_x
    vy += wx * high - ground_y
    wz -= ground_turn
    half = 0.5 * old_turn * h
    c = math.cos(2.0 * half)
    s = math.sin(2.0 * half)
    step_tires(robot, body, fleet.shafts, fleet.wheels, h, bus, c * vx + s * vy, c * vy - s * vx, wz)
    c = math.cos(half)
    s = math.sin(half)
    gx = 0.0
    gy = 0.0
    gz = 0.0
    mx = 0.0
    my = 0.0
    mz = 0.0
    for k in range(robot.model.last_wheel - robot.model.first_wheel):
        wheel = fleet.wheels[robot.model.first_wheel + k]
        wheel.mean_load += part * wheel.load
        wheel.mean_x += part * wheel.force_x
        wheel.mean_y += part * wheel.force_y
        size = wheel.force_x * wheel.force_x + wheel.force_y * wheel.force_y
        if size == 0.0:
            continue
        point = fleet.points[robot.model.first_point + k]
        normal = point.normal
        arm = point.arm
        ex, ey, ez = rotate(quat, c * wheel.force_x - s * wheel.force_y, s * wheel.force_x + c * wheel.force_y, 0.0)
        out = ex * normal[0] + ey * normal[1] + ez * normal[2]
        ex -= out * normal[0]
        ey -= out * normal[1]
        ez -= out * normal[2]
        left = ex * ex + ey * ey + ez * ez
        scale = math.sqrt(size / left) if left > 0.1 * size else 1.0
        ex *= scale
        ey *= scale
        ez *= scale
        gx += ex
        gy += ey
        gz += ez
        if point.on >= 0:
            plate = bodies[point.on]
            px, py, pz = _lever(point, body, plate)
            apply_impulse(plate, -h * ex, -h * ey, -h * ez, px, py, pz)
        mx += arm[1] * ez - arm[2] * ey
        my += arm[2] * ex - arm[0] * ez
        mz += arm[0] * ey - arm[1] * ex
    body.vel[0] += h * gx / mass
    body.vel[1] += h * gy / mass
    body.vel[2] += h * gz / mass
    mx, my, mz = rotate_back(quat, mx, my, mz)
    wz += ground_turn
    return wx + h * mx / inertia[0], wy + h * my / inertia[1], wz + h * mz / inertia[2]


@inner
def _height_above_contacts(fleet, robot, body):
    """Return the height of a robot's center of mass above the wheels' contacts, along the robot's z axis [m].

    The function weights the contacts by load. A wheel of radius R on a robot that is tilted by an angle t touches the
    ground R (1 - cos t) above the robot's origin. A tire at the origin's height would do work on a tipping robot.
    """
    total = 0.0
    high = 0.0
    for k in range(robot.model.last_wheel - robot.model.first_wheel):
        point = fleet.points[robot.model.first_point + k]
        if point.load > 0.0:
            _, _, z = rotate_back(body.quat, point.arm[0], point.arm[1], point.arm[2])
            high -= point.load * z
            total += point.load
    return high / total if total > 0.0 else body.model.center[2]


@inner
def _lever(point, body, plate):
    """Return the offset of a wheel's contact on a plate from the plate's pivot, field axes [m]."""
    return (
        point.arm[0] + body.com[0] - plate.com[0],
        point.arm[1] + body.com[1] - plate.com[1],
        point.arm[2] + body.com[2] - plate.com[2],
    )


@inner
def _ground_velocity(fleet, robot, bodies):
    """Return the mean velocity of the ground under a robot's wheels, weighted by load, robot axes [m/s, m/s, rad/s]."""
    body = bodies[robot.model.body]
    total = 0.0
    x = 0.0
    y = 0.0
    z = 0.0
    turn = 0.0
    for k in range(robot.model.last_wheel - robot.model.first_wheel):
        point = fleet.points[robot.model.first_point + k]
        total += point.load
        if point.on < 0:
            continue
        plate = bodies[point.on]
        ax, ay, az = _lever(point, body, plate)
        rate = plate.rate
        x += point.load * (rate[1] * az - rate[2] * ay)
        y += point.load * (rate[2] * ax - rate[0] * az)
        z += point.load * (rate[0] * ay - rate[1] * ax)
        _, _, own = rotate_back(body.quat, rate[0], rate[1], rate[2])
        turn += point.load * own
    if turn == 0.0 and x == 0.0 and y == 0.0 and z == 0.0:
        return 0.0, 0.0, 0.0
    gx, gy, _ = rotate_back(body.quat, x / total, y / total, z / total)
    return gx, gy, turn / total


@compiled
def settle(fleet: Fleet, r: int, bodies: Records, solids: Solids, has_floor: bool, gravity: float, h: float) -> None:
    """Simulate 3 s in which a robot sinks vertically onto the ground, and then stop the robot.

    Args:
        fleet: All robots.
        r: Index of the robot.
        bodies: Records of all bodies; the robot starts at rest above the ground, and other bodies do not move.
        solids: Solids of the field and of bodies.
        has_floor: Whether there is a floor at z = 0.
        gravity: Gravitational acceleration, downward [m/s^2].
        h: Time step [s].
    """
    robot = fleet.robots[r]
    body = bodies[robot.model.body]
    update_axes(body)
    x = body.pos[0]
    y = body.pos[1]
    clock = fleet.clock[0]
    for _ in range(int(_SETTLES / h)):
        for k in range(3):
            robot.press[k] = 0.0
            robot.twist[k] = 0.0
            robot.shift[k] = 0.0
        robot.is_upright = 1
        robot.is_put = 0
        fleet.clock[0] += 1
        touch_field(fleet, r, bodies, solids, has_floor, h)
        touch_swinging(fleet, r, bodies, solids, h)
        for b in range(len(bodies)):
            if bodies[b].model.swings:
                for k in range(3):
                    bodies[b].rate[k] = 0.0
        tx, ty, _ = rotate_back(body.quat, robot.twist[0], robot.twist[1], 0.0)
        wx, wy, _ = turned_rate(body, tx, ty, 0.0, h)
        body.vel[2] = _HELD_BACK * (body.vel[2] + h * (robot.press[2] / body.model.mass - gravity))
        body.rate[0], body.rate[1], _ = rotate(body.quat, _HELD_BACK * wx, _HELD_BACK * wy, 0.0)
        drift(body, h)
        body.com[0] += x - body.pos[0]
        body.com[1] += y - body.pos[1]
        body.pos[0] = x
        body.pos[1] = y
    fleet.clock[0] = clock  # the contacts of other robots continue
    for s in range(fleet.springs.shape[1]):
        fleet.springs[r, s].stamp = clock - 2
    for k in range(3):
        body.vel[k] = 0.0
        body.rate[k] = 0.0
