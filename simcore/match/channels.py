"""Telemetry schema (docs/telemetry.md): key, type, unit, meaning and value function of each channel.

`simcore.match.publish` calls each function once per snapshot. A function for robots or mechanisms returns the values of
all robots or of all mechanisms that have the channel. In such a function, `m["speed"]` is a field of the mechanisms'
records in the compiled loop (`simcore.loop.robot_state.SHAFT`).
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
from simcore.pieces.pool import PieceStatus
from simcore.robot.climber import Climber
from simcore.robot.intake import Intake
from simcore.robot.mechanisms import ArmSim, ElevatorSim, RackSim, ShaftSim
from simcore.robot.shooter import Shooter
from simcore.typing import FloatArray
from simcore.units import TICK
from simcore.world.hanging import HangingBody

__all__ = ["MATCH", "MECHANISM", "PART", "PIECES", "ROBOT"]

_AIRBORNE = 0.01  # [m]; a wheel at most this far above the ground counts as touching it


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
            "time of the match; it stops while a driver station disables the robots", "s"),
    Channel("Sim/Match/TimeLeft", "double", lambda m: m.timer.remaining, "time until the end of the match", "s"),
    Channel("Sim/Match/Enabled", "boolean", lambda m: m.timer.is_enabled, "robots may move"),
    Channel("Sim/Match/LastFoul", "string", lambda m: _last_foul(m.tracker.fouls),
            "number and text of the last foul; not before the first"),
    Channel("Sim/Score/Total", "int", lambda m: m.score.total, "points of both alliances"),
    Channel("Sim/Score/Red", "int", lambda m: m.score.red, "points of red"),
    Channel("Sim/Score/Blue", "int", lambda m: m.score.blue, "points of blue"),
    Channel("Sim/Performance/SubSteps", "int", lambda m: m.substeps,
            "steps of the engine in the tick: 4, and more while pieces that are not balls move"),
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
            "wall time of the previous tick, as measured by `simcore play` and `robotpy sim`", "ms"),
    Channel("Sim/Performance/RealTimeFactor", "double",
            lambda m: None if m.last_tick_ms is None else 1e3 * TICK / max(m.last_tick_ms, 1e-6),
            "20 ms divided by that time: how many times faster than real time"),
    Channel("Sim/Shots", "int", lambda m: len(m.record.shots), "pieces shot so far, by all robots"),
    Channel("Sim/Hits", "int", lambda m: m.record.hits, "shots that scored"),
    Channel("Sim/TakenIn", "int", lambda m: len(m.record.taken_in), "pieces that robots have taken in so far"),
    Channel("Sim/NewestShots", "int[]", lambda m: m.record.columns.shots,
            "the newest shot and those up to 1 s before it, each as its number, piece, robot, and tick of the run"),
    Channel("Sim/NewestHits", "int[]", lambda m: m.record.columns.hits,
            "the newest hit and those up to 1 s before it, each as its number and that of its shot"),
    Channel("Sim/NewestTakenIn", "int[]", lambda m: m.record.columns.taken_in,
            "the newest piece taken in and those up to 1 s before it, each as its number, and x and y of its place",
            "mm"),
    Channel("Sim/Failure", "string", lambda m: m.record.failure or None,
            "why the test of this run failed; in the log of a failed robot test"),
    Channel("Sim/Warnings", "string", lambda m: "\n".join(m.record.warnings) or None,
            "warnings, one per line; after the last tick also why robots took in or shot nothing"),
    Channel("Sim/Score/<name>", "int", lambda m: m.score_counts,
            "pieces through a scoring zone of the game, and other parts of its score"),
    Channel("Sim/Placed/<Level>", "int", lambda m: m.pieces.places.totals() if m.game.places else {},
            "pieces placed on a level, in a game with resting places"),
    Channel("Sim/Places/<Level>", "int[]", lambda m: m.pieces.places.counts() if m.game.places else {},
            "number of pieces in each place of that level, in the order of the game's `places`"),
    Channel("Sim/Hanging", "Pose3d[]", lambda m: _hanging(m.hanging),
            "bodies that hang from the field and swing, in a game that has them", "m", 6),
    Channel("Sim/Limelights/<name>/DirectionLine", "Pose3d[]", lambda m: m.cameras.direction_lines(),
            "line from a camera's lens to the target of its last frame, or 1 m ahead", "m", 6),
    Channel("Sim/Limelights/<name>/SeenTags", "Pose3d[]", lambda m: m.cameras.sighting_lines(),
            "line from the lens to each tag of the last frame and back; empty without tags", "m", 6),
)  # fmt: skip
"""Channels with one value for the whole match, or with a value for each named part of the match."""

PIECES = (
    Channel("Sim/GamePieces/<Type>", "Pose3d[]", lambda p: p.here,
            "all pieces on the field or in the air, with attitude; without held and scored ones"),
    Channel("Sim/PieceIds/<Type>", "int[]", lambda p: p.slots, "id of the piece in each of these rows"),
    Channel("Sim/InFlight/<Type>", "Pose3d[]", lambda p: p.flying,
            "pieces that were shot and have not touched anything yet, oldest first"),
    Channel("Sim/InFlightIds/<Type>", "int[]", lambda p: p.flying_slots, "id of the piece in each of these rows"),
    Channel("Sim/Held/<Type>", "Pose3d[]", lambda p: p.held,
            "pieces in all robots, at their places in them"),
    Channel("Sim/HeldIds/<Type>", "int[]", lambda p: p.held_slots, "id of the piece in each of these rows"),
)  # fmt: skip
"""Channels of each kind of game piece; the name of the kind replaces `<Type>` in the key."""

ROBOT = (
    Channel("Robot/Pose3d", "Pose3d", lambda f: f.view.places,
            "true pose of the robot; its origin is on the carpet under the center", "m", 6),
    Channel("Robot/ComponentPoses", "Pose3d[]", lambda f: f.components.poses(f.shafts),
            "moving parts in the robot frame, in the order of `RobotConfig.components`"),
    Channel("Robot/SwerveStates", "SwerveModuleState[]", lambda f: f.view.module_states,
            "speed over ground [m/s] and angle [rad] of each swerve module, in order, from its encoders"),
    Channel("Robot/SwerveSetpoints", "SwerveModuleState[]", lambda f: f.view.module_setpoints,
            "commanded module states; empty without a command, as with drive motors in voltage control"),
    Channel("Robot/GroundClearance", "double", lambda f: f.clearance,
            "height of the lowest wheel over the ground under it", "m", 6),
    Channel("Robot/IsAirborne", "boolean", lambda f: f.clearance > _AIRBORNE, "no wheel touches"),
    Channel("Robot/IsRed", "boolean", lambda f: [side == "red" for side in f.match.alliances],
            "the robot plays for the red alliance"),
    Channel("Robot/WheelSlip", "double", lambda f: f.view.slips,
            "speed of the fastest sliding tire over the ground; 0 while none slides", "m/s"),
    Channel("Robot/DistanceDriven", "double", lambda f: [record.distance for record in f.records],
            "distance driven so far, without moves by people", "m", 6),
    Channel("Robot/Placements", "int", lambda f: [len(record.placements) for record in f.records],
            "number of placements of the robot, its start included"),
    Channel("Robot/LastPlacement", "string", lambda f: [_placement(record.placements[-1]) for record in f.records],
            "`start`, `carried` (its gyro kept its reading) or `reset`, and where"),
    Channel("Robot/Player", "string", lambda f: [record.player or None for record in f.records],
            "in a match of scripted players: its role and level, e.g. `collector:3`"),
    Channel("Robot/EstimatedPose", "Pose3d", lambda f: f.view.believed,
            "pose estimated by robot code: a Phoenix 6 drivetrain's own pose estimate, else wheel odometry from "
            "encoders and gyro", "m", 6),
    Channel("Intake/HeldCount", "int", lambda f: f.held, "pieces in the robot"),
    Channel("Debug/HeldCount", "int", lambda f: f.held, "pieces in the robot, next to the other debug values"),
    Channel("Debug/BatteryVoltage", "double", lambda f: f.batteries["voltage"],
            "battery voltage at its terminals, under load", "V", 3),
    Channel("Debug/BatteryVoltageMin", "double", lambda f: f.batteries["tick_min_voltage"],
            "lowest battery voltage within the tick, over steps of 1 ms", "V", 3),
    Channel("Debug/BatteryVoltageLowest", "double", lambda f: f.batteries["min_voltage"],
            "lowest battery voltage since the run began", "V", 6),
    Channel("Debug/Brownouts", "int", lambda f: f.batteries["brownouts"], "brownouts since the run began"),
    Channel("Debug/BrownedOut", "boolean", lambda f: f.batteries["tick_was_off"],
            "the roboRIO switched its outputs off at some time in the tick"),
    Channel("Debug/BatteryCurrent", "double", lambda f: f.batteries["current"],
            "current out of the battery, all motors together; negative while a braking robot charges it", "A"),
    Channel("Debug/DrivetrainCurrent", "double", lambda f: f.drive_currents,
            "the drivetrain's share of it; the rest goes to the mechanisms", "A"),
    Channel("Debug/<Setpoint>Setpoint", "double", lambda f: [robot.setpoints for robot in f.robots],
            "goal of a velocity loop (`<Mechanism>VelocityRPS`) or position loop (`<Mechanism>PositionRot`), also "
            "along a profile: of a scripted robot, or of robot code for a TalonFX in simulated time or a SPARK",
            "turns/s, turns", 6),
    Channel("Sensors/<Sensor>", "boolean", lambda f: f.sensors,
            "a switch of `simcore.toml` is pressed, a beam is broken, or a piece is in front of a CANrange; as robot "
            "code reads it"),
    Channel("Lights/<name>/Colors", "int[]", lambda f: [robot.light_colors for robot in f.robots],
            "colors of robot code's lights: 0xRRGGBB of each LED; -1 where an animation has no one color (rainbow, RGB "
            "fade, fire)"),
    Channel("Lights/<name>/Shows", "string", lambda f: [robot.light_requests for robot in f.robots],
            "requests of a CANdle in words: `SolidColor 0-7 #00FF00, RainbowAnimation 8-67`"),
)  # fmt: skip
"""Channels of each robot, with the prefix `Sim/` for robot 0, `Sim/Robots/1/` for robot 1 and so on.

