"""Table `[[mechanism]]` of `simcore.toml`: mechanisms with motors or other actuators, encoders and joints."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from simcore.errors import ConfigError
from simcore.quantities import (
    DEGREES,
    DURATION,
    FORCE_OR_NONE,
    FRACTION,
    GEARING,
    INERTIA,
    MASS,
    MASS_OR_NONE,
    ROBOT_HEIGHT,
    ROBOT_LENGTH,
    ROBOT_PLACE,
    TORQUE_OR_NONE,
    VOLTAGE_OR_NONE,
    WHEEL_RADIUS,
    DeviceAddress,
    Quantity,
)
from simcore.robot.chassis_config import MovingMass
from simcore.robot.dc_motor import MOTOR_NAMES, motor
from simcore.robot.gearbox import GearboxConfig, default_friction, friction_from_volts
from simcore.robot.mechanisms import (
    ArmConfig,
    ElevatorConfig,
    FlywheelConfig,
    PistonConfig,
    RackConfig,
    RollerConfig,
    ServoConfig,
    guessed_inertia,
)
from simcore.robot.robot_config import MechanismConfig
from simcore.robot_file.drivetrain_table import OLD_CONTROLLERS
from simcore.robot_file.key_tables import Key, KeyTable, Several, Table
from simcore.robot_file.robot_settings import CONTROLLERS, MechanismSettings
from simcore.units import GRAVITY, plain_sum
from simcore.world.linkage import Joint

__all__ = [
    "CAN_ID", "KINDS", "MECHANISM", "MOTORS", "PLACE", "joints_to", "moving_masses",
    "read_mechanism", "require_chains", "usual_motor",
]  # fmt: skip

CAN_ID = Quantity("", 0, 62, is_whole=True)
_DEVICES = Several(DeviceAddress, or_one=False)
_CHANNEL = Quantity("", 0, 15, is_whole=True)
_MODULES = {"REVPH": 1, "CTREPCM": 0}
"""Default CAN id of each type of pneumatics module."""
_USUAL_MOTORS = {"SPARK MAX": "NEO", "SPARK Flex": "NEO Vortex"}
_GEARING = 1.0  # guess, if the program does not set a gearing
_WITH_ENCODER = ("SPARK MAX", "SPARK Flex")

_STOPS = (
    Key("min_deg", DEGREES, -180.0, "angle of the lower stop [deg]: 0 is level, 90 upright", 0.0, "min_angle",
        is_guess=True),
    Key("max_deg", DEGREES, 180.0, "angle of the upper stop [deg]", 90.0, "max_angle", is_guess=True),
    Key("start_deg", DEGREES, None, "initial angle [deg]; left out: min_deg, or 0 if min_deg is a guess", 0.0,
        "start_angle"),
)  # fmt: skip
_YAW = Key("yaw_deg", DEGREES, 0.0, "direction, counter-clockwise [deg]: 0 front, 90 left, 180 back", field="yaw")
_INERTIA = Key("inertia", INERTIA, None, "moment of inertia of all turning parts, at the mechanism [kg m^2]; left out: "
    "a guess from your program's configuration, else a value for two thirds of full speed after 50 ms", 0.004,
    is_guess=True)  # fmt: skip
_REVERSED = Key(
    "reversed", bool, False, "whether the positive direction in your code is the mechanism's negative direction"
)

MOTORS = KeyTable("[[mechanism]] with motors", "motors and encoders of the mechanism", (
    Key("leader", DeviceAddress, about="CAN id of the leader (PWM or Relay: channel)", example=20),
    Key("followers", _DEVICES, (), "CAN ids or channels of the followers, on the bus of the leader", [21, 22]),
    Key("opposed", _DEVICES, (), "followers mounted face to face with the leader", [22]),
    Key("controller", CONTROLLERS, CONTROLLERS[0], "model of the motor controllers; for PWM and Relay, leader and "
        "followers are channels", refused=OLD_CONTROLLERS),
    Key("motor", MOTOR_NAMES, None, "model of the motors; left out: NEO for SPARK MAX, NEO Vortex for SPARK Flex, else "
        "Kraken X60", "Kraken X60"),
    Key("gearing", GEARING, None, "rotor turns per turn of the mechanism; left out: a guess from your program's "
        "configuration, else 1", 0.75, is_guess=True),
    Key("friction_volts", VOLTAGE_OR_NONE, None, "static friction kS [V], to match a measured coasting time; left out: "
        "the kS in your program, else 0.2 V (flywheel: friction from the motors' no-load current)"),
    Key("friction_torque", TORQUE_OR_NONE, None, "friction torque at the mechanism [N m], instead of friction_volts"),
    _REVERSED,
    Key("coasts", bool, False, "whether a PWM or Relay controller coasts at zero output instead of braking"),
    Key("cancoder", DeviceAddress, None, "CAN id of a CANcoder on the mechanism; left out: no CANcoder"),
    Key("cancoder_gearing", GEARING, 1.0, "turns of the CANcoder per turn of the mechanism",
        needs=("cancoder", "<CAN id>")),
    Key("encoder_gearing", GEARING, 1.0, "turns of an encoder wired to a SPARK per turn of the mechanism"),
))  # fmt: skip
PLACE = KeyTable("arm, turret, elevator, rack", "position of the joint, if the mechanism carries other parts, and "
    "moving mass", (
    Key("x", ROBOT_PLACE, 0.0, "x coordinate of the joint, from the joint of the carrier [m]"),
    Key("y", ROBOT_PLACE, 0.0, "y coordinate of the joint, from the joint of the carrier [m]"),
    Key("z", ROBOT_PLACE, 0.0, "z coordinate of the joint, from the joint of the carrier [m]"),
    Key("on", str, None, "carrier: the name of an arm, turret, elevator or rack; left out: the robot"),
    Key("moving_mass", MASS_OR_NONE, None, "part of the robot's mass that moves with this mechanism alone [kg]; left "
        "out: mass (turret: 0) minus the moving masses of mechanisms on it"),
    Key("mass_center", (ROBOT_PLACE,) * 3, None, "center of the moving mass, from the joint, with all joints at 0 [m]; "
        "left out: at center_of_mass along an arm, else at the joint"),
))  # fmt: skip
KINDS: dict[str, KeyTable] = {table.head: table for table in (
    KeyTable("flywheel", "a wheel that launches pieces", (_INERTIA,)),
    KeyTable("roller", "a roller that pulls in, feeds or holds pieces", (
        replace(_INERTIA, default=0.001, about="moment of inertia of all turning parts, at the roller [kg m^2]",
            is_guess=False),
        Key("radius", WHEEL_RADIUS, 0.025, "radius of the roller [m]"),
    )),
    KeyTable("arm", "an arm that swings up and down", (
        _INERTIA,
        *_STOPS,
        Key("mass", MASS_OR_NONE, 0.0, "mass of all swinging parts [kg]; 0 for an arm balanced by a spring or a "
            "counterweight"),
        Key("center_of_mass", ROBOT_PLACE, 0.0, "distance from the joint to the center of mass [m]"),
        Key("spring_share", FRACTION, 0.0, "fraction of the arm's gravity torque that springs balance"),
        _YAW,
    )),
    KeyTable("turret", "a turret that turns about the vertical axis, counter-clockwise positive", (
        _INERTIA,
        replace(_STOPS[0], about="angle of the clockwise stop [deg]"),
        replace(_STOPS[1], about="angle of the counter-clockwise stop [deg]"),
        replace(_STOPS[2], about="initial angle [deg]; left out: 0, or the stop nearest to 0"),
    )),
    KeyTable("elevator", "an elevator that moves up and down", (
        Key("mass", MASS, 5.0, "mass of all lifted parts [kg]", field="carriage_mass", is_guess=True),
        Key("drum_radius", WHEEL_RADIUS, 0.02, "rise of the carriage per radian of the drum, including all stages [m]",
            is_guess=True),
        Key("min_height", ROBOT_PLACE, 0.0, "height of the lower stop [m]"),
        Key("max_height", ROBOT_PLACE, 1.0, "height of the upper stop [m]", is_guess=True),
        Key("start_height", ROBOT_PLACE, None, "initial height of the carriage [m]; left out: min_height"),
        Key("spring_force", FORCE_OR_NONE, 0.0, "upward force of constant-force or gas springs [N]"),
        Key("lean_deg", DEGREES, 0.0, "forward lean [deg]; 0 for an upright elevator", field="lean"),
    )),
    KeyTable("rack", "a slide with rack and pinion", (
        Key("mass", MASS, 3.0, "mass of all sliding parts [kg]", is_guess=True),
        Key("pinion_radius", WHEEL_RADIUS, 0.02, "pitch radius of the pinion [m]", is_guess=True),
        Key("travel", ROBOT_LENGTH, 0.3, "distance between the stops [m]", is_guess=True),
        Key("start_extension", ROBOT_HEIGHT, 0.0, "initial extension [m]"),
        _YAW,
        Key("rise_deg", DEGREES, 0.0, "upward angle of the slide from the floor [deg]", field="rise"),
    )),
    KeyTable("servo", "a servo on a PWM port, without leader and gearing", (
        Key("pwm", Quantity("", 0, 19, is_whole=True), about="PWM channel"),
        Key("min_deg", DEGREES, 0.0, "angle at servo position 0 [deg]", field="min_angle", is_guess=True),
        Key("max_deg", DEGREES, 180.0, "angle at servo position 1 [deg]", field="max_angle", is_guess=True),
        replace(_STOPS[2], about="initial angle [deg]; left out: min_deg"),
        Key("deg_per_second", Quantity("deg/s", 0.0, 10_000.0, is_open=True), 400.0, "no-load speed at 6 V [deg/s]",
            is_guess=True),
        _REVERSED,
    )),
    KeyTable("piston", "a pneumatic cylinder on solenoids, without leader and gearing", (
        Key("solenoid", Several(_CHANNEL), about="solenoid channel, or [forward, reverse] of a double solenoid"),
        Key("stroke", ROBOT_LENGTH, 0.2, "distance between the stops [m]", is_guess=True),
        Key("stroke_time", DURATION, 0.4, "time from stop to stop [s]", is_guess=True),
        Key("module", tuple(_MODULES), "REVPH", "type of the pneumatics module"),
        Key("module_id", CAN_ID, None, "CAN id of the pneumatics module; left out: 1 for a REVPH, 0 for a CTREPCM"),
        Key("start", ("in", "out"), None, "initial position; left out: in, or out for a reversed single solenoid"),
        _REVERSED,
    )),
)}  # fmt: skip
MECHANISM = KeyTable("[[mechanism]]", "a moving part of the robot; simcore guesses the mechanism of a motor without a "
    "table", (
    Key("name", str, about="name that other tables use for the mechanism", example="shooter"),
    Key("kind", tuple(KINDS), about="kind: flywheel, roller, arm, turret, elevator, rack, servo or piston",
        example="flywheel"),
))  # fmt: skip


def usual_motor(controller: str) -> str:
    """Return the motor that the reader assumes for a controller if the file names no motor."""
    return _USUAL_MOTORS.get(controller, "Kraken X60")


def read_mechanism(t: Table) -> MechanismSettings:
    """Return the mechanism that a `[[mechanism]]` table describes, with devices, joint, moving mass and guesses.

    Raises:
        ConfigError: A key is missing, unknown or invalid, or two keys contradict each other.
    """
    named = MECHANISM.read(t)
    name, kind = named["name"], named["kind"]
    if kind in ("servo", "piston"):
        settings = (_servo if kind == "servo" else _piston)(t, name, KINDS[kind].read(t))
        t.finish()
        return replace(settings, guessed=KINDS[kind].guesses(t))
    v = MOTORS.read(t)
    for device in v["opposed"]:
        if device not in v["followers"]:
            raise t.error(
                "opposed", f"must name followers, which are [{', '.join(map(str, v['followers']))}]; got {device}"
            )
    v["motor"] = v["motor"] or usual_motor(v["controller"])
    motors = 1 + len(v["followers"])
    gearbox = GearboxConfig(motor=motor(v["motor"]), motors=motors, gearing=v.pop("gearing") or _GEARING)
    friction = _friction(t, v.pop("friction_torque"), v.pop("friction_volts"), kind, gearbox)
    gearbox = replace(gearbox, friction_torque=friction)
    place, guessed = KINDS[kind].read(t), {**MOTORS.guesses(t), **KINDS[kind].guesses(t)}
    if "gearing" in guessed:
        guessed["gearing"] = _GEARING
    if "inertia" in guessed:
        guessed["inertia"] = place["inertia"] = guessed_inertia(gearbox)
    if kind in ("arm", "turret"):
        _require_stops(t, place)
    if kind in ("arm", "turret") and place["start_angle"] is None and (kind == "turret" or "min_deg" in guessed):
        place["start_angle"] = min(max(0.0, place["min_angle"]), place["max_angle"])
    yaw, rise, lean = (place.pop(angle, 0.0) for angle in ("yaw", "rise", "lean"))
    try:
        own = {"gravity": GRAVITY * math.cos(lean)} if kind == "elevator" else {}
        config = _CONFIGS[kind](gearbox=gearbox, **place, **own)
    except ConfigError as error:
        raise ConfigError(f"{t.where}: {error}") from error
    _check_devices(t, v)
    given = "friction_torque" in t or "friction_volts" in t
    settings = MechanismSettings(name=name, config=config, friction_is_given=given, guessed=guessed, **v)
    if kind not in ("flywheel", "roller"):
        settings = _placed(t, settings, kind, yaw, rise, lean)
    t.finish()
    return settings


def _friction(t: Table, torque: float | None, volts: float | None, kind: str, gearbox: GearboxConfig) -> float:
    """Return the friction torque at the mechanism [N m] from the torque or the kS in the file.

    Without friction in the file, return the default for the gearbox, which includes gear friction except for a
    flywheel.
    """
    if torque is not None and volts is not None:
        raise t.error("friction_volts", "means the same as friction_torque; keep one of them")
    if volts is not None:
        return friction_from_volts(gearbox, volts)
    return default_friction(gearbox, has_gears=kind != "flywheel") if torque is None else torque


_CONFIGS: dict[str, Callable[..., MechanismConfig]] = {
    **{"flywheel": FlywheelConfig, "roller": RollerConfig, "arm": ArmConfig, "turret": ArmConfig},
    **{"elevator": ElevatorConfig, "rack": RackConfig},
}


def _check_devices(t: Table, v: Mapping[str, Any]) -> None:
    """Check that the keys for encoders and coasting apply to the controller in the table."""
    controller = v["controller"]
    has_encoder = controller in _WITH_ENCODER
    if has_encoder and v["cancoder"] is not None:
        raise t.error("cancoder", f"is for a TalonFX; a {controller} has encoder_gearing for the encoder wired to it")
    if "encoder_gearing" in t and not has_encoder:
        raise t.error("encoder_gearing", f"is for a {' or '.join(_WITH_ENCODER)}; the controller is a {controller}")
    if "coasts" in t and controller not in ("PWM", "Relay"):
        raise t.error("coasts", f"is for a PWM or relay port; a {controller} has a configured neutral mode")


def _require_stops(t: Table, v: Mapping[str, Any]) -> None:
    """Check that the lower stop is below the upper stop, and that the initial angle is between the stops."""
    low, high, start = v["min_angle"], v["max_angle"], v["start_angle"]
    if not low < high:
        raise t.error("min_deg", f"must be below max_deg, got {math.degrees(low):g} and {math.degrees(high):g}")
    if start is not None and not low <= start <= high:
        raise t.error("start_deg", f"must be between min_deg and max_deg, got {math.degrees(start):g}")


def _servo(t: Table, name: str, v: dict[str, Any]) -> MechanismSettings:
    _require_stops(t, v)
    low, high = v["min_angle"], v["max_angle"]
    start = low if v["start_angle"] is None else v["start_angle"]
    speed = math.radians(v["deg_per_second"])
    config = ServoConfig(min_angle=low, max_angle=high, start_angle=start, speed=speed)
    return MechanismSettings(
        name=name, config=config, motor="", controller="Servo", leader=DeviceAddress(v["pwm"]), reversed=v["reversed"]
    )


def _piston(t: Table, name: str, v: dict[str, Any]) -> MechanismSettings:
    channels, module, number = v["solenoid"], v["module"], v["module_id"]
    if len(channels) > 2 or len(set(channels)) < len(channels):
        wanted = f"a channel from {_CHANNEL.least} to {_CHANNEL.most}, or two: [forward, reverse]"
        raise t.error("solenoid", f"must be {wanted}; got {list(channels)}")
    springs_out = v["reversed"] and len(channels) == 1
    config = PistonConfig(
        stroke=v["stroke"],
        stroke_time=v["stroke_time"],
        is_double=len(channels) == 2,
        springs_out=springs_out,
        starts_extended=(v["start"] or ("out" if springs_out else "in")) == "out",
    )
    return MechanismSettings(
        name=name,
        config=config,
        motor="",
        controller="Solenoid",
        leader=DeviceAddress(channels[0]),
        followers=tuple(map(DeviceAddress, channels[1:])),
        module=f"{module} {_MODULES[module] if number is None else number}",
        reversed=v["reversed"],
    )


# --- places, carriers and moving masses -------------------------------------------------------------------------------


def _placed(t: Table, m: MechanismSettings, kind: str, yaw: float, rise: float, lean: float) -> MechanismSettings:
    """Return a copy of a mechanism with the joint (in the frame of the carrier) and the moving mass of the table.

    Args:
        t: Table to read.
        m: Mechanism without a joint.
        kind: Kind of the mechanism in the file.
        yaw: Direction of an arm or a rack [rad].
        rise: Angle of a rack above the floor [rad].
        lean: Forward lean of an elevator [rad].
    """
    v, config = PLACE.read(t), m.config
    c, s = math.cos(yaw), math.sin(yaw)
    out, ratio = 0.0, 1.0
    if isinstance(config, ElevatorConfig):
        axis, ratio = (math.sin(lean), 0.0, math.cos(lean)), config.drum_radius
    elif isinstance(config, RackConfig):
        axis, ratio = (math.cos(rise) * c, math.cos(rise) * s, math.sin(rise)), config.pinion_radius
    else:
        assert isinstance(config, ArmConfig)
        axis = (0.0, 0.0, 1.0) if kind == "turret" else (s, -c, 0.0)  # a positive angle lifts the side along the yaw
        out = config.center_of_mass
    joint = Joint(
        mechanism=m.name,
        axis=axis,
        origin=(v["x"], v["y"], v["z"]),
        slides=isinstance(config, ElevatorConfig | RackConfig),
        ratio=ratio,
    )
    center = v["mass_center"] or ((-out * axis[1], out * axis[0], 0.0) if out else (0.0, 0.0, 0.0))
    return replace(m, joint=joint, on=v["on"], moving_mass=v["moving_mass"], mass_center=center)


def moving_masses(mechanisms: Mapping[str, MechanismSettings]) -> tuple[MovingMass, ...]:
    """Return the part of the robot's mass that each mechanism moves, without mechanisms that move no mass.

    The default of `moving_mass` is the `mass` of the elevator, rack or arm minus the moving masses of the mechanisms
    that the elevator, rack or arm carries. `require_chains` must have checked the mechanisms before this call.
    """
    found = []
    for m in mechanisms.values():
        mass = _all_moved(m, mechanisms) - _carried(m, mechanisms)
        if mass > 0.0:
            joints = joints_to(m.name, mechanisms)
            found.append(MovingMass(name=m.name, mass=mass, joints=joints, center=m.mass_center))
    return tuple(found)


def _all_moved(m: MechanismSettings, mechanisms: Mapping[str, MechanismSettings]) -> float:
    """Return the mass that a mechanism moves, including carried mechanisms [kg]."""
    carried, config = _carried(m, mechanisms), m.config
    if m.moving_mass is not None:
        return m.moving_mass + carried
    if isinstance(config, ElevatorConfig):
        return max(config.carriage_mass, carried)
    return max(config.mass, carried) if isinstance(config, ArmConfig | RackConfig) else carried


def _carried(m: MechanismSettings, mechanisms: Mapping[str, MechanismSettings]) -> float:
    """Return the moving mass of all mechanisms that a mechanism carries [kg]."""
    return plain_sum(_all_moved(one, mechanisms) for one in mechanisms.values() if one.on == m.name)


def require_chains(where: str, mechanisms: Mapping[str, MechanismSettings]) -> tuple[str, ...]:
    """Check that every `on` names a mechanism that can carry other mechanisms, and that no chain of `on` is a loop.

    Returns:
        Names of the mechanisms that can carry other mechanisms.

    Raises:
        ConfigError: A mechanism fails the check.
    """
    carriers = tuple(m.name for m in mechanisms.values() if m.joint is not None)
    for m in mechanisms.values():
        table = Table({}, f"{where} [[mechanism]] {m.name!r}")
        seen = [m.name]
        on = m.on
        while on is not None:
            if on not in carriers:
                known = f"those of the file are {', '.join(carriers)}" if carriers else "there is none in the file"
                raise table.error("on", f"must name an arm, a turret, an elevator or a rack, got {on!r}; {known}")
            if on in seen:
                raise table.error("on", f"forms a loop: {' on '.join([*seen, on])}")
            seen.append(on)
            on = mechanisms[on].on
    return carriers


def joints_to(name: str | None, mechanisms: Mapping[str, MechanismSettings]) -> tuple[Joint, ...]:
    """Return the joints from the robot frame to the frame that a mechanism moves; empty if the name is None."""
    chain: list[Joint] = []
    while name is not None:
        m = mechanisms[name]
        assert m.joint is not None
        chain.insert(0, m.joint)
        name = m.on
    return tuple(chain)
