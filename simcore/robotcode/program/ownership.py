"""Ownership of each device's simulated state: by simcore's physics, or by a team's own model.

If two models wrote the same rotor position, robot code would read the two values in turn. So each maker checks the
writes of other models (`Maker.watch_simulations`). The maker drops writes to a device that physics has claimed, with
one warning. The maker records a write to any other device, and physics does not claim that device.
"""

from __future__ import annotations

import logging
from collections.abc import Set

from simcore.errors import ConfigError
from simcore.quantities import DeviceKey

__all__ = ["DRIVETRAIN", "Ownership"]

_log = logging.getLogger(__name__)

_MANY = 100  # dropped writes before a warning; fewer may come from a model's thread that is still stopping

DRIVETRAIN = "drivetrain"
"""Name under which physics claims the drivetrain's devices."""


class Ownership:
    """Owners of all devices of one program, created before the robot object."""

    def __init__(self) -> None:
        self._claimed: dict[DeviceKey, str] = {}
        self._dropped: dict[str, int] = {}
        self.foreign: set[DeviceKey] = set()
        """Devices that another model has written."""

    def claim(self, key: DeviceKey, owner: str) -> None:
        """Reserve a device for physics from now on; `owner` is the owner's name in messages.

        Raises:
            ConfigError: A mechanism and the drivetrain both claim the device.
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
        """Devices that physics has claimed."""
        return self._claimed.keys()

    def may_write(self, key: DeviceKey) -> bool:
        """Record another model's write to a device; return False if physics owns the device, else True."""
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
