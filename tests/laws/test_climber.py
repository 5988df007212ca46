"""A robot lifts itself on a rung by a hook on an elevator, hangs, and comes down when the hook leaves the rung."""

from __future__ import annotations

import numpy as np
import pytest

from simcore.errors import ConfigError, UnknownNameError
from simcore.match.motion import Motion
from simcore.robot.climber import ClimberConfig, Rung
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import ElevatorConfig
from simcore.robot.robot import Robot
from simcore.robot.robot_config import RobotConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.units import GRAVITY
from simcore.world.linkage import Joint
from simcore.world.world import PhysicsWorld

pytestmark = pytest.mark.engines("bullet")

DT, MASS, DRUM, CARRIAGE = 0.02, 45.0, 0.02, 2.0
RUNG = Rung(name="rung", start=(0.0, -0.6, 0.75), end=(0.0, 0.6, 0.75))
GEARBOX = GearboxConfig(motor=motor("Kraken X60"), motors=2, gearing=60.0, stator_current_limit=60.0)
HOOK = Joint(mechanism="hook", axis=(0.0, 0.0, 1.0), origin=(0.0, 0.0, 0.35), slides=True, ratio=DRUM)


@pytest.fixture
def hanging():
    """Yield a robot below a rung with its hook above the rung, and the world."""
    config = RobotConfig(
        drivetrain=SwerveConfig.square(0.5, SwerveModuleConfig(x=0.0, y=0.0), mass=MASS, bumper=0.75),
        bumper=(0.75, 0.75),
        mechanisms={
            "hook": ElevatorConfig(
                gearbox=GEARBOX, carriage_mass=CARRIAGE, drum_radius=DRUM, max_height=0.6, start_height=0.45
            )
        },
        climbers=(ClimberConfig(joints=(HOOK,)),),
    )
    with PhysicsWorld() as world:
        yield Robot(world, config, rng=np.random.default_rng(0), rungs=(RUNG,)), world


def advance(robot, world, seconds, volts):
    motion = Motion(world, robots=[robot])
    for _ in range(round(seconds / DT)):
        robot.mechanisms["hook"].set_volts(volts)
        motion.tick()


def test_the_robot_stands_until_the_hook_comes_down_on_the_rung(hanging):
    robot, world = hanging
    advance(robot, world, 0.2, robot.mechanisms["hook"].holding_volts)
    assert robot.climbers[0].rung is None
    assert robot.chassis.pos[2] == pytest.approx(0.0, abs=0.003)
    advance(robot, world, 0.6, -3.0)
    assert robot.climbers[0].rung is RUNG


def test_a_climber_lifts_its_robot_and_the_forces_balance(hanging):
    """At rest the rung bears the whole weight, and the drum torque is weight times drum radius."""
    robot, world = hanging
    hook = robot.mechanisms["hook"]
    advance(robot, world, 2.0, -6.0)
    assert robot.chassis.pos[2] > 0.1
    weight = MASS * GRAVITY
    for _ in range(300):  # height control as in robot code, with the weight as feedforward
        wanted = 0.2
        error = (wanted - hook.height) / DRUM
        advance(robot, world, DT, -GEARBOX.holding_volts((weight - CARRIAGE * GRAVITY) * DRUM) + 0.5 * error)
    assert robot.chassis.vel[2] == pytest.approx(0.0, abs=5e-3)
    assert robot.chassis.pos[2] == pytest.approx(0.75 - 0.35 - hook.height, abs=0.02), "but for what the hook gives"
    (_, _, lift), torque = robot.climbers[0].push(DT / 4)
    assert lift == pytest.approx(weight, rel=0.03)
    assert np.hypot(*torque[:2]) < 0.02 * weight
    assert hook.load_torque + CARRIAGE * GRAVITY * DRUM == pytest.approx(weight * DRUM, rel=0.03)
    assert hook.current / GEARBOX.motors * GEARBOX.torque_per_amp == pytest.approx(-hook.load_torque, rel=0.05)


def test_at_zero_volts_the_robot_sinks_at_the_speed_of_its_shorted_motors(hanging):
    """w = torque R / (kt ke) at the drum; the robot stays on the rung."""
    robot, world = hanging
    hook = robot.mechanisms["hook"]
    advance(robot, world, 1.5, -6.0)
    advance(robot, world, 0.4, 0.0)
    before = robot.chassis.pos[2]
    advance(robot, world, 0.5, 0.0)
    torque = (MASS * GRAVITY - CARRIAGE * GRAVITY) * DRUM
    speed = torque * GEARBOX.resistance / (GEARBOX.torque_per_amp * GEARBOX.volts_per_speed) * DRUM
    assert robot.climbers[0].rung is RUNG
    assert before - robot.chassis.pos[2] == pytest.approx(0.5 * speed, rel=0.1)
    assert hook.velocity > 0.0


def test_the_robot_comes_down_and_is_free_when_the_hook_leaves_the_rung(hanging):
    robot, world = hanging
    advance(robot, world, 1.5, -6.0)
    assert robot.climbers[0].rung is RUNG
    advance(robot, world, 1.5, 6.0)
    assert robot.climbers[0].rung is None
    assert robot.climbers[0].push(DT / 4)[0] == (0.0, 0.0, 0.0)
    assert robot.chassis.pos[2] == pytest.approx(0.0, abs=0.003)


def test_a_hook_that_releases_in_the_air_drops_the_robot(hanging):
    """z = h - g t^2 / 2 until it lands."""
    robot, world = hanging
    advance(robot, world, 1.5, -6.0)
    height = robot.chassis.pos[2]
    robot.climbers[0].rung, robot.climbers[0]._rungs = None, ()
    advance(robot, world, 0.1, 0.0)
    fallen = height - robot.chassis.pos[2]
    assert fallen == pytest.approx(0.5 * GRAVITY * 0.1**2, abs=0.02)
    advance(robot, world, 1.0, 0.0)
    assert robot.chassis.pos[2] == pytest.approx(0.0, abs=0.003)


def test_invalid_rungs_and_climbers_are_refused():
    with pytest.raises(ConfigError, match="ends must differ"):
        Rung(name="r", start=(0.0, 0.0, 1.0), end=(0.0, 0.0, 1.0))
    with pytest.raises(ConfigError, match="at least one joint"):
        ClimberConfig(joints=())
    with pytest.raises(UnknownNameError, match="for a climber"):
        RobotConfig(
            drivetrain=SwerveConfig.square(0.5, SwerveModuleConfig(x=0.0, y=0.0)),
            climbers=(ClimberConfig(joints=(HOOK,)),),
        )
    assert RUNG.nearest((0.3, 0.1, 2.0)) == (0.0, pytest.approx(0.1), 0.75)
    assert RUNG.nearest((0.3, 5.0, 0.0)) == (0.0, pytest.approx(0.6), 0.75)
