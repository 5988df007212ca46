"""What `simcore check` finds: a second of each mechanism, and what cannot be right about a described robot.

Each mechanism gets full positive output from where it starts: which way it goes, how fast, and where it ends.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from simcore.geometry.footprints import box_corners
from simcore.geometry.linkage import part_pose
from simcore.geometry.rotation import rotate
from simcore.geometry.zones import BoxZone, CylinderZone, Zone
from simcore.pieces.intake import Intake, IntakeConfig
from simcore.pieces.launch import muzzle_offset
from simcore.pieces.shooter import ShooterConfig
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
)
from simcore.robot.robot_config import MechanismConfig, RobotConfig, build_mechanism
from simcore.robot_file.known_shot import elevations
from simcore.typing import FloatArray
from simcore.units import GRAVITY, inches

if TYPE_CHECKING:
    from simcore.match.game import Game

__all__ = [
    "CodeView", "MechanismRun", "RobotFinding", "ShotReach", "findings", "intake_zone", "reading_unit",
    "run_findings", "run_mechanism", "shot_reach", "sign_findings", "speed_text",
]  # fmt: skip

_FAR = 0.5  # [m]; beyond the bumpers. 2026 robots may extend by 0.305 m
_HARD = 0.7  # [-]; share of what the motors can hold
_LEAST_WAY = math.radians(10.0)  # of an arm or a turret
_SLOW = 5.0  # [s]
_NO_PIECE = 0.0  # [m]; radius where the game is not known


@dataclass(frozen=True, slots=True)
class RobotFinding:
    """One sentence."""

    text: str
    is_wrong: bool = True
    """Whether it cannot be meant; otherwise it is worth knowing."""


@dataclass(frozen=True, slots=True)
class ShotReach:
    """What a shooter can do at best: wheels at their free speed at 12 V, no air."""

    speed: float
    """Of the piece [m/s]."""
    elevations: tuple[float, float]
    """Lowest and highest that the hood gives [rad]."""
    rise: float
    """Highest place of a shot above the floor [m]."""
    distance: float
    """Farthest place at the muzzle's height [m]."""


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
        load = abs(config.weight_torque) * most
    elif isinstance(config, ElevatorConfig):
        load = abs(config.weight_torque)
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


# --- findings ---------------------------------------------------------------------------------------------------------


def findings(config: RobotConfig, *, game: Game | None, codes: Mapping[str, CodeView]) -> Iterator[RobotFinding]:
    """All of them.

    Args:
        config: The robot.
        game: That it plays; None: pieces and field are not known.
        codes: How robot code has configured the controllers of mechanisms, by the mechanisms' names.
    """
    for number, intake in enumerate(config.intakes, 1):
        yield from _of_intake(f"intake {number}", intake, config, game)
    for number, shooter in enumerate(config.shooters, 1):
        yield from _of_shooter(f"shooter {number}", shooter, config, game)
    if game is not None and game.pieces and not config.intakes:
        yield RobotFinding("no [[intake]] is described: pieces are pushed, not taken in", is_wrong=False)
    for name, mechanism in config.mechanisms.items():
        code = codes.get(name)
        if isinstance(mechanism, ArmConfig) and (way := mechanism.max_angle - mechanism.min_angle) < _LEAST_WAY:
            low, high = (math.degrees(math.degrees(angle)) for angle in (mechanism.min_angle, mechanism.max_angle))
            yield RobotFinding(
                f"{name} has only {math.degrees(way):.2g} deg of way; stops are in degrees: if they were meant in "
                f"radians, min_deg = {low:.0f} and max_deg = {high:.0f}",
                is_wrong=False,
            )
        share = holding_share(with_limits(mechanism, code))
        if share > 1.0:
            yield RobotFinding(
                f"{name} cannot hold itself: its weight needs {share:.1f} times what its motors give"
                f"{_at_limit(build_mechanism(with_limits(mechanism, code)).gearbox.stator_current_limit)}"
            )
        elif share > _HARD:
            text = f"{name} holds its weight with {100 * share:.0f} % of what its motors can give"
            yield RobotFinding(text, is_wrong=False)
    yield from _of_climbers(config)


