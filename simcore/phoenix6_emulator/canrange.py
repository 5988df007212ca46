"""CANrange: a distance, and whether something is near."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar, NamedTuple

from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6_emulator.clock import SimulatedClock
from simcore.phoenix6_emulator.device import Device
from simcore.phoenix6_emulator.wire import Setting

__all__ = ["CANrange", "CANrangeFrame"]

_STRONG = 3000.0
"""Signal strength that the simulated sensor always reports."""


class CANrangeFrame(NamedTuple):
    """What a CANrange tells robot code."""

    distance: float
    detected: bool
    time: float
    supply: float
    fov: tuple[float, float, float, float]


class CANrange(Device):
    """One CANrange.

    Args:
        device_id: CAN id.
        clock: Simulated time.
        defaults: Factory configuration.
    """

    model = "canrange"
    type_number = 8

    def __init__(self, device_id: int, clock: SimulatedClock, defaults: Mapping[int, Setting]) -> None:
        super().__init__(device_id, clock, defaults)
        self.distance = 0.0
        """To what is in front of it [m]."""
        self.is_detected = True
        """Whether something is nearer than the configured threshold."""
        self.configured()
        self.send_frame()

    def configured(self) -> None:
        """Take over the threshold."""
        c = self.config
        self._threshold = c[SpnValue.CANRANGE_PROXIMITY_THRESHOLD.value]
        self._hysteresis = c[SpnValue.CANRANGE_PROXIMITY_HYSTERESIS.value]
        self._strength = c[SpnValue.CANRANGE_MIN_SIG_STRENGTH_FOR_VALID_MEAS.value]
        self._detect()

    def _detect(self) -> None:
        band = self._hysteresis if self.is_detected else -self._hysteresis
        self.is_detected = self._strength <= _STRONG and self.distance < self._threshold + band

    def set_input(self, name: str, value: float) -> None:
        """What is in front of it."""
        if name == "Distance":
            self.distance = value
            self._detect()
        elif name == "SupplyVoltage":
            self.supply = max(value, 4.0)
        else:
            super().set_input(name, value)

    def sample(self) -> CANrangeFrame:
        """A frame of this moment."""
        c = self.config
        fov = tuple(
            float(c[spn.value])
            for spn in (
                SpnValue.CANRANGE_FOV_CENTER_X,
                SpnValue.CANRANGE_FOV_CENTER_Y,
                SpnValue.CANRANGE_FOV_RANGE_X,
                SpnValue.CANRANGE_FOV_RANGE_Y,
            )
        )
        return CANrangeFrame(self.distance, self.is_detected, self.clock.now, self.supply, fov)  # type: ignore[arg-type]

    signals: ClassVar[Mapping[int, Callable[[Any], float]]] = {
        SpnValue.CANRANGE_DISTANCE_METERS.value: lambda f: f.distance,
        SpnValue.CANRANGE_PROXIMITY_DETECTED.value: lambda f: f.detected,
        SpnValue.CANRANGE_MEAS_TIME.value: lambda f: f.time,
        SpnValue.CANRANGE_SIGNAL_STRENGTH.value: lambda f: _STRONG,
        SpnValue.CANRANGE_MEAS_STATE.value: lambda f: 0.0,
        SpnValue.CANRANGE_AMBIENT_SIGNAL.value: lambda f: 0.0,
        SpnValue.CANRANGE_DISTANCE_STD_DEV.value: lambda f: 0.0,
        SpnValue.CANRANGE_SUPPLY_VOLTAGE.value: lambda f: f.supply,
        SpnValue.CANRANGE_REAL_FOV_CENTER_X.value: lambda f: f.fov[0],
        SpnValue.CANRANGE_REAL_FOV_CENTER_Y.value: lambda f: f.fov[1],
        SpnValue.CANRANGE_REAL_FOV_RANGE_X.value: lambda f: f.fov[2],
        SpnValue.CANRANGE_REAL_FOV_RANGE_Y.value: lambda f: f.fov[3],
    }
