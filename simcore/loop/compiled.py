"""Compile the functions of this package, and keep them for later runs.

Numba notices when the file of a function has changed, not when one that it calls from another file has. So what was
compiled is kept in a folder named by the contents of all files of this package.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, BinaryIO, TypeVar, cast

import numba
from numba.core import caching

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

__all__ = ["cache_folder", "compiled", "inlined", "inner", "is_prepared", "not_kept", "preparing"]

_config: Any = numba.config  # its settings are made at run time
_Function = TypeVar("_Function", bound=Callable[..., Any])
_HERE = Path(__file__).resolve().parent
_MOST_WAITS = 30  # of ten seconds each, on Windows


def _user_caches() -> Path:
    """Return the folder in which this system keeps what can be made again."""
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local"))
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))


def _is_writable(folder: Path) -> bool:
    """Return whether files can be put into a folder, which is made if it is not there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _temporary_folder() -> Path | None:
    """Return a folder of this user alone among temporary files, as code is loaded from it; None if there is none."""
    if sys.platform == "win32":  # its temporary files are each user's own
        return Path(tempfile.gettempdir()) / "simcore"
    folder = Path(tempfile.gettempdir()) / f"simcore-{os.getuid()}"
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        status = folder.stat()
    except OSError:
        return None
    return folder if status.st_uid == os.getuid() and not status.st_mode & 0o077 else None


def _choose_folder() -> Path | None:
    """Return the folder for compiled functions; None if there is none.

    A folder that has them already and can only be read, as an administrator installs it, comes first; then the first
    that can be written of: next to the sources, the user's caches, temporary files.
    """
    contents = b"".join(path.read_bytes() for path in sorted(_HERE.glob("*.py")))
    name = f"simcore-{hashlib.sha256(contents).hexdigest()[:16]}"
    places = [_HERE / "__pycache__"]
    with contextlib.suppress(RuntimeError):  # nobody's home
        places.append(_user_caches() / "simcore")
    folders = [place / name for place in (*places, _temporary_folder()) if place is not None]
    has_all = [folder for folder in folders if all(_files(folder, one) for one in _PREPARED)]
    return next(iter(has_all), None) or next((folder for folder in folders if _is_writable(folder)), None)


def _files(folder: Path, name: str) -> list[Path]:
    """Return the index files of a compiled function, given as module.function, for this version of Python."""
    version = f"py{sys.version_info[0]}{sys.version_info[1]}"
    with contextlib.suppress(OSError):
        return list(folder.rglob(f"{name}-*.{version}*.nbi"))
    return []


_PREPARED = ("step.advance",)
cache_folder = None if _config.DISABLE_JIT else _choose_folder()
"""Folder of compiled functions; None if there is none."""


def is_prepared(names: Sequence[str] = _PREPARED) -> bool:
    """Return whether functions, given as module.function, need not be compiled any more on this computer."""
    return bool(_config.DISABLE_JIT) or (cache_folder is not None and all(_files(cache_folder, name) for name in names))


class _Locator(caching.UserProvidedCacheLocator):
    """Place of compiled functions, also where it can only be read."""

    def ensure_cache_path(self) -> None:
        """Make the folder if it can be made."""
        with contextlib.suppress(OSError):
            Path(self.get_cache_path()).mkdir(parents=True, exist_ok=True)


class _Files(caching.CompileResultCacheImpl):
    """Files of a compiled function."""

    _locator_classes = [_Locator]  # noqa: RUF012


class _Cache(caching.FunctionCache):
    """Compiled function that is kept; files that are damaged or cannot be written are no error."""

    _impl_class = _Files

    def load_overload(self, sig: object, target_context: object) -> object:
        """Return the kept function for a signature; None if there is none, or none that can be read."""
        try:
            return super().load_overload(sig, target_context)
        except Exception as error:  # pickle raises whatever damaged bytes lead it to
            what = f"{error or type(error).__name__}"
            _say(f"The compiled physics in {self.cache_path} is damaged ({what}); compiling it again ...")
            with contextlib.suppress(OSError):
                Path(self._cache_file._index_path).unlink()
            return None

    def save_overload(self, sig: object, data: object) -> None:
        """Keep the function for a signature where that is possible."""
        global not_kept
        try:
            super().save_overload(sig, data)
        except OSError as error:
            not_kept = f"{self.cache_path} cannot be written: {error.strerror or error}"
            self.disable()


not_kept = "" if cache_folder else "no folder for it is writable"
"""Reason for which compiled functions are not kept; empty if they are."""


def compiled(function: _Function) -> _Function:
    """Compile a function when it is first called, with the results of plain Python to the last bit."""
    return _kept(function)


def inner(function: _Function) -> _Function:
    """Compile a function that makes no array and that compiled functions alone call.

    References to the arrays that it is given are not counted: each count is an atomic operation, and all of them took
    a fifth of the loop (six robots in fuel: 3.1 to 2.8 ms a tick).
    """
    return _kept(function, _nrt=False)


def _kept(function: _Function, **options: Any) -> _Function:
    """Compile a function, and keep the result in `cache_folder`."""
    dispatcher: Any = numba.njit(error_model="numpy", **options)(function)
    if cache_folder is not None:
        before = _config.CACHE_DIR
        _config.CACHE_DIR = str(cache_folder)
        try:
            dispatcher._cache = _Cache(function)
        finally:
            _config.CACHE_DIR = before
    return cast(_Function, dispatcher)


def inlined(function: _Function) -> _Function:
    """Compile and inline at the call site: passing thirty arrays costs as much as a contact."""
    return cast(_Function, numba.njit(inline="always", error_model="numpy")(function))


_said: set[str] = set()


def _say(text: str) -> None:
    """Print a line once, on standard error."""
    if text not in _said:
        _said.add(text)
        print(text, file=sys.stderr, flush=True)


@contextlib.contextmanager
def preparing(name: str) -> Iterator[None]:
    """Enclose the first call of a function, given as module.function, that takes long to compile.

    Says before why it takes a while and after how long it took. One process compiles, and others wait for it.
    """
    if is_prepared([name]):
        yield
        return
    with _lock():
        if is_prepared([name]):
            yield
            return
        _say("Preparing the physics for this computer ...")
        begin = time.monotonic()
        yield
        seconds = time.monotonic() - begin
        kept = f"not kept, so every run does it: {not_kept}" if not_kept else f"kept in {cache_folder}"
        _say(f"... {name.partition('.')[0]} in {seconds:.0f} s, {kept}")


@contextlib.contextmanager
def _lock() -> Iterator[None]:
    """Keep other processes out that compile into the same folder; end of a process ends its lock."""
    file = None
    with contextlib.suppress(OSError):
        if cache_folder is not None:
            file = (cache_folder / "lock").open("ab")
            _take(file)
    try:
        yield
    finally:
        if file is not None:
            file.close()


def _take(file: BinaryIO) -> None:
    """Wait until no other process has a file."""
    if sys.platform == "win32":
        for _ in range(_MOST_WAITS):
            with contextlib.suppress(OSError):  # after ten seconds of waiting
                msvcrt.locking(file.fileno(), msvcrt.LK_LOCK, 1)
                return
    else:
        fcntl.flock(file, fcntl.LOCK_EX)
