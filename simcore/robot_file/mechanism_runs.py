"""Each mechanism of a robot for a second with full positive output: which way it goes, how fast, and where it ends."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import (
    ArmConfig,
    ArmSim,
    ElevatorConfig,
    ElevatorSim,
    FlywheelConfig,
    RackConfig,
    RackSim,
    RollerConfig,
    ShaftSim,
)  # fmt: skip
from simcore.robot.robot_config import MechanismConfig, build_mechanism
from simcore.units import inches

__all__ = [
    "VOLTS",
    "CodeView",
    "MechanismRun",
    "holding_share",
    "place_text",
    "reading_unit",
    "run_mechanism",
    "speed_text",
    "with_limits",
]

VOLTS, SECONDS, _STEP = 12.0, 1.0, 0.002


@dataclass(frozen=True, slots=True, kw_only=True)
class CodeView:
    """What the configuration of a motor controller makes of a mechanism's motion."""

    clockwise: bool = False
    """Whether it is configured `CLOCKWISE_POSITIVE`."""
    ratio: float = 1.0
    """Rotor turns per turn that robot code reads [-]."""
    reading: float | None = None
    """Position that it reads at first [turns]; None: an encoder's, which is not known before the robot stands."""
    lower_limit: float | None = None
    """Reverse soft limit [turns], if it is on."""
    upper_limit: float | None = None
    """Forward soft limit [turns], if it is on."""
    stator_limit: float = math.inf
    """[A]"""
    supply_limit: float = math.inf
    """[A]"""


@dataclass(frozen=True, slots=True, kw_only=True)
class MechanismRun:
    """A second of a mechanism with full output of its motor controller."""

    name: str
    mechanism: ShaftSim
    """As it is after it."""
    sign: float
    """+1 if it goes in its positive direction, -1 if not [-]."""
    speed: float
    """Largest on the way, without sign [rad/s]."""
    travel: float
    """From where it started, with sign [rad]."""
    position: float
    """Where it ended [rad]."""
    spin_up: float
    """Time until 95 % of that speed [s]."""
    is_rising: bool
    """Whether it was still getting faster by more than 5 % in the last tenth of the time."""
    stop: float | None
    """When it reached a hard stop [s]; None: it did not."""
    soft_limit: float | None = None
    """When its controller stopped it at a soft limit [s]; None: it did not."""
    read: tuple[float, float] | None = None
    """Position that robot code reads before and after it [turns]; None: nobody looked at the program."""
    code: CodeView | None = None


def with_limits(config: MechanismConfig, code: CodeView | None) -> MechanismConfig:
    """The mechanism behind the current limits that robot code has configured."""
    if code is None or not isinstance(config, FlywheelConfig | RollerConfig | ArmConfig | ElevatorConfig | RackConfig):
        return config
    box = config.gearbox
    limited: GearboxConfig = replace(
        box,
        stator_current_limit=min(box.stator_current_limit, code.stator_limit),
        supply_current_limit=min(box.supply_current_limit, code.supply_limit),
    )
    return replace(config, gearbox=limited)


