"""Building without a compiler: what is said when something is missing, and that nothing half-written is ever loaded."""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

import pytest

from simcore.compiled import build, command, finder, store
from simcore.compiled.modules import GROUP, MODULES
from simcore.errors import CompileError
from simcore.install_text import install_command

PACKAGE = Path(store.PACKAGE)


class Compiler:
    """In place of the process that compiles: writes empty files, or fails with an output."""

    def __init__(self, output: str = "", *, leaves_out: str = "") -> None:
        self.output, self.leaves_out = output, leaves_out
        self.runs: list[dict] = []

    def __call__(self, words, **settings):
        self.runs.append({"words": words, **settings})
        if self.output:
            return subprocess.CompletedProcess(words, 1, stdout=self.output)
        for module in (f"{GROUP}__mypyc", *MODULES):
            if module != self.leaves_out:
                path = Path(store.library(words[-1], module))
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(b"code")
        return subprocess.CompletedProcess(words, 0, stdout="")


@pytest.fixture
def environment(tmp_path, monkeypatch):
    monkeypatch.setattr(build.metadata, "version", lambda name: "1.0")  # of mypy, which need not be installed
    return {store.VARIABLE: str(tmp_path / "store")}


def test_a_build_comes_into_the_store_whole_under_its_tag(environment, tmp_path):
    folder = build.build(environment, run=Compiler())
    assert folder == tmp_path / "store" / store.tag()
    assert store.find(store.places(environment), store.tag()) == str(folder)
    assert [path.name for path in folder.parent.iterdir()] == [folder.name]
    assert (folder / "build.json").is_file()


def test_the_compiler_sees_copies_and_no_compiled_simcore(environment):
    run = Compiler()
    build.build(environment, run=run)
    (one,) = run.runs
    assert not Path(one["cwd"]).is_relative_to(PACKAGE)
    assert one["env"][store.VARIABLE] == "0" and one["env"]["PYTHONPATH"] == str(one["cwd"])


def test_what_fits_is_not_compiled_again(environment):
    first, second = Compiler(), Compiler()
    assert build.build(environment, run=first) == build.build(environment, run=second)
    assert second.runs == []


def test_a_new_build_replaces_the_old_one_of_this_python(environment, tmp_path):
    old, foreign = (tmp_path / "store" / name for name in (f"{store.abi()}-0", "cpython-39-other-0"))
    for path in (old, foreign):
        path.mkdir(parents=True)
    build.build(environment, run=Compiler())
    assert not old.exists() and foreign.exists()


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
    ],
)
def test_a_failure_says_what_to_do_and_that_python_goes_on(environment, tmp_path, monkeypatch, output, platform, words):
    monkeypatch.setattr(sys, "platform", platform)
    with pytest.raises(CompileError) as caught:
        build.build(environment, run=Compiler(output))
    assert words in str(caught.value) and "goes on in plain Python" in str(caught.value)
    assert list((tmp_path / "store").iterdir()) == []


def test_only_the_last_lines_of_a_long_output(environment):
    with pytest.raises(CompileError) as caught:
        build.build(environment, run=Compiler("\n".join(f"line {n}" for n in range(1000))))
    assert "line 999" in str(caught.value) and "line 900" not in str(caught.value)


def test_a_module_that_is_missing_is_an_error(environment, tmp_path):
    with pytest.raises(CompileError, match=MODULES[3]):
        build.build(environment, run=Compiler(leaves_out=MODULES[3]))
    assert list((tmp_path / "store").iterdir()) == []


def test_a_store_that_cannot_be_written_gives_way_to_the_next(tmp_path):
    (tmp_path / "file").write_text("")
    assert build.writable([str(tmp_path / "file" / "store"), str(tmp_path / "b")]) == tmp_path / "b"
    with pytest.raises(CompileError, match=store.VARIABLE):
        build.writable([str(tmp_path / "file" / "store")])


@pytest.mark.parametrize("missing", ["mypyc", "setuptools"])
def test_missing_tools_are_named_with_the_extra(missing):
    with pytest.raises(CompileError) as caught:
        build.check_tools(lambda name: None if name == missing else object())
    assert missing in str(caught.value) and install_command("compile") in str(caught.value)
    build.check_tools(lambda name: object())


def test_remove_takes_builds_and_nothing_else(environment, tmp_path):
    folder = build.build(environment, run=Compiler())
    half, mine = tmp_path / "store" / ".half-x", tmp_path / "store" / "notes"
    half.mkdir()
    mine.mkdir()
    assert build.remove(environment) == [half, folder]
    assert mine.exists() and build.remove(environment) == []


def test_the_command_says_what_it_did(environment, monkeypatch, capsys):
    monkeypatch.setenv(store.VARIABLE, environment[store.VARIABLE])
    call = argparse.Namespace(remove=False)
    monkeypatch.setattr(command.build, "check_tools", lambda: None)
    real = build.build
    monkeypatch.setattr(command.build, "build", lambda env: real(env, run=Compiler()))
    assert command.run(call) == 0
    said = capsys.readouterr().out
    assert "compiling" in said and " s: " in said and store.tag() in said
    assert command.run(call) == 0 and "up to date" in capsys.readouterr().out
    assert command.run(argparse.Namespace(remove=True)) == 0 and "removed" in capsys.readouterr().out
    assert command.run(argparse.Namespace(remove=True)) == 0 and "nothing" in capsys.readouterr().out


# --- what is found at run time --------------------------------------------------------------------------------------


def run_python(code: str, place: Path, package_parent: Path = PACKAGE.parent) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={"PYTHONPATH": str(package_parent), store.VARIABLE: str(place), "PATH": "", "SYSTEMROOT": "C:\\Windows"},
        cwd=place.parent,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


WHAT = (
    "from simcore.robot import tire_solver as tire; from simcore.compiled import finder; b = finder.installed();"
    "print(type(tire.__loader__).__name__, b and b.folder, b and b.trouble[:40])"
)


def test_without_a_store_nothing_is_put_in_the_way(tmp_path):
    assert run_python(WHAT, tmp_path / "none") == "SourceFileLoader None None"


def test_a_build_that_does_not_load_is_plain_python(environment, tmp_path):
    """Another C library, a torn file: here an empty one."""
    build.build(environment, run=Compiler())
    said = run_python(WHAT, tmp_path / "store")
    assert said.startswith("SourceFileLoader None ") and len(said) > len("SourceFileLoader None  ")


def test_a_build_of_other_sources_is_plain_python(tmp_path):
    (tmp_path / "store" / f"{store.abi()}-0").mkdir(parents=True)
    assert run_python(WHAT, tmp_path / "store") == "SourceFileLoader None"


def test_a_hook_answers_for_folders_of_the_package_only(tmp_path):
    it = finder.Build([str(tmp_path)])
    with pytest.raises(ImportError, match="not a folder of simcore"):
        it.finder(str(tmp_path))
    with pytest.raises(ImportError):
        it.finder(store.PACKAGE + "_other")
    assert it.finder(str(PACKAGE / "robot")).find_spec("simcore.robot.cots").origin.endswith("cots.py")