Each function returns the values of all robots.
"""

MECHANISM = (
    Channel("VelocityRPS", "double", lambda m: m["speed"] / math.tau, "speed of the mechanism, after its gears",
            "turns/s", 6, ShaftSim),
    Channel("PositionRot", "double", lambda m: m["position"] / math.tau, "position of the mechanism",
            "turns", 6, ShaftSim),
    Channel("VoltageIn", "double", lambda m: np.where(m["request", "mode"] == DUTY, m["volts"], m["request", "value"]),
            "voltage requested from its motors, before the battery limits it", "V", 6, ShaftSim),
    Channel("CurrentA", "double", lambda m: m["mean_supply"], "current of its motors from the battery",
            "A", 6, ShaftSim),
    Channel("AngleDeg", "double", lambda m: np.degrees(m["position"]), "angle of an arm, hood or servo",
            "degrees", 6, ArmSim),
    Channel("ExtendedPct", "double", lambda m: [100.0 * rack.extended_fraction for rack in m.mechanisms],
            "extension of a rack or piston, 0 to 100; a piston has no other channel", "%", 6, RackSim),
    Channel("HeightM", "double", lambda m: [lift.height for lift in m.mechanisms],
            "height of an elevator's carriage", "m", 6, ElevatorSim),
)  # fmt: skip
"""Channels of each mechanism, with `Debug/` and the mechanism's name before the key.

Each function returns the values of all mechanisms that have the channel.
"""

PART = (
    Channel("IntakeZoneActive", "boolean", lambda intake: intake.is_active,
            "the intake is out and its roller turns: pieces in its zone are taken in", owner=Intake),
    Channel("ShootingGateOpen", "boolean", lambda shooter: shooter.gate_open,
            "wheels and feeders of the shooter turn fast enough: pieces leave", owner=Shooter),
    Channel("IsHanging", "boolean", lambda climber: climber.rung is not None, "the climber hangs on a rung",
            owner=Climber),
)  # fmt: skip
"""Channels of each intake, shooter and climber, with `Debug/` before the key.

If a robot has several such parts, the keys from the second part on end in the number of the part.
"""
