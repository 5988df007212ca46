"""State of robots, as arrays of records: each has the constants, the requests and the state of one thing.

Numbers that belong to a robot's plane are in plan axes: those of the field where it stands level, else the robot's own
x and y axes turned back by its heading. Shafts and wheels are numbered within their robot.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numba
import numpy as np
import numpy.typing as npt

__all__ = [
    "AZIMUTH",
    "BATTERY",
    "CURRENT",
    "DUTY",
    "MECHANISM",
    "NEUTRAL",
    "OUTLINE",
    "PART",
    "PISTON",
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
    "Records",
    "join",
    "records",
]

Records: TypeAlias = npt.NDArray[Any]
"""An array of one of the record types of this module."""

STEP = 1e-3
"""Longest step of motors, shafts, tires and bumpers [s]."""
TOUCHES = 24
"""Bodies that a robot can touch at once, of which it is told."""

# Kinds of shafts.
WHEELS, AZIMUTH, MECHANISM, PISTON, SERVO = 0, 1, 2, 3, 4

# What a motor is asked for.
NEUTRAL, VOLTS, DUTY, CURRENT, TARGET = 0, 1, 2, 3, 4
"""Brake or coast as configured; volts; share of the bus; amperes; a speed of the tread or an angle of the azimuth."""

_f, _i, _b = np.float64, np.int64, np.uint8

SHAFT = np.dtype(
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
        # --- what it carries ---
        ("lower", _f),  # hard stops [rad]
        ("upper", _f),
        ("weight_torque", _f),  # of a weight on a lever, times the cosine of the position [N m]
        ("load", _f),  # torque from outside [N m]
        # --- wheels on it ---
        ("first", _i),  # wheel of the robot
        ("last", _i),  # the one behind its last
        ("radius", _f),  # [m]
        ("grain", _f),  # friction of the treads across over that along [-]
        ("slip_ratio", _f),  # slip per rolling speed at which tires begin to slide [-]
        ("slip_speed", _f),  # the same at standstill [m/s]
        ("cos", _f),  # of the direction of the wheels
        ("sin", _f),
        # --- swerve: the azimuth of a wheel's shaft, and the wheel's shaft of an azimuth ---
        ("partner", _i),  # shaft of the robot, -1: none
        ("zero", _f),  # of an azimuth: direction of the wheel at position 0 [rad]
        ("scrub", _f),  # of an azimuth: friction torque over load [m]
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
        # --- request ---
        ("mode", _i),
        ("request", _f),  # [V], [-], [A], [m/s] or [rad]
        ("brakes", _b),  # at zero volts: shorted, or else open
        ("idle", _f),  # of a piston: volts of its valve without power [V]
        # --- state ---
        ("position", _f),  # [rad]
        ("speed", _f),  # [rad/s]
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
        ("is_down", _b),  # whether it is on the ground
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

BATTERY = np.dtype(
    [
        # --- constants, see `BatteryConfig` ---
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

ROBOT = np.dtype(
    [
        # --- what it consists of ---
        ("row", _i),  # of its body in the engine
        ("first_shaft", _i),
        ("last_shaft", _i),
        ("drive_shafts", _i),  # how many have wheels; they come first
        ("first_wheel", _i),
        ("last_wheel", _i),
        ("first_part", _i),  # of its bumpers
        ("last_part", _i),
        ("mass", _f),  # [kg]
        ("center", _f, (3,)),  # of mass, robot axes [m]
        ("inertia", _f, (3,)),  # about it [kg m^2]
        ("tip", _f, (2,)),  # angular momentum in roll and pitch that its weight has still to take up [N m s]
        ("half_base", _f),  # from it to the nearest line through outer wheels, in plan [m]
        ("is_enabled", _b),
        ("other_current", _f),  # from the battery beside that of its motors [A]
        # --- body, field frame ---
        ("seen", _f, (13,)),  # center of mass, attitude and velocities as the engine has them [m, m/s, rad/s]
        ("pos", _f, (3,)),  # of its origin [m]
        ("quat", _f, (4,)),
        ("vel", _f, (3,)),  # of its center of mass [m/s]
        ("rate", _f, (3,)),  # [rad/s]
        ("given", _f, (6,)),  # velocity that the engine got in the last step
        ("rest", _f, (6,)),  # that is to be added to what the engine made of it
        ("early", _f),  # share of a step by which the engine's velocities are ahead of the loop's mean
        ("h_before", _f),  # length of the last step, 0 after a start [s]
        ("is_on_flat", _b),  # whether there is nothing but the floor under its wheels
        ("is_level", _b),  # on the flat carpet, with nothing that lifts or tips it
        ("force", _f, (3,)),  # from outside on the center of mass [N]
        ("torque", _f, (3,)),  # [N m]
        ("drive", _f, (3,)),  # acceleration by these, and by a driver without wheels, plan axes [m/s^2, rad/s^2]
        ("gravity", _f, (3,)),  # robot axes [m/s^2]
        ("has_fixed_loads", _b),  # whether its wheels' loads are given
        ("felt", _f, (3,)),  # acceleration by what the engine does, robot axes [m/s^2]
        # --- in its plane ---
        ("x", _f),  # of the center of mass [m]
        ("y", _f),
        ("yaw", _f),  # [rad]
        ("vx", _f),  # of the point on the carpet under it [m/s]
        ("vy", _f),
        ("omega", _f),  # [rad/s]
        ("pull", _f, (3,)),  # acceleration that the engine is expected to add [m/s^2, rad/s^2]
        ("contact", _f, (3,)),  # by bumpers in this step [N, N, N m]
        ("contact_load", _f, (2,)),  # acceleration by bumpers as it shifts load, plan axes [m/s^2]
        ("followed", _f, (3,)),  # acceleration that wheel loads have followed, robot axes [m/s^2]
        ("tires", _f, (2,)),  # by tires in the last step, robot axes [m/s^2]
        ("is_sliding", _b),
        ("bus", _f),  # voltage of the battery in the last step [V]
        ("time", _f),  # since the reset [s]
        # --- of the last call: changes of velocity at its end and in the mean ---
        ("end_change", _f, (3,)),  # by tires and driver, plan axes [m/s, m/s, rad/s]
        ("mean_change", _f, (3,)),
        ("hit_end", _f, (3,)),  # by bumpers
        ("hit_mean", _f, (3,)),
        ("hit_moment", _f, (2,)),  # that they have about the center of mass in roll and pitch, plan axes [N m s]
        ("touches", _i, (TOUCHES,)),  # engine rows of what its bumpers touched
        ("touched", _i),  # how many
        # --- its bumpers in plan, as it stood when the call began ---
        ("is_upright", _b),
        ("is_put", _b),  # whether people have put it where it stands since the last step
        ("is_solid", _b),  # whether the engine keeps it out of walls and robots: it lies, or is above another one
        ("z", _f),  # its height there [m]
        ("height", _f),  # of the middle of its bumpers above its origin, twice [m]
        ("yaw_before", _f),  # [rad]
        ("along", _f, (2,)),  # its x axis in plan, turned back by its yaw
        ("aside", _f, (2,)),  # its y axis
        ("upward", _f, (2,)),  # its z axis
        ("center_ahead", _f, (2,)),  # from its origin to the center of mass [m]
        ("leaning", _f, (2,)),  # by roll and pitch: velocity over height, plan axes [1/s]
        ("reach", _f),  # of the bumpers around their middle [m]
    ],
    align=True,
)
"""A robot."""

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
        ("row", _i),  # of its body in the engine
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

SPRING = np.dtype([("key", _i), ("stamp", _i), ("stretch", _f), ("put_in", _f)], align=True)
"""A contact of bumpers: what touches, the step in which it was touched last, the stretch of its friction [m], and how
deep people have put the two into each other, as far as that has not been pushed out [m]."""


def records(dtype: np.dtype[Any], count: int = 1) -> Records:
    """So many records, all zero."""
    made = np.zeros(count, dtype)
    return made.view(np.recarray) if numba.config.DISABLE_JIT else made  # type: ignore[attr-defined]


def join(some: Sequence[Records]) -> Records:
    """One array of the records of several."""
    made = np.concatenate(some)
    return made.view(np.recarray) if numba.config.DISABLE_JIT else made  # type: ignore[attr-defined]