def intake_zone(intake: IntakeConfig, config: RobotConfig) -> tuple[FloatArray, FloatArray]:
    """Smallest and largest corner of an intake's zone while it is out, wherever else it can be, robot frame [m]."""
    mechanisms = {name: build_mechanism(one) for name, one in config.mechanisms.items()}
    if intake.deploy is not None:
        low, high = mechanisms[intake.deploy].stops
        mechanisms[intake.deploy].reset(high if intake.deployed_at == "upper" else low)
    carriers = [joint.mechanism for joint in (*intake.joints, *([intake.stretch] if intake.stretch else []))]
    free = [name for name in dict.fromkeys(carriers) if name != intake.deploy]
    corners = []
    for positions in itertools.product(*(mechanisms[name].stops for name in free)):
        for name, position in zip(free, positions, strict=True):
            mechanisms[name].reset(position if math.isfinite(position) else 0.0)
        zone = Intake(intake, mechanisms).zone
        pos, quat = part_pose(intake.joints, mechanisms)
        box = box_corners((zone.x_min, zone.y_min, zone.z_min), (zone.x_max, zone.y_max, zone.z_max))
        corners += [np.add(pos, rotate(quat, corner)) for corner in box]
    return np.min(corners, axis=0), np.max(corners, axis=0)


def shot_reach(shooter: ShooterConfig, config: RobotConfig) -> ShotReach:
    """What a shooter can do at best."""
    speed = shooter.exit_speed(_free_speeds(shooter, config))
    steps = np.linspace(*elevations(shooter, config), 46)
    rise = shooter.launch.height + float(np.max(np.clip(speed * np.sin(steps), 0.0, None) ** 2)) / (2.0 * GRAVITY)
    distance = speed * speed * float(np.max(np.abs(np.sin(2.0 * steps)))) / GRAVITY
    return ShotReach(speed, (float(steps[0]), float(steps[-1])), rise, distance)


def run_findings(runs: Sequence[MechanismRun]) -> Iterator[RobotFinding]:
    """What the second of each mechanism shows, and how its program is configured."""
    for run in runs:
        box = run.mechanism.gearbox
        full_speed = 3.0 * run.mechanism.inertia * box.resistance / (box.torque_per_amp * box.volts_per_speed)
        if full_speed > _SLOW:
            yield RobotFinding(
                f"{run.name} takes {full_speed:.0f} s to its full speed: look at inertia ({run.mechanism.inertia:g} kg "
                f"m^2) and gearing ({run.mechanism.gearing:g})",
                is_wrong=False,
            )
        code = run.code
        if code is not None and code.ratio != 1.0 and reading_unit(run.mechanism, code) is None:
            turns = run.mechanism.gearing / code.ratio
            yield RobotFinding(
                f"{run.name}: gearing = {run.mechanism.gearing:g} in the file, but the program divides the rotor's "
                f"turns by {code.ratio:g}: it reads {turns:.3g} turns per turn of the mechanism",
                is_wrong=False,
            )


def sign_findings(
    runs: Sequence[tuple[MechanismRun, MechanismRun | None]], intakes: Sequence[IntakeConfig]
) -> Iterator[RobotFinding]:
    """Where robot code and mechanism may not share a sign: by its soft limits, and by how an intake gets out.

    Args:
        runs: Of each mechanism a second forward, and one backward where forward it had nowhere to go.
        intakes: Of the robot.
    """
    for forward, backward in runs:
        run = backward or forward
        if run.read is None or run.code is None:
            continue
        before, after = run.read
        if backward is not None and backward.soft_limit is not None and not backward.travel:
            limits = [f"{limit:.3g}" for limit in (run.code.lower_limit, run.code.upper_limit) if limit is not None]
            yield RobotFinding(
                f"{run.name} goes neither way from where it starts: forward is its stop, backward the soft limit of "
                f"robot code ({' to '.join(limits)} turns): does your code count the other way? write, or take out, "
                "reversed = true"
            )
        for number, intake in enumerate(intakes, 1):
            out = 1.0 if intake.deployed_at == "upper" else -1.0
            if intake.deploy == run.name and run.travel * out > 0.0 and after < before:
                yield RobotFinding(
                    f"intake {number}: {run.name} is out at its {intake.deployed_at} stop, and on the way there robot "
                    f"code reads {before:.2f} to {after:.2f} turns: if your code counts up as it goes out, write "
                    "reversed = true",
                    is_wrong=False,
                )


