"""How the functions of this package are compiled, and where what was compiled is kept.

Numba notices when the file of a function has changed, not when one that it calls from another file has. So what was
compiled is kept in a folder named by the contents of all files of this package.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

__all__ = ["announce", "cache_folder", "compiled", "inlined", "is_prepared"]

_config: Any = numba.config  # its settings are made at run time
_Function = TypeVar("_Function", bound=Callable[..., Any])
_HERE = Path(__file__).resolve().parent


def _user_caches() -> Path:
    """Where this system keeps what can be made again."""
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local"))
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))


def _is_writable(folder: Path) -> bool:
    """Whether files can be put into a folder, which is made if it is not there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _choose_folder() -> Path | None:
    """Beside the sources, else where the user's caches are; None: nothing can be kept."""
    contents = b"".join(path.read_bytes() for path in sorted(_HERE.glob("*.py")))
    name = f"simcore-{hashlib.sha256(contents).hexdigest()[:16]}"
    places = [_HERE / "__pycache__"]
    with contextlib.suppress(RuntimeError):  # nobody's home
        places.append(_user_caches() / "simcore")
    return next((place / name for place in places if _is_writable(place / name)), None)


cache_folder = None if _config.DISABLE_JIT else _choose_folder()
"""Where what was compiled is kept; None: nowhere."""


def is_prepared(names: Sequence[str] = ("step.advance",)) -> bool:
    """Whether functions, by module and name, need not be compiled any more, on this computer."""
    if _config.DISABLE_JIT:
        return True
    return cache_folder is not None and all(any(cache_folder.rglob(f"{name}-*.nbi")) for name in names)


def compiled(function: _Function) -> _Function:
    """Compile a function when it is first called, with the results of plain Python to the last bit."""
    before = _config.CACHE_DIR
    try:
        if cache_folder is not None:
            _config.CACHE_DIR = str(cache_folder)
        return cast(_Function, numba.njit(cache=cache_folder is not None, error_model="numpy")(function))
    finally:
        _config.CACHE_DIR = before


def inlined(function: _Function) -> _Function:
    """The same, put in where it is called: handing over thirty arrays costs as much as a contact."""
    return cast(_Function, numba.njit(inline="always", error_model="numpy")(function))


_told = False


def announce(name: str) -> None:
    """Say once, before a function is compiled that takes long, why it takes a while; see `is_prepared`."""
    global _told
    if not (_told or is_prepared([name])):
        _told = True
        print("Preparing the physics for this computer, once, half a minute ...", file=sys.stderr, flush=True)
