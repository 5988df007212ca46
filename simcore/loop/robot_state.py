"""Records of robots and bodies, with separate fields for model (constants), request and state.

A robot is a body with shafts, wheels and bumpers. A swinging body (cage, seesaw) or an object that the engine moves
(tube) is only a body. Indices of shafts and wheels in a model count from the robot's first shaft or wheel.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numba
import numpy as np
import numpy.typing as npt

from simcore.typing import FloatArray, IntArray

__all__ = [
    "AZIMUTH",
    "BATTERY",
    "BODY",
    "CURRENT",
    "DUTY",
    "MECHANISM",
    "NEUTRAL",
    "OUTLINE",
    "PART",
    "PISTON",
    "POINT",
    "ROBOT",
    "SERVO",
    "SHAFT",
    "SPRING",
    "STEP",
    "TARGET",
    "TOUCHES",
    "VOLTS",
    "WHEEL",
    "WHEELS",
    "Fleet",
    "Records",
    "join",
    "no_robots",
    "records",
]

Records: TypeAlias = npt.NDArray[Any]
"""Array of records of one of this module's types."""

STEP = 1e-3
"""Largest time step of motors, shafts, tires and bumpers [s]."""
TOUCHES = 24
"""Largest number of bodies and field elements in a robot's list of contacts."""
SPRINGS = 96
"""Largest number of contacts in the memory of a robot."""

# Kinds of shafts; AZIMUTH is a steer shaft.
WHEELS, AZIMUTH, MECHANISM, PISTON, SERVO = 0, 1, 2, 3, 4

NEUTRAL, VOLTS, DUTY, CURRENT, TARGET = 0, 1, 2, 3, 4
"""Modes of motor requests: brake or coast as configured, voltage, duty cycle, current, and target of the closed loop
(wheel speed, steer angle or servo angle)."""

_f, _i, _b = np.float64, np.int64, np.uint8

_MOTOR = np.dtype(
    [
        # --- identical motors with controller and gear, referred to the shaft; see `simcore.robot.wheel_config` ---
        ("kind", _i),  # WHEELS, AZIMUTH, MECHANISM, PISTON or SERVO
        ("inertia", _f),  # moment of inertia of all parts that turn with the shaft [kg m^2]
        ("emf", _f),  # back-EMF per shaft speed [V s/rad]
        ("resistance", _f),  # resistance of one motor at full duty cycle [ohm]
        ("winding", _f),  # resistance of the winding of one motor [ohm]
        ("driving", _f),  # torque of all motors per current of one motor, while the motors drive the gears [N m/A]
        ("driven", _f),  # torque of all motors per current of one motor, while the gears drive the motors [N m/A]
        ("friction", _f),  # dry friction torque [N m]
        ("stator_limit", _f),  # stator current limit of one motor [A]
        ("supply_limit", _f),  # supply current limit of one motor, drawn or regenerated [A]
        ("count", _f),  # number of motors
        ("rail", _f),  # voltage of a separate supply [V], 0 for the battery
        ("idle", _f),  # piston: voltage at the valve without power [V]
        # --- load ---
        ("lower", _f),  # lower hard stop [rad]
        ("upper", _f),  # upper hard stop [rad]
        ("weight_torque", _f),  # torque of the weight at position 0, proportional to the cosine of the position [N m]
        # --- wheels on the shaft ---
        ("first", _i),  # index of the first wheel, within the robot
        ("last", _i),  # index after the last wheel, within the robot
        ("radius", _f),  # wheel radius [m]
        ("grain", _f),  # coefficient of friction across the tread over that along the tread [-]
        ("slip_ratio", _f),  # slip over rolling speed at which tires begin to slide [-]
        ("slip_speed", _f),  # slip at standstill at which tires begin to slide [m/s]
        # --- swerve module ---
        ("partner", _i),  # index of the module's other shaft (steer or wheel) within the robot, -1 for none
        ("zero", _f),  # steer shaft: direction of the wheel at position 0 [rad]
        ("scrub", _f),  # steer shaft: mean radius of the contact patch [m]
        ("coupling", _f),  # steer shaft: torque per current of the drive motor [N m/A]
        ("coupled_emf", _f),  # wheel shaft: back-EMF per speed of the steer shaft [V s/rad]
        ("coupled_inertia", _f),  # wheel shaft: moment of inertia of the rotor that the steer shaft also turns [kg m^2]
        # --- closed loop of the motor controller ---
        ("feedforward", _f),  # voltage per target speed [V s/m]
        ("kp", _f),  # proportional gain, wheels [V s/m], steer shaft or servo [V/rad]
        ("ks", _f),  # voltage against friction, kS [V]
        ("ks_slope", _f),  # fraction of kS per target speed or angle error, up to 1 [s/m or 1/rad]
        ("known_radius", _f),  # wheel radius as configured in the controller [m]
        ("loop_coupled", _f),  # voltage per speed of the steer shaft [V s/rad]
    ],
    align=True,
)

