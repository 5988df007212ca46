"""Energy drawn from the battery equals the energy of the motors, as heat and motion."""

from __future__ import annotations

import math

import pytest

from simcore.match.match import Match
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import ArmConfig, FlywheelConfig
from simcore.robot.robot_config import RobotConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig

pytestmark = pytest.mark.engines("bullet")

DRIVETRAIN = SwerveConfig.square(0.5, SwerveModuleConfig(x=0.0, y=0.0))
UNLIMITED: dict[str, float] = {}
LIMITED = {"stator_current_limit": 120.0, "supply_current_limit": 70.0}


def robot(name: str, count: int, limits: dict[str, float], *, stalled: bool) -> RobotConfig:
    """Return a robot with a number of single-motor mechanisms: flywheels, or arms between two stops."""
    box = GearboxConfig(motor=motor(name), gearing=1.0, **limits)
    one = (
        ArmConfig(gearbox=box, inertia=0.01, min_angle=0.0, max_angle=0.001)
        if stalled
        else FlywheelConfig(gearbox=box, inertia=0.004)
    )
    return RobotConfig(drivetrain=DRIVETRAIN, mechanisms={f"one {k}": one for k in range(count)})


@pytest.mark.parametrize("stalled", [False, True])
@pytest.mark.parametrize("limits", [UNLIMITED, LIMITED], ids=["unlimited", "limited"])
@pytest.mark.parametrize("count", [0, 1, 2, 4, 12])
@pytest.mark.parametrize("name", ["Kraken X60", "NEO"])
def test_battery_energy_equals_motor_heat_and_kinetic_energy(name, count, limits, stalled):
    """Mechanisms and drivetrain run at 12 V for half a second; the energies agree within 0.5 %.

    A datasheet motor delivers kt kv times its electrical power as mechanical power, see `MotorModel`. In the
    millisecond in which an arm meets its stop, the energy of the impact is neither winding heat nor motion.
    """
    config = robot(name, count, limits, stalled=stalled)
    with Match.bare(config, start=(4.0, 4.0, 0.0)) as match:
        (one,), lowest = match.robots, math.inf
        for _ in range(25):
            for mechanism in one.mechanisms.values():
                mechanism.set_volts(12.0)
            one.drive.set_volts([3.0] * 4, [0.0] * 4)
            match.tick()
            lowest = min(lowest, one.battery.tick_min_voltage)
            assert one.battery.voltage < 13.0
        records = [mechanism.record for mechanism in one.mechanisms.values()]
        taken = sum(float(record["energy"][0]) for record in records)
        assert one.battery.energy == pytest.approx(taken + one.drive.electrical_energy, rel=0.005)
        assert one.battery.energy > 1.0 and lowest < 12.9
        if records:
            model = motor(name)
            heat = sum(float(record["model"]["winding"][0] * record["charge2"][0]) for record in records)
            motion = sum(0.5 * m.inertia * m.velocity**2 for m in one.mechanisms.values()) / (model.kt * model.kv)
            assert heat + motion == pytest.approx(taken, rel=0.005)


def test_regenerating_motors_return_no_more_than_the_flywheels_lose():
    """Twelve motors switched from 12 V to 6 V raise the battery voltage by at most current times resistance."""
    with Match.bare(robot("Kraken X60", 12, LIMITED, stalled=False), start=(4.0, 4.0, 0.0)) as match:
        (one,) = match.robots
        for mechanism in one.mechanisms.values():
            mechanism.reset(velocity=500.0)
            mechanism.set_volts(6.0)
        held = sum(0.5 * m.inertia * m.velocity**2 for m in one.mechanisms.values())
        highest = 0.0
        for _ in range(25):
            match.tick()
            highest = max(highest, one.battery.voltage)
        left = sum(0.5 * m.inertia * m.velocity**2 for m in one.mechanisms.values())
        assert -one.battery.energy < held - left
        assert one.battery.energy < 0.0
        assert 13.0 < highest < 12.9 + 0.028 * 12 * 70.0
