"""Robots, moved by small steps: motors, shafts, wheels, batteries and bumpers of all of them at once.

The engine keeps a robot's body: ramps, what lifts and tips it, and pieces that are no balls. It is told once a step
with which mean velocity tires and bumpers let the robot move; what the velocity at the end is more than that is added
to what the engine made of it.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import numpy.typing as npt

from simcore.loop.battery import bus_voltage, draw
from simcore.loop.bumpers import place_parts, touch_outlines, touch_robots
from simcore.loop.compiled import compiled, preparing
from simcore.loop.motor import within
from simcore.loop.robot_state import (
    AZIMUTH,
    BATTERY,
    OUTLINE,
    PART,
    ROBOT,
    SHAFT,
    SPRING,
    STEP,
    TARGET,
    WHEEL,
    WHEELS,
    Records,
    records,
)
from simcore.loop.shaft import begin_motor, open_circuit, request, turn
from simcore.loop.tires import share_loads, step_tires
from simcore.typing import FloatArray, IntArray

__all__ = ["begin_robots", "end_robots", "move_robots", "optimize", "prepare"]

_TIRE_LAG = 0.010
"""Treads and carpet give a little, so loads follow the chassis with a lag [s]; estimate, +-50 %."""
_MOST_PULL = 1.5
"""More than any tire can push against for longer than a hit [g]."""
_STEADY = 0.95
"""Share of the moment that would lift a wheel; less than that the carpet takes."""
_LIFTED = 0.001
"""A hit that tips a level robot so that its center rises by less leaves it level [m]."""
_LEVEL_HEIGHT, _LEVEL_TILT, _LEVEL_SPEED, _LEVEL_RATE = 0.002, 1e-3, 0.05, 0.5
"""Of a robot that stands level: how far from the carpet [m], sine of half the tilt, up or down [m/s], roll or pitch
[rad/s]."""
_UPRIGHT = math.cos(math.radians(25.0))
"""Of the tilt: a bump's 16 degrees with some to spare."""


@compiled
def rotate(quat, x, y, z):
    """A vector of a body in the axes of the field."""
    a, b, c, w = quat[0], quat[1], quat[2], quat[3]
    tx = 2.0 * (b * z - c * y)
    ty = 2.0 * (c * x - a * z)
    tz = 2.0 * (a * y - b * x)
    return x + w * tx + b * tz - c * ty, y + w * ty + c * tx - a * tz, z + w * tz + a * ty - b * tx


@compiled
def rotate_back(quat, x, y, z):
    """A vector of the field in the axes of a body."""
    return rotate((-quat[0], -quat[1], -quat[2], quat[3]), x, y, z)


@compiled
def begin_robots(robots: Records, parts: Records, gravity: float) -> int:
    """Look at what the engine made of the last step.

    Args:
        robots: All, with what the engine has of their bodies.
        parts: Of their bumpers.
        gravity: Downward [m/s^2].

    Returns:
        Number of a robot whose body the engine has lost (a value is not finite), -1: none.
    """
    for r in range(len(robots)):
        total = 0.0
        for k in range(13):
            total += robots[r].seen[k]
        if not math.isfinite(total):
            return r
        _begin_robot(robots, r, gravity)
    for r in range(len(robots)):
        for q in range(r + 1, len(robots)):
            if robots[r].is_upright and robots[q].is_upright and _are_near(robots, r, q):
                if not _overlap_in_height(robots, r, q, parts):
                    robots[r].is_solid = 1
                    robots[q].is_solid = 1
    return -1


@compiled
def _overlap_in_height(robots, r, q, parts):
    """Whether the outlines of two robots have a height in common."""
    for a in range(robots[r].first_part, robots[r].last_part):
        for b in range(robots[q].first_part, robots[q].last_part):
            mine = parts[a]
            theirs = parts[b]
            low = max(robots[r].z + mine.bottom, robots[q].z + theirs.bottom)
            if low < min(robots[r].z + mine.top, robots[q].z + theirs.top):
                return True
    return False


