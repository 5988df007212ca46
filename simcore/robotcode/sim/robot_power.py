"""Electrical readings for robot code: roboRIO voltage, user rails and brownout, and power distribution currents.

A robot program does not define the power distribution channel of each motor. This module therefore assigns the channels
in a fixed order: drive motors, steer motors, mechanisms. The total current is correct for any wiring.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from simcore import season
from simcore.robot.battery import Battery
from simcore.robot.robot import Robot
from simcore.robot.swerve_drive import SwerveDrive
from simcore.units import plain_sum

RobotController = season.wpilib.RobotController
PowerDistributionSim = season.wpilib_simulation.PowerDistributionSim
RoboRioSim = season.wpilib_simulation.RoboRioSim

__all__ = ["PowerDistributionView", "RoboRioPower", "channel_currents"]

_WATTS = 10.0  # power of a roboRIO with few loads on its rails; estimate, +-50 %: NI publishes only the maximum, 45 W
_MODULES = range(63)  # CAN IDs of panels
_CHANNELS = 24  # channels of a REV PDH; WPILib's simulation also has 24 for a CTRE PDP, which has 16
_LOOK = 50  # number of ticks between two checks for new panels


class RoboRioPower:
    """Simulated roboRIO power: voltage, rails and brownout in WPILib's `RobotController` follow a battery.

    In a brownout, a roboRIO disables the outputs and the 6 V, 5 V and 3.3 V user rails, and counts a fault for each
    rail (`RobotController.getEnabled6V()`, `getFaultCount6V()`). The counts include faults between two 20 ms loops. In
    the simulated HAL (2026.2), `RobotController.isBrownedOut()` is always False. This class therefore replaces the
    method to return the battery's state. `setBrownoutVoltage` of a roboRIO 2 sets the battery's brownout voltage.

    Source: WPILib documentation, "roboRIO Brownout and Understanding Current Draw", stage 2.

    Args:
        battery: Battery to read.
    """

    def __init__(self, battery: Battery) -> None:
        self._battery = battery
        self._is_low = False
        controller: Any = RobotController
        name = season.own_name(RobotController, "is_browned_out")
        setattr(controller, name, staticmethod(lambda: self._battery.browned_out))
        self._level = battery.config.brownout_voltage
        RoboRioSim.set_brownout_voltage(self._level)
        self.show_voltage()

    def show_voltage(self) -> None:
        """Write the input voltage and current, and apply robot code's brownout voltage to the battery.

        Call this method at least once per loop.
        """
        volts = self._battery.voltage
        RoboRioSim.set_vin_voltage(volts)
        season.show_input_current(_WATTS / volts if volts > 1.0 else 0.0)
        level = float(RoboRioSim.get_brownout_voltage())
        if level != self._level:
            self._follow_level(level)

    def show_rails(self) -> None:
        """Switch the user rails off or on and write the fault counts if a brownout has started or ended."""
        is_low = self._battery.browned_out
        if is_low == self._is_low:
            return
        self._is_low = is_low
        for active, count in season.user_rails():
            active(not is_low)
            count(self._battery.brownouts)

    def _follow_level(self, level: float) -> None:
        """Set the battery's brownout voltage [V], and raise the recovery voltage to at least this voltage."""
        self._level = level
        config = self._battery.config
        recovered = max(config.recovered_voltage, level)
        self._battery.config = replace(config, brownout_voltage=level, recovered_voltage=recovered)


def channel_currents(robot: Robot, channels: int) -> list[float]:
    """Return the supply current of each channel of a power distribution panel [A].

    The last channel includes all loads that exceed the number of channels. A panel does not measure reverse current, so
    a channel reads zero while the motor on the channel brakes into the battery.

    Args:
        robot: Robot with drivetrain and mechanisms.
        channels: Number of channels of the panel.
    """
    drive = robot.drive
    currents = list(drive.drive_motors.supply)
    if isinstance(drive, SwerveDrive):
        currents += drive.steer_motors.supply
    else:  # each side of the drivetrain has several motors
        motors = len([amps for side in drive.motor_currents().values() for amps in side]) // len(currents)
        currents = [current for current in currents for _ in range(motors)]
    for mechanism in robot.mechanisms.values():
        currents += [mechanism.supply_current / mechanism.motors] * mechanism.motors
    currents = [max(0.0, current) for current in currents]
    if len(currents) > channels:
        currents[channels - 1 :] = [plain_sum(currents[channels - 1 :])]
    return currents + [0.0] * (channels - len(currents))


class PowerDistributionView:
    """Simulated power distribution panels: WPILib's readings follow the robot's battery and currents.

    Args:
        robot: Robot with the motors and battery that the panels measure.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._panels: list[Any] = []
        self._ticks = 0

    def update(self) -> None:
        """Write the voltage and currents of all panels at the end of a tick. Search for new panels every 50 ticks."""
        if self._ticks % _LOOK == 0:
            panels = (PowerDistributionSim(module) for module in _MODULES)
            self._panels = [panel for panel in panels if panel.get_initialized()]
        self._ticks += 1
        if not self._panels:
            return
        currents = channel_currents(self._robot, _CHANNELS)
        for panel in self._panels:
            panel.set_voltage(self._robot.battery.voltage)
            for channel, current in enumerate(currents):
                panel.set_current(channel, current)
