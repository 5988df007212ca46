"""What robot code sees of the battery: the roboRIO's input voltage, and its user rails in a brown-out."""

from __future__ import annotations

from wpilib.simulation import RoboRioSim

from simcore.robot.battery import Battery

__all__ = ["RoboRioPower"]


class RoboRioPower:
    """Shows a battery to robot code.

    In a brown-out a roboRIO switches its 6 V, 5 V and 3.3 V user rails off besides its outputs, and counts a fault of
    each: `RobotController.getEnabled6V()`, `getFaultCount6V()`. The counts keep what a loop of 20 ms has missed.
    `RobotController.isBrownedOut()` cannot be had: it is a constant False in the simulated HAL (2026.2).

    Source: WPILib documentation, "roboRIO Brownout and Understanding Current Draw", stage 2.

    Args:
        battery: Stepped by its owner.
    """

    def __init__(self, battery: Battery) -> None:
        self._battery = battery
        self._is_low = False
        self._faults = 0
        self.show_voltage()

    def show_voltage(self) -> None:
        """Write the input voltage; once a robot loop is enough."""
        RoboRioSim.setVInVoltage(self._battery.voltage)

    def show_rails(self) -> None:
        """Switch the rails where a brown-out has begun or ended; costs nothing in between."""
        is_low = self._battery.browned_out
        if is_low == self._is_low:
            return
        self._is_low = is_low
        self._faults += is_low
        for active, count in (
            (RoboRioSim.setUserActive6V, RoboRioSim.setUserFaults6V),
            (RoboRioSim.setUserActive5V, RoboRioSim.setUserFaults5V),
            (RoboRioSim.setUserActive3V3, RoboRioSim.setUserFaults3V3),
        ):
            active(not is_low)
            count(self._faults)
