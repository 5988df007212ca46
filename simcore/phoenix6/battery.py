"""The battery as robot code sees it: the roboRIO's input voltage."""

from __future__ import annotations

from collections.abc import Sequence

from wpilib.simulation import RoboRioSim

from simcore.robot.battery import Battery
from simcore.robot.gearbox import SimMotor
from simcore.units import plain_sum

__all__ = ["RobotBattery"]


class RobotBattery:
    """A battery that feeds mechanisms and shows on the roboRIO. Update it first in every step.

    Brown-out reaches robot code as a low `RobotController.getBatteryVoltage()`; WPILib's own `isBrownedOut()` stays
    False in simulation (2026.2), whatever one writes. Whoever steps the motors looks at `browned_out`.

    Args:
        battery: The cells. A swerve model steps its own battery: then pass that one, and call `publish` only.
        loads: What draws from it, besides a swerve model.
    """

    def __init__(self, battery: Battery, loads: Sequence[SimMotor] = ()) -> None:
        self.battery = battery
        self._loads = list(loads)

    @property
    def voltage(self) -> float:
        """At the terminals [V]."""
        return self.battery.voltage

    @property
    def browned_out(self) -> bool:
        """Whether the roboRIO holds its outputs off."""
        return self.battery.browned_out

    def update(self, dt: float) -> float:
        """Draw what the loads took in their last step for dt [s], and show the voltage; returns it [V]."""
        self.battery.step(dt, plain_sum(load.supply_current for load in self._loads))
        self.publish()
        return self.voltage

    def publish(self) -> None:
        """Show the voltage to the roboRIO."""
        RoboRioSim.setVInVoltage(self.battery.voltage)