@compiled
def _begin_robot(robots, r, gravity):
    """The same for one of them."""
    robot = robots[r]
    quat = robot.quat
    for k in range(4):
        quat[k] = robot.seen[3 + k]
    cx, cy, cz = rotate(quat, robot.center[0], robot.center[1], robot.center[2])
    robot.pos[0] = robot.seen[0] - cx
    robot.pos[1] = robot.seen[1] - cy
    robot.pos[2] = robot.seen[2] - cz
    for k in range(3):
        robot.vel[k] = robot.seen[7 + k]
        robot.rate[k] = robot.seen[10 + k]
    h = robot.h_before
    down_x, down_y, down_z = rotate_back(quat, 0.0, 0.0, -gravity)
    robot.gravity[0] = down_x
    robot.gravity[1] = down_y
    robot.gravity[2] = down_z
    robot.felt[0] = down_x
    robot.felt[1] = down_y
    robot.felt[2] = 0.0
    robot.is_level = 0
    if robot.is_on_flat and abs(robot.pos[2]) < _LEVEL_HEIGHT and robot.force[2] == 0.0:
        if math.sqrt(quat[0] * quat[0] + quat[1] * quat[1]) < _LEVEL_TILT and abs(robot.vel[2]) < _LEVEL_SPEED:
            if math.sqrt(robot.rate[0] ** 2 + robot.rate[1] ** 2) < _LEVEL_RATE:
                robot.is_level = 1
    pull_x = down_x
    pull_y = down_y
    pull_turn = 0.0
    if h > 0.0:
        ax = (robot.vel[0] - robot.given[0]) / h
        ay = (robot.vel[1] - robot.given[1]) / h
        az = 0.0 if robot.is_level else (robot.vel[2] - robot.given[2]) / h
        turn_x = (robot.rate[0] - robot.given[3]) / h
        turn_y = (robot.rate[1] - robot.given[4]) / h
        turn_z = (robot.rate[2] - robot.given[5]) / h
        pull_x, pull_y, up = rotate_back(quat, ax, ay, az)
        _, _, pull_turn = rotate_back(quat, turn_x, turn_y, turn_z)
        robot.felt[0] = pull_x
        robot.felt[1] = pull_y
        robot.felt[2] = up
        size = math.sqrt(pull_x * pull_x + pull_y * pull_y)
        most = _MOST_PULL * gravity
        if size > most:
            pull_x *= most / size
            pull_y *= most / size
        most = most * robot.mass * robot.half_base / robot.inertia[2]
        pull_turn = within(pull_turn, most)
        for k in range(3):
            robot.vel[k] += robot.rest[k]
            robot.rate[k] += robot.rest[3 + k]
    along_x, along_y, _ = rotate(quat, 1.0, 0.0, 0.0)
    yaw = math.atan2(along_y, along_x)
    c = math.cos(yaw)
    s = math.sin(yaw)
    robot.yaw = yaw
    robot.yaw_before = yaw
    aside_x, aside_y, _ = rotate(quat, 0.0, 1.0, 0.0)
    up_x, up_y, up_z = rotate(quat, 0.0, 0.0, 1.0)
    robot.is_upright = 1 if up_z > _UPRIGHT else 0
    robot.is_solid = 1 - robot.is_upright
    high = 0.5 * robot.height
    robot.z = robot.pos[2] + (up_z - 1.0) * high
    robot.x = robot.seen[0]
    robot.y = robot.seen[1]
    robot.along[0] = c * along_x + s * along_y
    robot.along[1] = c * along_y - s * along_x
    robot.aside[0] = c * aside_x + s * aside_y
    robot.aside[1] = c * aside_y - s * aside_x
    # Velocity of the point on the carpet under the center of mass, robot axes, then plan axes.
    vx, vy, _ = rotate_back(quat, robot.vel[0], robot.vel[1], robot.vel[2])
    wx, wy, wz = rotate_back(quat, robot.rate[0], robot.rate[1], robot.rate[2])
    vx -= wy * robot.center[2]
    vy += wx * robot.center[2]
    robot.vx = c * vx - s * vy
    robot.vy = s * vx + c * vy
    robot.omega = wz
    robot.leaning[0] = c * wy + s * wx
    robot.leaning[1] = s * wy - c * wx
    robot.upward[0] = c * up_x + s * up_y
    robot.upward[1] = c * up_y - s * up_x
    robot.center_ahead[0] = c * cx + s * cy
    robot.center_ahead[1] = c * cy - s * cx
    robot.pull[0] = c * pull_x - s * pull_y
    robot.pull[1] = s * pull_x + c * pull_y
    robot.pull[2] = pull_turn
    # Outside forces.
    fx, fy, _ = rotate_back(quat, robot.force[0], robot.force[1], robot.force[2])
    _, _, tz = rotate_back(quat, robot.torque[0], robot.torque[1], robot.torque[2])
    px = fx / robot.mass
    py = fy / robot.mass
    robot.drive[0] = c * px - s * py
    robot.drive[1] = s * px + c * py
    robot.drive[2] = tz / robot.inertia[2]


