"""An emulated CANdle: its lights move nothing; the requests of robot code are recorded."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6_emulator.config_text import Setting
from simcore.phoenix6_emulator.device_clock import SimulatedClock
from simcore.phoenix6_emulator.emulated_device import EmulatedDevice

__all__ = ["LIGHT_REQUESTS", "EmulatedCANdle"]

LIGHT_REQUESTS = (
    "ColorFlowAnimation",
    "EmptyAnimation",
    "FireAnimation",
    "LarsonAnimation",
    "ModulateVBatOut",
    "RainbowAnimation",
    "RgbFadeAnimation",
    "SingleFadeAnimation",
    "SolidColor",
    "StrobeAnimation",
    "TwinkleAnimation",
    "TwinkleOffAnimation",
)
"""Requests of a CANdle."""


class EmulatedCANdle(EmulatedDevice):
    """One CANdle.

    Args:
        device_id: CAN id.
        clock: Simulated time.
        defaults: Factory configuration.
    """

    model = "candle"
    type_number = 10

    def __init__(self, device_id: int, clock: SimulatedClock, defaults: Mapping[int, Setting]) -> None:
        super().__init__(device_id, clock, defaults)
        self.shows: list[tuple[str, tuple[Any, ...]]] = []
        """Requests since the device was built, with their numbers as the library sends them; the newest 100."""
        self.send_frame()

    def show(self, name: str, args: tuple[Any, ...]) -> None:
        """A request of robot code."""
        self.shows = [*self.shows[-99:], (name, args)]

    def set_input(self, name: str, value: float) -> None:
        """Its supply; other inputs are not modelled."""
        if name == "SupplyVoltage":
            self.supply = max(value, 4.0)
        else:
            super().set_input(name, value)

    def sample(self) -> float:
        """Supply at this moment [V]."""
        return self.supply

    signals: ClassVar[Mapping[int, Callable[[Any], float]]] = {
        SpnValue.CANDLE_GENERAL_SUPPLY_VOLTAGE.value: lambda supply: supply,
        SpnValue.CANDLE_GENERAL_FIVE_V_RAIL_VOLTAGE.value: lambda supply: 5.0,
        SpnValue.CANDLE_GENERAL_OUTPUT_CURRENT.value: lambda supply: 0.0,
        SpnValue.CANDLE_GENERAL_DEVICE_TEMP.value: lambda supply: 25.0,
        SpnValue.CANDLE_GENERAL_V_BAT_MODULATION.value: lambda supply: 1.0,
        SpnValue.CANDLE_GENERAL_MAX_SIMUL_ANIM_COUNT.value: lambda supply: 8.0,
    }
