"""Run an unmodified robot project under `robotpy sim --nogui` and play the driver station inside it.

Arguments: the project's folder and the play. Reports the true motion on the field.
"""

from __future__ import annotations

import json
import math
import os
import shutil
import sys
import time
from pathlib import Path

import numpy as np
from hal import AllianceStationID
from ntcore import NetworkTableInstance
from phoenix6 import unmanaged
from robotpy.main import main as robotpy_main
from wpilib import DriverStation, RobotController
from wpilib.simulation import DriverStationSim

import simcore.robotcode.makers.phoenix6.swerve as swerve
from simcore.robotcode.sim.robot_physics import RobotPhysics, field_control


class Play:
    """Scripted driver that runs after every tick of the physics."""

    def __init__(self, name: str, alliance: str) -> None:
        station = AllianceStationID.kRed1 if alliance == "red" else AllianceStationID.kBlue2
        DriverStationSim.setAllianceStationId(station)
        self.play = getattr(self, name)
        self.tick = 0
        self.walls: list[float] = []
        self.results: dict[str, object] = {}

    def __call__(self, physics: RobotPhysics) -> None:
        if self.tick == 0:
            self.steps = self.play(physics)
        self.walls.append(time.perf_counter())
        self.tick += 1
        try:
            next(self.steps)
        except StopIteration:
            self.finish(physics)

    def finish(self, physics: RobotPhysics) -> None:
        match = physics.match
        gaps = np.diff(self.walls)
        count = match.count
        print(
            json.dumps(
                {
                    **self.results,
                    "score": match.tracker.totals,
                    "shots": len(match.record.shots),
                    "hits": match.record.hits,
                    "taken_in": len(match.record.taken_in),
                    "staged": count.staged,
                    "counted": count.on_field
                    + count.in_flight
                    + count.placed
                    + count.held
                    + count.scored
                    + count.off_field,
                    "lateness_ms": 1e3 * max(0.0, float(np.percentile(gaps, 99)) - 0.02),
                    "min_volts": physics.robot_sim.battery.min_voltage,
                }
            ),
            flush=True,
        )
        os._exit(0)

    # --- plays --------------------------------------------------------------------------------------------------------

    def auto(self, physics):
        """Play 20 s of autonomous with the default auto."""
        DriverStationSim.notifyNewData()  # the alliance
        yield from self.wait(1.0)
        path = [physics.robot_sim.chassis.pose]
        self.enable(autonomous=True)
        for _ in range(1000):
            path.append(physics.robot_sim.chassis.pose)
            yield
        track = np.array(path)
        odometry = physics.robot.container.drivetrain.get_state().pose
        self.results["distance"] = float(np.linalg.norm(np.diff(track[:, :2], axis=0), axis=1).sum())
        self.results["odometry_error"] = math.hypot(odometry.X() - path[-1][0], odometry.Y() - path[-1][1])
        self.results["match_time"] = DriverStation.getMatchTime()

    def straight(self, physics):
        """Push half a stick forward for two seconds; plain robots drive forward by themselves."""
        DriverStationSim.setJoystickAxisCount(0, 6)
        self.axes(left_y=-0.5)
        yield from self.wait(1.0)
        drivetrain = swerve.only_drivetrain()
        start, before = physics.robot_sim.chassis.pose, drivetrain.get_state().pose
        self.enable(autonomous=False)
        yield from self.wait(1.0)
        true, told = [], []
        for _ in range(50):
            true.append(math.hypot(*physics.robot_sim.chassis.ground_velocity[:2]))
            speeds = drivetrain.get_state().speeds
            told.append(math.hypot(speeds.vx, speeds.vy))
            yield
        DriverStationSim.setEnabled(False)
        DriverStationSim.notifyNewData()
        yield from self.wait(1.0)
        end, after = physics.robot_sim.chassis.pose, drivetrain.get_state().pose
        self.results["true_way"] = math.dist(end[:2], start[:2])
        self.results["odometry_way"] = math.hypot(after.X() - before.X(), after.Y() - before.Y())
        self.results["true_speed"] = float(np.mean(true))
        self.results["told_speed"] = float(np.mean(told))
        self.results["speed_at_end"] = physics.robot_sim.chassis.speed
        field = physics._view._field
        self.results["drawn_fuel"] = len(field.getObject("Fuel").getPoses())
        shown = field.getRobotPose()
        self.results["drawn_robot_off"] = math.hypot(shown.X() - end[0], shown.Y() - end[1])
        self.results["own_hook"] = getattr(physics.robot, "own_hook", None)
        self.results["volts_seen"] = RobotController.getBatteryVoltage()

    def control(self, physics):
        """Place the robot, and a piece in front of the robot, from a dashboard and again from robot code."""
        DriverStationSim.notifyNewData()
        yield from self.wait(0.4)
        tables = NetworkTableInstance.getDefault()
        table = tables.getTable("Sim/Control")
        status = table.getStringTopic("Status").subscribe("none")
        self.results["topics"] = sorted(t.getName() for t in tables.getTopics("/Sim/Control/"))
        pose = table.getDoubleArrayTopic("RobotPose").publish()
        pose.set([3.0, 6.5, 90.0])
        yield from self.wait(0.1)
        self.results["placed"] = (physics.robot_sim.chassis.pose, status.get())
        button = table.getBooleanTopic("SpawnPiece").publish()
        button.set(True)
        yield from self.wait(0.1)
        self.results["spawned"] = (physics.match.count.on_field, status.get())
        field = field_control()
        field.start_auto("depot")
        field.place_at_start()
        yield from self.wait(0.1)
        tables.getBooleanTopic("/Sim/HumanPlayer/Blue/Throw").publish().set(True)
        yield from self.wait(0.1)
        self.results["said"] = [str(result) for result in field.results]

    def shape(self, physics):
        """Drive any robot over the course."""
        from course import Course

        is_field_centric = os.environ["STICKS"] == "field"
        course = Course(physics, is_field_centric=is_field_centric, enable=lambda: self.enable(autonomous=False))
        yield from course.run()
        self.results |= course.results

    # --- sticks -------------------------------------------------------------------------------------------------------

    def enable(self, *, autonomous: bool) -> None:
        DriverStationSim.setDsAttached(True)
        DriverStationSim.setAutonomous(autonomous)
        DriverStationSim.setEnabled(True)
        DriverStationSim.notifyNewData()

    def axes(self, left_x: float = 0.0, left_y: float = 0.0, right_x: float = 0.0) -> None:
        for axis, value in ((0, left_x), (1, left_y), (4, right_x)):
            DriverStationSim.setJoystickAxis(0, axis, value)
        DriverStationSim.notifyNewData()

    def wait(self, seconds: float):
        for _ in range(round(seconds / 0.02)):
            yield


def main() -> None:
    project, play = Path(sys.argv[1]), Play(sys.argv[2], sys.argv[3])
    folder = Path.cwd() / "project"
    shutil.copytree(project, folder, ignore=shutil.ignore_patterns("ctre_sim", "__pycache__", "networktables*"))
    os.chdir(folder)
    unmanaged.set_phoenix_diagnostics_start_time(-1)
    RobotPhysics.after_tick = lambda physics: play(physics)  # a plain instance would not be bound
    flags = sys.argv[4:]
    shutil.copy(Path(__file__).parents[1] / "robots" / "shared" / "measures.py", folder)  # for others
    sys.argv = ["robotpy", "sim", "--nogui", *flags]
    robotpy_main()


if __name__ == "__main__":
    main()
