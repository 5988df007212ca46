"""The schema of telemetry (docs/telemetry.md): a line for each channel, with what gives its values.

`simcore.match.publish` writes them. A value is asked for once a tick, of all robots, or all mechanisms of a kind, at
once; `m["speed"]` are the records of the loop (`simcore.loop.robot_state.SHAFT`) of those mechanisms.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from simcore.channel import Channel
from simcore.loop.robot_state import DUTY
from simcore.match.run_record import Placement
from simcore.match.scoring import FoulEvent
from simcore.match.starts import pose_text
from simcore.physics.hanging import HangingBody
from simcore.pieces.intake import Intake
from simcore.pieces.pool import PieceStatus
from simcore.pieces.shooter import Shooter
from simcore.robot.climber import Climber
from simcore.robot.mechanisms import ArmSim, ElevatorSim, RackSim, ShaftSim
from simcore.typing import FloatArray
from simcore.units import TICK

__all__ = ["MATCH", "MECHANISM", "PART", "PIECES", "ROBOT"]

_AIRBORNE = 0.01  # [m]; a wheel within this of the ground touches it


@lru_cache
def _placement(last: Placement) -> str:
    return f"{last.reason}: {pose_text(last.pose)}"


def _last_foul(fouls: Sequence[FoulEvent]) -> str | None:
    return f"{len(fouls)}. {fouls[-1]}" if fouls else None


def _hanging(bodies: Sequence[HangingBody]) -> FloatArray | None:
    return np.array([(*body.pos, body.quat[3], *body.quat[:3]) for body in bodies]) if bodies else None


MATCH = (
    Channel("Sim/Match/Game", "string", lambda m: m.game.name, "name of the game"),
    Channel("Sim/Match/Period", "string", lambda m: m.timer.phase.name, "name of the phase, by the game's clock"),
    Channel("Sim/Match/Time", "double", lambda m: m.timer.time,
            "time of the match; it stands while a driver station disables the robots", "s"),
    Channel("Sim/Match/TimeLeft", "double", lambda m: m.timer.remaining, "until the end of the match", "s"),
    Channel("Sim/Match/Enabled", "boolean", lambda m: m.timer.is_enabled, "robots may move"),
    Channel("Sim/Match/LastFoul", "string", lambda m: _last_foul(m.tracker.fouls),
            "number and text of the last foul; not before the first"),
    Channel("Sim/Score/Total", "int", lambda m: m.score.total, "points of both alliances"),
    Channel("Sim/Score/Red", "int", lambda m: m.score.red, "points of red"),
    Channel("Sim/Score/Blue", "int", lambda m: m.score.blue, "points of blue"),
    Channel("Sim/Performance/SubSteps", "int", lambda m: m.substeps,
            "steps of the engine in the tick: 4, and more while pieces move that are no balls"),
    Channel("Sim/Performance/AwakePieces", "int",
            lambda m: m.pieces.count(PieceStatus.AWAKE) + m.pieces.count(PieceStatus.IN_FLIGHT),
            "pieces that move: the next two together"),
    Channel("Sim/Performance/FlyingPieces", "int", lambda m: m.pieces.count(PieceStatus.IN_FLIGHT),
            "pieces in the air, which touch nothing"),
    Channel("Sim/Performance/PiecesInContact", "int", lambda m: m.pieces.count(PieceStatus.AWAKE),
            "pieces that move and touch something"),
    Channel("Sim/Performance/SleepingPieces", "int", lambda m: m.pieces.count(PieceStatus.ASLEEP),
            "pieces at rest, which wake when something reaches them"),
    Channel("Sim/Performance/TickMs", "double", lambda m: m.last_tick_ms,
            "wall time of the tick before, as `simcore play` and `robotpy sim` measure it", "ms"),
    Channel("Sim/Performance/RealTimeFactor", "double",
            lambda m: None if m.last_tick_ms is None else 1e3 * TICK / max(m.last_tick_ms, 1e-6),
            "20 ms over that time: how many times faster than real time"),
    Channel("Sim/Shots", "int", lambda m: len(m.record.shots), "pieces shot so far, by all robots"),
    Channel("Sim/Hits", "int", lambda m: m.record.hits, "shots of these that scored"),
    Channel("Sim/TakenIn", "int", lambda m: len(m.record.taken_in), "pieces that robots have taken in so far"),
    Channel("Sim/NewestShots", "int[]", lambda m: m.record.columns.shots,
            "of the newest shot and those up to 1 s before it: number as in `Sim/Shots`, piece, robot, and ticks of "
            "20 ms since the run began when it had left, one after the other"),
    Channel("Sim/NewestHits", "int[]", lambda m: m.record.columns.hits,
            "of the newest hit and those up to 1 s before it: number as in `Sim/Hits`, and number of its shot"),
    Channel("Sim/NewestTakenIn", "int[]", lambda m: m.record.columns.taken_in,
            "of the newest piece taken in and those up to 1 s before it: number as in `Sim/TakenIn`, and x and y of "
            "where it was", "mm"),
    Channel("Sim/Failure", "string", lambda m: m.record.failure or None,
            "what the test of this run has failed of; in the log of a failed robot test"),
    Channel("Sim/Warnings", "string", lambda m: "\n".join(m.record.warnings) or None,
            "what simcore warned of, a line each; from the last tick on, why robots took in or threw nothing"),
    Channel("Sim/Score/<name>", "int", lambda m: m.score_counts,
            "pieces through a scoring zone of the game, and what else its score is made of"),
    Channel("Sim/Placed/<Level>", "int", lambda m: m.pieces.places.totals() if m.game.places else {},
            "pieces that are placed on a level, of a game with resting places"),
    Channel("Sim/Places/<Level>", "int[]", lambda m: m.pieces.places.counts() if m.game.places else {},
            "how many of them are in each place of that level, in the order of the game's `places`"),
    Channel("Sim/Hanging", "Pose3d[]", lambda m: _hanging(m.hanging),
            "what hangs from the field and swings, of a game that has such bodies", "m", 6),
    Channel("Sim/Limelights/<name>/DirectionLine", "Pose3d[]", lambda m: m.cameras.direction_lines(),
            "from a camera's lens to what its last frame aims at, or 1 m ahead", "m", 6),
    Channel("Sim/Limelights/<name>/SeenTags", "Pose3d[]", lambda m: m.cameras.sighting_lines(),
            "from the lens to each tag of the last frame and back; empty without tags", "m", 6),
)  # fmt: skip
"""Channels of the match."""

PIECES = (
    Channel("Sim/GamePieces/<Type>", "Pose3d[]", lambda p: p.here,
            "all pieces on the field or in the air, with attitude; not what robots hold, and not what has scored"),
    Channel("Sim/PieceIds/<Type>", "int[]", lambda p: p.slots, "which piece each of these rows is"),
    Channel("Sim/InFlight/<Type>", "Pose3d[]", lambda p: p.flying,
            "those that were shot and have not touched anything yet, oldest first"),
    Channel("Sim/InFlightIds/<Type>", "int[]", lambda p: p.flying_slots, "which piece each of these rows is"),
    Channel("Sim/Held/<Type>", "Pose3d[]", lambda p: p.held,
            "pieces in robots, where they are in them; those of all robots"),
    Channel("Sim/HeldIds/<Type>", "int[]", lambda p: p.held_slots, "which piece each of these rows is"),
)  # fmt: skip
"""Channels of each kind of pieces."""

ROBOT = (
    Channel("Robot/Pose3d", "Pose3d", lambda f: f.view.places,
            "true pose of the robot; its origin is on the carpet under the center", "m", 6),
    Channel("Robot/ComponentPoses", "Pose3d[]", lambda f: f.components.poses(f.shafts),
            "moving parts in the robot frame, in the order of `RobotConfig.components`"),
    Channel("Robot/SwerveStates", "SwerveModuleState[]", lambda f: f.view.module_states,
            "of a swerve drive: speed over ground [m/s] and angle [rad] of each module, in the order of its "
            "configuration, as its encoders show them; to 1 mm/s and 1 mrad"),
    Channel("Robot/SwerveSetpoints", "SwerveModuleState[]", lambda f: f.view.module_setpoints,
            "the same as they are wanted: by scripts, CTRE's `SwerveDrivetrain`, or closed loops of both motors of "
            "each module; empty while nothing says it, as with drive motors that are told volts"),
    Channel("Robot/GroundClearance", "double", lambda f: f.clearance,
            "height of the lowest wheel over the ground under it: about 0 on carpet and bumps, more in air", "m", 6),
    Channel("Robot/IsAirborne", "boolean", lambda f: f.clearance > _AIRBORNE, "no wheel touches"),
    Channel("Robot/IsRed", "boolean", lambda f: [side == "red" for side in f.match.alliances],
            "it plays for the red alliance"),
    Channel("Robot/WheelSlip", "double", lambda f: f.view.slips,
            "speed of the fastest sliding tire over the ground; 0 while all hold", "m/s"),
    Channel("Robot/DistanceDriven", "double", lambda f: [record.distance for record in f.records],
            "way driven so far, without those on which it was carried", "m", 6),
    Channel("Robot/Placements", "int", lambda f: [len(record.placements) for record in f.records],
            "how often it was put somewhere, its start included"),
    Channel("Robot/LastPlacement", "string", lambda f: [_placement(record.placements[-1]) for record in f.records],
            "`start`, `carried` (its gyro kept its reading) or `reset`, and where"),
    Channel("Robot/Player", "string", lambda f: [record.player or None for record in f.records],
            "in a match of scripted players: its role and level, e.g. `collector:3`"),
    Channel("Robot/EstimatedPose", "Pose3d", lambda f: f.view.believed,
            "where robot code believes the robot to be: a Phoenix 6 drivetrain's own pose estimate; else wheel "
            "encoders and gyro added up; to 1 mm and 1 mrad", "m", 6),
    Channel("Intake/HeldCount", "int", lambda f: f.held, "pieces in the robot"),
    Channel("Debug/HeldCount", "int", lambda f: f.held, "the same as above, beside the other debug numbers"),
    Channel("Debug/BatteryVoltage", "double", lambda f: f.batteries["voltage"],
            "at the battery's terminals, under load", "V", 3),
    Channel("Debug/BatteryVoltageMin", "double", lambda f: f.batteries["tick_min_voltage"],
            "the lowest within the tick, of its steps of 1 ms", "V", 3),
    Channel("Debug/BatteryVoltageLowest", "double", lambda f: f.batteries["min_voltage"],
            "the lowest since the run began", "V", 6),
    Channel("Debug/Brownouts", "int", lambda f: f.batteries["brownouts"], "brown-outs since then"),
    Channel("Debug/BrownedOut", "boolean", lambda f: f.batteries["tick_was_off"],
            "the roboRIO held its outputs off at some moment of the tick"),
    Channel("Debug/BatteryCurrent", "double", lambda f: f.batteries["current"],
            "out of the battery, all motors together; below 0 while a braking robot charges it", "A"),
    Channel("Debug/DrivetrainCurrent", "double", lambda f: f.drive_currents,
            "the drivetrain's part of it; the rest goes to the mechanisms", "A"),
    Channel("Debug/<Setpoint>Setpoint", "double", lambda f: [robot.setpoints for robot in f.robots],
            "what a velocity loop (`<Mechanism>VelocityRPS`) or position loop (`<Mechanism>PositionRot`) is to reach, "
            "also along a profile: of a scripted robot, or commanded by robot code to a TalonFX in simulated time or a "
            "SPARK", "turns/s, turns", 6),
    Channel("Sensors/<Sensor>", "boolean", lambda f: f.sensors,
            "a switch of `simcore.toml` is pressed, a beam broken, a piece before a CANrange; as robot code reads it"),
    Channel("Lights/<name>/Colors", "int[]", lambda f: [robot.light_colors for robot in f.robots],
            "what robot code's lights show: 0xRRGGBB of each LED; -1 where an animation has no one color (rainbow, RGB "
            "fade, fire)"),
    Channel("Lights/<name>/Shows", "string", lambda f: [robot.light_requests for robot in f.robots],
            "the same in words, of a CANdle: `SolidColor 0-7 #00FF00, RainbowAnimation 8-67`"),
)  # fmt: skip
"""Channels of each robot: the first under `Sim/`, numbers 1, 2, ... under `Sim/Robots/1/`; a value is that of all."""

MECHANISM = (
    Channel("VelocityRPS", "double", lambda m: m["speed"] / math.tau, "speed of the mechanism, after its gears",
            "turns/s", 6, ShaftSim),
    Channel("PositionRot", "double", lambda m: m["position"] / math.tau, "its position", "turns", 6, ShaftSim),
    Channel("VoltageIn", "double", lambda m: np.where(m["request", "mode"] == DUTY, m["volts"], m["request", "value"]),
            "volts asked of its motors, before the battery limits them", "V", 6, ShaftSim),
    Channel("CurrentA", "double", lambda m: m["mean_supply"], "what its motors take of the battery", "A", 6, ShaftSim),
    Channel("AngleDeg", "double", lambda m: np.degrees(m["position"]), "of an arm, also of a hood or servo: angle",
            "degrees", 6, ArmSim),
    Channel("ExtendedPct", "double", lambda m: [100.0 * rack.extended_fraction for rack in m.mechanisms],
            "of a rack or piston: how far it is out, 0 to 100; a piston has no other", "%", 6, RackSim),
    Channel("HeightM", "double", lambda m: [lift.height for lift in m.mechanisms],
            "of an elevator: height of its carriage", "m", 6, ElevatorSim),
)  # fmt: skip
"""Of each mechanism of a robot, after `Debug/` and its name, values of all of a kind."""

PART = (
    Channel("IntakeZoneActive", "boolean", lambda intake: intake.is_active,
            "the intake is out and its roller turns: pieces in its zone are taken", owner=Intake),
    Channel("ShootingGateOpen", "boolean", lambda shooter: shooter.gate_open,
            "wheels and feeders of the shooter turn fast enough: pieces leave", owner=Shooter),
    Channel("IsHanging", "boolean", lambda climber: climber.rung is not None, "the climber hangs on a rung",
            owner=Climber),
)  # fmt: skip
"""Of each intake, shooter and climber, after `Debug/`; the second of a robot has a number."""
