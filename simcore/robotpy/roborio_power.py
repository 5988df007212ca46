"""The roboRIO's own supply as robot code reads it: voltage, current, user rails and brown-out."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from wpilib import RobotController
from wpilib.simulation import RoboRioSim

from simcore.robot.battery import Battery

__all__ = ["RoboRioPower"]

_WATTS = (
    10.0  # of a roboRIO with little on its rails; estimate, +-50 %: NI publishes the most, 45 W, and no typical figure
)


class RoboRioPower:
    """Shows a battery to robot code.

    In a brown-out a roboRIO switches its 6 V, 5 V and 3.3 V user rails off besides its outputs, and counts a fault of
    each: `RobotController.getEnabled6V()`, `getFaultCount6V()`. The counts keep what a loop of 20 ms has missed.
    `RobotController.isBrownedOut()`, a constant False in the simulated HAL (2026.2), answers for this battery from now
    on; `setBrownoutVoltage` of a roboRIO 2 sets its level.

    Source: WPILib documentation, "roboRIO Brownout and Understanding Current Draw", stage 2.

    Args:
        battery: Stepped by its owner.
    """

    def __init__(self, battery: Battery) -> None:
        self._battery = battery
        self._is_low = False
        controller: Any = RobotController
        controller.isBrownedOut = staticmethod(lambda: self._battery.browned_out)
        self._level = battery.config.brownout_voltage
        RoboRioSim.setBrownoutVoltage(self._level)
        self.show_voltage()

    def show_voltage(self) -> None:
        """Write input voltage and current; once a robot loop is enough."""
        volts = self._battery.voltage
        RoboRioSim.setVInVoltage(volts)
        RoboRioSim.setVInCurrent(_WATTS / volts if volts > 1.0 else 0.0)
        level = float(RoboRioSim.getBrownoutVoltage())
        if level != self._level:
            self._follow_level(level)

    def show_rails(self) -> None:
        """Switch the rails where a brown-out has begun or ended; costs nothing in between."""
        is_low = self._battery.browned_out
        if is_low == self._is_low:
            return
        self._is_low = is_low
        for active, count in (
            (RoboRioSim.setUserActive6V, RoboRioSim.setUserFaults6V),
            (RoboRioSim.setUserActive5V, RoboRioSim.setUserFaults5V),
            (RoboRioSim.setUserActive3V3, RoboRioSim.setUserFaults3V3),
        ):
            active(not is_low)
            count(self._battery.brownouts)

    def _follow_level(self, level: float) -> None:
        """Robot code has set the voltage below which outputs are cut [V]."""
        self._level = level
        config = self._battery.config
        recovered = max(config.recovered_voltage, level)
        self._battery.config = replace(config, brownout_voltage=level, recovered_voltage=recovered)
