"""Where compiled parts are kept, and which of them fit the present sources.

A store is a folder with a folder a build in it, named by a tag: Python's ABI, the machine and a hash of the sources.
What does not fit is never looked at, so changed sources run as plain Python until they are compiled again.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Mapping
from importlib.machinery import EXTENSION_SUFFIXES

from simcore.compiled.modules import GROUP, MODULES, source_of

__all__ = ["PACKAGE", "SUFFIX", "VARIABLE", "abi", "find", "is_off", "library", "others", "places", "tag"]

VARIABLE = "SIMCORE_COMPILED"
"""Of the environment: 0 is plain Python whatever is there; a folder is the one store; unset: the usual places."""

PACKAGE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
"""The folder of the package simcore."""

SUFFIX = next((suffix for suffix in EXTENSION_SUFFIXES if suffix.count(".") > 1), EXTENSION_SUFFIXES[0])
"""Of a compiled module of this Python, e.g. `.cpython-311-x86_64-linux-gnu.so`."""


def is_off(environment: Mapping[str, str]) -> bool:
    """Whether plain Python is asked for."""
    return environment.get(VARIABLE) == "0"


def places(environment: Mapping[str, str], package: str = PACKAGE) -> list[str]:
    """Folders in which builds may be: beside the package's modules, else (an install that is read-only) the user's.

    Args:
        environment: Of the process.
        package: Folder of simcore.
    """
    named = environment.get(VARIABLE, "")
    if named not in ("", "0", "1"):
        return [os.path.abspath(named)]
    home = os.path.expanduser("~")
    if sys.platform == "win32":
        cache = environment.get("LOCALAPPDATA") or os.path.join(home, "AppData", "Local")
    elif sys.platform == "darwin":
        cache = os.path.join(home, "Library", "Caches")
    else:
        cache = environment.get("XDG_CACHE_HOME") or os.path.join(home, ".cache")
    return [os.path.join(package, "compiled", "store"), os.path.join(cache, "simcore", "compiled")]


def abi() -> str:
    """What a build is bound to beside its sources: Python's ABI and the machine."""
    machine = os.uname().machine if hasattr(os, "uname") else ""  # Windows has it in the suffix
    return "-".join(part for part in (SUFFIX.strip(".").rpartition(".")[0], machine) if part)


def tag(package: str = PACKAGE, modules: Iterable[str] = MODULES) -> str:
    """Name of the build that fits the sources as they are now.

    Args:
        package: Folder of simcore.
        modules: That are compiled.

    Raises:
        OSError: A source cannot be read.
    """
    import hashlib  # not loaded for an import of simcore that finds no build

    digest = hashlib.blake2b(digest_size=8)
    above = os.path.dirname(package)
    for module in ("simcore", *modules):  # the package itself carries the version
        path = "simcore/__init__.py" if module == "simcore" else source_of(module)
        with open(os.path.join(above, path), "rb") as source:
            digest.update(b"%s\0%s\0" % (module.encode(), source.read()))
    return f"{abi()}-{digest.hexdigest()}"


def library(folder: str, module: str) -> str:
    """Path of a compiled module in a build; `GROUP + '__mypyc'` is the library that holds the code of all."""
    return os.path.join(folder, *module.split(".")) + SUFFIX


def find(stores: Iterable[str], name: str) -> str | None:
    """The folder of a build by its tag, or None."""
    for store in stores:
        folder = os.path.join(store, name)
        if os.path.isfile(library(folder, f"{GROUP}__mypyc")):
            return folder
    return None


def others(stores: Iterable[str], name: str) -> list[str]:
    """Builds of this Python from other sources than those that a tag names."""
    prefix = f"{abi()}-"
    return [
        os.path.join(store, build)
        for store in stores
        if os.path.isdir(store)
        for build in sorted(os.listdir(store))
        if build.startswith(prefix) and build != name
    ]
