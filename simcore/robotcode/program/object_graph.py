"""Search of the robot object's attributes for devices: the object that holds each motor, and the attribute name."""

from __future__ import annotations

import sys
import types
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from simcore.robotcode.program.makers import MAKER_MODULES, device_of
from simcore.robotcode.program.motor_controllers import BuiltDevice
from simcore.robotcode.program.recorder import Built, built

__all__ = ["Holder", "ObjectGraph", "is_foreign"]

_MOST = 20_000  # maximum number of objects to search
_NEAR = 3  # maximum number of attributes from a holder to its own device; longer paths lead to other subsystems
_MAKERS = {package for package, _ in MAKER_MODULES}
_VENDORS = _MAKERS - {"wpilib"}
_PLAIN = (str, bytes, int, float, complex, bool, type(None), types.ModuleType, types.FunctionType, type)


@dataclass(frozen=True, slots=True, eq=False)
class Holder:
    """Object or module of the program whose attributes lead to devices."""

    made: Any
    name: str
    """Attribute path from the robot object: `container.drive.front_left`; empty for the robot object or a module."""
    devices: dict[str, BuiltDevice]
    """Devices by attribute path from the holder: `drive_motor`, `steer.motor`."""


class ObjectGraph:
    """Objects reachable from a robot object through attributes, lists, tuples and dictionaries.

    Args:
        robot: Robot object.
        folder: Folder of the project, to search the globals of the project's modules as well; None for no modules.
    """

    def __init__(self, robot: Any, folder: Path | None = None) -> None:
        self._parents: dict[int, int] = {}
        self._names: dict[int, str] = {}
        self._objects: dict[int, Any] = {}
        self._devices: dict[int, BuiltDevice | None] = {}
        self._below: dict[int, list[tuple[str, Any]]] = {}
        self._depths: dict[int, int] = {}
        self.modules = _modules(folder)
        """Imported modules in the project's folder; empty without a folder."""
        self._walk([("", robot), *(pair for module in self.modules for pair in _globals(module))])

    def holders(self) -> list[Holder]:
        """Return the objects that hold devices, directly or in members: nearest to the robot first, then modules."""
        found = []
        leads = self._leading()
        for key, made in self._objects.items():
            if key in leads:
                devices = self._held(made)
                if devices:
                    found.append(Holder(made, self._names[id(made)], devices))
        for module in self.modules:
            devices = {n: d for n, value in _globals(module) if (d := self._device(value)) is not None}
            if devices:
                found.append(Holder(module, "", devices))
        return found

    def objects(self) -> Iterator[tuple[str, Any]]:
        """Yield attribute path and object for every reachable object."""
        return ((self._names[key], made) for key, made in self._objects.items())

    def built(self, kind: str, name: str) -> list[Built]:
        """Return the WPILib objects that the program has built, reachable objects first.

        Args:
            kind: Kind of object, as in `Built.kind`.
            name: Beginning of the class name.
        """
        seen = {id(record.made): record for record in built(kind, name)}
        ends: dict[str, tuple[str, ...]] = {
            "kinematics": ("Kinematics",),
            "odometry": ("Odometry", "PoseEstimator"),
            "drive": ("Drive",),
        }
        kept: list[Built] = []
        for made in self._objects.values():
            cls = next((c for c in type(made).__mro__ if c.__module__.startswith(("wpimath", "wpilib"))), None)
            if cls is not None and cls.__name__.startswith(name) and cls.__name__.endswith(ends[kind]):
                kept.append(seen.pop(id(made)) if id(made) in seen else Built(kind, cls.__name__, made, (), {}))
        return kept + list(seen.values())

    def name_of(self, device: BuiltDevice) -> str:
        """Return the attribute path from the robot to a device, or an empty string if the device is unreachable."""
        return next((self._names[k] for k, made in self._objects.items() if self._same(made, device)), "")

    # --- internals ------------------------------------------------------------------------------------------------

    def _walk(self, roots: list[tuple[str, Any]]) -> None:
        queue: deque[tuple[str, Any, int]] = deque((name, made, 0) for name, made in roots)
        while queue and len(self._objects) < _MOST:
            name, made, parent = queue.popleft()
            key = id(made)
            if key in self._objects:
                continue
            self._objects[key], self._names[key], self._parents[key] = made, name, parent
            self._depths[key] = self._depths.get(parent, -1) + 1
            if self._device(made) is None:
                self._below[key] = list(_children(made))
                queue.extend((f"{name}.{n}" if name else n, child, key) for n, child in self._below[key])

    def _leading(self) -> set[int]:
        """Return the `id` of each object whose attributes lead to a device."""
        above: dict[int, list[int]] = {}
        for key, children in self._below.items():
            for _, child in children:
                above.setdefault(id(child), []).append(key)
        queue = [key for key, made in self._objects.items() if self._device(made) is not None]
        leads: set[int] = set()
        while queue:
            for key in above.get(queue.pop(), ()):
                if key not in leads:
                    leads.add(key)
                    queue.append(key)
        return leads

    def _device(self, made: Any) -> BuiltDevice | None:
        key = id(made)
        if key not in self._devices:
            self._devices[key] = None if isinstance(made, (dict, list, tuple, set)) else device_of(made)
        return self._devices[key]

    def _same(self, made: Any, device: BuiltDevice) -> bool:
        found = self._device(made)
        return found is not None and found.key == device.key

    def _held(self, made: Any) -> dict[str, BuiltDevice]:
        """Return the devices below an object, excluding paths back through the object's parents."""
        above = set()
        key = id(made)
        while key:
            above.add(key)
            key = self._parents.get(key, 0)
        found: dict[str, BuiltDevice] = {}
        seen = set(above)
        level, deep, own = [("", made)], 0, self._depths[id(made)]
        while level:
            below, deep = [], deep + 1
            for name, parent in level:
                for n, child in self._below.get(id(parent), ()):
                    if id(child) in seen:
                        continue
                    seen.add(id(child))
                    path = f"{name}.{n}" if name else n
                    device = self._device(child)
                    if device is not None:
                        found.setdefault(path, device)
                    elif deep < _NEAR or self._depths.get(id(child), 0) > own:
                        below.append((path, child))
            level = below
        return found


