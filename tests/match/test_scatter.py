"""Draws of scatter: each spread has its stated size and is independent of the other spreads."""

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from each_case import each

from games.rebuilt import REBUILT
from simcore.errors import ConfigError, UnknownNameError
from simcore.match.match import Match
from simcore.match.scatter import Scatter, ScatterDraws, built_robot, piece_variation, start_error
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.robot_config import BuiltRobot, RobotConfig
from simcore.robot.shooter import ShotErrors
from simcore.vision.camera import CameraConfig, PiecePipeline

ROBOT = REBUILT.robot()
TANK = RobotConfig(drivetrain=TankConfig(mass=50.0))
ROBOTS, PIECES, SHOTS = 40, 400, 100


def only(name: str, factor: float = 1.0) -> Scatter:
    return replace(Scatter.none(), **{name: factor * getattr(Scatter(), name)})


def leaves(value: object, path: str = "") -> Iterator[tuple[str, float | tuple[float, ...]]]:
    """Yield every number of a built robot with its path; for a supplier its next hundred values."""
    if isinstance(value, dict):
        for key, part in value.items():
            yield from leaves(part, f"{path}.{key}")
    elif isinstance(value, tuple):
        for number, part in enumerate(value):
            yield from leaves(part, f"{path}.{number}")
    elif dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from leaves(getattr(value, field.name), f"{path}.{field.name}")
    elif callable(value):
        yield path, tuple(value() for _ in range(SHOTS))
    elif isinstance(value, float) and not isinstance(value, bool):
        yield path, value


def drawn(scatter: Scatter, robot: int = 0, config: RobotConfig = ROBOT, seed: int = 5) -> dict[str, object]:
    """Return all draws of a match's scatter for one robot, and for its pieces."""
    draws = ScatterDraws(scatter, seed)
    found = dict(leaves(built_robot(config, draws, robot)))
    found |= {f"start.{axis}": value for axis, value in zip("xyw", start_error(draws, robot), strict=True)}
    pieces = piece_variation(draws, (PIECES, 7))
    found |= {f"piece.{f.name}": tuple(getattr(pieces, f.name).tolist()) for f in dataclasses.fields(pieces)}
    return found | {f"{name}": draws.factor(name, robot) for name in ("camera_noise", "human_players")}


CHANGED = {
    "piece_mass": {"piece.mass"},
    "piece_diameter": {"piece.diameter"},
    "restitution": {"piece.restitution"},
    "drag": {"piece.drag"},
    "tread_friction": {"wheel_cof"},
    "wheel_wear": {"wheel_radius"},
    "battery_charge": {"initial_charge"},
    "battery_resistance": {"battery.resistance", "recovery_resistance"},
    "motor_kt": {"stall_torque", "free_speed", "free_current"},
    "motor_resistance": {"stall_torque", "free_speed", "stall_current"},
    "swerve_friction": {"drive_friction_volts"},
    "drive_friction": {"friction_volts"},
    "drive_sides": {"drive_efficiency"},
    "encoder": {"steer_offset", "shot_errors.0.hood"},
    "gyro": {"bias_dps"},
    "start_position": {"start.x", "start.y"},
    "start_heading": {"start.w"},
}


@each("name", Scatter.names())
def test_each_spread_changes_only_its_own_values_whichever_other_spreads_are_on(name):
    config = TANK if name == "drive_friction" else ROBOT
    none, alone, every = (drawn(scatter, config=config) for scatter in (Scatter.none(), only(name), Scatter()))
    wanted = tuple(f".{end}" for end in CHANGED.get(name, {name}))
    changed = {path for path, value in alone.items() if value != none[path]}
    assert changed == {path for path in none if f".{path}".endswith(wanted)}
    for path in changed:
        if not path.endswith(("stall_torque", "free_speed")):  # both spreads of motors affect this number
            assert alone[path] == every[path], path
    assert drawn(only(name), config=config, seed=6) != alone
    assert (drawn(only(name), robot=1, config=config) == alone) == (
        name in ("piece_mass", "piece_diameter", "restitution", "drag")
    )


def test_a_robot_without_scatter_is_built_as_configured():
    for config in (ROBOT, TANK):
        built = dict(leaves(replace(built_robot(config, ScatterDraws(Scatter.none(), 3), 0), shot_errors=())))
        assert built == dict(leaves(BuiltRobot.exactly(config))) and len(built) > 40


