"""Version of simcore that played a run, and digests of the files that affect the result of a run."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterable
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import simcore
from simcore.errors import ConfigError

__all__ = ["code_version", "files_digest", "module_digest", "project_digest"]

_APART = ("new_game", "show", "testing")
"""Packages of simcore that do not affect the result of a run, and that `code_version` therefore ignores."""
_SOURCES = (".cpp", ".gradle", ".h", ".java", ".json", ".obj", ".py", ".toml")
_OUTPUTS = ("__pycache__", "out", "test_output", "tests", "venv", "env", "build", "dist", "ctre_sim", "logs")
"""Names of folders in a robot project that the robot program does not read."""


@cache
def code_version() -> str:
    """Return the version of simcore in this process with a digest of the sources, e.g. `1.0.0+3f2a9c01`.

    Processes with equal versions produce equal results. The digest distinguishes a modified checkout from the release.
    """
    package = Path(simcore.__file__).parent
    files = (file for file in package.rglob("*.py") if file.relative_to(package).parts[0] not in _APART)
    return f"{simcore.__version__}+{files_digest(files, package)[:8]}"


@cache
def module_digest(name: str) -> str:
    """Return the digest of a module's file or of all sources of a package.

    For a module that is built into Python, return the version of Python.

    Raises:
        ConfigError: If the module cannot be found.
    """
    try:
        spec = find_spec(name)
    except (ImportError, ValueError):
        spec = None
    if spec is None or spec.origin is None:
        raise ConfigError(f"no module named {name!r}: it must be found from where the sweep is started")
    if not spec.has_location:
        return sys.version  # part of the interpreter
    file = Path(spec.origin)
    if not spec.submodule_search_locations:
        return files_digest([file], file.parent)
    return files_digest((f for f in file.parent.rglob("*") if f.suffix in _SOURCES), file.parent)


def project_digest(folder: Path) -> str:
    """Return the digest of a robot project's code, settings (`.toml`, `.json`), meshes and deployed files.

    Files in hidden folders and in the folders of `_OUTPUTS` do not affect the digest.
    """
    files = []
    for file in folder.rglob("*"):
        inside = file.relative_to(folder).parts
        is_read = inside[0] == "deploy" or file.suffix in _SOURCES
        if is_read and file.is_file() and not any(part in _OUTPUTS or part.startswith(".") for part in inside):
            files.append(file)
    return files_digest(files, folder)


def files_digest(files: Iterable[Path], base: Path) -> str:
    """Return the SHA-256 digest of the names and contents of files as 64 hexadecimal digits.

    Files that differ only in CRLF and LF line endings have equal digests.

    Args:
        files: Files in any order.
        base: Folder to which the names are relative.
    """
    total = hashlib.sha256()
    for file in sorted(files):
        total.update(f"{file.relative_to(base).as_posix()}\n".encode())
        # git may have changed the line endings on another system
        total.update(hashlib.sha256(file.read_bytes().replace(b"\r\n", b"\n")).digest())
    return total.hexdigest()