def _children(made: Any) -> Iterator[tuple[str, Any]]:
    """Yield the attributes of a program's object, or the members of a container, with their names."""
    if isinstance(made, Mapping) and not is_foreign(type(made), containers=True):
        pairs = [(str(key), value) for key, value in list(made.items())]
    elif isinstance(made, (list, tuple, set, frozenset)):
        pairs = [(str(k), value) for k, value in enumerate(list(made))]
    elif isinstance(made, type):
        pairs = [] if is_foreign(made) else [(n, v) for n, v in vars(made).items() if not n.startswith("__")]
    elif is_foreign(type(made)):
        return
    else:
        pairs = []
        for cls in type(made).__mro__:
            if not is_foreign(cls):
                pairs += [(name, v) for name, v in vars(cls).items() if not name.startswith("__")]
                pairs += [(n, getattr(made, n, None)) for n in _slots(cls)]
        pairs = [*getattr(made, "__dict__", {}).items(), *pairs]
    for name, value in pairs:
        if not isinstance(value, (*_PLAIN, property, classmethod, staticmethod)):
            yield name, value


def _slots(cls: type) -> list[str]:
    names = vars(cls).get("__slots__", ())
    return [names] if isinstance(names, str) else list(names)


def is_foreign(cls: type, *, containers: bool = False) -> bool:
    """Return whether a class belongs to Python, simcore or a library that builds no motor controllers.

    With `containers`, Python's containers are not foreign.
    """
    root = cls.__module__.split(".")[0]
    if root in sys.stdlib_module_names:
        return not (containers and root in ("builtins", "collections", "types")) and root != "__main__"
    if root == "simcore":
        return True
    file = getattr(sys.modules.get(cls.__module__), "__file__", None) or ""
    if file.endswith((".so", ".pyd")):
        return True
    return ("site-packages" in file or "dist-packages" in file) and not _builds_motors(root)


@cache
def _builds_motors(package: str) -> bool:
    """Return whether an installed package, such as a team's shared library, imports anything from a vendor library."""
    if package in _MAKERS:
        return False
    for name, module in list(sys.modules.items()):
        if name.split(".")[0] == package and module is not None:
            for part in list(vars(module).values()):
                home = part.__name__ if isinstance(part, types.ModuleType) else getattr(part, "__module__", None)
                if isinstance(home, str) and home.split(".")[0] in _VENDORS:
                    return True
    return False


def _modules(folder: Path | None) -> list[types.ModuleType]:
    """Return the imported modules in the project's folder; empty without a folder."""
    if folder is None:
        return []
    base, found = folder.resolve(), []
    for module in list(sys.modules.values()):
        file = getattr(module, "__dict__", {}).get("__file__")
        if isinstance(file, str) and "site-packages" not in file and Path(file).is_relative_to(base):
            found.append(module)
    return found


def _globals(module: types.ModuleType) -> list[tuple[str, Any]]:
    """Return the globals of a module that may hold devices, then the classes defined in the module."""
    names = [(n, v) for n, v in list(vars(module).items()) if not n.startswith("__")]
    classes = [(n, v) for n, v in names if isinstance(v, type) and v.__module__ == module.__name__]
    return [(n, v) for n, v in names if not isinstance(v, _PLAIN)] + classes