@compiled
def end_robots(robots: Records, h: float, gravity: float) -> None:
    """Work out the velocity that the engine gets for the step of h [s] to come, and what is to be added after it.

    Args:
        robots: All.
        h: Step [s].
        gravity: Downward [m/s^2].
    """
    for r in range(len(robots)):
        _end_robot(robots, r, h, gravity)


@compiled
def _end_robot(robots, r, h, gravity):
    """The same for one of them."""
    robot = robots[r]
    quat = robot.quat
    c = math.cos(robot.yaw_before)
    s = math.sin(robot.yaw_before)
    mean_x = c * robot.mean_change[0] + s * robot.mean_change[1]
    mean_y = c * robot.mean_change[1] - s * robot.mean_change[0]
    end_x = c * robot.end_change[0] + s * robot.end_change[1]
    end_y = c * robot.end_change[1] - s * robot.end_change[0]
    # Grip acts below the center of mass; an outside force at it.
    fx, fy, fz = rotate_back(quat, robot.force[0], robot.force[1], robot.force[2])
    tx, ty, _ = rotate_back(quat, robot.torque[0], robot.torque[1], robot.torque[2])
    lever = robot.mass * robot.center[2]
    hit_x = c * robot.hit_moment[0] + s * robot.hit_moment[1]
    hit_y = c * robot.hit_moment[1] - s * robot.hit_moment[0]
    roll = lever * (end_y - h * fy / robot.mass) + hit_x
    pitch = -lever * (end_x - h * fx / robot.mass) + hit_y
    if robot.is_level:
        # Its weight takes up what it can at once, and more while the robot hardly rises: then wheels stay down.
        weight = robot.mass * gravity
        hold = _STEADY * weight * robot.half_base * h
        roll += robot.tip[0]
        pitch += robot.tip[1]
        size = math.sqrt(roll * roll + pitch * pitch)
        share = 1.0 - hold / size if size > hold else 0.0
        robot.tip[0] = roll * share
        robot.tip[1] = pitch * share
        roll = 0.0
        pitch = 0.0
        if size - hold > math.sqrt(2.0 * min(robot.inertia[0], robot.inertia[1]) * weight * _LIFTED):
            roll = robot.tip[0]
            pitch = robot.tip[1]
            robot.tip[0] = 0.0
            robot.tip[1] = 0.0
    else:
        robot.tip[0] = 0.0
        robot.tip[1] = 0.0
    ax, ay, az = rotate(quat, mean_x, mean_y, h * fz / robot.mass)
    bx, by, bz = rotate(
        quat, (roll + tx * h) / robot.inertia[0], (pitch + ty * h) / robot.inertia[1], robot.mean_change[2]
    )
    robot.given[0] = robot.vel[0] + ax + robot.hit_mean[0]
    robot.given[1] = robot.vel[1] + ay + robot.hit_mean[1]
    robot.given[2] = robot.vel[2] + az
    robot.given[3] = robot.rate[0] + bx
    robot.given[4] = robot.rate[1] + by
    robot.given[5] = robot.rate[2] + bz + robot.hit_mean[2]
    ax, ay, az = rotate(quat, end_x - mean_x, end_y - mean_y, 0.0)
    bx, by, bz = rotate(quat, 0.0, 0.0, robot.end_change[2] - robot.mean_change[2])
    robot.rest[0] = ax + robot.hit_end[0] - robot.hit_mean[0]
    robot.rest[1] = ay + robot.hit_end[1] - robot.hit_mean[1]
    robot.rest[2] = az
    robot.rest[3] = bx
    robot.rest[4] = by
    robot.rest[5] = bz + robot.hit_end[2] - robot.hit_mean[2]
    # The engine adds all that it does before it moves the body: what is early of that waits.
    early = h * robot.early
    ax, ay, az = rotate(
        quat, early * (c * robot.pull[0] + s * robot.pull[1]), early * (c * robot.pull[1] - s * robot.pull[0]), 0.0
    )
    bx, by, bz = rotate(quat, 0.0, 0.0, early * robot.pull[2])
    robot.given[0] -= ax
    robot.given[1] -= ay
    robot.given[2] -= az
    robot.given[3] -= bx
    robot.given[4] -= by
    robot.given[5] -= bz
    robot.rest[0] += ax
    robot.rest[1] += ay
    robot.rest[2] += az
    robot.rest[3] += bx
    robot.rest[4] += by
    robot.rest[5] += bz
    robot.h_before = h


