"""Runs a robot project under `robotpy sim --nogui`, unmodified, and plays the driver station from inside.

Arguments: the project's folder and what to play. Reports what truly happened on the field.
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
from wpimath.geometry import Pose2d, Rotation2d

import simcore.phoenix6.swerve as swerve
from simcore.robotpy.robot_physics import RobotPhysics, field_control

A, B, X, Y, LEFT_BUMPER = 1, 2, 3, 4, 5


class Play:
    """One scripted driver; called after every tick of the physics."""

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

    # --- the plays ----------------------------------------------------------------------------------------------

    def auto(self, physics):
        """20 s of autonomous; the auto is the one named in AUTO, or the default."""
        DriverStationSim.notifyNewData()  # the alliance
        if "AUTO" in os.environ:
            NetworkTableInstance.getDefault().getEntry("/SmartDashboard/Auto/selected").setString(os.environ["AUTO"])
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
        self.results["end"] = path[-1]
        self.results["match_time"] = DriverStation.getMatchTime()

    def teleop(self, physics):
        """Joystick and buttons only: shoot the preload, drive back with the intake out, turn, hood."""
        DriverStationSim.setJoystickAxisCount(0, 6)
        DriverStationSim.setJoystickButtonCount(0, 10)
        DriverStationSim.setJoystickPOVCount(0, 0)
        DriverStationSim.notifyNewData()  # the alliance
        yield from self.wait(1.0)
        self.enable(autonomous=False)
        yield from self.wait(0.2)
        feeder, plant, shots = physics.robot.container.feeder, physics.robot_sim, physics.match.record.shots
        DriverStationSim.setJoystickButton(0, Y, True)
        DriverStationSim.notifyNewData()
        for _ in range(100):
            if shots:
                break
            self.results["wheels_rps"] = plant.mechanisms["shooter"].velocity / math.tau  # just before the first shot
            yield
        self.results["goal_rps"] = physics.robot.container.shooter.goal_rps
        feed = feeder.set_turning
        feed(False)
        feeder.set_turning = lambda turning: None  # as if it were jammed
        yield from self.wait(0.3)
        fired = len(shots)
        yield from self.wait(1.0)
        self.results["shots_while_jammed"] = len(shots) - fired
        self.results["wheels_rps_while_jammed"] = plant.mechanisms["shooter"].velocity / math.tau
        feeder.set_turning = feed
        yield from self.hold(Y, 2.0)
        self.results["hits_of_preload"] = physics.match.record.hits
        start = physics.robot_sim.chassis.pose
        self.axes(left_y=-0.5)  # W, half: away from the blue wall at 2 m/s
        yield from self.wait(0.6)
        self.axes()
        yield from self.wait(0.6)
        self.results["ahead"] = physics.robot_sim.chassis.pose[0] - start[0]
        before = physics.robot_sim.chassis.pose[2]
        self.axes(right_x=-0.4)  # Q
        yield from self.wait(0.5)
        self.axes()
        yield from self.wait(0.4)
        self.results["turned"] = math.remainder(physics.robot_sim.chassis.pose[2] - before, math.tau)
        hood = physics.robot_sim.mechanisms["hood"]
        angle = math.degrees(hood.position)
        yield from self.hold(X, 0.5)
        yield from self.wait(0.5)
        self.results["hood_raised_deg"] = math.degrees(hood.position) - angle
        yield from self.hold(B, 0.5)
        yield from self.hold(A, 0.1)
        yield from self.wait(0.6)
        self.results["intake_active"] = physics.robot_sim.intakes[0].is_active
        # a driver sees the robot: stick by eye to the depot, in and out of it, and back
        for x, y, yaw, fastest, seconds in (
            (1.7, 5.96, 0.0, 0.5, 2.5),
            (0.9, 5.96, 0.0, 0.3, 2.0),
            (0.95, 6.2, 0.0, 0.2, 1.2),
            (0.95, 5.7, 0.0, 0.2, 1.6),
            (2.4, 5.2, -0.4, 0.5, 2.5),
        ):
            yield from self.stick_to(physics, x, y, yaw, fastest, seconds)
        self.results["held"] = physics.match.count.held
        yield from self.hold(A, 0.1)
        yield from self.hold(Y, 5.0)

    def stick_to(self, physics, x: float, y: float, yaw: float, fastest: float, seconds: float):
        for _ in range(round(seconds / 0.02)):
            here_x, here_y, heading = physics.robot_sim.chassis.pose
            dx, dy, turn = x - here_x, y - here_y, math.remainder(yaw - heading, math.tau)
            way = math.hypot(dx, dy)
            if way < 0.05 and abs(turn) < 0.05:
                break
            push = min(fastest, 0.6 * way + 0.06) / max(way, 1e-6)
            self.axes(left_x=-push * dy, left_y=-push * dx, right_x=-min(max(0.6 * turn, -0.4), 0.4))
            yield
        self.axes()
        yield from self.wait(0.2)

    def straight(self, physics):
        """Half a stick ahead for two seconds; plain robots drive ahead without."""
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
        self.results["own_hook"] = getattr(type(physics.robot), "own_hook", None)
        self.results["volts_seen"] = RobotController.getBatteryVoltage()

    def control(self, physics):
        """A dashboard places the robot and puts a piece before it; robot code asks for the same."""
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

    def cameras(self, physics):
        """Odometry is told a wrong place, and cameras see the right one; then the driver asks for fuel."""
        DriverStationSim.setJoystickAxisCount(0, 6)
        DriverStationSim.setJoystickButtonCount(0, 10)
        DriverStationSim.notifyNewData()
        yield from self.wait(1.0)
        self.enable(autonomous=False)
        yield from self.wait(0.2)
        tables = NetworkTableInstance.getDefault()
        drivetrain, plant = physics.robot.container.drivetrain, physics.robot_sim
        orientation = tables.getDoubleArrayTopic("/limelight-two/robot_orientation_set").subscribe([])
        x, y, yaw = plant.chassis.pose
        drivetrain.reset_pose(Pose2d(x + 0.5, y - 0.3, Rotation2d(yaw)))

        def error() -> float:
            pose = drivetrain.get_state().pose
            return math.dist((pose.X(), pose.Y()), plant.chassis.pose[:2])

        before = []
        for _ in range(5):
            before.append(error())
            yield
        self.results["error_before"] = max(before)
        self.axes(left_y=-0.25)
        after = []
        for k in range(100):
            if k == 50:
                self.axes()
            after.append(error())
            yield
        self.results["seconds_to_5_cm"] = 0.02 * next((k for k, e in enumerate(after) if e < 0.05), 10**6)
        self.results["error_after"] = error()
        self.results["heading_told"] = orientation.get()[0]
        self.results["heading"] = math.degrees(plant.chassis.pose[2])
        yield from self.stick_to(physics, 2.6, 5.3, -0.5, 0.4, 2.0)
        DriverStationSim.setJoystickButton(0, LEFT_BUMPER, True)
        DriverStationSim.notifyNewData()
        yield from self.wait(4.0)
        DriverStationSim.setJoystickButton(0, LEFT_BUMPER, False)
        DriverStationSim.notifyNewData()
        yield

    def push(self, physics):
        """The pushing robot leans on the wall for two seconds and lets go."""
        DriverStationSim.notifyNewData()
        yield from self.wait(1.0)
        self.enable(autonomous=False)
        off, drawn = 0, []
        for _ in range(100):
            off += physics.robot_sim.battery.browned_out
            drawn.append(physics.robot_sim.mechanisms["shooter"].current)
            yield
        robot = physics.robot
        self.results["seen_volts"] = [volts for volts, _, _ in robot.seen]
        self.results["rail_was_off"] = sum(not on for _, on, _ in robot.seen)
        self.results["is_browned_out"] = any(low for _, _, low in robot.seen)
        self.results["ticks_off"] = off
        self.results["shooter_amps"] = drawn
        self.results["faults"] = RobotController.getFaultCount6V()
        self.results["moved"] = math.dist(physics.robot_sim.chassis.pose[:2], (0.45, 2.2))
        DriverStationSim.setEnabled(False)
        DriverStationSim.notifyNewData()
        yield from self.wait(0.5)
        self.results["volts_after"] = RobotController.getBatteryVoltage()
        self.results["rail_after"] = RobotController.getEnabled6V()

    def ports(self, physics):
        """The robot of ports and sensors: homes its hood, takes in what it backs into, and throws some of it."""
        DriverStationSim.setJoystickAxisCount(0, 6)
        DriverStationSim.setJoystickButtonCount(0, 10)
        DriverStationSim.notifyNewData()
        yield from self.wait(0.4)
        self.enable(autonomous=False)
        yield from self.wait(0.8)
        robot, mechanisms = physics.robot, physics.robot_sim.mechanisms
        self.results["homed"] = robot.facts()
        self.results["hood_deg"] = math.degrees(mechanisms["hood"].position)
        DriverStationSim.setJoystickButton(0, A, True)
        self.axes(left_y=0.5)
        for _ in range(90):
            yield
            if physics.match.count.held >= 3 and mechanisms["deploy"].extension == 0.2:
                break
        self.axes()
        yield from self.wait(0.3)
        self.results["held"] = physics.match.count.held
        self.results["full"] = robot.facts()
        snapshot = physics.match.snapshot()
        self.results["sensors"] = {k: v for k, v in snapshot.booleans.items() if "/Sensors/" in k}
        self.results["lights"] = snapshot.strings["Sim/Lights/CANdle40/Shows"]
        DriverStationSim.setJoystickButton(0, A, False)
        yield from self.hold(X, 1.5)
        self.results["left"] = len(physics.match.record.shots)

    def shape(self, physics):
        """Any robot: 5 m across the field, into the fuel of the depot, and against the wall."""
        DriverStationSim.setJoystickAxisCount(0, 6)
        DriverStationSim.setJoystickButtonCount(0, 10)
        DriverStationSim.notifyNewData()
        yield from self.wait(0.4)
        drivetrain, chassis = swerve.only_drivetrain(), physics.robot_sim.chassis
        start, before = chassis.pose, drivetrain.get_state().pose
        self.enable(autonomous=False)
        told, true = [], []
        for tick in range(170):
            self.hold_heading(chassis, left_x=-0.8)  # 2.4 m/s to the left
            yield
            if math.dist(chassis.pose[:2], start[:2]) > 5.0:
                break
            if tick > 60:
                speeds = drivetrain.get_state().speeds
                told.append(math.hypot(speeds.vx, speeds.vy))
                true.append(math.hypot(*chassis.ground_velocity[:2]))
        self.axes()
        yield from self.wait(0.5)
        end, after = chassis.pose, drivetrain.get_state().pose
        self.results["start"] = start
        self.results["believed_start"] = (before.X(), before.Y())
        self.results["true_way"] = math.dist(end[:2], start[:2])
        self.results["odometry_way"] = math.hypot(after.X() - before.X(), after.Y() - before.Y())
        self.results["true_speed"], self.results["told_speed"] = float(np.mean(true)), float(np.mean(told))
        self.results["yaw_error"] = abs(
            math.remainder(after.rotation().radians() - before.rotation().radians() - end[2] + start[2], math.tau)
        )
        fuel = physics.match.piece_positions()["Fuel"].copy()
        for _ in range(100):
            self.hold_heading(chassis, left_y=0.6)  # back, into the depot
            yield
            if chassis.pose[0] < 0.7:
                break
        self.axes()
        yield from self.wait(0.2)
        now = physics.match.piece_positions()["Fuel"]
        gone = len(fuel) - len(now)
        self.results["x_in_depot"] = chassis.pose[0]
        self.results["pushed"] = gone + int((np.linalg.norm(now - fuel[: len(now)], axis=1) > 0.02).sum())
        for _ in range(100):
            self.hold_heading(chassis, left_y=-0.6)  # out of it, to where the wall is clear
            yield
            if chassis.pose[0] > 2.0:
                break
        places = []
        for _ in range(100):
            self.hold_heading(chassis, left_x=-0.8)
            yield
            places.append(chassis.pose[1])
        self.results["gap_at_wall"] = 8.069 - chassis.config.bumper_width / 2 - max(places)
        self.results["speed_at_wall"] = abs(places[-1] - places[-51])  # mean of the last second
        if physics.settings.shooters:
            self.results["held_before_shots"] = physics.match.count.held
            yield from self.hold(A, 1.8)
        self.results["facts"] = physics.robot.facts() if hasattr(physics.robot, "facts") else {}
        self.results["held"] = physics.match.count.held

    # --- a driver's hands ---------------------------------------------------------------------------------------

    def enable(self, *, autonomous: bool) -> None:
        DriverStationSim.setDsAttached(True)
        DriverStationSim.setAutonomous(autonomous)
        DriverStationSim.setEnabled(True)
        DriverStationSim.notifyNewData()

    def axes(self, left_x: float = 0.0, left_y: float = 0.0, right_x: float = 0.0) -> None:
        for axis, value in ((0, left_x), (1, left_y), (4, right_x)):
            DriverStationSim.setJoystickAxis(0, axis, value)
        DriverStationSim.notifyNewData()

    def hold_heading(self, chassis, left_x: float = 0.0, left_y: float = 0.0) -> None:
        """As a driver does, who sees the robot turn: modules that steer at different speeds give it a kick."""
        self.axes(left_x, left_y, min(max(0.8 * chassis.pose[2], -0.5), 0.5))

    def hold(self, button: int, seconds: float):
        DriverStationSim.setJoystickButton(0, button, True)
        DriverStationSim.notifyNewData()
        yield from self.wait(seconds)
        DriverStationSim.setJoystickButton(0, button, False)
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
    shutil.copy(Path(__file__).parents[1] / "robots" / "shared" / "measures.py", folder)  # for those without their own
    sys.argv = ["robotpy", "sim", "--nogui", *flags]
    robotpy_main()


if __name__ == "__main__":
    main()
