"""Default robot of REEFSCAPE: swerve drive, elevator, arm with coral claw and algae wheel, funnel and climber.

Numbers without a source are our choice for a plausible robot.
"""

from __future__ import annotations

from dataclasses import replace

from games.reefscape.dimensions import CAGE_SIZE
from simcore.robot.chassis_config import ChassisConfig, MovingMass
from simcore.robot.climber import ClimberConfig
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig, default_friction
from simcore.robot.intake import IntakeConfig, IntakeZone
from simcore.robot.mechanisms import ArmConfig, ElevatorConfig, RollerConfig
from simcore.robot.placer import PlacerConfig
from simcore.robot.robot_config import ComponentConfig, MechanismConfig, RobotConfig
from simcore.robot.storage import StorageConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.units import degrees
from simcore.world.linkage import Joint
from simcore.world.rotation import from_rpy

__all__ = [
    "ALGAE_REACH",
    "BUMPER",
    "CORAL_REACH",
    "CORAL_TILT",
    "FLOOR_PIVOT_HEIGHT",
    "PIVOT",
    "elevator_turns",
    "reefscape_robot",
]

_DRUM = 0.064  # [m]; carriage travel per radian, three times the drum's radius for two stages and the carriage
_HOOK_DRUM = 0.012  # [m]; drum radius of the climber's winch
BUMPER = 0.80
"""Length and width over the bumpers [m]."""
PIVOT = (0.12, 0.0, 0.45)
"""Position of the arm's pivot with the elevator at the bottom, robot frame [m]."""
CORAL_REACH = 0.46
"""Distance from the arm's pivot to the center of a coral in the claw [m]."""
CORAL_TILT = degrees(35.0)
"""Tilt of a coral in the claw toward the robot, relative to the perpendicular to the arm [rad]. The coral is upright
while the arm points down by this angle."""
FLOOR_PIVOT_HEIGHT = 0.62
"""Height of the arm's pivot while the claw takes coral off the carpet [m]."""
ALGAE_REACH = 0.73
"""Distance from the arm's pivot to the center of an algae at the algae wheel [m]."""


def elevator_turns(pivot_height: float) -> float:
    """Compute the angle of the elevator's drum [rad] at which the arm's pivot has a given height [m]."""
    return (pivot_height - PIVOT[2]) / _DRUM


def _gearbox(gearing: float, *, motors: int = 1, limit: float = 60.0) -> GearboxConfig:
    return GearboxConfig(motor=motor("Kraken X60"), motors=motors, gearing=gearing, stator_current_limit=limit)


_WINCH = _gearbox(50.0, motors=2)
_MECHANISMS: dict[str, MechanismConfig] = {
    "elevator": ElevatorConfig(gearbox=_gearbox(26.0, motors=2), carriage_mass=8.0, drum_radius=_DRUM, max_height=1.90),
    "arm": ArmConfig(
        gearbox=_gearbox(60.0),
        inertia=0.6,
        mass=3.0,
        center_of_mass=0.3,
        min_angle=degrees(-75.0),  # low, so that the arm does not count as lowered at the release on level 4
        max_angle=degrees(90.0),
        start_angle=degrees(85.0),
    ),
    "claw": RollerConfig(gearbox=_gearbox(4.0, limit=40.0), inertia=0.001, radius=0.025),
    "algae_wheel": RollerConfig(gearbox=_gearbox(6.0, limit=40.0), inertia=0.002, radius=0.05),
    "funnel": RollerConfig(gearbox=_gearbox(3.0, limit=40.0), inertia=0.001, radius=0.025),
    "climber": ElevatorConfig(
        # gear friction, 11.8 N m, is twice the torque of the robot's weight, so the climber holds without power
        gearbox=replace(_WINCH, friction_torque=default_friction(_WINCH)),
        carriage_mass=2.0,
        drum_radius=_HOOK_DRUM,
        max_height=0.55,
    ),
}

_LIFT = Joint(mechanism="elevator", axis=(0.0, 0.0, 1.0), origin=PIVOT, slides=True, ratio=_DRUM)
_SWING = Joint(mechanism="arm", axis=(0.0, -1.0, 0.0))
_HOOK = Joint(mechanism="climber", axis=(0.0, 0.0, 1.0), origin=(0.0, 0.0, 0.30), slides=True, ratio=_HOOK_DRUM)


_BEFORE_BUMPER = IntakeZone(x_min=0.24, x_max=0.50, y_min=-0.25, y_max=0.25, z_min=-0.62, z_max=-0.42)
"""Zone in which the claw takes coral off the carpet, in a frame at the arm's pivot with robot axes."""


