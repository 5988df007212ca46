"""The text of a new `simcore.toml`: every key with its meaning, those that need a choice commented out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from simcore.robot_file.camera_template import FoundCamera, cameras_text
from simcore.robot_file.port_templates import FoundPort, ports_text

__all__ = ["FILE_NAME", "FoundMotor", "template"]

FILE_NAME = "simcore.toml"


@dataclass(frozen=True, slots=True, kw_only=True)
class FoundMotor:
    """A motor of the robot program that nobody has described yet."""

    controller: str
    leader: int
    followers: tuple[int, ...] = ()
    opposed: tuple[int, ...] = ()
    gearing: float = 1.0
    has_gravity: bool = False
    """Whether it holds a weight (a kG is configured)."""
    problem: str = ""
    """Why its configuration could not be read, so that its gearing is not known."""


_HEAD = """\
# What `robotpy sim --simcore` cannot read from your robot program. Lengths in meters, angles in degrees, masses in kg.
# x is forward, y to the left, z up; a robot's origin is on the floor under its center.

# game = "name"                 # where several are installed; left out: the newest
# engine = "mujoco"             # physics engine: bullet or mujoco; left out: bullet where it is installed

[robot]
mass = 55.0                     # with bumpers and battery: weigh it
# bumper_length = 0.80          # outside of the bumpers, along x; left out: 15 cm beyond the wheels' centers
# bumper_width = 0.80
# bay_depth = 0.50              # opening in the back of bumpers and frame, into which a climber takes what it hangs on
# bay_width = 0.30
center_of_mass_height = 0.20
# tread = 1.2                   # friction of the wheels on carpet
# drive_motor = "Kraken X60"    # left out: Kraken X60 with FOC
# steer_motor = "Kraken X44"
# capacity = 1                  # game pieces that a storage holds; left out: as many as the game's own robot

[start]                         # as a blue robot; red starts at the corresponding place
x = 2.0
y = 1.2
heading_deg = 0.0
preload = 0

# [autos."Left two piece"]      # where an auto of this name starts; others at [start]
# start = [2.0, 1.2, 0.0]       # x, y, heading_deg

"""

_NOTHING_FOUND = """\
# Mechanisms: one [[mechanism]] each. A motor that is not named here gets a guess, made of its configuration.
#
# [[mechanism]]
# name = "shooter"
# kind = "flywheel"             # flywheel, roller, arm, turret, elevator or rack
# leader = 20                   # CAN id
# followers = [21, 22]
# opposed = [22]                # followers that are mounted face to face with the leader
# controller = "TalonFX"        # or TalonFXS, SPARK MAX, SPARK Flex; PWM and Relay: leader and followers are channels
# motor = "Kraken X60"          # left out: this one, or NEO and NEO Vortex for SPARKs
# gearing = 0.75                # rotor turns per turn of the mechanism
# inertia = 0.004               # of all that turns, at the mechanism [kg m^2]
"""

_FOUND = """\
# Mechanisms: your program has these motors besides its drivetrain. Take the # off and say what they turn; until then
# each gets a guess, made of its configuration.
"""

_KINDS = """\
#
# What each kind needs besides name, kind, leader and gearing:
#   flywheel  inertia [kg m^2]
#   roller    (inertia, radius)
#   arm       inertia, min_deg, max_deg, mass, center_of_mass (from the joint), start_deg; 0 is level, 90 upright
#   turret    inertia, min_deg, max_deg, start_deg; about the vertical, counter-clockwise
#   elevator  mass, drum_radius, max_height (min_height, start_height)
#   rack      mass, pinion_radius, travel (start_extension)
#   servo     pwm, min_deg, max_deg (at PWM 0 and 1), deg_per_second; neither leader nor gearing
#   piston    solenoid (a channel, or [forward, reverse]), stroke, stroke_time; module "REVPH" or "CTREPCM", module_id
# and, if there is one: cancoder = <id> and cancoder_gearing = <its turns per turn of the mechanism>; the encoder wired
# to a SPARK has encoder_gearing. friction_volts = <kS> or friction_torque [N m] if it coasts for too long or too short;
# left out: the kS that your program has set, else 0.2 V (a flywheel: its motors' no-load current).
# reversed = true if your code counts down while the mechanism goes up.
# Where something moves that carries an intake, a claw, a hook or another mechanism: x, y, z of its joint, and
#   on = "lift"   what carries it (an arm, turret, elevator or rack); left out: the robot
#   moving_mass   how much of the robot's mass goes with it; left out: its mass (a turret: 0) without what is on it
#   mass_center = [0.2, 0.0, 0.0]   where that is from the joint, with all joints at 0; left out: as center_of_mass says
#   yaw_deg       of an arm or a rack: 0 reaches to the front, 180 to the back
#   rise_deg      of a rack: up from the floor;   lean_deg of an elevator: 0 is upright, 15 leans to the front

# [[storage]]                   # only if the robot has several, e.g. one for each shooter
# name = "front"
# capacity = 20
# order = "fifo"                # or lifo, a stack

