"""In place of the native library that holds swerve: functions are added by the swerve stand-in."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

__all__ = ["PREFIX", "SimulatedApi", "plain"]

PREFIX = "c_ctre_phoenix6_"
"""First part of the names of nearly all native functions."""


def plain(name: str) -> str:
    """Name of a native function as a reader knows it, `Follower` or `platform_replay_play`."""
    return name.removeprefix(PREFIX).removeprefix("RequestControl")


class SimulatedApi:
    """An object with functions, as `Native.api_instance()` returns."""

    def add(self, functions: Mapping[str, Callable[..., Any]]) -> None:
        """Answer these native functions."""
        self.__dict__.update(functions)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        raise NotImplementedError(f"Phoenix 6 function {plain(name)} is not modelled in simulated time")
