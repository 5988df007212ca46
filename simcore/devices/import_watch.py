"""Calls a function with a module once the program has loaded it, and never loads it itself."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

__all__ = ["after_import"]

Hook = Callable[[Any], None]


def after_import(name: str, hook: Hook) -> None:
    """Call a function with a module: at once if it is loaded, else when it is.

    Args:
        name: Of the module.
        hook: Called once.

    >>> seen = []
    >>> after_import("json", lambda module: seen.append(module.__name__))
    >>> seen
    ['json']
    """
    module = sys.modules.get(name)
    if module is not None and getattr(getattr(module, "__spec__", None), "_initializing", False) is False:
        hook(module)
        return
    if not any(isinstance(finder, _Watcher) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Watcher())
    _hooks.setdefault(name, []).append(hook)


_hooks: dict[str, list[Hook]] = {}


class _Watcher(MetaPathFinder):
    """Finds what the others find, with a loader that calls the hooks once it has executed the module."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname not in _hooks:
            return None
        others = (finder.find_spec(fullname, path, target) for finder in sys.meta_path if finder is not self)
        spec = next(filter(None, others), None)
        if spec is not None and spec.loader is not None:
            spec.loader.exec_module = functools.partial(_execute, spec.loader.exec_module)  # type: ignore[method-assign]
        return spec


def _execute(exec_module: Callable[[ModuleType], object], module: ModuleType) -> None:
    exec_module(module)
    for hook in _hooks.pop(module.__name__, []):
        hook(module)
