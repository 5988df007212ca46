"""Match time and game data, as a field gives them to the driver station."""

from __future__ import annotations

from wpilib import DriverStation
from wpilib.simulation import DriverStationSim

__all__ = ["MatchTime"]


class MatchTime:
    """Time left in the present mode, for `DriverStation.getMatchTime()`; -1 while disabled.

    Whole seconds, as on a field. With an FMS attached it stays out of the way.

    Args:
        auto: Length of autonomous [s].
        teleop: Length of teleop [s].
    """

    def __init__(self, *, auto: float = 20.0, teleop: float = 140.0) -> None:
        self._length = {"auto": auto, "teleop": teleop}
        self._mode = ""
        self._elapsed = 0.0
        self._message = ""

    def update(self, dt: float) -> str:
        """Advance by dt [s].

        Returns:
            `auto` or `teleop` if it has just begun, else nothing.
        """
        if DriverStation.isFMSAttached():
            return ""
        mode = "" if DriverStation.isDisabled() else "auto" if DriverStation.isAutonomous() else "teleop"
        if mode != self._mode:
            self._mode, self._elapsed = mode, 0.0
            self._show(self._length[mode] if mode else -1.0)
            return mode
        if mode:
            before, self._elapsed = self._elapsed, self._elapsed + dt
            if int(self._elapsed) > int(before):
                self._show(max(0.0, self._length[mode] - int(self._elapsed)))
        return ""

    def send(self, message: str) -> None:
        """Give robot code the field's game data; what somebody has typed into the driver station stays."""
        if message == self._message or DriverStation.isFMSAttached():
            return
        if DriverStation.getGameSpecificMessage() == self._message:
            DriverStationSim.setGameSpecificMessage(message)
            DriverStationSim.notifyNewData()
        self._message = message

    def _show(self, seconds: float) -> None:
        DriverStationSim.setMatchTime(seconds)
        DriverStationSim.notifyNewData()  # without it robot code goes on to read the old one
