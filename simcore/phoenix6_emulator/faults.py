"""Fault flags: one that is active now, one that stays until robot code clears it, and the setting that clears it."""

from __future__ import annotations

from collections.abc import Set

from phoenix6.spns.spn_value import SpnValue

__all__ = ["CLEAR_ALL", "FAULTS", "FaultFlags"]

CLEAR_ALL = SpnValue.SPN_CLEAR_STICKY_FAULTS.value
"""The setting that clears every sticky fault."""
FAULTS: dict[str, int] = {
    name.removeprefix("FAULT_"): member.value
    for name, member in SpnValue.__members__.items()
    if name.startswith("FAULT_")
}
"""Number of each fault, by its name in `SpnValue` without `FAULT_`."""
_MEMBERS = SpnValue.__members__
_STICKY = {_MEMBERS[f"STICKY_FAULT_{name}"].value: spn for name, spn in FAULTS.items()}
_CLEAR = {
    _MEMBERS[f"CLEAR_STICKY_FAULT_{name}"].value: spn
    for name, spn in FAULTS.items()
    if f"CLEAR_STICKY_FAULT_{name}" in _MEMBERS
}


class FaultFlags:
    """The faults of one device."""

    __slots__ = ("_active", "_sticky")

    def __init__(self) -> None:
        self._active: Set[int] = frozenset()
        self._sticky: set[int] = set()

    def show(self, active: Set[int]) -> None:
        """These faults are active now; they become sticky."""
        self._active = active
        if active:
            self._sticky |= active

    def clear(self, setting: int) -> bool:
        """Clear what this setting clears; False when it is another kind of setting."""
        if setting == CLEAR_ALL:
            self._sticky.clear()
            return True
        fault = _CLEAR.get(setting)
        if fault is None:
            return False
        self._sticky.discard(fault)
        return True

    def read(self, spn: int) -> float | None:
        """1 or 0 for a fault or a sticky fault, None for any other signal."""
        if spn in _STICKY:
            return float(_STICKY[spn] in self._sticky)
        if spn in _ALL:
            return float(spn in self._active)
        if spn == SpnValue.ALL_FAULTS.value:
            return float(len(self._active))
        if spn == SpnValue.ALL_STICKY_FAULTS.value:
            return float(len(self._sticky))
        return None


_ALL = frozenset(FAULTS.values())
