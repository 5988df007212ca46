"""Import hooks: call a function after a module is imported, or refuse the import."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

from simcore.errors import VendorError

__all__ = ["after_import", "refuse_import"]

Hook = Callable[[Any], None]


def after_import(name: str, hook: Hook) -> None:
    """Call a function with a module, at once if the module is loaded, else after the import of the module.

    Args:
        name: Name of the module, which this function does not import.
        hook: Function that receives the module, called once.

    >>> seen = []
    >>> after_import("json", lambda module: seen.append(module.__name__))
    >>> seen
    ['json']
    """
    module = sys.modules.get(name)
    if module is not None and getattr(getattr(module, "__spec__", None), "_initializing", False) is False:
        hook(module)
        return
    _watch()
    _hooks.setdefault(name, []).append(hook)


def refuse_import(name: str, sentence: str) -> None:
    """Make each import of a module raise a `VendorError` with a message, even if the module is installed.

    >>> refuse_import("flux_capacitor", "it needs 1.21 GW")
    >>> import flux_capacitor
    Traceback (most recent call last):
    simcore.errors.VendorError: it needs 1.21 GW
    """
    _watch()
    _refused[name] = sentence


def _watch() -> None:
    if not any(isinstance(finder, _Watcher) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Watcher())


_hooks: dict[str, list[Hook]] = {}
_refused: dict[str, str] = {}


class _Watcher(MetaPathFinder):
    """Import finder whose loaders call the hooks of a module after loading, or raise for a refused module."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname in _refused:
            return ModuleSpec(fullname, _Refusal(_refused[fullname]))
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


class _Refusal(Loader):
    """Loader that raises a `VendorError` instead of loading the module."""

    def __init__(self, sentence: str) -> None:
        self._sentence = sentence

    def exec_module(self, module: ModuleType) -> None:
        raise VendorError(self._sentence)
