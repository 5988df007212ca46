"""WPILib's SimDevice copies of the devices, for the simulation GUI: off in simulated time unless asked for.

Each device object copies its state into WPILib SimDevices before every robot tick, 17-39 us a device. Tests have no
use for that, and it would be most of the cost of a tick.
"""

from __future__ import annotations

from typing import Any

from phoenix6 import hardware

__all__ = ["Mirror"]

_CLASSES = ("TalonFX", "TalonFXS", "CANcoder", "Pigeon2", "CANrange", "CANdi", "CANdle")


def _nothing(device: Any) -> None:
    return None


class Mirror:
    """Switches the copying off, and on again."""

    def __init__(self) -> None:
        self._saved: list[tuple[type, str, Any]] = []

    def off(self) -> None:
        """Devices built from here on do not copy themselves."""
        for name in _CLASSES:
            cls = getattr(hardware, name)
            attribute = f"_{name}__on_periodic"
            method = cls.__dict__.get(attribute)
            if method is not None:
                self._saved.append((cls, attribute, method))
                setattr(cls, attribute, _nothing)

    def on(self) -> None:
        """As the library has it."""
        for cls, attribute, method in self._saved:
            setattr(cls, attribute, method)
        self._saved.clear()
