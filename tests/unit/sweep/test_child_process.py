"""A function in a process of its own: its end, its words, and that nothing is left of it."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from multiprocessing import forkserver
from pathlib import Path

import psutil
import pytest

from simcore.sweep.child_process import death_text, kill_processes, run_process

IS_WARM = sys.platform == "linux"
TASK = """
import os, sys, time

count = 0

def main(word):
    global count
    count += 1
    warm = "simcore.robotpy.preloaded" in sys.modules
    print("says", word, count, os.getcwd(), os.environ.get("COLOR"), warm, sys.argv[1:], hash("a"), flush=True)
    if word == "raise":
        raise ValueError("no such word")
    if word == "kill":
        os.kill(os.getpid(), 9)
    if word == "sleep":
        time.sleep(60.0)
    if word == "abort":
        import faulthandler
        faulthandler.enable()
        os.abort()
    if word == "read":
        print("got", repr(os.read(0, 9)))
    return 3 if word == "three" else None
"""


@pytest.fixture
def module(tmp_path, monkeypatch):
    """A module that can be run, with a name of its own."""
    name = f"task_{tmp_path.name.replace('-', '_')}"
    (tmp_path / f"{name}.py").write_text(TASK, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    return name


def run(module: str, word: str, folder: Path, timeout: float | None = 60.0) -> tuple[int | None, str]:
    said = folder / f"said {word}"
    return run_process(f"{module}:main", word, said=said, timeout=timeout, folder=folder), said.read_text("utf-8")


@pytest.mark.parametrize(
    "word, code",
    [
        *(("fine", 0), ("three", 3), ("raise", 1), ("read", 0)),
        pytest.param("kill", -9, marks=pytest.mark.skipif(os.name == "nt", reason="Windows has no signals")),
    ],
)
def test_exit_codes_and_words_are_those_of_a_fresh_process(module, tmp_path, word, code, monkeypatch):
    monkeypatch.setenv("COLOR", "red")
    got, said = run(module, word, tmp_path)
    assert got == code
    plain = subprocess.run(
        [sys.executable, "-c", "print(hash('a'))"], env={"PYTHONHASHSEED": "0"}, capture_output=True, text=True
    )
    assert f"says {word} 1 {tmp_path} red {IS_WARM} [] {plain.stdout.strip()}" in said
    assert ("ValueError: no such word" in said) == (word == "raise")
    assert ("got b''" in said) == (word == "read")
    if word == "kill":
        assert death_text(got, tmp_path / "said kill").startswith("its process died (SIGKILL); its last words: says")


def test_the_last_words_of_a_crash_say_where_it_was(module, tmp_path):
    code, _ = run(module, "abort", tmp_path)
    how = death_text(code, tmp_path / "said abort")
    assert "last words: Current thread" in how and f"{module}.py" in how


def test_one_that_takes_too_long_is_ended(module, tmp_path):
    begun = time.monotonic()
    assert run(module, "sleep", tmp_path, timeout=1.0)[0] is None
    assert time.monotonic() - begun < 20.0
    assert run(module, "fine", tmp_path)[0] == 0, "and the next one runs"
    assert run(module, "sleep", tmp_path, timeout=1e-3)[0] is None, "before it has begun"


def test_threads_may_ask_at_the_same_time(module, tmp_path):
    codes = {}
    words = ["fine", "three", "raise", "read", "sleep"]
    threads = [threading.Thread(target=lambda w=w: codes.update({w: run(module, w, tmp_path)[0]})) for w in words]
    for thread in threads:
        thread.start()
    for thread in threads[:4]:
        thread.join(60.0)
    kill_processes()
    threads[4].join(30.0)
    assert codes == {"fine": 0, "three": 3, "raise": 1, "read": 0, "sleep": -9}


@pytest.mark.skipif(not IS_WARM, reason="looks for processes as Linux has them")
def test_they_end_with_who_asked(module, tmp_path):
    code = (
        "from pathlib import Path\n"
        "from simcore.sweep.child_process import run_process\n"
        f"run_process('{module}:main', 'sleep', said=Path('said'), timeout=60.0, folder=Path.cwd())"
    )
    path = os.pathsep.join((str(tmp_path), *sys.path))
    asker = subprocess.Popen([sys.executable, "-c", code], cwd=tmp_path, env={**os.environ, "PYTHONPATH": path})
    deadline = time.monotonic() + 60.0
    while not (tmp_path / "said").exists() or "says sleep" not in (tmp_path / "said").read_text("utf-8"):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    children = psutil.Process(asker.pid).children(recursive=True)
    assert len(children) >= 2, "the fork server, and the one that sleeps"
    asker.kill()
    asker.wait()
    assert psutil.wait_procs(children, timeout=20.0)[1] == []


@pytest.mark.skipif(not IS_WARM, reason="processes are forked on Linux alone")
def test_a_fork_server_that_has_ended_is_replaced(module, tmp_path):
    assert run(module, "fine", tmp_path)[0] == 0
    server = psutil.Process(forkserver._forkserver._forkserver_pid)
    threading.Timer(1.0, server.kill).start()
    assert run(module, "sleep", tmp_path)[0] not in (0, None)
    while server.status() != psutil.STATUS_ZOMBIE:  # its sockets close some time before
        time.sleep(0.01)
    assert run(module, "fine", tmp_path)[0] == 0