def samples() -> dict[str, tuple[str, np.ndarray]]:
    """Return for each spread its distribution, and samples divided by its size."""
    size, draws = Scatter(), [ScatterDraws(Scatter(), seed) for seed in range(ROBOTS)]
    built = [built_robot(ROBOT, one, 0) for one in draws]
    pieces = piece_variation(draws[0], (PIECES,))
    shots: list[ShotErrors] = [one.shot_errors[0] for one in built]
    nominal = ROBOT.drivetrain.modules

    def of_shots(name, log=False):
        values = np.array([[getattr(one, name)() for _ in range(SHOTS)] for one in shots])
        return "normal", (np.log(values) if log else values) / getattr(size, name)

    def of_modules(value):
        return np.array([[value(m, n) for m, n in zip(b.drivetrain.modules, nominal, strict=True)] for b in built])

    def of_robots(value):
        return np.array([value(b) for b in built])

    motors = lambda b, n: b.drive_motor.kt / n.drive_motor.kt  # noqa: E731
    windings = lambda b, n: b.drive_motor.resistance / n.drive_motor.resistance  # noqa: E731
    wear = of_modules(lambda b, n: 1.0 - b.wheel_radius / n.wheel_radius)
    starts = np.array([start_error(one, 0) for one in draws])
    return {
        "exit_speed": of_shots("exit_speed", log=True),
        "elevation": of_shots("elevation"),
        "azimuth": of_shots("azimuth"),
        "spin": of_shots("spin", log=True),
        "feed_time": of_shots("feed_time"),
        "piece_mass": ("even", (pieces.mass - 1.0) / size.piece_mass),
        "piece_diameter": ("even", (pieces.diameter - 1.0) / size.piece_diameter),
        "restitution": ("normal", np.log(pieces.restitution) / size.restitution),
        "drag": ("normal", np.log(pieces.drag) / size.drag),
        "tread_friction": (
            "normal",
            np.log(of_robots(lambda b: b.drivetrain.modules[0].wheel_cof / nominal[0].wheel_cof)) / size.tread_friction,
        ),
        "wheel_wear": ("even", 2.0 * wear / size.wheel_wear - 1.0),
        "battery_charge": (
            "even",
            2.0 * (1.0 - of_robots(lambda b: b.battery.initial_charge)) / size.battery_charge - 1.0,
        ),
        "battery_resistance": (
            "normal",
            np.log(of_robots(lambda b: b.battery.resistance / ROBOT.battery.resistance)) / size.battery_resistance,
        ),
        "motor_kt": ("normal", np.log(of_modules(motors)) / size.motor_kt),
        "motor_resistance": ("normal", np.log(of_modules(windings)) / size.motor_resistance),
        "swerve_friction": (
            "normal",
            np.log(of_modules(lambda b, n: b.drive_friction_volts / n.drive_friction_volts)[:, 0])
            / size.swerve_friction,
        ),
        "drive_friction": (
            "normal",
            np.log([built_robot(TANK, one, 0).drivetrain[0].friction_volts / 0.65 for one in draws])
            / size.drive_friction,
        ),
        "drive_sides": (
            "even",
            2.0 * of_modules(lambda b, n: 1.0 - b.drive_efficiency / n.drive_efficiency) / size.drive_sides - 1.0,
        ),
        "encoder": ("normal", of_modules(lambda b, n: b.steer_offset) / size.encoder),
        "gyro": ("normal", np.radians(of_robots(lambda b: b.gyro.bias_dps)) / size.gyro),
        "start_position": ("normal", starts[:, :2] / size.start_position),
        "start_heading": ("normal", starts[:, 2] / size.start_heading),
        "camera_noise": ("normal", np.log([one.factor("camera_noise", 0, 7) for one in draws]) / size.camera_noise),
        "human_players": ("normal", np.log([one.factor("human_players", 1) for one in draws]) / size.human_players),
    }


def test_each_spread_has_its_stated_size():
    """Means and mean squares of n samples are within 4 standard errors, which one number in 16,000 exceeds."""
    found = samples()
    assert set(found) == set(Scatter.names())
    for name, (kind, values) in found.items():
        z, n = values.ravel(), values.size
        if kind == "even":  # even from -1 to 1: variance 1/3, and of the squares 4/45
            assert np.abs(z).max() <= 1.0 + 1e-9, name
            variance, of_squares = 1.0 / 3.0, 4.0 / 45.0
        else:
            assert np.abs(z).max() < 5.5, name
            variance, of_squares = 1.0, 2.0
        assert abs(z.mean()) < 4.0 * math.sqrt(variance / n), name
        assert abs((z * z).mean() - variance) < 4.0 * math.sqrt(of_squares / n), name