@compiled
def move_robots(
    robots: Records, shafts: Records, wheels: Records, batteries: Records, parts: Records, outlines: Records,
    corners: FloatArray, normals: FloatArray, hidden: npt.NDArray[np.uint8], springs: Records, clock: IntArray,
    h: float,
) -> None:  # fmt: skip
    """Move all robots for h [s] in their planes, by steps of `STEP` or less.

    Args:
        robots: All, each with its pose and velocity in its plane.
        shafts: Of all robots.
        wheels: Of all robots.
        batteries: One of each robot.
        parts: Of the bumpers of all robots.
        outlines: Of what stands on the field.
        corners: Of all outlines [m], shape (n, 2).
        normals: Of the sides after them, shape (n, 2).
        hidden: Whether each side is covered by another outline, shape (n,).
        springs: Of friction between bumpers, shape (robots, m).
        clock: Number of the last step, shape (1,).
        h: Time [s].
    """
    count = math.ceil(h / STEP - 1e-9)
    dt = h / count
    n = len(robots)
    found = np.zeros((2, 6))
    for r in range(n):
        robots[r].early = 0.5 - 0.5 / count
        _begin_call(robots, r, shafts, wheels)
    for _ in range(count):
        clock[0] += 1
        for r in range(n):
            robot = robots[r]
            for k in range(3):
                robot.contact[k] = 0.0
            robot.contact_load[0] = 0.0
            robot.contact_load[1] = 0.0
            if robot.is_upright:
                place_parts(robots, r, parts)
        for r in range(n):
            if robots[r].is_upright:
                touch_outlines(robots, r, parts, outlines, corners, normals, hidden, springs, clock[0], dt, found)
                for q in range(r + 1, n):
                    if robots[q].is_upright and _are_near(robots, r, q):
                        touch_robots(robots, r, q, parts, springs, clock[0], dt, found)
        for r in range(n):
            _move(robots, r, shafts, wheels, batteries, dt, dt / h)
    for r in range(n):
        robot = robots[r]
        for i in range(robot.first_shaft, robot.last_shaft):
            shafts[i].mean_current /= h
            shafts[i].mean_supply /= h


@compiled
def _are_near(robots, a, b):
    """Whether the bumpers of two robots could touch."""
    one = robots[a]
    other = robots[b]
    dx = one.x - other.x
    dy = one.y - other.y
    far = one.reach + other.reach
    return dx * dx + dy * dy < far * far


@compiled
def _begin_call(robots, r, shafts, wheels):
    """Forget the sums of the last call."""
    robot = robots[r]
    for k in range(3):
        robot.end_change[k] = 0.0
        robot.mean_change[k] = 0.0
        robot.hit_end[k] = 0.0
        robot.hit_mean[k] = 0.0
    robot.hit_moment[0] = 0.0
    robot.hit_moment[1] = 0.0
    robot.touched = 0
    for i in range(robot.first_shaft, robot.last_shaft):
        begin_motor(shafts, i)
    for k in range(robot.first_wheel, robot.last_wheel):
        wheels[k].mean_load = 0.0
        wheels[k].mean_x = 0.0
        wheels[k].mean_y = 0.0