_MOTOR_REQUEST = np.dtype(
    [
        ("mode", _i),  # NEUTRAL, VOLTS, DUTY, CURRENT or TARGET
        ("value", _f),  # requested value [V], [-], [A], [m/s] or [rad]
        ("brakes", _b),  # whether the motor brakes (shorted) at zero voltage; otherwise the motor coasts (open)
        ("stator_limit", _f),  # stator current limit of one motor, at most the model's [A]
        ("supply_limit", _f),  # supply current limit of one motor, drawn or regenerated, at most the model's [A]
        ("load", _f),  # external torque [N m]
    ],
    align=True,
)

SHAFT = np.dtype(
    [
        ("model", _MOTOR),  # constant parameters
        ("request", _MOTOR_REQUEST),  # request, valid until the next request
        # --- state ---
        ("position", _f),  # shaft position [rad]
        ("speed", _f),  # shaft speed [rad/s]
        ("cos", _f),  # cosine of the wheel direction in the robot frame [-]
        ("sin", _f),  # sine of the wheel direction [-]
        ("volts", _f),  # voltage at each motor in the last step [V]
        ("current", _f),  # stator current of each motor in the last step [A]
        ("supply", _f),  # supply current of all motors in the last step [A]
        ("energy", _f),  # electrical energy into all motors since the reset, integral of V I [J]
        ("charge2", _f),  # integral of the square of one motor's current since the reset [A^2 s]
        ("mean_current", _f),  # mean stator current of all motors in the last call [A]
        ("mean_supply", _f),  # mean supply current of all motors in the last call [A]
        ("noted_supply", _f),  # supply current of all motors when the last brownout or reset began [A]
        # --- within a step ---
        ("is_open", _b),  # whether the circuit is open
        ("wanted", _f),  # requested voltage [V]
        ("limit", _f),  # stator current limit in force [A]
        ("before", _f),  # shaft speed before the step [rad/s]
        ("weighted", _f),  # time step for which `weight` is valid [s]
        ("weight", _f),  # weight of the final speed in the mean speed [-]; see `end_weight`
        ("line_emf", _f),
        ("line_resistance", _f),
        ("emf_offset", _f),
        ("torque_offset", _f),
        ("i0", _f),
        ("i1", _f),
        ("t0", _f),
        ("t1", _f),
        ("push", _f),
        ("stiffness", _f),
        ("power", _f),
        ("s0", _f),
        ("drag", _f),
        ("most_drag", _f),
        ("touching", _i),
        ("arm", _f),
    ],
    align=True,
)
"""Record of a shaft with motors, gears and load: wheels, the steering of a swerve module, or a mechanism."""

_WHEEL_MODEL = np.dtype(
    [
        ("x", _f),  # forward offset from the center of mass, robot frame [m]
        ("y", _f),  # offset to the left [m]
        ("cof", _f),  # coefficient of friction along the wheel [-]
        ("rolling", _f),  # rolling drag over load [-]
        ("is_lowered", _b),  # whether the wheel is a lowered middle wheel
    ],
    align=True,
)

WHEEL = np.dtype(
    [
        ("model", _WHEEL_MODEL),  # constant parameters, until the robot takes in or loses mass
        # --- state ---
        ("load", _f),  # normal force of the ground [N]
        ("slip", _f),  # slip for which the tire law is linearized [m/s]
        ("force_x", _f),  # force of the ground in the last step, robot axes, forward [N]
        ("force_y", _f),  # force of the ground in the last step, to the left [N]
        ("mean_load", _f),  # mean load in the last call [N]
        ("mean_x", _f),  # mean of `force_x` in the last call [N]
        ("mean_y", _f),  # mean of `force_y` in the last call [N]
        # --- within a step ---
        ("grip", _f),  # largest tire force mu N [N]
        ("along", _f),  # tire force along the wheel [N]
        ("across", _f),  # tire force across the wheel [N]
    ],
    align=True,
)
"""Record of a wheel: constant parameters, normal load, slip and tire force."""

