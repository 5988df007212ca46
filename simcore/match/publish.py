"""What a tick looks like from outside: telemetry keys (docs/telemetry.md) from what match and robots have."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from simcore.geometry.rotation import matrix, multiply
from simcore.match.camera_rig import CameraRig
from simcore.match.game import PlayedMatch
from simcore.match.run_record import RobotRecord
from simcore.match.scoring import Alliance, Score
from simcore.match.starts import pose_text
from simcore.pieces.pool import PieceStatus
from simcore.robot.chassis import ground_clearance
from simcore.robot.mechanisms import ArmSim, ElevatorSim, PistonSim, RackSim
from simcore.robot.robot import Robot
from simcore.robot.robot_config import telemetry_name
from simcore.robot.swerve_drive import SwerveDrive
from simcore.telemetry.snapshot import Snapshot, robot_prefix
from simcore.typing import FloatArray, IntArray
from simcore.units import TICK

__all__ = ["build_snapshot"]

_DECIMALS = 6
"""Of the poses of robots and of what they carry [um, 1e-6], and of mechanisms: the engine holds a robot at rest to some
1e-9 m, and a log would take up every tick of it."""
_VOLT_DECIMALS = 3
"""Of the battery's voltage [mV], which comes back after a load for minutes."""


class PublishedMatch(PlayedMatch, Protocol):
    """Match as telemetry shows it."""

    cameras: CameraRig
    ticks: int
    """Ticks since the start."""
    last_tick_ms: float | None
    """Wall time of the last tick [ms], if somebody measures it."""

    @property
    def substeps(self) -> int:
        """Steps of the engine in the last tick."""

    @property
    def score(self) -> Score:
        """Points so far."""

    @property
    def score_counts(self) -> Mapping[str, int]:
        """Pieces that scored, by zone, and the rules' breakdown."""


@dataclass
class _Rows:
    """What a snapshot is made of."""

    poses: dict[str, FloatArray] = field(default_factory=dict)
    pose_arrays: dict[str, FloatArray] = field(default_factory=dict)
    doubles: dict[str, float] = field(default_factory=dict)
    integers: dict[str, int] = field(default_factory=dict)
    booleans: dict[str, bool] = field(default_factory=dict)
    integer_arrays: dict[str, IntArray] = field(default_factory=dict)
    state_arrays: dict[str, FloatArray] = field(default_factory=dict)
    strings: dict[str, str] = field(default_factory=dict)

    def add(self, key: str, value: float | int | bool | str) -> None:
        """Sort a value in by its type."""
        if isinstance(value, bool):
            self.booleans[key] = value
        elif isinstance(value, int):
            self.integers[key] = value
        elif isinstance(value, float):
            self.doubles[key] = value
        else:
            self.strings[key] = value


def build_snapshot(match: PublishedMatch) -> Snapshot:
    """The snapshot of the last tick. Keys without a number are of the first robot; others carry theirs."""
    rows = _Rows()
    _add_pieces(rows, match)
    _add_match(rows, match)
    if match.hanging:
        bodies = [(*body.pos, body.quat[3], *body.quat[:3]) for body in match.hanging]
        rows.pose_arrays["Sim/Hanging"] = _rounded(np.array(bodies))
    rows.pose_arrays |= {key: _rounded(line) for key, line in match.cameras.lines(match.robots).items()}
    for robot in match.robots:
        _add_robot(rows, robot, match.alliances[robot.number], match.record.robots[robot.number])
    for key, value in match.rules.telemetry().items():
        rows.add(key, value)
    return Snapshot(time=match.time, tick=match.ticks - 1, **vars(rows))


def _add_pieces(rows: _Rows, match: PublishedMatch) -> None:
    pieces = match.pieces
    flying = match.record.flying
    held, carried = _carried(match)
    kinds = pieces.state.kind[held]
    for number, supply in enumerate(match.game.pieces):
        name = supply.kind.name
        slots, here = pieces.shown.of(number)
        rows.pose_arrays[f"Sim/GamePieces/{name}"] = here
        rows.integer_arrays[f"Sim/PieceIds/{name}"] = slots
        in_flight, mine = _NO_POSES, _NO_IDS
        if len(flying):
            mine = _frozen_ids(flying[pieces.state.kind[flying] == number])
            in_flight = here[np.searchsorted(slots, mine)]  # a piece in flight is one of those here, which are in order
            in_flight.setflags(write=False)
        rows.pose_arrays[f"Sim/InFlight/{name}"] = in_flight
        rows.integer_arrays[f"Sim/InFlightIds/{name}"] = mine
        poses, ids = _NO_POSES, _NO_IDS
        if (inside := kinds == number).any():
            poses, ids = _rounded(carried[inside]), _frozen_ids(held[inside])
        rows.pose_arrays[f"Sim/Held/{name}"] = poses
        rows.integer_arrays[f"Sim/HeldIds/{name}"] = ids


