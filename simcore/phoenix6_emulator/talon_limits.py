"""Soft limits and limit switches of a motor controller."""

from __future__ import annotations

from collections.abc import Mapping

from phoenix6.spns.spn_value import SpnValue

from simcore.phoenix6_emulator.config_text import Setting
from simcore.phoenix6_emulator.emulated_device import Devices
from simcore.phoenix6_emulator.emulated_encoders import EmulatedCANdi
from simcore.phoenix6_emulator.emulated_peripherals import EmulatedCANrange

__all__ = ["TalonLimit"]

_PIN, _TALON, _DISABLED, _CANCODER, _CANRANGE, _CANDI_S1, _CANDI_S2 = 0, 1, 3, 4, 6, 7, 8


class TalonLimit:
    """One direction: a position not to pass, and a switch.

    Args:
        controller: Name of the controller, for messages.
        forward: Whether it is the forward one.
    """

    __slots__ = (
        "_autoset",
        "_autoset_value",
        "_controller",
        "_forward",
        "_hard",
        "_normally_closed",
        "_remote",
        "_soft",
        "_source",
        "_threshold",
        "_was_closed",
        "closed",
        "is_plain",
    )

    def __init__(self, controller: str, *, forward: bool) -> None:
        self._controller = controller
        self._forward = forward
        self.closed = False
        """Whether the switch on the controller itself is closed, as `sim_state` sets it."""
        self._was_closed = False
        self.is_plain = True
        """Whether nothing but the switch on the controller itself could stop the motor."""

    def configure(self, config: Mapping[int, Setting]) -> None:
        """Apply the configuration of this direction.

        Raises:
            NotImplementedError: The switch is on a device whose switches are not modelled.
        """
        way = "FORWARD" if self._forward else "REVERSE"

        def get(name: str) -> Setting:
            return config[SpnValue[name.format(way)].value]

        self._soft = bool(get("CONFIG_{}_SOFT_LIMIT_ENABLE"))
        self._threshold = get("CONFIG_{}_SOFT_LIMIT_THRESHOLD")
        self._source = int(get("CONFIG_{}_LIMIT_SOURCE"))
        self._remote = int(get("CONFIG_{}_LIMIT_REMOTE_SENSOR_ID"))
        self._hard = bool(get("CONFIG_{}_LIMIT_ENABLE")) and self._source != _DISABLED
        self._normally_closed = get("CONFIG_{}_LIMIT_TYPE") == 1
        self._autoset = bool(get("CONFIG_{}_LIMIT_AUTOSET_POS_ENABLE"))
        self._autoset_value = get("CONFIG_{}_LIMIT_AUTOSET_POS_VALUE")
        self.is_plain = not self._soft and (not self._hard or (self._source == _PIN and not self._normally_closed))
        if self._hard and self._source not in (_PIN, _TALON, _CANRANGE, _CANDI_S1, _CANDI_S2):
            raise NotImplementedError(
                f"{self._controller}: limit source {self._source} is not modelled in simulated time"
            )

    def is_closed(self, devices: Devices) -> bool:
        """Whether the switch connects to ground now."""
        if self._source == _PIN:
            return self.closed
        if self._source == _TALON:
            talon = devices.get((4, self._remote))
            limit = getattr(talon, "forward" if self._forward else "reverse", None)
            return limit is not None and limit.closed
        if self._source == _CANRANGE:
            near = devices.get((8, self._remote))
            return isinstance(near, EmulatedCANrange) and near.is_detected
        candi = devices.get((9, self._remote))
        return isinstance(candi, EmulatedCANdi) and candi.is_closed(0 if self._source == _CANDI_S1 else 1)

    def autoset(self, devices: Devices) -> float | None:
        """Position to take when the switch has just been hit; None otherwise."""
        if not self._autoset:
            return None
        hit = self.is_closed(devices) != self._normally_closed
        fresh = hit and not self._was_closed
        self._was_closed = hit
        return self._autoset_value if fresh else None

    def stops(self, devices: Devices, position: float, ignore_soft: bool, ignore_hard: bool) -> tuple[bool, bool]:
        """Whether the soft limit and the switch block this direction."""
        soft = False
        if self._soft and not ignore_soft:
            soft = position > self._threshold if self._forward else position < self._threshold
        hard = self._hard and not ignore_hard and self.is_closed(devices) != self._normally_closed
        return soft, hard
