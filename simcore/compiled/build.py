"""Compiles a copy of the sources in a temporary folder, and puts the result into the store in one move."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path

from simcore.compiled import store
from simcore.compiled.modules import GROUP, MODULES
from simcore.errors import CompileError
from simcore.install_text import install_command

__all__ = ["build", "check_tools", "compile_into", "remove", "writable"]

Runner = Callable[..., "subprocess.CompletedProcess[str]"]

_COMPILER = {
    "win32": 'install "Build Tools for Visual Studio" with "Desktop development with C++", then open a new terminal',
    "darwin": "`xcode-select --install`",
}
_COMPILER_ELSEWHERE = "install gcc and the headers of Python (Debian, Ubuntu: `apt install gcc python3-dev`)"
_GOES_ON = "simcore goes on in plain Python"
_NO_COMPILER = re.compile(
    r"microsoft visual c\+\+|unable to find vcvarsall|xcrun: error|command '[^']*(cc|clang)[^']*' failed: no such"
    r"|no such file or directory: '[^']*(cc|clang)[^']*'"
)
_LAST_LINES = 12
_HALF = ".half-"  # of the name of a build that is not whole


def check_tools(find: Callable[[str], object] = find_spec) -> None:
    """Raise `CompileError` unless mypyc and setuptools are installed; whether there is a C compiler shows when it runs.

    Args:
        find: Finds a module by name, as `importlib.util.find_spec` does.
    """
    for module in ("mypyc", "setuptools"):
        if find(module) is None:
            raise CompileError(f"{module} is not installed: {install_command('compile')}")


def writable(stores: Sequence[str]) -> Path:
    """The first store that can be written, made if it is not there.

    Raises:
        CompileError: None can.
    """
    for place in stores:
        path = Path(place)
        try:
            path.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=path):
                return path
        except OSError:
            continue
    raise CompileError(
        f"none of these folders can be written: {list(stores)}; name another with the environment variable "
        f"{store.VARIABLE}, also where simcore runs"
    )


def build(environment: Mapping[str, str], package: Path = Path(store.PACKAGE), run: Runner = subprocess.run) -> Path:
    """Compile, and replace what this Python had of other sources.

    Args:
        environment: Of the process.
        package: Folder of simcore.
        run: Starts a process, as `subprocess.run` does.

    Returns:
        The folder of the build; the one that was there, if it fits the sources.

    Raises:
        CompileError: A tool is missing, or a module does not compile; what was in the store stays.
    """
    stores = store.places(environment)
    name = store.tag(str(package))
    have = store.find(stores, name)
    if have is not None:
        return Path(have)
    place = writable(stores)
    with tempfile.TemporaryDirectory(prefix="simcore-", ignore_cleanup_errors=True) as work:
        compiled = compile_into(Path(work), package, environment, run)
        # Into the store under another name, then renamed in one step: what has the right name is complete.
        half = Path(tempfile.mkdtemp(prefix=_HALF, dir=place))
        try:
            shutil.copytree(compiled, half, dirs_exist_ok=True)
            half.chmod(0o755)  # mkdtemp's is for its maker alone
            os.rename(half, place / name)
        finally:
            shutil.rmtree(half, ignore_errors=True)
    for old in store.others([str(place)], name):
        shutil.rmtree(old, ignore_errors=True)  # on Windows a program that runs still holds its files
    return place / name


def compile_into(work: Path, package: Path, environment: Mapping[str, str], run: Runner = subprocess.run) -> Path:
    """Compile a copy of the sources.

    Args:
        work: An empty folder.
        package: Folder of simcore.
        environment: Of the process.
        run: Starts a process.

    Returns:
        Folder of the compiled modules, laid out like packages.

    Raises:
        CompileError: With what to install, or the compiler's last lines.
    """
    copies, out = work / "sources", work / "out"
    for top in ("simcore", "games"):
        source = package.parent / top
        if source.is_dir():
            shutil.copytree(source, copies / top, ignore=_only_python)
    done = run(
        [sys.executable, "-m", "simcore.compiled.worker", str(out)],
        cwd=copies,
        env={**environment, store.VARIABLE: "0", "PYTHONPATH": str(copies)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        check=False,
    )
    if done.returncode:
        raise CompileError(_reason(done.stdout))
    missing = [m for m in (f"{GROUP}__mypyc", *MODULES) if not os.path.isfile(store.library(str(out), m))]
    if missing:
        raise CompileError(f"the compiler left out {missing}; {_GOES_ON}")
    note = {"modules": len(MODULES), "mypy": metadata.version("mypy"), "python": sys.version.split()[0]}
    (out / "build.json").write_text(json.dumps(note) + "\n", encoding="utf-8")
    return out


def remove(environment: Mapping[str, str]) -> list[Path]:
    """Delete every build in every store.

    Returns:
        What is gone.

    Raises:
        CompileError: Something could not be deleted.
    """
    gone = []
    for place in map(Path, store.places(environment)):
        for path in sorted(place.iterdir()) if place.is_dir() else ():
            if path.name.startswith(_HALF) or any(path.glob(f"{GROUP}__mypyc*")):
                try:
                    shutil.rmtree(path)
                except OSError as error:
                    raise CompileError(
                        f"cannot delete {path}: {error}; end the programs that use simcore, or leave it and set "
                        f"{store.VARIABLE}=0"
                    ) from error
                gone.append(path)
    return gone


def _only_python(folder: str, names: list[str]) -> list[str]:
    """What not to copy: all but Python's sources and what says that they are typed."""
    return [
        name
        for name in names
        if name == "__pycache__"
        or not (name.endswith(".py") or name == "py.typed" or os.path.isdir(os.path.join(folder, name)))
        or os.path.join(folder, name).endswith(os.path.join("compiled", "store"))
    ]


def _reason(output: str) -> str:
    """Why a build failed, from what it printed."""
    low = output.lower()
    if _NO_COMPILER.search(low):
        return f"no C compiler: {_COMPILER.get(sys.platform, _COMPILER_ELSEWHERE)}; until then {_GOES_ON}"
    if "python.h" in low:
        return f"the headers of Python are missing: {_COMPILER.get(sys.platform, _COMPILER_ELSEWHERE)}; {_GOES_ON}"
    lines = [line for line in output.splitlines() if line.strip() and "warning: Treating generator" not in line]
    last = "\n  ".join(lines[-_LAST_LINES:])
    return f"does not compile; {_GOES_ON}. The last lines of the compiler:\n  {last}"
