"""Mechanisms of simcore.toml on the devices that the robot program has built."""

from __future__ import annotations

import logging

from simcore.errors import ConfigError
from simcore.phoenix6.ownership import Ownership
from simcore.robot.robot import Robot
from simcore.robot_file.robot_settings import MechanismSettings, RobotSettings
from simcore.robotpy.connected_devices import MotorDevices
from simcore.robotpy.motor_families import family_of, find_device
from simcore.robotpy.port_assignment import PORT_CONTROLLERS

__all__ = ["connect_mechanism", "with_configured_friction"]

_log = logging.getLogger(__name__)


def connect_mechanism(settings: MechanismSettings, robot: Robot, ownership: Ownership) -> MotorDevices:
    """The devices of a mechanism of the file, on that mechanism.

    Raises:
        ConfigError: The program has built no such device.
    """
    m, where = settings, _where(settings)
    devices = [find_device(where, m.controller, number) for number in m.devices]
    encoder = None
    if m.cancoder is not None:
        made = find_device(where, "CANcoder", m.cancoder)
        ownership.claim(made.key, m.name)
        encoder = made.hardware
    for device in devices:
        ownership.claim(device.key, m.name)
    return family_of(m.controller).connect(m, devices, robot.mechanisms[m.name], encoder)


def with_configured_friction(settings: RobotSettings) -> RobotSettings:
    """The settings with friction from the controllers' own kS, where the file says none and the program has set one.

    Raises:
        ConfigError: The program has built no such device.
    """
    volts: dict[str, float] = {}
    for m in settings.mechanisms:
        if m.friction_is_given or m.controller in PORT_CONTROLLERS:
            continue  # a port has no configuration to ask
        leader = find_device(_where(m), m.controller, m.leader)
        try:
            found = family_of(m.controller).friction_volts(m, leader)
        except ConfigError as error:
            _log.warning("%s keeps the default friction of its kind: %s", m.name, error)
            continue
        if found > 0.0:
            volts[m.name] = found
    return settings.with_friction(volts)


def _where(settings: MechanismSettings) -> str:
    return f"simcore.toml [[mechanism]] {settings.name!r}"
