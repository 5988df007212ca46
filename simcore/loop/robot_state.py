"""State of robots, as arrays of records, one of each thing: its state, with its model and requests apart.

A robot is a body with shafts, wheels and bumpers; what the engine moves (tubes, cages) is a body alone. Shafts and
wheels are numbered within their robot.
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
"""An array of one of the record types of this module."""

STEP = 1e-3
"""Longest step of motors, shafts, tires and bumpers [s]."""
TOUCHES = 24
"""Bodies and elements of the field that a robot can touch at once, that it lists."""
SPRINGS = 96
"""Contacts of a robot whose friction is remembered."""

# Kinds of shafts.
WHEELS, AZIMUTH, MECHANISM, PISTON, SERVO = 0, 1, 2, 3, 4

# What a motor is asked for.
NEUTRAL, VOLTS, DUTY, CURRENT, TARGET = 0, 1, 2, 3, 4
"""Brake or coast as configured; volts; share of the bus; amperes; a speed of the tread or an angle of the azimuth."""

_f, _i, _b = np.float64, np.int64, np.uint8

_MOTOR = np.dtype(
    [
        # --- motors behind their controller and gear, all of them equal; see `simcore.robot.wheel_config` ---
        ("kind", _i),
        ("inertia", _f),  # of everything that turns with it, about it [kg m^2]
        ("emf", _f),  # back-EMF per speed [V s/rad]
        ("resistance", _f),  # of one motor at full duty [ohm]
        ("winding", _f),  # of one motor behind its controller [ohm]
        ("driving", _f),  # torque of all motors per current of one, while they drive the gears [N m/A]
        ("driven", _f),  # the same while the gears drive them [N m/A]
        ("friction", _f),  # dry friction [N m]
        ("stator_limit", _f),  # of one motor [A]
        ("supply_limit", _f),  # of one motor, drawing and feeding back [A]
        ("count", _f),  # motors
        ("rail", _f),  # voltage of a supply of its own [V]; 0: the battery's
        ("idle", _f),  # of a piston: volts of its valve without power [V]
        # --- what it carries ---
        ("lower", _f),  # hard stops [rad]
        ("upper", _f),
        ("weight_torque", _f),  # of a weight on a lever, times the cosine of the position [N m]
        # --- wheels on it ---
        ("first", _i),  # wheel of the robot
        ("last", _i),  # the one behind its last
        ("radius", _f),  # [m]
        ("grain", _f),  # friction of the treads across over that along [-]
        ("slip_ratio", _f),  # slip per rolling speed at which tires begin to slide [-]
        ("slip_speed", _f),  # the same at standstill [m/s]
        # --- swerve: the azimuth of a wheel's shaft, and the wheel's shaft of an azimuth ---
        ("partner", _i),  # shaft of the robot, -1: none
        ("zero", _f),  # of an azimuth: direction of the wheel at position 0 [rad]
        ("scrub", _f),  # of an azimuth: mean radius of the contact patch [m]
        ("coupling", _f),  # of an azimuth: torque over current of the wheel's motor [N m/A]
        ("coupled_emf", _f),  # of wheels: back-EMF per speed of the azimuth [V s/rad]
        ("coupled_inertia", _f),  # of wheels: of the rotor that the azimuth turns as well [kg m^2]
        # --- the loop on board ---
        ("feedforward", _f),  # volts per target [V s/m]
        ("kp", _f),  # [V s/m], of an azimuth or servo [V/rad]
        ("ks", _f),  # against friction [V]
        ("ks_slope", _f),  # of its rise with the target or error [s/m or 1/rad]
        ("known_radius", _f),  # tread speed over shaft speed as the loop has it [m]
        ("loop_coupled", _f),  # volts per speed of the azimuth [V s/rad]
    ],
    align=True,
)

_MOTOR_REQUEST = np.dtype(
    [
        ("mode", _i),
        ("value", _f),  # [V], [-], [A], [m/s] or [rad]
        ("brakes", _b),  # at zero volts: shorted, or else open
        ("stator_limit", _f),  # of one motor, at most the model's [A]
        ("supply_limit", _f),  # the same, drawing and feeding back [A]
        ("load", _f),  # torque from outside [N m]
    ],
    align=True,
)

SHAFT = np.dtype(
    [
        ("model", _MOTOR),  # constant
        ("request", _MOTOR_REQUEST),  # until the next one
        # --- state ---
        ("position", _f),  # [rad]
        ("speed", _f),  # [rad/s]
        ("cos", _f),  # of the direction of the wheels
        ("sin", _f),
        ("volts", _f),  # at each motor in the last step [V]
        ("current", _f),  # of each motor in the last step [A]
        ("supply", _f),  # of all motors from the battery in the last step [A]
        ("energy", _f),  # that all motors took since the reset: integral of V I [J]
        ("charge2", _f),  # integral of the square of one motor's current since the reset [A^2 s]
        ("mean_current", _f),  # of all motors in the last call [A]
        ("mean_supply", _f),  # of all motors from the battery in the last call [A]
        ("noted_supply", _f),  # the same in the last step as the last brown-out began [A]
        # --- within a step ---
        ("is_open", _b),
        ("wanted", _f),  # [V]
        ("limit", _f),  # of the stator, in force [A]
        ("before", _f),  # speed [rad/s]
        ("weighted", _f),  # step that `weight` is of [s]
        ("weight", _f),  # share of the end of the step in the mean; see `end_weight`
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
"""Motors, the gear behind them, and what they turn: wheels, an azimuth or a mechanism."""

WHEEL = np.dtype(
    [
        ("x", _f),  # from the center of mass, forward and to the left [m]
        ("y", _f),
        ("cof", _f),  # coefficient of friction along the wheel [-]
        ("rolling", _f),  # drag over load [-]
        ("is_lowered", _b),
        ("load", _f),  # [N]
        ("slip", _f),  # that makes its force [m/s]
        ("force_x", _f),  # of the ground, robot axes, in the last step [N]
        ("force_y", _f),
        ("grip", _f),  # mu N [N]
        ("along", _f),
        ("across", _f),
        ("shaft", _i),
        ("mean_load", _f),  # in the last call [N]
        ("mean_x", _f),
        ("mean_y", _f),
    ],
    align=True,
)
"""A wheel on carpet."""

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
        ("model", _BATTERY_MODEL),  # constant, see `BatteryConfig`
        # --- state ---
        ("charge", _f),  # [0..1]
        ("slow_drop", _f),  # [V]
        ("drawn", _f),  # [A s]
        ("energy", _f),  # given at the terminals [J]
        ("current", _f),  # in the last step [A]
        ("voltage", _f),  # at the terminals [V]
        ("min_voltage", _f),
        ("tick_min_voltage", _f),
        ("is_low", _b),  # what the roboRIO sees
        ("is_off", _b),  # what its controllers have heard
        ("tick_was_off", _b),
        ("heard", _f),  # since the last heartbeat [s]
        ("starved", _f),  # for how long below the reset voltage [s]
        ("boots", _f),  # until it is back [s]
        ("off_time", _f),  # [s]
        ("brownouts", _i),
        ("resets", _i),
        ("noted_voltage", _f),  # as the last brown-out or reset began [V]
        ("noted_current", _f),  # [A]
    ],
    align=True,
)
"""A battery, and the roboRIO that it feeds."""

BODY = np.dtype(
    [
        ("row", _i),  # its number among the bodies of the world
        ("is_robot", _b),  # whether the loop moves it; the engine moves all others
        ("is_active", _b),  # whether a ball may touch it now
        ("swings", _b),  # whether it turns about a pivot
        ("carries", _b),  # whether robots drive on it
        ("mark", _i),  # bit that it leaves in `Balls.bodies`
        ("first_solid", _i),
        ("last_solid", _i),  # the one behind its last
        ("reach", _f),  # of the ball around its origin that holds it [m]
        ("mass", _f),  # [kg]
        ("center", _f, (3,)),  # of mass, in its frame, or pivot, in that of the field [m]
        ("inertia", _f, (3,)),  # principal moments about it [kg m^2]
        ("principal", _f, (3, 3)),  # principal axes in its frame, as columns
        ("pos", _f, (3,)),  # origin, field frame [m]
        ("quat", _f, (4,)),  # attitude x, y, z, w
        ("axes", _f, (3, 3)),  # its axes as columns
        ("com", _f, (3,)),  # center of mass, or pivot, field frame [m]
        ("vel", _f, (3,)),  # of the center of mass, 0 of a pivot [m/s]
        ("rate", _f, (3,)),  # angular velocity, field frame [rad/s]
        ("pull", _f, (3,)),  # angular acceleration that the engine gave it in its last step, of what carries [rad/s^2]
        ("mean_twist", _f, (6,)),  # of both over the last call [m/s, rad/s]
        ("impulse", _f, (6,)),  # by balls in the last call: impulse [N s], angular impulse about the center [N m s]
    ],
    align=True,
)
"""A rigid body."""

_ROBOT_REQUEST = np.dtype(
    [
        ("is_enabled", _b),
        ("other_current", _f),  # from the battery, in addition to that of its motors [A]
        ("force", _f, (3,)),  # from outside on the center of mass, field frame [N]
        ("torque", _f, (3,)),  # [N m]
    ],
    align=True,
)

ROBOT = np.dtype(
    [
        ("request", _ROBOT_REQUEST),  # until the next one
        # --- what it consists of ---
        ("body", _i),
        ("first_shaft", _i),
        ("last_shaft", _i),
        ("drive_shafts", _i),  # how many have wheels; they come first
        ("first_wheel", _i),
        ("last_wheel", _i),
        ("first_point", _i),  # of what touches the field: its wheels first
        ("last_point", _i),
        ("first_part", _i),  # of its bumpers
        ("last_part", _i),
        ("reach", _f),  # of bumpers and wheels around its vertical axis [m]
        ("low", _f),  # lowest and highest part of its bumpers and frame, robot frame [m]
        ("high", _f),
        # --- in this step ---
        ("press", _f, (3,)),  # by all contacts but tires, field frame [N]
        ("twist", _f, (3,)),  # their moment about the center of mass [N m]
        ("shift", _f, (3,)),  # out of what people have put it into [m]
        ("is_upright", _b),  # whether its bumpers meet walls and other robots in plan
        ("is_put", _b),  # whether people have put it where it stands since the last step
        ("plan_mass", _f, (2,)),  # mass that its contact with the carpet shows along its axes [kg]
        ("yaw_rate", _f),  # about its own vertical axis, as its tires leave it [rad/s]
        ("is_sliding", _b),
        ("bus", _f),  # voltage of the battery [V]
        ("time", _f),  # since the reset [s]
        # --- of the last call ---
        ("touches", _i, (TOUCHES,)),  # rows of what it touched
        ("touched", _i),  # how many
    ],
    align=True,
)
"""A robot."""

POINT = np.dtype(
    [
        ("x", _f),  # middle of a soft ball, robot frame [m]
        ("y", _f),
        ("z", _f),
        ("radius", _f),  # [m]
        ("stiffness", _f),  # [N/m]
        ("damping", _f),  # [N s/m]
        ("is_wheel", _b),
        ("on", _i),  # number of the body that it stands on, -1: the field
        ("load", _f),  # normal force in this step [N]
        ("gap", _f),  # to floor or field, as far as it is near [m]
        ("normal", _f, (3,)),  # mean direction of the load, field frame
        ("arm", _f, (3,)),  # mean place of the contact from the center of mass, field frame [m]
    ],
    align=True,
)
"""A place of a robot that touches the field: a wheel, or a point of bumpers, frame or underside."""

PART = np.dtype(
    [
        ("robot", _i),
        ("x", _f),  # middle, robot axes [m]
        ("y", _f),
        ("half_length", _f),  # [m]
        ("half_width", _f),
        ("bottom", _f),  # above the robot's origin [m]
        ("top", _f),
        ("friction", _f),  # factors of its surface
        ("restitution", _f),
        ("stiffness", _f),  # force over depth and length of the side that touches [N/m^2]
        ("edge_stiffness", _f),  # against one end of an edge of the field [N/m]
        ("edge_damping", _f),  # [N s/m]
        ("low", _f),  # heights now, field frame [m]
        ("high", _f),
        ("first_outline", _i),  # of the field's, at these heights
        ("last_outline", _i),
        ("corners", _f, (4, 2)),  # in plan, counter-clockwise [m]
        ("normals", _f, (4, 2)),  # of the side after each corner
    ],
    align=True,
)
"""A rectangle of a robot's outline: bumpers, or the frame above them."""