@each(
    ("make", "problem"),
    [
        (lambda: Scatter(exit_speed=-0.1), "exit_speed must be a number from 0 to 0.5, got -0.1"),
        (lambda: Scatter(elevation=math.nan), "elevation must be a number from 0 to 0.5 rad, got nan"),
        (lambda: Scatter(wheel_wear="1"), "wheel_wear must be a number from 0 to 0.5, got '1'"),
        (lambda: Scatter().scaled(-1.0), "factor must be a number from 0"),
        (lambda: Scatter().scaled(50.0), "exit_speed must be a number from 0 to 0.5, got 1.5"),
        (lambda: Scatter.parse("much"), "scatter must be a factor of the default spreads"),
        (lambda: Scatter.parse("1,exit_speed"), "scatter must be a factor of the default spreads"),
        (lambda: Match.bare(scatter=0.5), "scatter must be a Scatter or None, got 0.5"),
    ],
)
def test_invalid_scatter_is_refused(make, problem):
    with pytest.raises(ConfigError, match=problem.replace("(", r"\(")):
        make()
    with pytest.raises(UnknownNameError, match="Did you mean 'elevation'"):
        Scatter.parse("1,elevatoin=0.1")


def test_a_robot_stands_at_the_scattered_pose_but_estimates_the_intended_pose():
    start = (4.0, 3.0, 0.5)
    scatter = replace(Scatter.none(), start_position=0.05, start_heading=0.1)
    with Match.bare(start=start, scatter=scatter, seed=2) as match:
        (robot,) = match.robots
        ahead, left, turn = start_error(match.draws, 0)
        c, s = math.cos(0.5), math.sin(0.5)
        there = (4.0 + c * ahead - s * left, 3.0 + s * ahead + c * left, 0.5 + turn)
        assert robot.chassis.pose == pytest.approx(there)
        assert robot.odometry.pose == pytest.approx(start) and robot.gyro.yaw == pytest.approx(0.5)
        assert robot.reckoned_pose == pytest.approx(start)
        robot.drive.set_volts([6.0] * 4, [0.0] * 4)
        match.play(0.5)
        gone = robot.chassis.pose[0] - there[0], robot.chassis.pose[1] - there[1]
        way = math.hypot(*gone)
        assert way > 0.5  # straight ahead by its estimate: the true path is rotated by the error of its start heading
        assert robot.reckoned_pose[:2] == pytest.approx((4.0 + c * way, 3.0 + s * way), abs=0.01)
        match.carry_to(0, (2.0, 2.0, 0.0))
        assert robot.chassis.pose == pytest.approx((2.0, 2.0, 0.0)) == robot.reckoned_pose
        match.carry_to(0, (2.0, 2.0, 0.0), by_people=True)
        assert robot.chassis.pose == pytest.approx((2.0 + ahead, 2.0 + left, turn))


def test_a_scattered_start_pose_is_never_inside_a_wall():
    """With each of 12 seeds, the robot is meant to start 2 mm from the wall y = 0."""
    scatter = replace(Scatter.none(), start_position=0.03)
    moved = []
    with Match.bare(start=(4.0, 0.402, 0.0), scatter=scatter) as match:
        for seed in range(12):
            match.reset(seed)
            y = match.robots[0].chassis.pose[1]
            assert y >= 0.4
            moved.append(y != pytest.approx(0.402))
    assert sum(moved) >= 8


def test_scatter_scales_the_noise_of_cameras():
    cameras = tuple(CameraConfig(name=name, pipelines=(PiecePipeline(),)) for name in ("a", "b"))
    with Match.bare(replace(TANK, cameras=cameras), scatter=only("camera_noise")) as match:
        factors = []
        for camera in match.cameras.cameras.values():
            factor = camera.config.type.corner_noise / cameras[0].type.corner_noise
            assert camera.config.pipelines[0].box_noise == pytest.approx(factor)
            factors.append(factor)
        assert factors[0] != factors[1] and all(0.3 < factor < 3.0 for factor in factors)
