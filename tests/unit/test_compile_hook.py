"""The build hook without a compiler: when it compiles, what comes into the wheel, and what is said when it cannot."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("hatchling", reason="needs hatchling: pip install -e .[test]")
ROOT = Path(__file__).resolve().parents[2]
MODULES = ["simcore.robot.battery", "simcore.robot.gyro"]
LIBRARIES = ["simcore_native__mypyc", *MODULES]


@pytest.fixture
def build(monkeypatch):
    """Runs the hook as hatchling does, with a compiler that writes empty libraries or fails with an output."""
    spec = importlib.util.spec_from_file_location("hatch_build", ROOT / "hatch_build.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    runs = []

    def build(asked, *, version="standard", output="", left_out=""):
        def compiler(words, cwd, **settings):
            runs.append(cwd)
            assert (cwd / "simcore" / "robot" / "battery.py").is_file() and not cwd.is_relative_to(ROOT)
            for library in LIBRARIES:
                path = Path(words[2], *library.split(".")).with_suffix(".cpython-312.so")
                if library != left_out:
                    path.parent.mkdir(parents=True, exist_ok=True)
                    path.touch()
            return subprocess.CompletedProcess(words, int(bool(output)), stdout=output)

        monkeypatch.setattr(module.subprocess, "run", compiler)
        monkeypatch.setenv("SIMCORE_COMPILE", asked)
        hook = module.CompileHook(str(ROOT), {"modules": MODULES}, None, None, "", "wheel")
        data = {"force_include": {}, "pure_python": True, "infer_tag": False}
        tools = hook.dependencies()
        try:
            hook.initialize(version, data)
        finally:
            hook.finalize(version, data, "")
        return tools, data

    build.runs = runs
    return build


@pytest.mark.parametrize("asked", ["", "0"])
def test_a_wheel_is_pure_unless_compiling_is_asked_for(build, asked):
    assert build(asked) == ([], {"force_include": {}, "pure_python": True, "infer_tag": False})
    assert build("0", version="editable")[0] == [] and build.runs == []


def test_libraries_come_into_the_wheel_beside_their_sources(build):
    tools, data = build("1")
    assert [tool.partition(">")[0] for tool in tools] == ["mypy[mypyc]", "setuptools"]
    assert data["infer_tag"] and not data["pure_python"]
    wanted = [f"{library.replace('.', '/')}.cpython-312.so" for library in LIBRARIES]
    assert sorted(data["force_include"].values()) == sorted(wanted)
    assert not any(Path(path).exists() for path in data["force_include"]), "the temporary folder is gone"


def test_a_library_that_is_missing_is_an_error(build):
    with pytest.raises(SystemExit, match=r"left out \['simcore.robot.gyro'\]"):
        build("1", left_out="simcore.robot.gyro")


def test_what_cannot_be_is_refused_before_anything_is_compiled(build):
    with pytest.raises(SystemExit, match="install without -e"):
        build("1", version="editable")
    with pytest.raises(SystemExit, match="got 'yes'"):
        build("yes")
    assert build.runs == []


@pytest.mark.parametrize(
    ("output", "platform", "words"),
    [
        ("error: Microsoft Visual C++ 14.0 or greater is required.", "win32", "Desktop development with C++"),
        ("error: command 'gcc' failed: No such file or directory", "linux", "apt install gcc python3-dev"),
        ("error: [Errno 2] No such file or directory: 'gcc'", "linux", "apt install gcc python3-dev"),
        ("xcrun: error: invalid active developer path", "darwin", "xcode-select --install"),
        ("error: command 'clang' failed: No such file or directory", "darwin", "xcode-select --install"),
        ("fatal error: Python.h: No such file or directory", "linux", "python3-dev"),
        ("simcore/x.py:3: error: Incompatible types", "linux", "simcore/x.py:3: error: Incompatible types"),
        ("\n".join(f"line {n}" for n in range(1000)), "linux", "line 999"),
    ],
)
def test_a_failure_says_what_to_do_and_that_it_goes_without(build, monkeypatch, output, platform, words):
    monkeypatch.setattr(sys, "platform", platform)
    with pytest.raises(SystemExit) as caught:
        build("1", output=output)
    said = str(caught.value)
    assert words in said and "installed as plain Python" in said and "line 900" not in said