OUTLINE = np.dtype(
    [
        ("row", _i),  # of its element
        ("first", _i),  # corner
        ("last", _i),
        ("low_x", _f),
        ("high_x", _f),
        ("low_y", _f),
        ("high_y", _f),
        ("bottom", _f),  # heights between which it stands [m]
        ("top", _f),
        ("friction", _f),
        ("restitution", _f),
    ],
    align=True,
)
"""Convex outline of a part of the field, between two heights."""

SPRING = np.dtype([("key", _i), ("stamp", _i), ("stretch", _f, (3,)), ("put_in", _f)], align=True)
"""A contact of a robot: what touches, the step in which it was touched last, the stretch of its friction, field frame
[m], and how deep the two were in each other without having been pressed, as far as they have not come out of it [m]."""


class Fleet(NamedTuple):
    """Robots of a world, and the outlines that their bumpers may meet."""

    robots: Records
    shafts: Records
    wheels: Records
    batteries: Records
    """Battery of each robot."""
    parts: Records
    points: Records
    springs: Records
    """Records of all contacts, shape (robots, `SPRINGS`)."""
    outlines: Records
    corners: FloatArray
    """Corners of all outlines [m], shape (n, 2)."""
    normals: FloatArray
    """Normals of the sides after these corners, shape (n, 2)."""
    hidden: npt.NDArray[np.uint8]
    """Whether each side is covered by another outline, shape (n,)."""
    clock: IntArray
    """Number of the last step, shape (1,)."""


def no_robots() -> Fleet:
    """Make a fleet without a robot."""
    return Fleet(
        records(ROBOT, 0), records(SHAFT, 0), records(WHEEL, 0), records(BATTERY, 0), records(PART, 0),
        records(POINT, 0), records(SPRING, 0).reshape(0, SPRINGS), records(OUTLINE, 0), np.zeros((0, 2)),
        np.zeros((0, 2)), np.zeros(0, np.uint8), np.zeros(1, np.int64),
    )  # fmt: skip


def records(dtype: np.dtype[Any], count: int = 1) -> Records:
    """Return `count` records, all zero."""
    made = np.zeros(count, dtype)
    return made.view(np.recarray) if numba.config.DISABLE_JIT else made  # type: ignore[attr-defined]


def join(some: Sequence[Records]) -> Records:
    """Concatenate arrays of records."""
    made = np.concatenate(some)
    return made.view(np.recarray) if numba.config.DISABLE_JIT else made  # type: ignore[attr-defined]
