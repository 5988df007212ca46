"""Programs for the bridge, compiled against headers and libraries of robotpy-native-*."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

import simcore

collect_ignore_glob = ["programs/*", "play*.py"]
PROGRAMS = Path(__file__).parent / "programs"
TANK = Path(__file__).parents[2] / "examples" / "cpp_tank"
PACKAGES = str(Path(simcore.__file__).resolve().parents[1])
LIBRARIES = {
    **{"wpiutil": "wpiutil", "wpinet": "wpinet", "ntcore": "ntcore"},
    **{"wpimath": "wpimath", "wpihal": "wpiHal", "wpilib": "wpilibc"},
}


def _native(name: str) -> Path | None:
    try:
        found = find_spec(f"native.{name}")
    except ModuleNotFoundError:
        return None
    return None if found is None or not found.submodule_search_locations else Path(found.submodule_search_locations[0])


@pytest.fixture(scope="session")
def compiled(tmp_path_factory) -> Callable[[str], Path]:
    """Return a function that compiles a program by name at its first call and returns the executable's path."""
    if find_spec("wpilib") is None:
        pytest.skip("needs wpilib: pip install .[robotpy]")
    folders = {library: _native(name) for name, library in LIBRARIES.items()}
    if shutil.which("g++") is None or sys.platform != "linux" or None in folders.values():
        pytest.skip("needs g++ on Linux, and the headers that come with wpilib")
    folder, done = tmp_path_factory.mktemp("programs"), {}

    def compile_program(name: str) -> Path:
        if name not in done:
            paths = [str(path) for path in folders.values()]
            flags = [f"-I{path}/include" for path in paths] + [f"-L{path}/lib" for path in paths]
            flags += [f"-Wl,-rpath,{path}/lib" for path in paths] + [f"-l{library}" for library in folders]
            source = TANK / "src" / "main" / "cpp" / "Robot.cpp" if name == "tank" else PROGRAMS / f"{name}.cpp"
            command = ["g++", "-std=c++20", "-O1", str(source), "-o", str(folder / name)]
            subprocess.run([*command, "-Wl,--no-as-needed", *flags], check=True)
            done[name] = folder / name
        return done[name]

    return compile_program


def robot_file(name: str) -> str:
    """Return the robot file of a program; the file of the tank drive is in the example."""
    return str(TANK / "simcore.toml" if name == "tank.toml" else PROGRAMS / name)


@pytest.fixture
def serve(tmp_path) -> Callable[..., tuple[int, str, str]]:
    """Return a function that runs `simcore serve` in a folder and returns status, stdout and stderr."""

    def run(file: str, *options: str, command: Sequence[str] = (), timeout: float = 300.0, **environment: str) -> Any:
        words = ["serve", "--robot", robot_file(file), *options, *(["--", *command] if command else [])]
        done = subprocess.run(
            [sys.executable, "-m", "simcore", *words],
            cwd=tmp_path, env={**os.environ, "PYTHONPATH": PACKAGES, **environment}, capture_output=True,
            text=True, errors="replace", timeout=timeout, check=False,
        )  # fmt: skip
        return done.returncode, done.stdout, done.stderr

    return run


@pytest.fixture
def play(tmp_path) -> Callable[..., dict[str, Any]]:
    """Return a function that plays an auto over the bridge and returns digest, pose, wall time and positions."""

    def run(file: str, seconds: float, *command: str) -> dict[str, Any]:
        done = subprocess.run(
            [sys.executable, str(PROGRAMS.parent / "play.py"), robot_file(file), str(seconds), *command],
            cwd=tmp_path, env={**os.environ, "PYTHONPATH": PACKAGES}, capture_output=True, text=True, timeout=300,
            check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stdout + done.stderr
        return dict(json.loads(done.stdout.splitlines()[-1]))

    return run