def _roller(name: str, x: float, z: float) -> Joint:
    """Return the hinge joint of a roller with an axle along y, at x and z in the frame of the carrying part [m]."""
    return Joint(mechanism=name, axis=(0.0, 1.0, 0.0), origin=(x, 0.0, z))


def _around(reach: float, spare: float) -> IntakeZone:
    """Return a cubic zone with the half width `spare` [m] around a point on the arm at a distance `reach` [m]."""
    return IntakeZone(x_min=reach - spare, x_max=reach + spare, y_min=-spare, y_max=spare, z_min=-spare, z_max=spare)


def reefscape_robot() -> RobotConfig:
    """Build the config of a 52 kg robot with an elevator that lifts up to 11 kg.

    The robot takes coral from a station at the rear, or off the carpet with the lowered arm at the front. The arm
    places coral at the front. The algae wheel holds algae farther out on the arm. To climb, the robot drives backward
    until a cage is in the bay at the rear and the hook is above or in the cage. The robot then hangs level.
    """
    module = SwerveModuleConfig(
        x=0.0,
        y=0.0,
        drive_stator_limit=60.0,
        drive_supply_limit=40.0,
        steer_stator_limit=40.0,
        steer_supply_limit=20.0,
    )
    drivetrain = SwerveConfig.square(0.5334, module, mass=52.0, bumper=BUMPER)
    body = ChassisConfig.around(drivetrain, bumper=(BUMPER, BUMPER))
    return RobotConfig(
        drivetrain=drivetrain,
        bumper=(BUMPER, BUMPER),
        chassis=replace(body, bay=(0.5 * BUMPER + 0.5 * CAGE_SIZE + 0.04, CAGE_SIZE + 0.11)),
        mechanisms=_MECHANISMS,
        intakes=(
            IntakeConfig(
                zone=IntakeZone(x_min=-0.48, x_max=-0.10, y_min=-0.33, y_max=0.33, z_min=0.55, z_max=1.10),
                roller="funnel",
                kinds=("Coral",),
            ),
            IntakeConfig(  # claw in front of the front bumper
                joints=(_LIFT,),
                zone=_BEFORE_BUMPER,
                roller="claw",
                deploy="arm",
                deployed_at="lower",
                kinds=("Coral",),
            ),
        ),
        storage=StorageConfig(capacity=1, low=(-0.30, -0.20, 0.45), high=(0.0, 0.20, 0.75)),
        placers=(
            PlacerConfig(
                joints=(_LIFT, _SWING),
                offset=(CORAL_REACH, 0.0, 0.0),
                attitude=from_rpy(0.0, -CORAL_TILT, 0.0),
                roller="claw",
                zone=_around(CORAL_REACH, 0.06),
                from_storage=True,
                kinds=("Coral",),
            ),
            PlacerConfig(
                joints=(_LIFT, _SWING),
                offset=(ALGAE_REACH, 0.0, 0.0),
                roller="algae_wheel",
                zone=_around(ALGAE_REACH, 0.14),
                kinds=("Algae",),
            ),
        ),
        climbers=(ClimberConfig(joints=(_HOOK,)),),
        components=(
            ComponentConfig(name="elevator stage 1", joints=(replace(_LIFT, ratio=_DRUM / 3.0),)),
            ComponentConfig(name="elevator stage 2", joints=(replace(_LIFT, ratio=2.0 * _DRUM / 3.0),)),
            ComponentConfig(name="carriage", joints=(_LIFT,)),
            ComponentConfig(name="arm", joints=(_LIFT, _SWING)),
            ComponentConfig(name="coral roller", joints=(_LIFT, _SWING, _roller("claw", 0.395, -0.045))),
            ComponentConfig(name="algae wheel", joints=(_LIFT, _SWING, _roller("algae_wheel", 0.543, -0.158))),
            ComponentConfig(name="funnel roller", joints=(_roller("funnel", -0.15, 0.68),)),
            ComponentConfig(name="hook", joints=(_HOOK,)),
        ),
        # Effective mass at the elevator's motors, which is `carriage_mass`: 3 / 3 + 2 * 3 / 3 + 2 + 3 = 8 kg.
        moving_masses=(
            MovingMass(name="elevator stage 1", mass=3.0, joints=(replace(_LIFT, ratio=_DRUM / 3.0),)),
            MovingMass(name="elevator stage 2", mass=3.0, joints=(replace(_LIFT, ratio=2.0 * _DRUM / 3.0),)),
            MovingMass(name="carriage", mass=2.0, joints=(_LIFT,)),
            MovingMass(name="arm", mass=3.0, joints=(_LIFT, _SWING), center=(0.3, 0.0, 0.0)),
        ),
    )