_BATTERY_MODEL = np.dtype(
    [
        ("full", _f),
        ("empty", _f),
        ("resistance", _f),
        ("recovery_resistance", _f),
        ("recovery_time", _f),
        ("capacity", _f),  # [A s]
        ("brownout_voltage", _f),
        ("recovered_voltage", _f),
        ("heartbeat", _f),
        ("reset_voltage", _f),
        ("reset_hold", _f),
        ("reboot_time", _f),
        ("browns_out", _b),
    ],
    align=True,
)

BATTERY = np.dtype(
    [
        ("model", _BATTERY_MODEL),  # constant parameters; see `BatteryConfig`
        # --- state ---
        ("charge", _f),  # state of charge [0..1]
        ("slow_drop", _f),  # slow part of the voltage drop [V]
        ("drawn", _f),  # charge drawn since the battery was swapped in [A s]
        ("energy", _f),  # energy delivered at the terminals since then [J]
        ("current", _f),  # current in the last step [A]
        ("voltage", _f),  # terminal voltage [V]
        ("min_voltage", _f),  # lowest terminal voltage [V]
        ("tick_min_voltage", _f),  # lowest terminal voltage in this tick [V]
        ("is_low", _b),  # whether the roboRIO is browned out
        ("is_off", _b),  # whether the last heartbeat disabled the motor controllers
        ("tick_was_off", _b),  # whether motor controllers were disabled in this tick
        ("heard", _f),  # time since the last heartbeat [s]
        ("starved", _f),  # time since the voltage fell below the reset voltage [s]
        ("boots", _f),  # remaining boot time of the roboRIO [s]
        ("off_time", _f),  # total time with disabled motor controllers [s]
        ("brownouts", _i),  # number of brownouts
        ("resets", _i),  # number of resets of the roboRIO
        ("noted_voltage", _f),  # voltage when the last brownout or reset began [V]
        ("noted_current", _f),  # current when the last brownout or reset began [A]
    ],
    align=True,
)
"""Record of a robot's battery, and of the power state of the roboRIO."""

_BODY_MODEL = np.dtype(
    [
        ("row", _i),  # index among the bodies of the world
        ("is_robot", _b),  # whether the body is a robot; the loop moves robots and swinging bodies, the engine others
        ("swings", _b),  # whether the body turns about a pivot; its origin is then the center of mass
        ("carries", _b),  # whether robots drive on the body
        ("hinge", _i),  # swinging body: axis of the hinge, 0 for x or 1 for y, -1 for a chain
        ("spring", _f),  # hinge: stiffness of the spring that returns the body to angle 0 [N m/rad]
        ("drag", _f),  # swinging body: decay rate of the angular velocity [1/s]
        ("mark", _i),  # bit of the body in `Balls.bodies`
        ("first_solid", _i),  # index of the first solid
        ("last_solid", _i),  # index after the last solid
        ("reach", _f),  # radius of the bounding sphere around the origin [m]
        ("mass", _f),  # mass [kg]
        ("center", _f, (3,)),  # center of mass, body frame, or pivot, field frame [m]
        ("inertia", _f, (3,)),  # principal moments of inertia about the center of mass or pivot, infinite across a
        # hinge [kg m^2]
        ("principal", _f, (3, 3)),  # principal axes, body frame, as columns
    ],
    align=True,
)

BODY = np.dtype(
    [
        ("model", _BODY_MODEL),  # constant parameters, until a robot takes in or loses mass
        # --- state ---
        ("is_active", _b),  # whether balls can touch the body now
        ("pos", _f, (3,)),  # origin, field frame [m]
        ("quat", _f, (4,)),  # attitude quaternion (x, y, z, w)
        ("axes", _f, (3, 3)),  # body axes, field frame, as columns
        ("com", _f, (3,)),  # center of mass or pivot, field frame [m]
        ("vel", _f, (3,)),  # velocity of the center of mass, 0 for a pivot, field frame [m/s]
        ("rate", _f, (3,)),  # angular velocity, field frame [rad/s]
        ("is_awake", _b),  # swinging body: whether the body moves; a contact force wakes the body
        ("torque", _f, (3,)),  # swinging body: external torque about the pivot in the next call, field frame [N m]
        ("turn", _f, (3,)),  # neither robot nor swinging body: angular acceleration, field frame [rad/s^2]
        # --- in the last call ---
        ("mean_twist", _f, (6,)),  # mean of `vel` and `rate` over the call [m/s, rad/s]
        ("impulse", _f, (6,)),  # contact impulse in the call [N s], angular impulse about `com` [N m s]
    ],
    align=True,
)
"""Record of a rigid body: constant parameters, pose, velocity, and contact impulse in the last call."""