def run_mechanism(
    name: str,
    config: MechanismConfig,
    *,
    code: CodeView | None = None,
    reversed: bool = False,
    output: float = 1.0,
) -> MechanismRun:
    """Run one from where it starts; it stops where it meets a stop, or a soft limit of its controller.

    Args:
        name: Of the mechanism.
        config: Its masses and gears.
        code: How robot code has configured its controller; None: not known.
        reversed: Whether positive in robot code is negative for the mechanism.
        output: +1 or -1: full output that way.
    """
    mechanism = build_mechanism(with_limits(config, code))
    turned = -1.0 if reversed else 1.0
    sign = turned * output
    start = mechanism.position
    limit = None if code is None else _soft_limit(code, mechanism, turned, output)
    speeds = []
    stop = soft = None
    for step in range(1, round(SECONDS / _STEP) + 1):
        blocked = limit is not None and sign * (mechanism.position - limit) >= 0.0
        if blocked and soft is None:
            soft = (step - 1) * _STEP
        mechanism.set_volts(0.0 if blocked else sign * VOLTS)
        mechanism.step(_STEP, VOLTS)
        speeds.append(abs(mechanism.velocity))
        at_stop = mechanism.position in mechanism.stops and mechanism.velocity == 0.0
        if at_stop and stop is None and not blocked:
            stop = step * _STEP
    top = max(speeds)
    spin_up = next((k for k, speed in enumerate(speeds, 1) if speed >= 0.95 * top), 0) * _STEP
    read = None
    if code is not None:
        turns = turned * (mechanism.position - start) / math.tau * mechanism.gearing / code.ratio
        before = 0.0 if code.reading is None else code.reading
        read = (before, before + turns)
    return MechanismRun(
        name=name,
        mechanism=mechanism,
        sign=sign,
        speed=top,
        travel=mechanism.position - start,
        position=mechanism.position,
        spin_up=spin_up,
        is_rising=speeds[-1] > 1.05 * speeds[round(0.9 * len(speeds)) - 1],
        stop=stop,
        soft_limit=soft,
        read=read,
        code=code,
    )


def holding_share(config: MechanismConfig) -> float:
    """Largest load of its own weight over what the motors hold at 12 V and their current limits [-]; 0 without one."""
    if isinstance(config, ArmConfig):
        low, high = config.min_angle, config.max_angle
        level = any(low <= turn * math.pi <= high for turn in range(math.ceil(low / math.pi), 3 + int(high / math.pi)))
        most = 1.0 if level else max(abs(math.cos(low)), abs(math.cos(high)))
        load = config.mass * config.gravity * abs(config.center_of_mass) * most
    elif isinstance(config, ElevatorConfig):
        load = config.carriage_mass * config.gravity * config.drum_radius
    else:
        return 0.0
    return load / (config.gearbox.stall_torque(VOLTS) + config.gearbox.friction_torque)


def _soft_limit(code: CodeView, mechanism: ShaftSim, turned: float, output: float) -> float | None:
    """Where a soft limit stops the mechanism [rad]; None: it is off, or what it counts from is not known."""
    limit = code.upper_limit if output > 0.0 else code.lower_limit
    if limit is None or code.reading is None:
        return None
    return mechanism.position + turned * (limit - code.reading) * code.ratio / mechanism.gearing * math.tau


def reading_unit(mechanism: ShaftSim, code: CodeView) -> str | None:
    """Unit of the positions that robot code reads, by what its controller makes of a turn of the mechanism.

    Returns:
        E.g. "turns", or "m" where the ratio has the drum in it; None: it is none of the usual ones.
    """
    per_turn = mechanism.gearing / code.ratio
    units = {"turns": 1.0}
    if isinstance(mechanism, ElevatorSim | RackSim):
        way = math.tau * mechanism.travel_per_radian
        units |= {"m": way, "in": way / inches(1.0)}
    else:
        units |= {"deg": 360.0, "rad": math.tau}
    return next((unit for unit, value in units.items() if math.isclose(per_turn, value, rel_tol=0.01)), None)


def speed_text(mechanism: ShaftSim, speed: float) -> str:
    """A speed [rad/s] in the unit that its kind is thought of in."""
    if isinstance(mechanism, ArmSim):
        return f"{math.degrees(speed):.0f} deg/s"
    if isinstance(mechanism, ElevatorSim | RackSim):
        return f"{speed * mechanism.travel_per_radian:.2f} m/s"
    return f"{speed / math.tau:.1f} turns/s"


def place_text(mechanism: ShaftSim, position: float) -> str:
    """A position [rad] in the unit that its kind is thought of in."""
    if isinstance(mechanism, ArmSim):
        return f"{math.degrees(position):.0f} deg"
    if isinstance(mechanism, ElevatorSim | RackSim):
        return f"{position * mechanism.travel_per_radian:.2f} m"
    return f"{position / math.tau:.1f} turns"
