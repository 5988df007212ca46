"""REV's `Maker`: SPARK MAX and SPARK Flex, on drivetrains and mechanisms."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from simcore import season
from simcore.quantities import DeviceAddress, DeviceKey
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import GuessedMechanism, ShaftSim, guessed_shaft
from simcore.robotcode.makers.revlib.built_sparks import SPARKS, watch_simulations
from simcore.robotcode.makers.revlib.spark_configuration import read_spark_configuration
from simcore.robotcode.makers.revlib.spark_loop import Feedback, SparkConfiguration
from simcore.robotcode.makers.revlib.spark_motor import SparkMotorSim, WiredEncoder
from simcore.robotcode.makers.revlib.spark_port import ANALOG_SPAN, SparkPort
from simcore.robotcode.program.makers import Maker, MotorFacts, Mounting
from simcore.robotcode.program.motor_controllers import BuiltDevice, FollowerGroup, group_by_leader
from simcore.robotcode.program.motor_ports import AnglePort, MotorPort

rev = season.rev

__all__ = ["MAKER"]

_TURNS = (1.0, math.tau, 360.0)
"""Size of one turn in the units that robot code may use: turns, radians, degrees."""


class _Rev(Maker):
    name = "REV"
    motors = ("SPARK MAX", "SPARK Flex")
    unserved = ("ColorSensorV3", "DetachedEncoder", "ServoChannel", "ServoHub", "SplineEncoder")
    sim_devices = ("SPARK MAX [", "SPARK Flex [")

    def watch_simulations(self, may_write: Callable[[DeviceKey], bool]) -> None:
        watch_simulations(may_write)

    def groups(self, motors: Sequence[BuiltDevice]) -> list[FollowerGroup]:
        return group_by_leader(motors, _leader)

    def has_wheel_encoder(self, motor: BuiltDevice) -> bool:
        return bool(motor.hardware.get_motor_type() == rev.MotorType.BRUSHED)

    def facts(self, motor: BuiltDevice) -> MotorFacts:
        config = read_spark_configuration(motor.hardware)
        of_sensor = {
            Feedback.ABSOLUTE: config.absolute[0],
            Feedback.EXTERNAL: config.external[0],
            Feedback.ANALOG: config.analog[0] * ANALOG_SPAN,
        }.get(config.feedback)
        factor = config.primary[0]
        ratio = abs(of_sensor / factor) if of_sensor and factor not in (0.0, 1.0) else None
        return MotorFacts(
            motor=self._usual_motor(motor),
            is_guess=config.is_brushed or motor.model == "SPARK MAX",
            stator_limit=config.current_limit if config.current_limit > 0.0 else None,
            brakes=config.brakes,
            units_per_rotor_turn=factor,
            sensor=motor.key if of_sensor else None,
            rotor_per_sensor=ratio,
            has_gains=bool(config.slots[0].p or config.slots[0].kv),
            free_speed_volts=self._free_speed_volts(motor, config),
        )

    def _free_speed_volts(self, device: BuiltDevice, config: SparkConfiguration) -> float | None:
        kv = config.slots[0].kv
        if not kv or config.feedback is not Feedback.PRIMARY:
            return None
        rpm = 60.0 * motor(self._usual_motor(device)).free_speed / math.tau
        return kv * abs(config.primary[1]) * rpm

    def _usual_motor(self, device: BuiltDevice) -> str:
        brushless = "NEO Vortex" if device.model == "SPARK Flex" else "NEO"
        return "CIM" if self.has_wheel_encoder(device) else brushless

    def motor_port(self, motor: BuiltDevice) -> SparkPort:
        return SparkPort(motor)

    def encoder_port(self, encoder: BuiltDevice, port: MotorPort | None = None) -> AnglePort:
        assert isinstance(port, SparkPort), f"{encoder} is no encoder of its own"
        return WiredEncoder(port)

    def connect(self, group: FollowerGroup, mechanism: ShaftSim, mounting: Mounting | None = None) -> SparkMotorSim:
        m = mounting or Mounting()
        return SparkMotorSim(
            group.leader,
            mechanism,
            followers=group.followers,
            opposed=group.opposed,
            reversed=m.reversed,
            zero_at=mechanism.position,
            encoder_gearing=m.encoder_gearing,
        )

    def guess(self, group: FollowerGroup) -> GuessedMechanism:
        config = read_spark_configuration(group.leader.hardware)
        gains, name = config.slots[0], self._usual_motor(group.leader)
        is_arm = gains.kcos > 0.0
        shaft = guessed_shaft(
            GearboxConfig(motor=motor(name), motors=len(group.devices), gearing=_gearing(config)),
            static=gains.ks,
            kv=gains.kv,
            ka=gains.ka,
            weight=gains.kcos if is_arm else gains.kg,
            arm=(0.0, 0.0) if is_arm else None,
        )
        return GuessedMechanism(mechanism=shaft, motor=name, arm_gain="kCos")

    def friction_volts(self, motor: BuiltDevice, gearbox: GearboxConfig) -> float:
        return abs(float(motor.hardware.config_accessor.closed_loop.feed_forward.getk_s()))


def _leader(device: BuiltDevice) -> tuple[Any, bool]:
    """Return the leader's address, or None without a leader, and whether the follower is inverted."""
    accessor, is_follower = device.hardware.config_accessor, device.hardware.is_follower()
    leader = DeviceAddress(accessor.get_follower_mode_leader_id(), device.address.bus) if is_follower else None
    return leader, leader is not None and bool(accessor.get_follower_mode_inverted())


def _gearing(config: SparkConfiguration) -> float:
    """Return the gearing between rotor and mechanism [-] from the conversion factors, or 1 without a factor.

    A factor of 2 pi / 50 means a gearing of 50 in radians. An absolute encoder on the mechanism determines the unit.
    Without an absolute encoder, the function tries turns, radians and degrees, first for a gearing that is a multiple
    of 1/4, and then for any gearing above 1.
    """
    factor = abs(config.primary[0])
    if factor in (0.0, 1.0):
        return 1.0
    if config.feedback is Feedback.ABSOLUTE and config.absolute[0] > 0.0:
        return max(config.absolute[0] / factor, 1e-3)
    gears = [unit / factor for unit in _TURNS if unit / factor > 1.0]
    round_gears = [gear for gear in gears if abs(4.0 * gear - round(4.0 * gear)) < 1e-4 * gear]
    return next(iter(round_gears or gears), 1.0)


MAKER = _Rev(SPARKS)
"""`Maker` of REV's motor controllers, for `simcore.robotcode.program.makers`."""