_ROBOT_MODEL = np.dtype(
    [
        ("body", _i),  # index of the body
        ("first_shaft", _i),  # index of the first shaft
        ("last_shaft", _i),  # index after the last shaft
        ("drive_shafts", _i),  # number of shafts with wheels, which come first
        ("first_wheel", _i),  # index of the first wheel
        ("last_wheel", _i),  # index after the last wheel
        ("first_point", _i),  # index of the first contact point; points of wheels come first
        ("last_point", _i),  # index after the last contact point
        ("first_part", _i),  # index of the first part of bumpers and frame
        ("last_part", _i),  # index after the last part
        ("reach", _f),  # largest distance of bumpers and wheels from the robot's vertical axis [m]
        ("low", _f),  # smallest height of bumpers and frame, robot frame [m]
        ("high", _f),  # largest height of bumpers and frame, robot frame [m]
    ],
    align=True,
)

_ROBOT_REQUEST = np.dtype(
    [
        ("is_enabled", _b),
        ("other_current", _f),  # battery current of loads other than motors [A]
        ("force", _f, (3,)),  # external force on the center of mass, field frame [N]
        ("torque", _f, (3,)),  # external torque, field frame [N m]
    ],
    align=True,
)

ROBOT = np.dtype(
    [
        ("model", _ROBOT_MODEL),  # parts of the robot, and their extent
        ("request", _ROBOT_REQUEST),  # request, valid until the next request
        # --- in this step ---
        ("press", _f, (3,)),  # contact forces without tire friction, field frame [N]
        ("twist", _f, (3,)),  # torque of these forces about the center of mass, field frame [N m]
        ("shift", _f, (3,)),  # displacement out of initial overlaps, field frame [m]
        ("is_upright", _b),  # whether the bumpers collide with walls and other robots in plan view
        ("is_put", _b),  # whether a user has placed the robot since the last step
        ("plan_mass", _f, (2,)),  # effective mass at the carpet along the robot's x and y axes [kg]
        ("yaw_rate", _f),  # angular velocity about the robot's vertical axis, after tire forces [rad/s]
        ("is_sliding", _b),  # whether a tire slides
        ("bus", _f),  # battery voltage [V]
        ("time", _f),  # time since the reset [s]
        # --- in the last call ---
        ("touches", _i, (TOUCHES,)),  # rows of the bodies and field elements in contact
        ("touched", _i),  # number of entries in `touches`
    ],
    align=True,
)
"""Record of a robot: indices of the robot's parts, external forces, and contact forces in the present step."""

_POINT_MODEL = np.dtype(
    [
        ("x", _f),  # x of the center of the soft ball, robot frame [m]
        ("y", _f),  # y of the center [m]
        ("z", _f),  # z of the center [m]
        ("radius", _f),  # radius of the soft ball [m]
        ("stiffness", _f),  # normal stiffness [N/m]
        ("damping", _f),  # normal damping [N s/m]
        ("is_wheel", _b),  # whether the point is a wheel
    ],
    align=True,
)

POINT = np.dtype(
    [
        ("model", _POINT_MODEL),  # constant parameters, until the robot takes in or loses mass
        # --- in this step ---
        ("on", _i),  # index of the body under the point, -1 for the field
        ("load", _f),  # normal force [N]
        ("gap", _f),  # gap to the floor or to a near field element [m]
        ("normal", _f, (3,)),  # mean direction of the load, field frame
        ("arm", _f, (3,)),  # mean offset of the contact from the center of mass, field frame [m]
    ],
    align=True,
)
"""Record of a contact point of a robot: a wheel, or a point on bumpers, frame or underside."""