def _carried(match: PublishedMatch) -> tuple[IntArray, FloatArray]:
    """Slots and poses of the pieces in robots, field frame, shape (n, 7)."""
    robots = [robot for robot in match.robots if robot.held]
    if not robots:
        return _NO_IDS, _NO_POSES
    inside = [robot.held_poses(match.pieces.radius) for robot in robots]
    counts, rows = [len(poses) for poses in inside], np.concatenate(inside)
    own = np.repeat([(*robot.chassis.pos, *robot.chassis.quat) for robot in robots], counts, axis=0).T
    w, x, y, z = rows[:, 3:].T
    x, y, z, w = multiply(tuple(own[3:]), (x, y, z, w))
    places = own[:3] + np.einsum("ijn,nj->in", matrix(own[3:]), rows[:, :3])
    return _frozen_ids([slot for robot in robots for slot in robot.held]), np.array((*places, w, x, y, z)).T


def _rounded(poses: FloatArray) -> FloatArray:
    rows: FloatArray = np.round(poses, _DECIMALS) + 0.0
    rows.setflags(write=False)
    return rows


def _rounded_pose(*row: float) -> FloatArray:
    pose = np.array([round(value, _DECIMALS) + 0.0 for value in row])  # no -0.0, which would be another value
    pose.setflags(write=False)
    return pose


def _module_states(rows: FloatArray) -> FloatArray:
    """To 1 mm/s and 1 mrad, with angles within half a turn."""
    turned = np.column_stack((rows[:, 0], np.arctan2(np.sin(rows[:, 1]), np.cos(rows[:, 1]))))
    states: FloatArray = np.round(turned, 3) + 0.0
    states.setflags(write=False)
    return states


def _settled(value: float) -> float:
    """A value of a mechanism; one that a loop holds in place comes to rest and does not fall to 1e-70."""
    return round(value, _DECIMALS) + 0.0


def _frozen_ids(slots: IntArray | list[int]) -> IntArray:
    ids = np.array(slots, dtype=np.int64)
    ids.setflags(write=False)
    return ids


def _add_match(rows: _Rows, match: PublishedMatch) -> None:
    timer, score, record = match.timer, match.score, match.record
    rows.doubles |= {"Sim/Match/Time": timer.time, "Sim/Match/TimeLeft": timer.remaining}
    rows.strings["Sim/Match/Game"] = match.game.name
    rows.strings["Sim/Match/Period"] = timer.phase.name
    rows.booleans["Sim/Match/Enabled"] = timer.is_enabled
    rows.integers |= {
        "Sim/Score/Total": score.total,
        "Sim/Score/Red": score.red,
        "Sim/Score/Blue": score.blue,
        "Sim/Performance/SubSteps": match.substeps,
        "Sim/Performance/AwakePieces": len(match.pieces.awake),
        "Sim/Performance/FlyingPieces": match.pieces.count(PieceStatus.IN_FLIGHT),
        "Sim/Performance/PiecesInContact": len(match.pieces.in_contact),
        "Sim/Performance/SleepingPieces": match.pieces.count(PieceStatus.ASLEEP),
        "Sim/Shots": len(record.shots),
        "Sim/Hits": record.hits,
        "Sim/TakenIn": len(record.taken_in),
    }
    columns = record.columns
    rows.integer_arrays |= {
        "Sim/ShotIds": columns.shot_ids,
        "Sim/ShotRobots": columns.shot_robots,
        "Sim/ShotHits": columns.shot_hits,
        "Sim/ShotTicks": columns.shot_ticks,
        "Sim/TakenInPlaces": columns.taken_places,
    }
    if record.failure:
        rows.strings["Sim/Failure"] = record.failure
    if record.warnings:
        rows.strings["Sim/Warnings"] = "\n".join(record.warnings)
    rows.integers |= {f"Sim/Score/{name}": count for name, count in match.score_counts.items()}
    if fouls := match.tracker.fouls:
        rows.strings["Sim/Match/LastFoul"] = f"{len(fouls)}. {fouls[-1]}"
    for level, total in match.pieces.places.totals().items():
        rows.integers[f"Sim/Placed/{level}"] = total
    for level, counts in match.pieces.places.counts().items():
        rows.integer_arrays[f"Sim/Places/{level}"] = counts
    if match.last_tick_ms is not None:
        rows.doubles["Sim/Performance/TickMs"] = match.last_tick_ms
        rows.doubles["Sim/Performance/RealTimeFactor"] = 1e3 * TICK / max(match.last_tick_ms, 1e-6)


