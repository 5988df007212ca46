"""Findings of `simcore check`: a test run of each mechanism, and mistakes in the description of a robot.

A test run applies full output to a mechanism at the start position for one second. The result is the direction, the
speed and the end of the motion.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from simcore.pieces.launch import muzzle_offset
from simcore.robot.intake import Intake, IntakeConfig
from simcore.robot.mechanisms import (
    ArmConfig,
    ArmSim,
    ElevatorConfig,
    ElevatorSim,
    PistonConfig,
    RackSim,
    ServoConfig,
    ShaftSim,
)
from simcore.robot.robot_config import MechanismConfig, RobotConfig, build_mechanism
from simcore.robot.shooter import ShooterConfig
from simcore.robot_file.needed_speeds import goal_of, needed_speeds
from simcore.typing import FloatArray
from simcore.units import GRAVITY, inches
from simcore.world.footprints import box_corners
from simcore.world.linkage import part_pose
from simcore.world.rotation import rotate

if TYPE_CHECKING:
    from simcore.match.game import Game

__all__ = [
    "CodeView", "MechanismRun", "RobotFinding", "findings", "intake_zone", "reading_unit", "run_findings",
    "run_mechanism", "speed_text", "top_exit_speed",
]  # fmt: skip

_FAR = 0.5  # [m] beyond the bumpers; 2026 robots may extend by 0.305 m
_HARD = 0.7  # [-], fraction of the load that the motors can hold
_LEAST_WAY = math.radians(10.0)  # [rad], smallest plausible travel of an arm or a turret
_SLOW = 5.0  # [s], longest plausible time to full speed


@dataclass(frozen=True, slots=True)
class RobotFinding:
    """Mistake in the description of a robot, or note about the description."""

    text: str
    is_wrong: bool = True
    """Whether the finding is certainly a mistake; False for a note."""


_note = partial(RobotFinding, is_wrong=False)


VOLTS, SECONDS, _STEP = 12.0, 1.0, 0.002


@dataclass(frozen=True, slots=True, kw_only=True)
class CodeView:
    """Configuration of a motor controller in robot code that affects a mechanism's motion."""

    clockwise: bool = False
    """Whether the controller is configured `CLOCKWISE_POSITIVE`."""
    ratio: float = 1.0
    """Rotor turns per turn of the position in robot code [-]."""
    reading: float | None = None
    """Initial position in robot code [turns]; None if an absolute encoder gives the position at the start."""
    lower_limit: float | None = None
    """Reverse soft limit [turns]; None if the limit is disabled."""
    upper_limit: float | None = None
    """Forward soft limit [turns]; None if the limit is disabled."""
    stator_limit: float = math.inf
    """Stator current limit [A]; infinite for no limit."""
    supply_limit: float = math.inf
    """Supply current limit [A]; infinite for no limit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MechanismRun:
    """Result of a test run of a mechanism: one second at full output of the motor controller."""

    name: str
    mechanism: ShaftSim
    """Mechanism at the end of the run."""
    sign: float
    """Sign of the voltage at the mechanism: +1 for the mechanism's positive direction, else -1 [-]."""
    speed: float
    """Largest absolute speed in the run [rad/s]."""
    travel: float
    """Final minus initial position [rad]."""
    position: float
    """Final position [rad]."""
    spin_up: float
    """Time from the start until 95 % of the largest speed [s]."""
    is_rising: bool
    """Whether the speed rose by more than 5 % in the last tenth of the run."""
    stop: float | None
    """Time at which the mechanism reached a hard stop [s]; None if the mechanism reached no hard stop."""
    soft_limit: float | None = None
    """Time at which the mechanism reached a soft limit [s]; None if the mechanism reached no soft limit."""
    read: tuple[float, float] | None = None
    """Position in robot code at the start and the end of the run [turns]; None if `code` is None."""
    code: CodeView | None = None


def with_limits(config: MechanismConfig, code: CodeView | None) -> MechanismConfig:
    """Return a copy of a config whose current limits are the lower of the config's and robot code's limits."""
    if code is None or isinstance(config, PistonConfig | ServoConfig):
        return config
    box = config.gearbox
    stator = min(box.stator_current_limit, code.stator_limit)
    supply = min(box.supply_current_limit, code.supply_limit)
    return replace(config, gearbox=replace(box, stator_current_limit=stator, supply_current_limit=supply))


