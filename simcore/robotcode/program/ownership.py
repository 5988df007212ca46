"""Owner of a device's simulated state: simcore's physics, or a team's own model.

If two models write one rotor, robot code reads both in turn. So each maker asks before another model writes
(`Maker.watch_simulations`): it drops writes to a device that physics has claimed, with one warning; it records others,
and physics does not write that device.
"""

from __future__ import annotations

import logging
from collections.abc import Set

from simcore.errors import ConfigError
from simcore.quantities import DeviceKey

__all__ = ["DRIVETRAIN", "Ownership"]

_log = logging.getLogger(__name__)

_MANY = 100  # dropped writes; fewer may come from a model's thread that ran when it was switched off

DRIVETRAIN = "drivetrain"
"""Owner of the drivetrain's devices."""


class Ownership:
    """Owners of devices; one per program, made before the robot is built."""

    def __init__(self) -> None:
        self._claimed: dict[DeviceKey, str] = {}
        self._dropped: dict[str, int] = {}
        self.foreign: set[DeviceKey] = set()
        """Devices that another model has written."""

    def claim(self, key: DeviceKey, owner: str) -> None:
        """Reserve this device for physics from now on; `owner` is its name in messages.

        Raises:
            ConfigError: A mechanism and the drivetrain both claim it.
        """
        before = self._claimed.get(key, owner)
        if before != owner and DRIVETRAIN in (before, owner):
            mechanism = before if owner == DRIVETRAIN else owner
            raise ConfigError(
                f"mechanism {mechanism!r}: {key[0]} {key[1]} is the drivetrain's; "
                "give the device that moves the mechanism"
            )
        self._claimed[key] = owner

    @property
    def claimed(self) -> Set[DeviceKey]:
        """Devices that only physics writes."""
        return self._claimed.keys()

    def may_write(self, key: DeviceKey) -> bool:
        """Record another model's write to a device; return False to drop it, if physics has claimed the device."""
        owner = self._claimed.get(key)
        if owner is None:
            self.foreign.add(key)
            return True
        self._dropped[owner] = count = self._dropped.get(owner, 0) + 1
        if count == _MANY:
            _log.warning(
                "%s %s belongs to simcore's %s: what the project's own simulation writes into it is dropped",
                *key,
                owner,
            )
        return False