_PART_MODEL = np.dtype(
    [
        ("robot", _i),  # index of the robot
        ("x", _f),  # x of the center, robot frame [m]
        ("y", _f),  # y of the center, robot frame [m]
        ("half_length", _f),  # half of the length [m]
        ("half_width", _f),  # half of the width [m]
        ("bottom", _f),  # height of the bottom above the robot's origin [m]
        ("top", _f),  # height of the top above the robot's origin [m]
        ("friction", _f),  # friction factor of the surface [-]
        ("restitution", _f),  # restitution factor of the surface [-]
        ("stiffness", _f),  # force per depth and length of the side in contact [N/m^2]
        ("edge_stiffness", _f),  # stiffness against one end of a field edge [N/m]
        ("edge_damping", _f),  # damping against one end of a field edge [N s/m]
    ],
    align=True,
)

PART = np.dtype(
    [
        ("model", _PART_MODEL),  # constant parameters, until the robot takes in or loses mass
        # --- state, from the pose of the robot ---
        ("low", _f),  # present height of the bottom, field frame [m]
        ("high", _f),  # present height of the top, field frame [m]
        ("first_outline", _i),  # index of the first field outline at these heights
        ("last_outline", _i),  # index after the last field outline at these heights
        ("corners", _f, (4, 2)),  # corners in plan view, counter-clockwise, field frame [m]
        ("normals", _f, (4, 2)),  # outward unit normal of the side after each corner
    ],
    align=True,
)
"""Record of a rectangular box of a robot: the bumpers, or the frame above the bumpers."""

OUTLINE = np.dtype(
    [
        ("row", _i),  # row of the field element
        ("first", _i),  # index of the first corner
        ("last", _i),  # index after the last corner
        ("low_x", _f),  # lowest x of the corners [m]
        ("high_x", _f),  # highest x of the corners [m]
        ("low_y", _f),  # lowest y of the corners [m]
        ("high_y", _f),  # highest y of the corners [m]
        ("bottom", _f),  # height of the bottom [m]
        ("top", _f),  # height of the top [m]
        ("friction", _f),  # friction factor of the surface [-]
        ("restitution", _f),  # restitution factor of the surface [-]
    ],
    align=True,
)
"""Record of a convex plan-view outline of a part of the field, between two heights; all values are constant."""

SPRING = np.dtype([("key", _i), ("stamp", _i), ("stretch", _f, (3,)), ("put_in", _f)], align=True)
"""Record of a contact of a robot: key, number of the last step with the contact, stretch of the friction spring, field
frame [m], and remaining initial overlap [m]."""


class Fleet(NamedTuple):
    """Robots of a world, and the outlines of the field with which bumpers can collide."""

    robots: Records
    shafts: Records
    wheels: Records
    batteries: Records
    """Record of each robot's battery, shape (robots,)."""
    parts: Records
    points: Records
    springs: Records
    """Records of the robots' contacts, shape (robots, `SPRINGS`)."""
    outlines: Records
    corners: FloatArray
    """Corners of all outlines [m], shape (n, 2)."""
    normals: FloatArray
    """Outward unit normal of the side after each corner, shape (n, 2)."""
    hidden: npt.NDArray[np.uint8]
    """Whether another outline covers the side after each corner, shape (n,)."""
    clock: IntArray
    """Number of the last step, shape (1,)."""


def no_robots() -> Fleet:
    """Return a fleet without robots and without field outlines."""
    return Fleet(
        records(ROBOT, 0), records(SHAFT, 0), records(WHEEL, 0), records(BATTERY, 0), records(PART, 0),
        records(POINT, 0), records(SPRING, 0).reshape(0, SPRINGS), records(OUTLINE, 0), np.zeros((0, 2)),
        np.zeros((0, 2)), np.zeros(0, np.uint8), np.zeros(1, np.int64),
    )  # fmt: skip


def records(dtype: np.dtype[Any], count: int = 1) -> Records:
    """Return an array of `count` records filled with zeros."""
    made = np.zeros(count, dtype)
    return made.view(np.recarray) if numba.config.DISABLE_JIT else made  # type: ignore[attr-defined]


def join(some: Sequence[Records]) -> Records:
    """Return the concatenation of arrays of records of one type."""
    made = np.concatenate(some)
    return made.view(np.recarray) if numba.config.DISABLE_JIT else made  # type: ignore[attr-defined]
