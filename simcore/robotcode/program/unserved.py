"""Devices of the program that simcore does not simulate, for a warning at startup."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from importlib.metadata import packages_distributions, requires
from typing import Any

from simcore.robotcode.program.makers import MAKER_MODULES, device_of, makers
from simcore.robotcode.program.object_graph import ObjectGraph

__all__ = ["unknown_sim_devices", "unserved_devices"]


def unserved_devices(graph: ObjectGraph) -> list[str]:
    """List the vendor library objects that simcore does not simulate, by class, CAN ID and attribute path.

    A vendor library is a C++ package built on WPILib; pure Python objects need no simulation.

    Args:
        graph: Graph of the robot object.
    """
    unserved = {name for maker in makers() for name in maker.unserved}
    packages = {package for package, _ in MAKER_MODULES}
    found = []
    for name, made in graph.objects():
        cls = next((c for c in type(made).__mro__ if type(c).__name__ == "pybind11_type"), None)
        if cls is None:
            continue
        package = cls.__module__.split(".")[0]
        is_unserved = cls.__name__ in unserved if package in packages else _is_of_a_vendor(package)
        if is_unserved and device_of(made) is None:
            found.append(f"{cls.__name__} {_number(made)}({name})")
    return sorted(set(found))


def unknown_sim_devices(names: Sequence[str]) -> list[str]:
    """Return the names of WPILib SimDevices that no maker in simcore simulates."""
    known = [part for maker in makers() for part in maker.sim_devices]
    return sorted({name.split("/")[0] for name in names if not any(part in name for part in known)})


def _number(made: Any) -> str:
    """Return the CAN ID of a device followed by a space, or an empty string without a CAN ID."""
    for method in ("getDeviceId", "getDeviceID", "getDeviceNumber"):
        if hasattr(made, method):
            return f"{int(getattr(made, method)())} "
    return ""


_OWN = (
    *("wpilib", "robotpy-wpi", "robotpy-hal", "robotpy-cscore", "robotpy-commands", "pyntcore"),
    *("robotpy-apriltag", "robotpy-fields"),
)
"""Prefixes of the names of WPILib's own distributions."""


@cache
def _is_of_a_vendor(package: str) -> bool:
    """Return whether a package depends on WPILib but is not part of WPILib."""
    others = (name for name in packages_distributions().get(package, ()) if not name.lower().startswith(_OWN))
    wanted = [text.lower() for name in others for text in requires(name) or ()]
    return any(text.startswith(("wpilib", "robotpy-hal", "robotpy-wpi")) for text in wanted)
