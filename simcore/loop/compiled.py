"""Compile the functions of this package, and cache the machine code for later runs.

Numba recompiles a function after a change of the source file, but not after a change of a called function in another
file. The name of the cache folder therefore contains a hash of all files of this package.
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

_config: Any = numba.config  # Any because Numba defines the settings at run time
_Function = TypeVar("_Function", bound=Callable[..., Any])
_HERE = Path(__file__).resolve().parent
_MOST_WAITS = 30  # attempts to lock a file on Windows, ten seconds each


def _user_caches() -> Path:
    """Return the user's cache folder on this operating system."""
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local"))
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))


def _is_writable(folder: Path) -> bool:
    """Return whether a folder is writable; create the folder if it is missing."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _temporary_folder() -> Path | None:
    """Return a temporary folder that only this user can access; None if no such folder is available.

    The folder must be private because Python loads machine code from the folder.
    """
    if sys.platform == "win32":  # every user has a private folder of temporary files
        return Path(tempfile.gettempdir()) / "simcore"
    folder = Path(tempfile.gettempdir()) / f"simcore-{os.getuid()}"
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        status = folder.stat()
    except OSError:
        return None
    return folder if status.st_uid == os.getuid() and not status.st_mode & 0o077 else None


def _choose_folder() -> Path | None:
    """Return the cache folder for compiled functions; None if no folder is writable.

    The candidates are next to the source files, in the user's cache folder and in the folder of temporary files. The
    function prefers a folder that already has the compiled functions, even a read-only folder (installed by an
    administrator), and otherwise returns the first writable folder.
    """
    contents = b"".join(path.read_bytes() for path in sorted(_HERE.glob("*.py")))
    name = f"simcore-{hashlib.sha256(contents).hexdigest()[:16]}"
    places = [_HERE / "__pycache__"]
    with contextlib.suppress(RuntimeError):  # raised if the user has no home folder
        places.append(_user_caches() / "simcore")
    folders = [place / name for place in (*places, _temporary_folder()) if place is not None]
    has_all = [folder for folder in folders if all(_files(folder, one) for one in _PREPARED)]
    return next(iter(has_all), None) or next((folder for folder in folders if _is_writable(folder)), None)


def _files(folder: Path, name: str) -> list[Path]:
    """Return the Numba index files of a function (`module.function`) in a folder, for this version of Python."""
    version = f"py{sys.version_info[0]}{sys.version_info[1]}"
    with contextlib.suppress(OSError):
        return list(folder.rglob(f"{name}-*.{version}*.nbi"))
    return []


_PREPARED = ("step.advance",)
cache_folder = None if _config.DISABLE_JIT else _choose_folder()
"""Folder of compiled functions; None if no folder is writable or Numba's JIT is disabled."""


def is_prepared(names: Sequence[str] = _PREPARED) -> bool:
    """Return whether all functions (`module.function`) are in the cache, or Numba's JIT is disabled."""
    return bool(_config.DISABLE_JIT) or (cache_folder is not None and all(_files(cache_folder, name) for name in names))


class _Locator(caching.UserProvidedCacheLocator):
    """Locator of the cache folder that accepts a read-only folder."""

    def ensure_cache_path(self) -> None:
        """Create the cache folder if possible."""
        with contextlib.suppress(OSError):
            Path(self.get_cache_path()).mkdir(parents=True, exist_ok=True)


class _Files(caching.CompileResultCacheImpl):
    """Storage of a compiled function's cache files in the folder of `_Locator`."""

    _locator_classes = [_Locator]  # noqa: RUF012


class _Cache(caching.FunctionCache):
    """Cache of a compiled function that tolerates damaged or read-only files."""

    _impl_class = _Files

    def load_overload(self, sig: object, target_context: object) -> object:
        """Return the cached function for a signature; None if the cache has no intact function.

        If the cached data is damaged, print a message and delete the index file.
        """
        try:
            return super().load_overload(sig, target_context)
        except Exception as error:  # pickle can raise any exception on damaged bytes
            what = f"{error or type(error).__name__}"
            _say(f"The compiled physics in {self.cache_path} is damaged ({what}); compiling it again ...")
            with contextlib.suppress(OSError):
                Path(self._cache_file._index_path).unlink()
            return None

    def save_overload(self, sig: object, data: object) -> None:
        """Cache the function for a signature; if this fails, set `not_kept` and stop caching the function."""
        global not_kept
        try:
            super().save_overload(sig, data)
        except OSError as error:
            not_kept = f"{self.cache_path} cannot be written: {error.strerror or error}"
            self.disable()


not_kept = "" if cache_folder else "no folder for it is writable"
"""Reason why compiled functions are not cached; empty if the functions are cached."""


def compiled(function: _Function) -> _Function:
    """Compile a function with Numba on the first call.

    The compiled function returns the same values as plain Python, to the last bit.
    """
    return _kept(function)


def inner(function: _Function) -> _Function:
    """Compile an inner function of the loop on the first call.

    The function must not allocate arrays, and only compiled functions may call the function. Numba does not count
    references to the array arguments. The counts are atomic operations. Without the counts, a tick of six robots among
    balls takes 2.8 ms, not 3.1 ms.
    """
    return _kept(function, _nrt=False)


def _kept(function: _Function, **options: Any) -> _Function:
    """Return a dispatcher that compiles the function on the first call and stores the result in `cache_folder`."""
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
    """Compile a function that Numba inlines at each call site.

    Inlining saves time because passing thirty arrays takes as long as computing a contact.
    """
    return cast(_Function, numba.njit(inline="always", error_model="numpy")(function))


_said: set[str] = set()


def _say(text: str) -> None:
    """Print a line to standard error, unless this process has printed the line before."""
    if text not in _said:
        _said.add(text)
        print(text, file=sys.stderr, flush=True)


@contextlib.contextmanager
def preparing(name: str) -> Iterator[None]:
    """Wrap the first call of a function (`module.function`) that takes long to compile.

    If the function is not in the cache, print the reason for the wait before the call and the duration after the call.
    One process compiles while other processes wait.
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
    """Lock the cache folder against other processes that compile.

    The operating system releases the lock when the process ends. If the folder cannot be locked, continue without a
    lock.
    """
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
    """Lock a file; wait while another process has the lock.

    On Windows, give up after five minutes and return without a lock.
    """
    if sys.platform == "win32":
        for _ in range(_MOST_WAITS):
            with contextlib.suppress(OSError):  # raised after ten seconds of waiting
                msvcrt.locking(file.fileno(), msvcrt.LK_LOCK, 1)
                return
    else:
        fcntl.flock(file, fcntl.LOCK_EX)
