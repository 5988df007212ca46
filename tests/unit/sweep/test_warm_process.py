"""Processes that begin with their imports done, each one fresh, and what becomes of them."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from simcore.errors import SimcoreError
from simcore.sweep import child_process
from simcore.sweep.child_process import run_process
from simcore.sweep.warm_process import CAN_FORK

TASK = """
import os, sys, time
import {heavy}

WARM = ("json.tool", "a_package_that_nobody_has")
loaded, count = os.getpid(), 0

def main():
    global count
    count += 1
    word = sys.argv[1]
    print("says", word, count, os.getpid() == loaded, os.getcwd(), os.environ.get("COLOR"), "json.tool" in sys.modules)
    if word == "raise":
        raise ValueError("no such word")
    if word == "kill":
        os.kill(os.getpid(), 9)
    if word == "sleep":
        time.sleep(60.0)
    if word == "read":
        print("got", repr(sys.stdin.read()))
    return 3 if word == "three" else None

if __name__ == "__main__":
    sys.exit(main())
"""


@pytest.fixture
def module(tmp_path, monkeypatch):
    """A module that can be run, with a name of its own."""
    name = f"task_{tmp_path.name.replace('-', '_')}"
    (tmp_path / f"{name}.py").write_text(TASK.format(heavy="decimal"), encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    return name


def run(module: str, word: str, folder: Path, **more) -> tuple[int | None, str]:
    said = folder / f"said {word}"
    more = {"timeout": 60.0, "folder": folder, **more}
    return run_process(module, word, said=said, **more), said.read_text("utf-8")


@pytest.mark.parametrize(
    "word, code",
    [
        *(("fine", 0), ("three", 3), ("raise", 1), ("read", 0)),
        pytest.param("kill", -9, marks=pytest.mark.skipif(os.name == "nt", reason="Windows has no signals")),
    ],
)
def test_exit_codes_and_words_are_those_of_a_fresh_process(module, tmp_path, word, code):
    got, said = run(module, word, tmp_path, COLOR="red")
    assert got == code
    if word == "kill":
        return  # nothing is flushed
    assert f"says {word} 1 {not CAN_FORK} {tmp_path} red {CAN_FORK}" in said
    assert ("ValueError: no such word" in said) == (word == "raise")
    assert ("got ''" in said) == (word == "read")


def test_one_that_takes_too_long_is_ended(module, tmp_path):
    begun = time.monotonic()
    assert run(module, "sleep", tmp_path, timeout=1.0)[0] is None
    assert time.monotonic() - begun < 20.0
    assert run(module, "fine", tmp_path)[0] == 0, "and the next one runs"


def test_threads_may_ask_at_the_same_time(module, tmp_path):
    codes = {}
    words = ["fine", "three", "raise", "read"]
    threads = [threading.Thread(target=lambda w=w: codes.update({w: run(module, w, tmp_path)[0]})) for w in words]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60.0)
    assert codes == {"fine": 0, "three": 3, "raise": 1, "read": 0}


@pytest.mark.skipif(not CAN_FORK, reason="processes begin warm on Linux alone")
def test_they_end_with_who_asked(module, tmp_path):
    asker = subprocess.Popen(
        [
            sys.executable,
            "-c",
            "from pathlib import Path\n"
            "from simcore.sweep.child_process import run_process\n"
            f"run_process({module!r}, 'sleep', said=Path('said'), timeout=60.0, folder=None)",
        ],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join((str(tmp_path), *sys.path))},
    )

    def processes() -> list[str]:
        names = []
        for folder in Path("/proc").glob("[0-9]*"):
            try:
                names.append((folder / "cmdline").read_bytes().decode())
            except OSError:
                continue
        return [name for name in names if module in name and "run_process" not in name]

    deadline = time.monotonic() + 30.0
    while len(processes()) < 2 and time.monotonic() < deadline:
        time.sleep(0.05)
    assert len(processes()) == 2, "the parent, and the one that sleeps"
    asker.kill()
    asker.wait()
    while processes() and time.monotonic() < deadline:
        time.sleep(0.05)
    assert processes() == []


@pytest.mark.skipif(not CAN_FORK, reason="processes begin warm on Linux alone")
def test_a_parent_that_has_ended_is_told_and_replaced(module, tmp_path):
    assert run(module, "fine", tmp_path)[0] == 0
    parent = child_process._parents[module][1]._process
    threading.Timer(1.0, parent.kill).start()
    with pytest.raises(SimcoreError, match="the parent of this run's process has ended"):
        run(module, "sleep", tmp_path)
    assert run(module, "fine", tmp_path)[0] == 0


@pytest.mark.skipif(not CAN_FORK, reason="processes begin warm on Linux alone")
def test_a_timeout_before_the_process_is_known_ends_it_all_the_same(module, tmp_path):
    assert run(module, "sleep", tmp_path, timeout=1e-3)[0] is None, "its parent is still importing"
    assert child_process._parents[module][1]._pids == {}
    assert run(module, "fine", tmp_path)[0] == 0