def run_mechanism(
    name: str,
    config: MechanismConfig,
    *,
    code: CodeView | None = None,
    reversed: bool = False,
    output: float = 1.0,
) -> MechanismRun:
    """Apply 12 V to a mechanism at the start position for one second, and return the result.

    The voltage is 0 at a soft limit of robot code.

    Args:
        name: Name of the mechanism.
        config: Config of the mechanism.
        code: Configuration of the controller in robot code; None if the configuration is unknown.
        reversed: Whether the positive direction in robot code is the negative direction of the mechanism.
        output: Sign of the full output in robot code: +1 or -1 [-].
    """
    mechanism = build_mechanism(with_limits(config, code))
    turned = -1.0 if reversed else 1.0
    sign = turned * output
    start = mechanism.position
    limit = None if code is None else _soft_limit(code, mechanism, turned, output)
    speeds: list[float] = []
    held: list[float] = []  # times at a soft limit [s]; `stopped` has the times at a hard stop
    stopped: list[float] = []
    for time in np.arange(round(SECONDS / _STEP)) * _STEP:
        is_held = limit is not None and sign * (mechanism.position - limit) >= 0.0
        mechanism.set_volts(0.0 if is_held else sign * VOLTS)
        mechanism.step(_STEP, VOLTS)
        speeds.append(abs(mechanism.velocity))
        if is_held:
            held.append(float(time))
        elif mechanism.position in mechanism.stops and mechanism.velocity == 0.0:
            stopped.append(float(time) + _STEP)
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
        stop=stopped[0] if stopped else None,
        soft_limit=held[0] if held else None,
        read=read,
        code=code,
    )


def holding_share(config: MechanismConfig) -> float:
    """Return the largest gravity torque over stall torque at 12 V plus friction torque [-]; 0 without weight.

    The largest gravity torque is that of the arm's angle nearest to the horizontal between the stops.
    """
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
    """Return the position at which a soft limit stops the mechanism [rad]; None if the limit is off or unknown."""
    limit = code.upper_limit if output > 0.0 else code.lower_limit
    if limit is None or code.reading is None:
        return None
    return mechanism.position + turned * (limit - code.reading) * code.ratio / mechanism.gearing * math.tau


