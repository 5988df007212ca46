"""Default robot of REBUILT: swerve drive, over-the-bumper intake at the rear, hopper, and shooter with two barrels.

Numbers without a source are our choice for a plausible robot.
"""

from __future__ import annotations

from dataclasses import replace

from simcore.pieces.launch import LaunchParameters
from simcore.robot.climber import ClimberConfig
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig, default_friction
from simcore.robot.intake import IntakeConfig, IntakeZone
from simcore.robot.mechanisms import ArmConfig, ElevatorConfig, FlywheelConfig, RackConfig, RollerConfig
from simcore.robot.robot_config import ComponentConfig, MechanismConfig, RobotConfig
from simcore.robot.shooter import ShooterConfig
from simcore.robot.storage import StorageConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.units import degrees
from simcore.world.linkage import Joint

__all__ = ["CLIMBER", "MECHANISMS", "climbing_robot", "rebuilt_robot"]

_PINION = 0.019  # [m]; pinion radius of the intake's rack
_OUTWARD = (-1.0, 0.0, 0.0)

MECHANISMS: dict[str, MechanismConfig] = {
    "shooter": FlywheelConfig(
        gearbox=GearboxConfig(motor=motor("Kraken X60"), motors=4, gearing=24 / 36, stator_current_limit=40.0),
        inertia=0.008,
    ),
    "hood": ArmConfig(
        gearbox=GearboxConfig(motor=motor("Kraken X44"), gearing=90.0, stator_current_limit=30.0),
        inertia=0.05,
        mass=1.2,
        center_of_mass=0.12,
        min_angle=degrees(20.0),
        max_angle=degrees(65.0),
    ),
    "feeder": RollerConfig(
        gearbox=GearboxConfig(motor=motor("Kraken X60"), gearing=2.0, stator_current_limit=60.0),
        inertia=0.002,
        radius=0.025,
    ),
    "spindexer": RollerConfig(
        gearbox=GearboxConfig(motor=motor("Kraken X60"), gearing=5.0, stator_current_limit=60.0),
        inertia=0.02,
        radius=0.2,
    ),
    "intake_deploy": RackConfig(
        gearbox=GearboxConfig(motor=motor("Kraken X60"), gearing=10.0, stator_current_limit=40.0),
        mass=4.0,
        pinion_radius=_PINION,
        travel=0.28,
    ),
    "intake_roller": RollerConfig(
        gearbox=GearboxConfig(motor=motor("Kraken X60"), gearing=3.0, stator_current_limit=60.0),
        inertia=0.001,
        radius=0.025,
    ),
}


def _slide(share: float, drop: float = 0.0) -> tuple[Joint, ...]:
    """Return the slide joints of a part that moves with the intake's rack.

    Args:
        share: Travel to the rear per travel of the rack [-].
        drop: Travel downward per travel of the rack [-].
    """
    joint = Joint(mechanism="intake_deploy", axis=_OUTWARD, slides=True, ratio=share * _PINION)
    if not drop:
        return (joint,)
    down = Joint(mechanism="intake_deploy", axis=(0.0, 0.0, -1.0), slides=True, ratio=drop * _PINION)
    return (joint, down)