# [[intake]]                    # pieces in this box are taken in while the roller turns forward; one table an intake
# x_min = -0.60
# x_max = -0.35
# y_min = -0.30
# y_max = 0.30
# roller = "intake"             # a mechanism
# takes_in = "forward"          # or backward: how the roller turns then
# deploy = "pivot"              # a mechanism that must be out; leave it out if there is none
# out_at = "lower"              # at which of its stops it is out: upper or lower
# on = "pivot"                  # what carries the box; it is then measured from that joint, with all joints at 0
# storage = "front"             # where pieces go, if there are several
# kinds = ["Name"]              # kinds of pieces that it takes; left out: all

# [[shooter]]                   # one table a shooter
# wheels = "shooter"            # a mechanism of kind flywheel, or two with speeds of their own: ["lower", "upper"]
# side_by_side = false          # whether two wheels are the left and the right one
# feeder = "feeder"             # what must turn forward, one name or a list; leave it out if spinning wheels are enough
# feeder_backward = "feeder"    # those of them that feed while they turn backward
# storage = "front"             # where pieces come from, if there are several
# hood = "hood"                 # a mechanism that tilts the shot; leave it out for a fixed one
# elevation_deg = 65.0          # of the shot, with the hood at angle 0
# elevation_per_hood = -1       # -1 if the shot gets flatter as the hood goes up
# turret = "turret"             # a mechanism that turns the shot; leave it out if there is none
# turret_ratio = 1.0            # turns of the shot per turn of that mechanism
# turret_x = 0.0                # where the turret's axis is
# turret_y = 0.0
# height = 0.5                  # of the muzzle
# forward = 0.15                # of the muzzle ahead of the robot's center, or of the turret's axis
# yaw_deg = 0.0                 # direction of the shot, with the turret at 0; 180 is to the back
# barrels = [0.0]               # places across, to the left
# shots_per_second = 8.0
# wheel_radius = 0.05           # or, of two wheels, [lower, upper]
# exit_efficiency = 0.49        # speed of the piece over the rim's: one half against a fixed hood, one between wheels
# kinds = ["Name"]              # kinds of pieces that it throws; left out: all

# [[claw]]                      # holds one piece at the end of what carries it
# on = "arm"                    # a mechanism; an arm on an elevator says on = "lift" itself
# x = 0.35                      # middle of the held piece from that joint, with all joints at 0
# y = 0.0
# z = 0.0
# size = [0.3, 0.3, 0.3]        # of the box around it in which pieces are taken
# roller = "claw"               # a mechanism: forward takes, backward lets go
# give = 0.01                   # how deep the field can be in the held piece before it is knocked out
# passes_through = false        # whether forward lets go, too, once the roller has stopped in between
# pitch_deg = 0.0               # of the held piece; also roll_deg, yaw_deg
# from_storage = true           # the storage hands pieces on to it; left out: it does not
# handover = [0.1, 0.0, 0.5]    # where: its box must be there; left out: wherever it is
# kinds = ["Name"]

# [[climber]]                   # a hook that comes down on a rung of the field, and pulls the robot up
# on = "climb"                  # a mechanism
# x = 0.0                       # inside of the hook from that joint, with all joints at 0
# y = 0.0
# z = 0.0
# reach = 0.04                  # half of the hook's mouth

# [[component]]                 # a moving part with a model of its own in AdvantageScope, in the order of the models
# name = "forearm"
# on = "arm"                    # a mechanism
# roller = "claw"               # a roller that turns it about y at that place; then it needs no "on"
# share = 1.0                   # of the motion: 0.33 for the first stage of an elevator with three
# x = 0.0                       # origin of the model from that joint, with all joints at 0
# y = 0.0
# z = 0.0
"""


def template(
    motors: Sequence[FoundMotor] | None = None,
    ports: Sequence[FoundPort] = (),
    cameras: Sequence[FoundCamera] = (),
) -> str:
    """The text.

    Args:
        motors: Of the robot program; None if nobody could look.
        ports: What else it has.
        cameras: That it builds or asks for.
    """
    found = _FOUND + "".join(_mechanism(m) for m in motors) if motors else _NOTHING_FOUND
    return _HEAD + found + _KINDS + "\n" + cameras_text(cameras) + ports_text(ports)


def _mechanism(m: FoundMotor) -> str:
    lines = ["", "[[mechanism]]", f'name = "motor{m.leader}"']
    lines.append('kind = "arm"                    # it holds a weight: an arm or an elevator' if m.has_gravity else
                 'kind = "roller"                 # flywheel, roller, arm, elevator or rack')  # fmt: skip
    lines.append(f"leader = {m.leader}")
    if m.followers:
        lines.append(f"followers = {list(m.followers)}")
    if m.opposed:
        lines.append(f"opposed = {list(m.opposed)}")
    if m.controller != "TalonFX":
        lines.append(f'controller = "{m.controller}"')
    lines.append(
        "gearing = 1                     # not known: " + m.problem if m.problem else f"gearing = {m.gearing:.6g}"
    )
    return "".join(f"# {line}".rstrip() + "\n" for line in lines)
