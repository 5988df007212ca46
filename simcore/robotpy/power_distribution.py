"""Shows the currents of a robot's motors on its power distribution panel, as `wpilib.PowerDistribution` reads them.

Which motor hangs on which channel stands nowhere in a robot program. So channels are taken in order: the drivetrain's
drive motors, its steer motors, then the mechanisms. Sums and total current are right whatever the wiring.
"""

from __future__ import annotations

from wpilib.simulation import PowerDistributionSim

from simcore.robot.robot import Robot
from simcore.robot.swerve_drive import SwerveDrive
from simcore.units import plain_sum

__all__ = ["PowerDistributionView", "channel_currents"]

_MODULES = range(63)  # CAN ids
_CHANNELS = 24  # of a REV PDH; WPILib's simulation keeps as many for a CTRE PDP, which has 16
_LOOK = 50  # ticks between two looks for panels that the program has built since


def channel_currents(robot: Robot, channels: int) -> list[float]:
    """Current of each channel [A]; what finds no channel of its own is on the last one.

    A panel measures no current that flows back: it reads zero while a motor brakes into the battery.

    Args:
        robot: With drivetrain and mechanisms.
        channels: Of the panel.
    """
    drive = robot.drive
    currents = list(drive.drive_motors.supply)
    if isinstance(drive, SwerveDrive):
        currents += drive.steer_motors.supply
    else:  # its sides have several motors each
        currents = [current for current in currents for _ in drive.motor_currents()["left"]]
    for mechanism in robot.mechanisms.values():
        currents += [mechanism.supply_current / mechanism.motors] * mechanism.motors
    currents = [max(0.0, current) for current in currents]
    if len(currents) > channels:
        currents[channels - 1 :] = [plain_sum(currents[channels - 1 :])]
    return currents + [0.0] * (channels - len(currents))


class PowerDistributionView:
    """The panels that a robot program has built.

    Args:
        robot: Whose currents they show.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._panels: list[PowerDistributionSim] = []
        self._ticks = 0

    def update(self) -> None:
        """Once a tick, at its end."""
        if self._ticks % _LOOK == 0:
            panels = (PowerDistributionSim(module) for module in _MODULES)
            self._panels = [panel for panel in panels if panel.getInitialized()]
        self._ticks += 1
        if not self._panels:
            return
        currents = channel_currents(self._robot, _CHANNELS)
        for panel in self._panels:
            panel.setVoltage(self._robot.battery.voltage)
            for channel, current in enumerate(currents):
                panel.setCurrent(channel, current)
