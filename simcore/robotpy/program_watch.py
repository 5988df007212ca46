"""What a robot program builds and asks for: noted from before its modules are imported.

Programs keep devices at the top of robot.py, in class bodies and in modules of their own, which are built on import. So
whoever loads a program calls `watch_program` first. Tables of NetworkTables that a program only reads leave no trace
there: the functions of ntcore that name one are wrapped, and modules that were loaded before are searched.
"""

from __future__ import annotations

import functools
import importlib
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from simcore import season
from simcore.devices.import_watch import after_import

if TYPE_CHECKING:
    from simcore.devices.ownership import Ownership

ntcore = season.ntcore

__all__ = ["TableWatch", "begin_robot", "load_watched_class", "table_watch", "watch_program"]

_ownership: Ownership | None = None
_robots = 0  # that tests have built in this process


def watch_program(*, simulated: bool = False) -> Ownership:
    """Note from now on what a program builds, and which devices its own simulation writes.

    Args:
        simulated: Whether Phoenix 6 shall run in simulated time from here on.
    """
    global _ownership
    if _ownership is None:
        if simulated and find_spec("phoenix6") is not None:
            from simcore.robotpy.simulated_phoenix import install_simulated_phoenix

            install_simulated_phoenix()
        import simcore.devices.program_odometry
        import simcore.robotpy.built_ports  # noqa: F401
        from simcore.devices.makers import watch_makers
        from simcore.devices.ownership import Ownership
        from simcore.devices.simulation_questions import watch_questions
        from simcore.photonvision.photon_program import HOOKS

        _ownership = Ownership()
        watch_makers(_ownership.may_write)
        watch_questions()
        table_watch()
        for name, hook in HOOKS.items():
            after_import(name, hook)
    return _ownership


def begin_robot() -> None:
    """A test is about to build a robot: the second one of a process, and each later one, finds no devices.

    The first one finds those that its modules have built.
    """
    global _robots
    _robots += 1
    watch_program(simulated=True)
    if _robots > 1 and find_spec("phoenix6") is not None:
        from simcore.robotpy.simulated_phoenix import install_simulated_phoenix

        install_simulated_phoenix()


def load_watched_class(module: str, name: str, simulated: bool) -> Any:
    """Import a program in a new process, and return its robot class; what it builds on the way is noted.

    Args:
        module: Of the class.
        name: Of the class in it, with dots.
        simulated: As `watch_program` wants it.
    """
    from simcore.robotpy.repeatable_runs import seed_generators

    seed_generators()  # a program may draw while it is imported
    watch_program(simulated=simulated)
    return functools.reduce(getattr, name.split("."), importlib.import_module(module))


# --- tables of NetworkTables -----------------------------------------------------------------------------------------


class TableWatch:
    """First parts of all names that were asked for, in their order."""

    def __init__(self) -> None:
        self.names: dict[str, None] = {}
        cls = ntcore.NetworkTableInstance
        names = {season.own_name(cls, name) for name in ("get_table", "get_entry")}
        for method in sorted({*names, *(n for n in dir(cls) if n.startswith("get") and n.lower().endswith("topic"))}):
            setattr(cls, method, self._noting(getattr(cls, method)))

    def search(self, folder: Path) -> None:
        """Note tables that modules of a project, loaded already, keep at their top or in their classes.

        Args:
            folder: Of the project.
        """
        for module in list(sys.modules.values()):
            names = getattr(module, "__dict__", {})  # not by getattr: that can load a module that loads itself lazily
            file = names.get("__file__")
            if not isinstance(file, str) or "site-packages" in file or not Path(file).is_relative_to(folder):
                continue
            for value in list(names.values()):
                self._note_owned(value)
                if isinstance(value, type):
                    for part in list(vars(value).values()):
                        self._note_owned(part)

    def _note(self, name: str) -> None:
        first = name.strip("/").split("/", 1)[0]
        if first:
            self.names.setdefault(first)

    def _note_owned(self, value: Any) -> None:
        if isinstance(value, ntcore.NetworkTable):
            self._note(value.get_path())
        elif isinstance(value, ntcore.NetworkTableEntry):
            self._note(value.get_name())
        elif isinstance(value, ntcore.Subscriber):
            self._note(value.get_topic().get_name())

    def _noting(self, method: Any) -> Any:
        @functools.wraps(method)
        def get(instance: Any, *args: Any, **kwargs: Any) -> Any:
            for name in (*args[:1], *kwargs.values()):
                if isinstance(name, str):
                    self._note(name)
            return method(instance, *args, **kwargs)

        return get


_watch: TableWatch | None = None


def table_watch() -> TableWatch:
    """That of this process; it watches from the first call on."""
    global _watch
    if _watch is None:
        _watch = TableWatch()
    return _watch