def _of_intake(name: str, intake: IntakeConfig, config: RobotConfig, game: Game | None) -> Iterator[RobotFinding]:
    low, high = intake_zone(intake, config)
    kinds = [] if game is None else [s.kind for s in game.pieces if not intake.kinds or s.kind.name in intake.kinds]
    body = config.body
    beyond = max(high[0] - 0.5 * body.bumper_length, -low[0] - 0.5 * body.bumper_length,
                 high[1] - 0.5 * body.bumper_width, -low[1] - 0.5 * body.bumper_width)  # fmt: skip
    if low[2] < body.bumper_top:
        radius = min((kind.inner_radius for kind in kinds), default=_NO_PIECE)
        if beyond <= 0.0:
            yield RobotFinding(f"{name} is inside of the bumpers, which no piece passes: move its zone out")
        elif beyond < radius:
            yield RobotFinding(
                f"{name} ends {1000 * beyond:.0f} mm before the bumpers; the middle of a piece that touches them is "
                f"{1000 * radius:.0f} mm before them"
            )
    if beyond > _FAR:
        yield RobotFinding(f"{name} reaches {beyond:.2f} m beyond the bumpers", is_wrong=False)
    lowest = min((kind.rest_height for kind in kinds), default=0.0)
    if high[2] < lowest:
        yield RobotFinding(
            f"{name} ends {high[2]:.2f} m above the floor; the middle of a piece there is at {lowest:.3f} m"
        )


def _of_shooter(name: str, shooter: ShooterConfig, config: RobotConfig, game: Game | None) -> Iterator[RobotFinding]:
    body, launch = config.body, shooter.launch
    mechanisms = {mechanism: build_mechanism(one) for mechanism, one in config.mechanisms.items()}
    places = np.array(
        [
            muzzle_offset(launch, barrel, angle)
            for barrel in range(len(launch.barrels))
            for angle in _turret_angles(shooter, mechanisms)
        ]
    )
    out = np.abs(places[:, :2]) - (0.5 * body.bumper_length, 0.5 * body.bumper_width)
    worst = int(np.argmax(out.max(axis=1)))
    if out[worst].max() > 0.0:
        x, y, _ = places[worst]
        yield RobotFinding(
            f"{name}: its muzzle is {1000 * out[worst].max():.0f} mm outside of the robot, at ({x:.2f}, {y:.2f}) m"
        )
    reach = shot_reach(shooter, config)
    wheels = _free_speeds(shooter, config)
    mean = 0.5 * (wheels[0] + wheels[-1])
    if mean < shooter.min_wheel_speed:
        yield RobotFinding(
            f"{name} never throws: its wheels turn {mean / math.tau:.1f} times a second at 12 V, and pieces leave "
            f"above {shooter.min_wheel_speed / math.tau:g}"
        )
        return
    goals = [] if game is None else [
        zone for zone in game.zones
        if not zone.kinds or not shooter.kinds or set(zone.kinds) & set(shooter.kinds)
    ]  # fmt: skip
    if goals and all(_entry(goal.zone, downward=goal.downward) > reach.rise for goal in goals):
        goal = min(goals, key=lambda goal: _entry(goal.zone, downward=goal.downward))
        yield RobotFinding(
            f"{name} reaches nothing: at 12 V pieces leave at {reach.speed:.1f} m/s and rise to {reach.rise:.2f} m; "
            f"{goal.name} begins at {_entry(goal.zone, downward=goal.downward):.2f} m"
        )


def _free_speeds(shooter: ShooterConfig, config: RobotConfig) -> list[float]:
    """Of each wheel at 12 V [rad/s]."""
    return [build_mechanism(config.mechanisms[name]).gearbox.free_speed(VOLTS) for name in shooter.wheels]


def _turret_angles(shooter: ShooterConfig, mechanisms: Mapping[str, ShaftSim]) -> list[float]:
    if shooter.turret is None:
        return [0.0]
    low, high = mechanisms[shooter.turret].stops
    if not math.isfinite(high - low):
        low, high = -math.pi, math.pi
    angles: list[float] = np.linspace(shooter.turret_ratio * low, shooter.turret_ratio * high, 73).tolist()
    return angles


def _entry(zone: Zone, *, downward: bool) -> float:
    """How high a piece must rise to score in a zone [m]: to its top, if only falling pieces count."""
    if downward and isinstance(zone, CylinderZone):
        return zone.top
    return zone.high[2] if downward and isinstance(zone, BoxZone) else zone.bottom


def _of_climbers(config: RobotConfig) -> Iterator[RobotFinding]:
    for number, climber in enumerate(config.climbers, 1):
        last = climber.joints[-1].mechanism
        mechanism = config.mechanisms[last]
        if isinstance(mechanism, ElevatorConfig):
            pull = mechanism.gearbox.stall_torque(VOLTS) / mechanism.drum_radius
            weight = config.drivetrain.mass * GRAVITY / len(config.climbers)
            if pull < weight:
                yield RobotFinding(
                    f"climber {number} cannot lift the robot: {last} pulls with {pull:.0f} N, and the robot's weight"
                    f" (its share of it) is {weight:.0f} N"
                )


def _at_limit(amps: float) -> str:
    return "" if math.isinf(amps) else f" at their limit of {amps:g} A"
