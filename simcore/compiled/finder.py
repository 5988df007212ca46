"""Lets Python's import system take a compiled module where one fits its source.

Anything else is plain Python, without a word: no build, another Python, changed sources, a build that does not load.

A hook for the folders of the package, not a finder of its own in `sys.meta_path`: pytest puts its finder in front of
all others and takes the sources of plugins for itself, and then half of the modules would be compiled. It asks these
folders too.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from importlib.machinery import SOURCE_SUFFIXES, ExtensionFileLoader, FileFinder, ModuleSpec, SourceFileLoader
from types import ModuleType

from simcore.compiled import store
from simcore.compiled.modules import GROUP, MODULES, source_of

__all__ = ["Build", "CompiledLoader", "install", "installed"]

_LIBRARY = f"{GROUP}__mypyc"


class CompiledLoader(ExtensionFileLoader):
    """Loads a compiled module under the name and the `__file__` of its source.

    Args:
        name: Of the module.
        source: What it was compiled from.
        path: The compiled file.
    """

    def __init__(self, name: str, source: str, path: str) -> None:
        super().__init__(name, path)
        self.source = source

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        """Load the file; `spec` is of the source, so that its file is found."""
        module = super().create_module(ModuleSpec(spec.name, self, origin=self.path))
        module.__file__ = self.source
        return module


class Build:
    """The build that fits the sources, looked for once, at the first import of a module that may be compiled.

    Args:
        stores: Where builds may be.
        package: Folder of simcore.
    """

    def __init__(self, stores: Sequence[str], package: str = store.PACKAGE) -> None:
        self.stores = list(stores)
        self.trouble = ""
        """Why a build that fits is not in use."""
        self.package = package
        self._sources = {
            module: os.path.join(os.path.dirname(package), *source_of(module).split("/")) for module in MODULES
        }
        self._folder: str | None = None
        self._has_looked = False

    @property
    def folder(self) -> str | None:
        """Where it is, its library loaded: all modules come compiled, or none."""
        if not self._has_looked:
            self._has_looked = True
            self._folder = self._look()
        return self._folder

    def spec(self, fullname: str) -> ModuleSpec | None:
        """Where a module comes from, if it is one of the compiled."""
        source = self._sources.get(fullname)
        if source is None or self.folder is None:
            return None
        compiled = store.library(self.folder, fullname)
        spec = ModuleSpec(fullname, CompiledLoader(fullname, source, compiled), origin=source)
        spec.has_location = True
        return spec

    def finder(self, path: str) -> FileFinder:
        """For a folder of the package, as `sys.path_hooks` asks for it.

        Raises:
            ImportError: It is another folder.
        """
        path = os.path.abspath(path)
        if path != self.package and not path.startswith(self.package + os.sep):
            raise ImportError("not a folder of simcore", path=path)
        return _Finder(path, self)

    def _look(self) -> str | None:
        if any(name in sys.modules for name in self._sources):
            self.trouble = "simcore was imported before"  # compiled modules crash beside plain ones
            return None
        try:
            folder = store.find(self.stores, store.tag(self.package))
        except OSError:  # no sources, e.g. packed into one file
            return None
        if folder is None:
            return None
        path = store.library(folder, _LIBRARY)
        loader = ExtensionFileLoader(_LIBRARY, path)
        try:
            module = loader.create_module(ModuleSpec(_LIBRARY, loader, origin=path))
            loader.exec_module(module)
        except ImportError as error:
            self.trouble = str(error)
            return None
        sys.modules[_LIBRARY] = module  # under this name the compiled modules ask for it
        return folder


class _Finder(FileFinder):
    """Finds modules in one folder of the package, compiled ones first."""

    def __init__(self, path: str, build: Build) -> None:
        super().__init__(path, (SourceFileLoader, SOURCE_SUFFIXES))
        self._build = build

    def find_spec(self, fullname: str, target: ModuleType | None = None) -> ModuleSpec | None:
        """Where a module comes from."""
        return self._build.spec(fullname) or super().find_spec(fullname, target)


_installed: Build | None = None


def install(environment: Mapping[str, str]) -> Build | None:
    """Ask for compiled modules from here on, if any build may be there and they are not switched off.

    Args:
        environment: Of the process.
    """
    global _installed
    if _installed is not None or store.is_off(environment):
        return _installed
    stores = [place for place in store.places(environment) if os.path.isdir(place)]
    if stores:
        _installed = Build(stores)
        sys.path_hooks.insert(0, _installed.finder)
        for path in [path for path in sys.path_importer_cache if path.startswith(store.PACKAGE)]:
            del sys.path_importer_cache[path]
    return _installed


def installed() -> Build | None:
    """What `install` has set up in this process, or None."""
    return _installed