def reading_unit(mechanism: ShaftSim, code: CodeView) -> str | None:
    """Return the unit of positions in robot code that follows from the ratio in the controller.

    Returns:
        "turns", "deg", "rad", "m" or "in" for a ratio within 1 % of this unit; None for any other ratio.
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
    """Format the speed of a mechanism [rad/s] in deg/s for an arm, m/s for an elevator or rack, else turns/s."""
    if isinstance(mechanism, ArmSim):
        return f"{math.degrees(speed):.0f} deg/s"
    if isinstance(mechanism, ElevatorSim | RackSim):
        return f"{speed * mechanism.travel_per_radian:.2f} m/s"
    return f"{speed / math.tau:.1f} turns/s"


# --- findings ---------------------------------------------------------------------------------------------------------


def findings(config: RobotConfig, *, game: Game | None, codes: Mapping[str, CodeView]) -> Iterator[RobotFinding]:
    """Yield mistakes and notes about the intakes, shooters, mechanisms and climbers of a robot.

    Args:
        config: Robot to check.
        game: Game that the robot plays; None if pieces and field are unknown.
        codes: Configurations of the controllers in robot code, by name of the mechanism.
    """
    for number, intake in enumerate(config.intakes, 1):
        yield from _intake_findings(f"intake {number}", intake, config, game)
    for number, shooter in enumerate(config.shooters, 1):
        yield from _shooter_findings(f"shooter {number}", shooter, config, game)
    if game is not None and game.pieces and not config.intakes:
        yield _note("no [[intake]] is described: pieces are pushed, not taken in")
    for name, mechanism in config.mechanisms.items():
        yield from _mechanism_findings(name, with_limits(mechanism, codes.get(name)))
    for number, climber in enumerate(config.climbers, 1):
        lift = config.mechanisms[climber.joints[-1].mechanism]
        if not isinstance(lift, ElevatorConfig):
            continue
        pull = lift.gearbox.stall_torque(VOLTS) / lift.drum_radius
        weight = config.drivetrain.mass * GRAVITY / len(config.climbers)
        if pull < weight:
            yield RobotFinding(
                f"climber {number} cannot lift the robot: {climber.joints[-1].mechanism} pulls with {pull:.0f} N, and "
                f"its share of the robot's weight is {weight:.0f} N"
            )


def _mechanism_findings(name: str, config: MechanismConfig) -> Iterator[RobotFinding]:
    """Yield findings about the stops and the weight of a mechanism."""
    if isinstance(config, ArmConfig) and (way := config.max_angle - config.min_angle) < _LEAST_WAY:
        low, high = (math.degrees(math.degrees(angle)) for angle in (config.min_angle, config.max_angle))
        yield _note(
            f"{name} moves only {math.degrees(way):.2g} deg: min_deg and max_deg are degrees; from radians they would "
            f"be min_deg = {low:.0f} and max_deg = {high:.0f}"
        )
    share = holding_share(config)
    if share > 1.0:
        amps = build_mechanism(config).gearbox.stator_current_limit
        limit = "" if math.isinf(amps) else f" at their limit of {amps:g} A"
        yield RobotFinding(f"{name} cannot hold itself: its weight needs {share:.1f} times what its motors give{limit}")
    elif share > _HARD:
        yield _note(f"{name} needs {100 * share:.0f} % of what its motors can give to hold its weight")


def intake_zone(intake: IntakeConfig, config: RobotConfig) -> tuple[FloatArray, FloatArray]:
    """Return the lowest and highest corner of the box around a deployed intake's zone, robot frame [m].

    The box contains the zone at all stops of the mechanisms that carry the intake.
    """
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


def _intake_findings(name: str, intake: IntakeConfig, config: RobotConfig, game: Game | None) -> Iterator[RobotFinding]:
    """Yield findings about an intake that reaches no pieces, or reaches too far beyond the bumpers."""
    low, high = intake_zone(intake, config)
    kinds = [] if game is None else [s.kind for s in game.pieces if not intake.kinds or s.kind.name in intake.kinds]
    body = config.body
    half = np.array((0.5 * body.bumper_length, 0.5 * body.bumper_width))
    beyond = float(np.max((high[:2] - half, -low[:2] - half)))
    if low[2] < body.bumper_top:
        radius = min((kind.inner_radius for kind in kinds), default=0.0)
        if beyond <= 0.0:
            yield RobotFinding(f"{name} is inside of the bumpers, which no piece passes: move its zone out")
        elif beyond < radius:
            yield RobotFinding(
                f"{name} ends {1000 * beyond:.0f} mm outside of the bumpers; the middle of a piece that touches them "
                f"is {1000 * radius:.0f} mm outside"
            )
    if beyond > _FAR:
        yield _note(f"{name} reaches {beyond:.2f} m beyond the bumpers")
    lowest = min((kind.rest_height for kind in kinds), default=0.0)
    if high[2] < lowest:
        yield RobotFinding(
            f"{name} ends {high[2]:.2f} m above the floor; the middle of a piece there is at {lowest:.3f} m"
        )


def top_exit_speed(shooter: ShooterConfig, config: RobotConfig) -> float:
    """Return the exit speed of a piece relative to the muzzle, with the wheels at their free speed at 12 V [m/s]."""
    return shooter.exit_speed(_free_speeds(shooter, config))


def _shooter_findings(
    name: str, shooter: ShooterConfig, config: RobotConfig, game: Game | None
) -> Iterator[RobotFinding]:
    """Yield findings about a shooter that has its muzzle outside the robot, cannot fire, or cannot reach the goal."""
    body, launch = config.body, shooter.launch
    places = np.array([muzzle_offset(launch, barrel) for barrel in range(len(launch.barrels))])
    out = np.abs(places[:, :2]) - (0.5 * body.bumper_length, 0.5 * body.bumper_width)
    worst = int(np.argmax(out.max(axis=1)))
    if out[worst].max() > 0.0:
        x, y, _ = places[worst]
        yield RobotFinding(
            f"{name}: its muzzle is {1000 * out[worst].max():.0f} mm outside of the robot, at ({x:.2f}, {y:.2f}) m"
        )
    wheels = _free_speeds(shooter, config)
    mean = 0.5 * (wheels[0] + wheels[-1])
    if mean < shooter.min_wheel_speed:
        yield RobotFinding(
            f"{name} never shoots: its wheels turn {mean / math.tau:.1f} times a second at 12 V, and pieces leave "
            f"above {shooter.min_wheel_speed / math.tau:g}"
        )
        return
    goal = None if game is None else goal_of(shooter, game)
    needs = [] if game is None or goal is None else needed_speeds(shooter, config, game)
    speed, least = top_exit_speed(shooter, config), min((need.speed for need in needs), default=0.0)
    if goal is not None and speed < least:
        yield RobotFinding(
            f"{name} does not reach {goal.name} from {needs[0].distance:g} m or more: at 12 V pieces leave at "
            f"{speed:.1f} m/s, and need {least:.1f} m/s"
        )


def _free_speeds(shooter: ShooterConfig, config: RobotConfig) -> list[float]:
    """Return the free speed of each wheel at 12 V [rad/s]."""
    return [build_mechanism(config.mechanisms[name]).gearbox.free_speed(VOLTS) for name in shooter.wheels]


def run_findings(runs: Sequence[tuple[MechanismRun, MechanismRun | None]]) -> Iterator[RobotFinding]:
    """Yield findings about the test runs of mechanisms and the configurations of their controllers.

    Args:
        runs: Forward run of each mechanism, and a backward run if the forward run started at a stop, else None.
    """
    for run, backward in runs:
        box, code, gearing = run.mechanism.gearbox, run.code, run.mechanism.gearing
        full_speed = 3.0 * run.mechanism.inertia * box.resistance / (box.torque_per_amp * box.volts_per_speed)
        if full_speed > _SLOW:
            yield _note(
                f"{run.name} takes {full_speed:.0f} s to reach full speed: look at inertia ({run.mechanism.inertia:g} "
                f"kg m^2) and gearing ({gearing:g})"
            )
        if code is None:
            continue
        if code.ratio != 1.0 and reading_unit(run.mechanism, code) is None:
            yield _note(
                f"{run.name}: gearing = {gearing:g} in the file, but the program divides the rotor's turns by "
                f"{code.ratio:g}: it reads {gearing / code.ratio:.3g} turns per turn of the mechanism"
            )
        if backward is not None and backward.soft_limit is not None and not backward.travel:
            limits = [f"{limit:.3g}" for limit in (code.lower_limit, code.upper_limit) if limit is not None]
            yield RobotFinding(
                f"{run.name} cannot move either way from where it starts: forward is its stop, backward the soft limit "
                f"of robot code ({' to '.join(limits)} turns): does your code count the other way? add or remove "
                "reversed = true"
            )
