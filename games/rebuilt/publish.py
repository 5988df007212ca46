"""What a tick looks like from outside: the telemetry keys of REBUILT (docs/telemetry.md)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from games.rebuilt.components import component_poses
from games.rebuilt.fuel import FUEL
from simcore.telemetry.ground import ground_clearance
from simcore.telemetry.snapshot import Snapshot
from simcore.typing import FloatArray

if TYPE_CHECKING:
    from games.rebuilt.robot import RebuiltRobot
    from games.rebuilt.sim import RebuiltSim

__all__ = ["build_snapshot"]


def build_snapshot(sim: RebuiltSim) -> Snapshot:
    """The snapshot of the last tick. Keys without a number are of the first robot; others carry theirs."""
    poses: dict[str, FloatArray] = {}
    arrays: dict[str, FloatArray] = {
        f"Sim/GamePieces/{FUEL.name}": _upright(sim.pieces.state.pos[sim.pieces.on_field()]),
        f"Sim/InFlight/{FUEL.name}": _upright(sim.flying),
    }
    doubles: dict[str, float] = {"Sim/Match/Time": sim.time, "Sim/Match/TimeLeft": sim.match.remaining(sim.match_time)}
    integers: dict[str, int] = {
        "Sim/Score/Total": sum(sim.tracker.totals.values()),
        "Sim/Score/Red": sim.tracker.totals["red"],
        "Sim/Score/Blue": sim.tracker.totals["blue"],
        "Sim/Performance/SubSteps": sim.substeps,
        "Sim/Performance/AwakePieces": len(sim.pieces.awake),
        "Sim/Shots": len(sim.shots),
        "Sim/Hits": sim.hits,
    }
    for zone, count in sim.tracker.pieces.items():
        integers[f"Sim/Score/{zone}"] = count
    arrays |= sim.vision.lines(sim.robots)
    booleans: dict[str, bool] = {}
    if sim.last_tick_ms is not None:
        doubles["Sim/Performance/TickMs"] = sim.last_tick_ms
    for robot in sim.robots:
        prefix = "Sim" if robot.number == 0 else f"Sim/Robots/{robot.number}"
        _add_robot(sim, robot, prefix, poses, arrays, doubles, integers, booleans)
    return Snapshot(
        time=sim.time,
        tick=sim.ticks - 1,
        poses=poses,
        pose_arrays=arrays,
        doubles=doubles,
        integers=integers,
        booleans=booleans,
    )


def _upright(places: FloatArray) -> FloatArray:
    rows = np.zeros((len(places), 7))
    rows[:, :3] = places
    rows[:, 3] = 1.0
    rows.setflags(write=False)
    return rows


def _add_robot(
    sim: RebuiltSim,
    robot: RebuiltRobot,
    prefix: str,
    poses: dict[str, FloatArray],
    arrays: dict[str, FloatArray],
    doubles: dict[str, float],
    integers: dict[str, int],
    booleans: dict[str, bool],
) -> None:
    x, y, z, w = robot.chassis.quat
    poses[f"{prefix}/Robot/Pose3d"] = np.array((*robot.chassis.pos, w, x, y, z))
    arrays[f"{prefix}/Robot/ComponentPoses"] = component_poses(robot)
    held = len(sim.pieces.held(robot.number))
    integers[f"{prefix}/Intake/HeldCount"] = held
    ground = ground_clearance(*robot.chassis.wheel_ground())
    doubles[f"{prefix}/Robot/GroundClearance"] = ground.height
    booleans[f"{prefix}/Robot/IsAirborne"] = ground.is_airborne
    booleans[f"{prefix}/Robot/IsRed"] = sim.alliances[robot.number] == "red"
    debug = f"{prefix}/Debug"
    turn = math.tau
    doubles |= {
        f"{debug}/ShooterVelocityRPS": robot.shooter_wheels.velocity / turn,
        f"{debug}/ShooterVoltageIn": robot.shooter_wheels.volts,
        f"{debug}/FeederVelocityRPS": robot.feeder.velocity / turn,
        f"{debug}/FeederVoltageIn": robot.feeder.volts,
        f"{debug}/SpindexerVelocityRPS": robot.spindexer.velocity / turn,
        f"{debug}/SpindexerVoltageIn": robot.spindexer.volts,
        f"{debug}/HoodAngleDeg": math.degrees(robot.hood.position),
        f"{debug}/HoodVoltageIn": robot.hood.volts,
        f"{debug}/HoodPositionRot": robot.hood.position / turn,
        f"{debug}/IntakeDeployPositionRot": robot.deploy.position / turn,
        f"{debug}/IntakeDeployExtendedPct": 100.0 * robot.deploy.extended_fraction,
        f"{debug}/IntakeRollerVelocityRPS": robot.roller.velocity / turn,
        f"{debug}/BatteryVoltage": robot.battery.voltage,
        f"{debug}/BatteryCurrent": robot.battery.current,
        f"{debug}/DrivetrainCurrent": robot.battery.current - robot.drive.other_current,
        "Robot/Intake/ExtensionPct" if robot.number == 0 else f"{prefix}/Robot/Intake/ExtensionPct": 100.0
        * robot.deploy.extended_fraction,
    }
    booleans[f"{debug}/IntakeZoneActive"] = robot.intake_active
    booleans[f"{debug}/ShootingGateOpen"] = robot.gate_open
    integers[f"{debug}/FuelHeld"] = held