@compiled
def _ask(robots, r, shafts, battery):
    """What all controllers of a robot want of their motors in the next step."""
    robot = robots[r]
    for i in range(robot.first_shaft, robot.last_shaft):
        s = shafts[i]
        is_drive = s.kind == WHEELS or s.kind == AZIMUTH
        s.emf_offset = 0.0
        s.torque_offset = 0.0
        if is_drive:
            if s.kind == WHEELS and s.partner >= 0:
                s.emf_offset = s.coupled_emf * shafts[robot.first_shaft + s.partner].speed
            s.limit = s.stator_limit
            if battery.is_off:
                s.is_open = 1
            elif not robot.is_enabled:
                s.is_open = 0 if s.brakes else 1
                s.wanted = 0.0
            elif s.mode == TARGET:
                s.is_open = 0
                _follow_target(shafts, i, robot.first_shaft)
            else:
                request(shafts, i, robot.bus, 0.0)
        else:
            if battery.is_off or not robot.is_enabled:
                open_circuit(shafts, i)
            request(shafts, i, s.rail if s.rail > 0.0 else robot.bus, s.emf * s.speed)


@compiled
def optimize(speed: float, angle: float, present: float) -> tuple[float, float]:
    """Reach a module state with less than a quarter turn: drive backwards where that is nearer.

    Args:
        speed: Wanted [m/s].
        angle: Wanted steer angle [rad].
        present: Steer angle now, any number of turns [rad].

    Returns:
        Signed speed [m/s], scaled by the cosine of the steer error so that a wheel on its way does not scrub
        sideways, and the error to steer away [rad], within -pi/2..pi/2.
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


@compiled
def _follow_target(shafts, i, first_shaft):
    """The loop on board of a drive motor or an azimuth: a speed of the tread, or an angle."""
    s = shafts[i]
    if s.kind == AZIMUTH:
        _, error = optimize(0.0, s.request, s.position)
        s.wanted = s.kp * error + s.ks * within(s.ks_slope * error, 1.0)
        return
    speed = s.request
    turning = 0.0
    if s.partner >= 0:
        azimuth = shafts[first_shaft + s.partner]
        if azimuth.mode == TARGET:
            speed, _ = optimize(speed, azimuth.request, azimuth.position)
        turning = azimuth.speed
    s.wanted = (
        s.feedforward * speed
        + s.kp * (speed - s.speed * s.known_radius)
        + s.ks * within(s.ks_slope * speed, 1.0)
        + s.loop_coupled * turning
    )
    if s.wanted == 0.0 and not s.brakes:
        s.is_open = 1


@compiled
def _steer(robots, r, shafts, wheels, h, bus):
    """Turn the azimuths, and the mechanisms."""
    robot = robots[r]
    for i in range(robot.first_shaft + robot.drive_shafts, robot.last_shaft):
        s = shafts[i]
        if s.kind != AZIMUTH:
            turn(shafts, i, h, bus, 0.0, 0.0)
            continue
        wheel_shaft = shafts[robot.first_shaft + s.partner]
        before = s.speed
        load = wheels[robot.first_wheel + wheel_shaft.first].load
        turn(shafts, i, h, bus, s.scrub * load, s.coupling * wheel_shaft.current)
        wheel_shaft.emf_offset = wheel_shaft.coupled_emf * 0.5 * (before + s.speed)
        wheel_shaft.torque_offset = -wheel_shaft.coupled_inertia * (s.speed - before) / h
        wheel_shaft.cos = math.cos(s.position + s.zero)
        wheel_shaft.sin = math.sin(s.position + s.zero)


@compiled
def _set_loads(robots, r, wheels, h):
    """Loads of the wheels in a step of h [s], if tires and bumpers do as in the last one."""
    robot = robots[r]
    c = math.cos(robot.yaw)
    s = math.sin(robot.yaw)
    share = -math.expm1(-h / _TIRE_LAG)
    bump_x = c * robot.contact_load[0] + s * robot.contact_load[1]
    bump_y = c * robot.contact_load[1] - s * robot.contact_load[0]
    robot.followed[0] += share * (robot.felt[0] + bump_x + robot.tires[0] - robot.followed[0])
    robot.followed[1] += share * (robot.felt[1] + bump_y + robot.tires[1] - robot.followed[1])
    robot.followed[2] += share * (robot.felt[2] - robot.followed[2])
    lever = robot.mass * robot.center[2]
    share_loads(
        wheels, robot.first_wheel, robot.last_wheel, robot.mass * (robot.followed[2] - robot.gravity[2]),
        lever * (robot.gravity[0] - robot.followed[0]), lever * (robot.gravity[1] - robot.followed[1]),
    )  # fmt: skip


@compiled
def _move(robots, r, shafts, wheels, batteries, h, part):
    """Move one robot by a step of h [s], which is a part of the call.

    Velocity first, then with it the place (semi-implicit Euler). Slip is that in the robot's axes at the end of the
    step, and forces act in those of its middle: so a circle is closed to second order.
    """
    robot = robots[r]
    robot.is_put = 0
    old_x = robot.vx
    old_y = robot.vy
    old_turn = robot.omega
    ax = robot.contact[0] / robot.mass
    ay = robot.contact[1] / robot.mass
    alpha = robot.contact[2] / robot.inertia[2]
    dx = h * robot.drive[0]
    dy = h * robot.drive[1]
    dturn = h * robot.drive[2]
    if robot.last_shaft > robot.first_shaft:
        battery = batteries[r]
        _ask(robots, r, shafts, battery)
        bus = bus_voltage(batteries, r, robot.bus, robot.other_current, shafts, robot.first_shaft, robot.last_shaft)
        robot.bus = bus
        _steer(robots, r, shafts, wheels, h, bus)
        if robot.drive_shafts:
            if not robot.has_fixed_loads:
                _set_loads(robots, r, wheels, h)
            vx = old_x + h * (ax + robot.pull[0]) + dx
            vy = old_y + h * (ay + robot.pull[1]) + dy
            omega = old_turn + h * (alpha + robot.pull[2]) + dturn
            half = 0.5 * old_turn * h
            c = math.cos(robot.yaw + 2.0 * half)
            s = math.sin(robot.yaw + 2.0 * half)
            jx, jy, jn = step_tires(robot, shafts, wheels, h, bus, c * vx + s * vy, c * vy - s * vx, omega)
            robot.tires[0] = jx / h
            robot.tires[1] = jy / h
            c = math.cos(robot.yaw + half)
            s = math.sin(robot.yaw + half)
            dx += c * jx - s * jy
            dy += s * jx + c * jy
            dturn += jn
            for k in range(robot.first_wheel, robot.last_wheel):
                wheel = wheels[k]
                wheel.mean_load += part * wheel.load
                wheel.mean_x += part * wheel.force_x
                wheel.mean_y += part * wheel.force_y
        supply = robot.other_current
        for i in range(robot.first_shaft, robot.last_shaft):
            supply += shafts[i].supply
        robot.time += h
        if draw(batteries, r, h, supply, bus):
            for i in range(robot.first_shaft, robot.last_shaft):
                shafts[i].noted_supply = shafts[i].supply
    for k in range(3):
        change = (dx, dy, dturn)[k]
        hit = h * (ax, ay, alpha)[k]
        robot.end_change[k] += change
        robot.hit_end[k] += hit
        robot.mean_change[k] += part * robot.end_change[k]
        robot.hit_mean[k] += part * robot.hit_end[k]
    robot.vx = old_x + h * (ax + robot.pull[0]) + dx
    robot.vy = old_y + h * (ay + robot.pull[1]) + dy
    robot.omega = old_turn + h * (alpha + robot.pull[2]) + dturn
    robot.x += h * (robot.vx + robot.leaning[0] * robot.center[2])
    robot.y += h * (robot.vy + robot.leaning[1] * robot.center[2])
    turned = h * robot.omega
    robot.yaw += turned
    c = math.cos(turned)
    s = math.sin(turned)
    fx = robot.followed[0]
    robot.followed[0] = c * fx + s * robot.followed[1]
    robot.followed[1] = c * robot.followed[1] - s * fx


@cache
def prepare() -> None:
    """Compile the loop of robots for this computer, or load what was compiled before, so that no tick waits for it."""
    with preparing("robots.move_robots"):
        robots, parts = records(ROBOT, 0), records(PART, 0)
        begin_robots(robots, parts, 9.8)
        move_robots(
            robots, records(SHAFT, 0), records(WHEEL, 0), records(BATTERY, 0), parts, records(OUTLINE, 0),
            np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0, np.uint8), records(SPRING, 0).reshape(0, 1),
            np.zeros(1, np.int64), STEP,
        )  # fmt: skip
        end_robots(robots, STEP, 9.8)
