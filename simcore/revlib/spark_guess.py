"""A mechanism guessed from a SPARK's configuration, for motors whose mechanism is described nowhere."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import rev

from simcore.revlib.spark_configuration import read_spark_configuration
from simcore.revlib.spark_loop import Feedback, SlotGains, SparkConfiguration
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.guessed_mechanism import GuessedMechanism, guessed_inertia, guessed_weight, with_guessed_friction
from simcore.robot.mechanisms import ArmConfig, ArmSim
from simcore.robot.motor_controllers import FollowerGroup
from simcore.robot.shaft import ShaftSim
from simcore.robot_file.reader import gearbox_motor

__all__ = ["SparkGuess", "guess_spark_mechanism"]

_TURNS = (1.0, math.tau, 360.0)
"""What robot code may call one turn of a mechanism."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SparkGuess(GuessedMechanism):
    """What a group of SPARKs probably turns."""

    ARM_GAIN: ClassVar[str] = "kCos"


def guess_spark_mechanism(group: FollowerGroup) -> SparkGuess:
    """A plausible mechanism from the configuration of the leader."""
    spark = group.leader.hardware
    config = read_spark_configuration(spark)
    gains = config.slots[0]
    if spark.getMotorType() == rev.SparkLowLevel.MotorType.kBrushed:
        name = "CIM"
    else:
        name = "NEO Vortex" if group.leader.model == "SPARK Flex" else "NEO"
    gearbox = GearboxConfig(motor=gearbox_motor(name), motors=len(group.devices), gearing=_gearing(config))
    gearbox = with_guessed_friction(gearbox, gains.ks)
    inertia = guessed_inertia(gearbox, gains.kv, gains.ka)
    return SparkGuess(mechanism=_mechanism(gearbox, inertia, gains), motor=name)


def _gearing(config: SparkConfiguration) -> float:
    """Rotor turns per turn of the mechanism, as far as conversion factors tell it.

    A factor of 2 pi / 50 is a gear of 50 in radians. An absolute encoder on the mechanism says which unit it is;
    without one it is the first of turns, radians and degrees in which the gear is a round number, else the first above
    1.
    """
    factor = abs(config.primary[0])
    if factor in (0.0, 1.0):
        return 1.0
    if config.feedback is Feedback.ABSOLUTE and config.absolute[0] > 0.0:
        return max(config.absolute[0] / factor, 1e-3)
    gears = [unit / factor for unit in _TURNS if unit / factor > 1.0]
    round_gears = [gear for gear in gears if abs(4.0 * gear - round(4.0 * gear)) < 1e-4 * gear]
    return next(iter(round_gears or gears), 1.0)


def _mechanism(gearbox: GearboxConfig, inertia: float, gains: SlotGains) -> ShaftSim:
    """A free shaft; with a kCos or kG, one with a weight that rests on a stop where it is at first."""
    torque_per_volt = gearbox.torque_per_amp / gearbox.resistance
    if gains.kcos > 0.0:
        return ArmSim(
            ArmConfig(
                gearbox=gearbox,
                inertia=inertia,
                mass=gains.kcos * torque_per_volt,
                center_of_mass=1.0,
                gravity=1.0,  # mass and lever are not known apart, and need not be
                min_angle=0.0,
                max_angle=math.pi,
            )
        )
    return guessed_weight(gearbox, inertia, gains.kg * torque_per_volt)