def _add_robot(rows: _Rows, robot: Robot, alliance: Alliance, record: RobotRecord) -> None:
    prefix = robot_prefix(robot.number)
    x, y, z, w = robot.chassis.quat
    rows.poses[f"{prefix}/Robot/Pose3d"] = _rounded_pose(*robot.chassis.pos, w, x, y, z)
    rows.pose_arrays[f"{prefix}/Robot/ComponentPoses"] = robot.component_poses()
    if isinstance(robot.drive, SwerveDrive):
        wanted = robot.drive.module_setpoints() if robot.module_setpoints is None else robot.module_setpoints
        for name, states in (("States", robot.drive.module_states()), ("Setpoints", wanted)):
            rows.state_arrays[f"{prefix}/Robot/Swerve{name}"] = _module_states(states)
    held = len(robot.held)
    ground = ground_clearance(*robot.chassis.wheel_ground())
    rows.doubles[f"{prefix}/Robot/GroundClearance"] = round(ground.height, _DECIMALS)
    rows.booleans[f"{prefix}/Robot/IsAirborne"] = ground.is_airborne
    rows.booleans[f"{prefix}/Robot/IsRed"] = alliance == "red"
    rows.doubles[f"{prefix}/Robot/WheelSlip"] = robot.drive.wheel_slip
    rows.doubles[f"{prefix}/Robot/DistanceDriven"] = round(record.distance, _DECIMALS)
    rows.integers[f"{prefix}/Robot/Placements"] = len(record.placements)
    last = record.placements[-1]
    rows.strings[f"{prefix}/Robot/LastPlacement"] = f"{last.reason}: {pose_text(last.pose)}"
    if record.player:
        rows.strings[f"{prefix}/Robot/Player"] = record.player
    # To 1 mm and 1 mrad: a gyro's noise would change it in every tick of a robot that stands.
    px, py, yaw = (round(value, 3) for value in robot.believed_pose)
    half = 0.5 * yaw
    rows.poses[f"{prefix}/Robot/EstimatedPose"] = _rounded_pose(px, py, 0.0, math.cos(half), 0.0, 0.0, math.sin(half))
    rows.integers[f"{prefix}/Intake/HeldCount"] = held
    rows.integers[f"{prefix}/Debug/HeldCount"] = held
    debug = f"{prefix}/Debug/"
    rows.doubles[f"{debug}BatteryVoltage"] = round(robot.battery.voltage, _VOLT_DECIMALS)
    rows.doubles[f"{debug}BatteryVoltageMin"] = round(robot.battery.tick_min_voltage, _VOLT_DECIMALS)
    rows.doubles[f"{debug}BatteryVoltageLowest"] = round(record.battery.min_voltage, _DECIMALS)
    rows.integers[f"{debug}Brownouts"] = record.battery.brownouts
    rows.booleans[f"{debug}BrownedOut"] = robot.battery.tick_browned_out
    rows.doubles[f"{debug}BatteryCurrent"] = robot.battery.current
    rows.doubles[f"{debug}DrivetrainCurrent"] = robot.drive.supply_current
    for name, mechanism in robot.mechanisms.items():
        key = debug + telemetry_name(name)
        if isinstance(mechanism, PistonSim):  # it has no turns, and takes air
            rows.doubles[f"{key}ExtendedPct"] = 100.0 * mechanism.extended_fraction
            continue
        rows.doubles[f"{key}VelocityRPS"] = _settled(mechanism.velocity / math.tau)
        rows.doubles[f"{key}PositionRot"] = _settled(mechanism.position / math.tau)
        rows.doubles[f"{key}VoltageIn"] = _settled(mechanism.volts)
        rows.doubles[f"{key}CurrentA"] = _settled(mechanism.supply_current)
        if isinstance(mechanism, ArmSim):
            rows.doubles[f"{key}AngleDeg"] = _settled(math.degrees(mechanism.position))
        elif isinstance(mechanism, RackSim):
            rows.doubles[f"{key}ExtendedPct"] = _settled(100.0 * mechanism.extended_fraction)
        elif isinstance(mechanism, ElevatorSim):
            rows.doubles[f"{key}HeightM"] = _settled(mechanism.height)
    for name, goal in robot.setpoints.items():
        rows.doubles[f"{debug}{name}Setpoint"] = _settled(goal)
    for number, intake in enumerate(robot.intakes):
        rows.booleans[f"{debug}{_numbered('IntakeZoneActive', number)}"] = intake.is_active
    for number, shooter in enumerate(robot.shooters):
        rows.booleans[f"{debug}{_numbered('ShootingGateOpen', number)}"] = shooter.gate_open
    for number, climber in enumerate(robot.climbers):
        rows.booleans[f"{debug}{_numbered('IsHanging', number)}"] = climber.rung is not None
    for name, state in robot.sensor_states.items():
        rows.booleans[f"{prefix}/Sensors/{telemetry_name(name)}"] = state
    for name, colors in robot.light_colors.items():
        rows.integer_arrays[f"{prefix}/Lights/{name}/Colors"] = colors
    for name, words in robot.light_requests.items():
        rows.strings[f"{prefix}/Lights/{name}/Shows"] = words


_NO_POSES = _rounded(np.empty((0, 7)))
_NO_IDS = _frozen_ids([])


def _numbered(name: str, number: int) -> str:
    """The first of its kind has no number."""
    return name if number == 0 else f"{name}{number + 1}"