def _turn(mechanism: str, origin: tuple[float, float, float], axis: str = "y", ratio: float = 1.0) -> tuple[Joint, ...]:
    axes = {"y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
    return (Joint(mechanism=mechanism, origin=origin, axis=axes[axis], ratio=ratio),)


_WITH_INTAKE = _slide(1.0, drop=0.5)

_COMPONENTS = (
    ComponentConfig(name="intake", offset=(-0.30, 0.0, 0.35), joints=_WITH_INTAKE),
    ComponentConfig(name="hopper", offset=(-0.05, 0.0, 0.30), joints=_slide(0.5)),
    ComponentConfig(name="intake roller, lower", joints=_WITH_INTAKE + _turn("intake_roller", (-0.37, 0.0, 0.31))),
    ComponentConfig(
        name="intake roller, upper", joints=_WITH_INTAKE + _turn("intake_roller", (-0.33, 0.0, 0.45), ratio=-1.0)
    ),
    ComponentConfig(name="hopper roller", joints=_turn("intake_roller", (-0.24, 0.0, 0.22))),
    ComponentConfig(name="spindexer plate", joints=_turn("spindexer", (-0.03, 0.0, 0.14), "z")),
    ComponentConfig(name="spindexer cone", joints=_turn("spindexer", (-0.03, 0.0, 0.155), "z")),
    ComponentConfig(name="spindexer kicker", joints=_turn("spindexer", (0.19, 0.0, 0.19), "z", ratio=-2.0)),
    ComponentConfig(name="feeder wheel, lower left", joints=_turn("feeder", (0.25, 0.08, 0.25))),
    ComponentConfig(name="feeder wheel, lower right", joints=_turn("feeder", (0.25, -0.08, 0.25))),
    ComponentConfig(name="feeder wheel, upper left", joints=_turn("feeder", (0.25, 0.08, 0.36))),
    ComponentConfig(name="feeder wheel, upper right", joints=_turn("feeder", (0.25, -0.08, 0.36))),
    ComponentConfig(name="hood", joints=_turn("hood", (0.27, 0.0, 0.50))),
    ComponentConfig(name="shooter wheel, left", joints=_turn("shooter", (0.27, 0.08, 0.50))),
    ComponentConfig(name="shooter wheel, right", joints=_turn("shooter", (0.27, -0.08, 0.50))),
    ComponentConfig(name="shooter backspin roller", joints=_turn("shooter", (0.055, 0.0, 0.40), ratio=-1.0)),
)
"""Components in the order of the model files.

Fuel rises behind the feeder wheels and shooter wheels, and leaves at the edge of the hood. The hood turns about the
axle of the shooter wheels. Fuel leaves straight up with the hood at 20 degrees, and at 45 degrees with the hood at 65
degrees.
"""


def rebuilt_robot() -> RobotConfig:
    """Build the config of a 55 kg robot with bumpers of 0.8 x 0.8 m.

    The robot holds 50 fuel, and shoots eight fuel per second from each of two barrels.
    """
    module = SwerveModuleConfig(
        x=0.0,
        y=0.0,
        drive_stator_limit=60.0,
        drive_supply_limit=40.0,
        steer_stator_limit=40.0,
        steer_supply_limit=20.0,
    )
    return RobotConfig(
        drivetrain=SwerveConfig.square(0.5334, module, mass=55.0, bumper=0.8),
        bumper=(0.8, 0.8),
        mechanisms=MECHANISMS,
        intakes=(
            IntakeConfig(
                # 0.66 m wide, like other over-the-bumper intakes of 2026
                zone=IntakeZone(x_min=-0.50, x_max=-0.35, y_min=-0.33, y_max=0.33, z_max=0.20),
                roller="intake_roller",
                deploy="intake_deploy",
                stretch=Joint(mechanism="intake_deploy", axis=_OUTWARD, slides=True, ratio=_PINION),
            ),
        ),
        # 54 fuel fit in staggered layers up to the height limit of 30 in
        storage=StorageConfig(capacity=50, low=(-0.36, -0.305, 0.18), high=(0.17, 0.305, 0.76)),
        shooters=(
            ShooterConfig(
                wheels=("shooter",),
                wheel_radius=0.05,
                exit_efficiency=0.49,  # about one half, because the fuel rolls along a fixed hood
                launch=LaunchParameters(height=0.55, forward=0.168, barrels=(0.08, -0.08)),
                hood="hood",
                elevation=degrees(110.0),  # shoots straight up with the hood at 20 degrees
                elevation_per_hood=-1.0,
                gate=("feeder",),
                shot_rate=8.0,
            ),
        ),
        components=_COMPONENTS,
    )


CLIMBER = "climber"
"""Name of the mechanism that raises and lowers the climbing robot's hook, at the center of the robot."""
_HOOK_DRUM = 0.012  # [m]
_WINCH = GearboxConfig(motor=motor("Kraken X60"), motors=2, gearing=50.0, stator_current_limit=60.0)


def climbing_robot() -> RobotConfig:
    """Build the config of a robot that climbs with a hook on the low rung.

    The robot has bumpers of 0.70 x 0.70 m, which fit between the uprights of the tower.
    """
    robot = rebuilt_robot()
    assert isinstance(robot.drivetrain, SwerveConfig)
    hook = ElevatorConfig(
        # as for REEFSCAPE's robot: gear friction is twice the torque of the robot's weight
        gearbox=replace(_WINCH, friction_torque=default_friction(_WINCH)),
        carriage_mass=2.0,
        drum_radius=_HOOK_DRUM,
        max_height=0.5,
    )
    joint = Joint(mechanism=CLIMBER, axis=(0.0, 0.0, 1.0), origin=(0.0, 0.0, 0.30), slides=True, ratio=_HOOK_DRUM)
    return replace(
        robot,
        drivetrain=SwerveConfig.square(0.45, robot.drivetrain.modules[0], mass=55.0, bumper=0.70),
        bumper=(0.70, 0.70),
        mechanisms={**robot.mechanisms, CLIMBER: hook},
        climbers=(ClimberConfig(joints=(joint,)),),
    )
