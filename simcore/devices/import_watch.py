"""Calls a function with a module once the program has loaded it, or refuses the import; never loads a module itself."""

from __future__ import annotations

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
    _watch()
    _hooks.setdefault(name, []).append(hook)


def refuse_import(name: str, sentence: str) -> None:
    """Raise a `VendorError` with a sentence where the program imports a module, installed or not.

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
    """Finds what the others find, with a loader that calls the hook at its end."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname in _refused:
            return ModuleSpec(fullname, _Refusal(_refused[fullname]))
        if fullname not in _hooks:
            return None
        for finder in sys.meta_path:
            if finder is self:
                continue
            spec = finder.find_spec(fullname, path, target)
            if spec is not None:
                if spec.loader is not None:
                    spec.loader = _HookedLoader(spec.loader, fullname)
                return spec
        return None


class _Refusal(Loader):
    """Loads nothing and says why."""

    def __init__(self, sentence: str) -> None:
        self._sentence = sentence

    def exec_module(self, module: ModuleType) -> None:
        raise VendorError(self._sentence)


class _HookedLoader(Loader):
    """Another loader, and then the hook."""

    def __init__(self, loader: Any, name: str) -> None:
        self._loader = loader
        self._name = name

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        made: ModuleType | None = self._loader.create_module(spec)
        return made

    def exec_module(self, module: ModuleType) -> None:
        self._loader.exec_module(module)
        for hook in _hooks.pop(self._name, []):
            hook(module)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._loader, name)
