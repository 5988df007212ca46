"""`simcore view` with good and bad input; a page is served, but nobody need look at it."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import shlex
import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from pathlib import Path

import pytest
from simcore.show.replay import Replay

from games.rebuilt import REBUILT, RebuiltSim
from simcore import cli
from simcore.install_text import install_command
from simcore.show.view_models import load_models
from simcore.show.view_server import open_browser
from simcore.telemetry.log_reader import read_log
from simcore.telemetry.snapshot import Snapshot
from simcore.telemetry.wpilog import WpilogSink


def main(words: list[str]) -> int:
    return cli.main(["view", *words])


ROOT = Path(__file__).resolve().parents[2]
MODELS = ("--models", str(REBUILT.models), "--no-browser")


@pytest.fixture
def log(tmp_path: Path) -> Path:
    with RebuiltSim(sinks=[WpilogSink(tmp_path / "run.wpilog")]) as sim:
        for _ in range(60):
            sim.tick()
    return tmp_path / "run.wpilog"


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def test_a_log_is_served_on_this_computer_only(log, capsys):
    pytest.importorskip("viser", reason="the extra 'view' is not installed")
    port, got = free_port(), {}

    def visit():
        end = time.monotonic() + 20.0
        while time.monotonic() < end and "page" not in got:
            try:
                with urllib.request.urlopen(f"http://127.0.0.1:{port}/", timeout=5) as answer:
                    got["page"] = answer.read(100)
            except OSError:
                time.sleep(0.05)
        try:
            socket.create_connection(("127.0.0.2", port), timeout=1.0).close()
        except OSError:
            got["elsewhere"] = "refused"

    visitor = threading.Thread(target=visit)
    visitor.start()
    assert main([str(log), *MODELS, "--port", str(port), "--seconds", "3"]) == 0
    visitor.join()
    assert b"<!doctype html" in got["page"].lower() and got["elsewhere"] == "refused"
    said = capsys.readouterr().out
    assert "run.wpilog: 1.2 s" in said and f"http://127.0.0.1:{port}" in said
    assert "viser" not in said, "it speaks for itself, not for its library"


@pytest.mark.skipif(sys.platform == "win32", reason="a POSIX shell is needed")
def test_a_replay_in_the_background_of_a_script_ends_with_sigint(log):
    """A shell that is not interactive starts what it puts behind `&` with SIGINT ignored."""
    pytest.importorskip("viser", reason="the extra 'view' is not installed")
    words = [sys.executable, "-m", "simcore", "view", str(log), *MODELS]
    script = f"{shlex.join(words)} & echo $!; wait $!; echo status $?"
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(["sh", "-c", script], env=env, cwd=log.parent, stdout=subprocess.PIPE, text=True) as shell:
        assert shell.stdout is not None
        pid = int(shell.stdout.readline())
        try:
            while "Ctrl-C ends it" not in (line := shell.stdout.readline()):
                assert line, "it ended before it served"
            os.kill(pid, signal.SIGINT)
            assert shell.stdout.read().endswith("status 0\n")
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)


def test_a_replay_waits_for_its_first_page(log):
    pytest.importorskip("viser", reason="the extra 'view' is not installed")
    replay = Replay(read_log(log), load_models(REBUILT.models).with_field(None))
    try:
        replay.run(seconds=0.5)
        assert replay.time == replay.start
        replay.step(0.1)
        replay.run(seconds=0.2)
        assert replay.time == pytest.approx(replay.start + 0.3), "it goes on, whoever has left"
    finally:
        replay.close()


def test_a_cut_log_and_a_foreign_one_are_shown_with_a_word(log, capsys, tmp_path):
    pytest.importorskip("viser", reason="the extra 'view' is not installed")
    cut = tmp_path / "cut.wpilog"
    cut.write_bytes(log.read_bytes()[:-1000])
    assert main([str(cut), *MODELS, "--seconds", "0.1"]) == 0
    assert "its end is cut off; what is there is shown" in capsys.readouterr().out
    sink = WpilogSink(tmp_path / "foreign.wpilog")
    sink.write(Snapshot(time=1.0, tick=0, doubles={"SmartDashboard/Speed": 3.0}))
    sink.close()
    assert main([str(sink.path), *MODELS, "--seconds", "0.1"]) == 0
    assert "it holds no Sim/Robot/Pose3d" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["none.wpilog"], "cannot read the log 'none.wpilog'"),
        (["text.wpilog"], "the log 'text.wpilog' is not a .wpilog file"),
        (["run.wpilog", "--models", "none"], "no folder 'none'"),
        (["run.wpilog", *MODELS, "--robot", "Simcore Rebuild"], "Did you mean 'Simcore Rebuilt'"),
        (["run.wpilog", "--game", "rebilt"], "no game named 'rebilt'. Did you mean 'rebuilt'"),
    ],
)
def test_wrong_input_is_one_sentence(log, capsys, monkeypatch, arguments, words):
    monkeypatch.chdir(log.parent)
    Path("text.wpilog").write_text("time,score\n0,1\n")
    assert main(arguments) == 1
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert words in line


def test_a_port_that_cannot_be_is_refused(log, capsys):
    with pytest.raises(SystemExit):
        main([str(log), *MODELS, "--port", "70000"])
    assert "--port: must be a whole number from 0 to 65535, got '70000'" in capsys.readouterr().err


def test_a_taken_port_and_a_missing_extra(log, capsys, monkeypatch):
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        if importlib.util.find_spec("viser") is not None:
            assert main([str(log), *MODELS, "--port", str(other.getsockname()[1])]) == 1
            assert "Another view may be running" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "viser", None)
    assert main([str(log), *MODELS]) == 1
    assert install_command("view") in capsys.readouterr().err


def test_without_a_display_or_a_browser_the_page_is_named(monkeypatch):
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert open_browser("http://x:1") == "no display here: open http://x:1 in a browser on this computer"
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr("webbrowser.open", lambda url: False)
    assert open_browser("http://x:1") == "no browser found: open http://x:1 yourself"
    monkeypatch.setattr("webbrowser.open", lambda url: True)
    assert open_browser("http://x:1") == "the view is at http://x:1"
