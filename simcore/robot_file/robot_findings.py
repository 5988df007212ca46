"""What cannot be right about a described robot: places, speeds, holding torques, and how its program differs."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from simcore.geometry.footprints import box_corners
from simcore.geometry.linkage import part_pose
from simcore.geometry.rotation import rotate
from simcore.geometry.zones import BoxZone, CylinderZone, Zone
from simcore.pieces.intake import Intake, IntakeConfig
from simcore.pieces.launch import muzzle_offset
from simcore.pieces.shooter import ShooterConfig
from simcore.robot.mechanisms import ArmConfig, ElevatorConfig
from simcore.robot.robot_config import RobotConfig, build_mechanism
from simcore.robot.shaft import ShaftSim
from simcore.robot.tipping import stored_kind
from simcore.robot_file.known_shot import elevations
from simcore.robot_file.mechanism_runs import VOLTS, CodeView, MechanismRun, holding_share, reading_unit, with_limits
from simcore.typing import FloatArray
from simcore.units import GRAVITY

if TYPE_CHECKING:
    from simcore.match.game import Game

__all__ = ["RobotFinding", "ShotReach", "findings", "intake_zone", "run_findings", "shot_reach"]

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
    yield from _of_storages(config, game)
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
    yield from _of_climbers(config, game)


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
        if code is None:
            continue
        if code.upper_limit is not None and code.lower_limit is not None and code.upper_limit <= code.lower_limit:
            yield RobotFinding(
                f"{run.name}: its forward soft limit ({code.upper_limit:g}) is not above its reverse one "
                f"({code.lower_limit:g}): it cannot move"
            )
        elif run.soft_limit is not None and abs(run.travel) < 1e-9 and code.reading is not None:
            yield RobotFinding(
                f"{run.name} starts beyond its forward soft limit: the code reads {code.reading:.3g} turns and allows "
                f"{code.upper_limit:g}",
                is_wrong=False,
            )
        turns = run.mechanism.gearing / code.ratio
        if code.ratio != 1.0 and reading_unit(run.mechanism, code) is None:
            yield RobotFinding(
                f"{run.name}: gearing = {run.mechanism.gearing:g} in the file, but the program divides the "
                f"rotor's turns by {code.ratio:g}: it reads {turns:.3g} turns per turn of the mechanism",
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
    lowest, highest = (math.degrees(angle) for angle in reach.elevations)
    if highest > 120.0 or lowest < -30.0:
        yield RobotFinding(
            f"{name} shoots at {lowest:.0f} to {highest:.0f} deg over the hood's travel: look at elevation_deg and the "
            "sign of elevation_per_hood"
        )
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


def _of_storages(config: RobotConfig, game: Game | None) -> Iterator[RobotFinding]:
    for storage in (config.storage, *config.more_storages):
        kind = stored_kind(config, storage, () if game is None else [supply.kind for supply in game.pieces])
        if kind is None:
            continue
        name = f"storage{f' {storage.name!r}' if storage.name else ''}"
        is_ball = kind.inner_radius == kind.bounding_radius
        if storage.hopper is not None:
            wide = storage.hopper.outlet_width / (2.0 * kind.bounding_radius)
            if min(wide, (storage.hopper.outlet_height or math.inf) / (2.0 * kind.bounding_radius)) < 1.0:
                ball = "" if is_ball else f", which counts as a ball of {2.0 * kind.bounding_radius:.2f} m in it"
                yield RobotFinding(f"{name}: its outlet is smaller than a {kind.name}{ball}: none comes out")
            elif wide < 2.0 and storage.capacity > 1:
                text = f"{name}: its outlet is {wide:.1f} {kind.name} wide: below 2 two of them can jam it"
                yield RobotFinding(text, is_wrong=False)
        if not is_ball:  # other shapes stack in their own ways
            continue
        most = storage.balls_that_fit(kind.bounding_radius)
        if most < storage.capacity:
            x, y, z = (high - low for low, high in zip(storage.low, storage.high, strict=True))
            rest = "they are drawn into one another" if storage.hopper is None else "intakes leave the rest"
            yield RobotFinding(
                f"{name}: {storage.capacity} {kind.name} do not fit in its room of {x:.2f} x {y:.2f} x {z:.2f} m, "
                f"{most} do; {rest}. "
                f"Give it the size that the robot has (x_min to z_max), or a capacity of {most}",
                is_wrong=False,
            )


def _of_climbers(config: RobotConfig, game: Game | None) -> Iterator[RobotFinding]:
    if not config.climbers:
        return
    rungs = () if game is None else game.field.rungs
    if game is not None and not rungs:
        yield RobotFinding(f"a climber finds nothing in {game.heading}: its field has no rungs", is_wrong=False)
    for number, climber in enumerate(config.climbers, 1):
        last = climber.joints[-1].mechanism
        heights = []
        for position in build_mechanism(config.mechanisms[last]).stops:
            mechanisms = {name: build_mechanism(one) for name, one in config.mechanisms.items()}
            mechanisms[last].reset(position)
            heights.append(part_pose(climber.joints, mechanisms, climber.offset)[0][2])
        lowest = min((min(rung.start[2], rung.end[2]) for rung in rungs), default=None)
        if lowest is not None and max(heights) < lowest:
            yield RobotFinding(
                f"climber {number} reaches no rung: its hook comes to {max(heights):.2f} m, and the lowest rung is at "
                f"{lowest:.2f} m"
            )
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
