"""The command `python -m games.rebuilt` with valid and invalid input."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

import simcore
from simcore import cli, season
from simcore.install_text import install_command
from simcore.telemetry.wpilog import read_log

PACKAGES = Path(simcore.__file__).resolve().parents[1]

KEYS = {
    "auto", "seed", "sim_seconds", "wall_seconds", "realtime_factor", "ticks", "score", "pieces", "shots", "hits",
    "tick_ms", "substeps", "awake", "min_battery_v", "brownouts", "resets", "digest",
}  # fmt: skip
NESTED = {
    "score": {"red", "blue", "total"},
    "pieces": {"staged", "on_field", "in_flight", "held", "scored", "off_field"},
    "tick_ms": {"median", "p95", "p99", "max"},
    "substeps": {"mean", "max"},
    "awake": {"mean", "max"},
}


def main(words: list[str]) -> int:
    return cli.main(["play", "rebuilt", *words], program="python -m games.rebuilt")


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Change to an empty folder, where default outputs go to `out/`."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def command(*arguments: str) -> list[str]:
    return [sys.executable, "-m", "games.rebuilt", *arguments]


def environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(PACKAGES)}


def refused(capsys, *arguments: str) -> str:
    """Return the message on stderr for invalid input; check that stdout is empty and there is no traceback."""
    try:
        status = main([*arguments, "--json"])
    except SystemExit as stop:  # argparse
        status = stop.code
    said = capsys.readouterr()
    assert status in (1, 2)
    assert said.out == ""
    assert "Traceback" not in said.err
    return said.err


# --- good input ---------------------------------------------------------------------------------------------------


def test_json_output_is_a_single_object_on_stdout_with_the_documented_keys(here):
    run = subprocess.run(
        command("--seconds", "0.5", "--json"), cwd=here, env=environment(), capture_output=True, text=True, timeout=60
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.count("\n") == 1
    report = json.loads(run.stdout)
    assert set(report) >= KEYS
    for key, keys in NESTED.items():
        assert set(report[key]) >= keys
    assert report["auto"] == "depot" and report["seed"] == 0
    assert report["ticks"] == 25 and report["sim_seconds"] == 0.5
    fuel = report["pieces"]
    assert fuel["staged"] == sum(fuel[k] for k in ("on_field", "in_flight", "held", "scored", "off_field")) == 504
    assert len(bytes.fromhex(report["digest"])) == 32
    assert (here / "out" / "depot.wpilog").is_file() and (here / "out" / "depot.html").is_file()


def test_the_readable_report_names_score_fuel_and_outputs(here, capsys):
    assert main(["--seconds", "0.1"]) == 0
    said = capsys.readouterr().out
    for word in ("points", "504", "not in play yet", "battery", "times as fast", "depot.wpilog", "depot.html"):
        assert word in said


def test_the_list_names_all_autos_and_roles_without_a_run(here, capsys):
    assert main(["--list"]) == 0
    said = capsys.readouterr().out
    autos, roles = ["depot", "neutral", "tour", "drive"], ["collector", "shuttle", "defender", "climber", "idle"]
    assert [line.split()[0] for line in said.splitlines()] == ["REBUILT", *autos, *roles]
    assert list(here.iterdir()) == []


def test_outputs_go_to_the_given_paths_in_new_folders(here, capsys):
    assert main(["--seconds", "0.1", "--json", "--log", "a/b/run.wpilog", "--page", "c/run.html"]) == 0
    outputs = json.loads(capsys.readouterr().out)["outputs"]
    assert [Path(outputs[k]) for k in ("log", "page")] == [Path("a/b/run.wpilog"), Path("c/run.html")]
    assert read_log(here / "a/b/run.wpilog").span[1] > 0.05
    assert (here / "c/run.html").read_text().startswith("<!DOCTYPE html>")
    assert not (here / "out").exists()


# --- bad input ----------------------------------------------------------------------------------------------------

AUTOS = "no auto named 'dept'. Did you mean 'depot'?"
SECONDS = "--seconds: must be a number above 0 and up to 3600 s, got"
SEED = "--seed: must be a whole number from 0 to 4294967295, got"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--auto dept", AUTOS),
        *((f"--seconds={seconds}", f"{SECONDS} '{seconds}'") for seconds in ("-1", "0", "nan", "inf", "ten")),
        *((f"--seed={seed}", f"{SEED} '{seed}'") for seed in ("1.5", "-1", "x", "nan")),
        ("--alliance green", "green"),
        ("--sedd 1", "--sedd"),
    ],
)
def test_invalid_arguments_are_refused_and_leave_no_files(here, capsys, words, said):
    assert said in refused(capsys, *words.split())
    assert list(here.iterdir()) == []


@pytest.mark.parametrize(
    "content", [None, "", "this is no mesh\n", "v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n", "v 0 0 0\nf 1 2 3\n"]
)
def test_the_error_names_a_missing_or_broken_mesh(here, capsys, content):
    if content is not None:
        (here / "broken.obj").write_text(content)
    assert "broken.obj" in refused(capsys, "--field", "broken.obj")


@pytest.mark.parametrize(("what", "name"), [("--log", "run.x"), ("--page", "run.html")])
def test_an_output_path_that_cannot_be_written_is_refused_before_the_run(here, capsys, what, name):
    (here / f"folder.{name}").mkdir()
    (here / "file").write_text("keep me")
    for path in (f"folder.{name}", f"file/{name}"):
        said = refused(capsys, what, path, "--seconds", "160")
        assert name in said and "cannot write" in said
    assert (here / "file").read_text() == "keep me"


def test_bad_input_in_the_shell_gives_status_1_and_no_traceback(here):
    run = subprocess.run(
        command("--auto", "center"), cwd=here, env=environment(), capture_output=True, text=True, timeout=60
    )
    assert (run.returncode, run.stdout) == (1, "")
    assert run.stderr.startswith("\npython -m games.rebuilt: no auto named 'center'") and "Traceback" not in run.stderr


# --- Ctrl-C -------------------------------------------------------------------------------------------------------


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT to a child on Windows")
@pytest.mark.parametrize("as_json", [False, True])
def test_ctrl_c_ends_a_run_with_its_report_and_a_readable_log(here, as_json):
    run = subprocess.Popen(
        command("--seconds", "1600", *(["--json"] if as_json else [])),
        cwd=here, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    log = here / "out" / "depot.wpilog"
    deadline = time.monotonic() + 30.0
    while time.monotonic() < deadline and not (log.exists() and log.stat().st_size > 300_000):
        time.sleep(0.02)
    run.send_signal(signal.SIGINT)
    out, err = run.communicate(timeout=30)
    assert run.returncode == 130
    assert "Traceback" not in err
    last = read_log(log).span[1]
    if as_json:
        report = json.loads(out)
        assert 0.1 < report["sim_seconds"] < 1600.0
        assert last == pytest.approx(report["sim_seconds"], abs=0.020_001), "up to the last tick"
        fuel = report["pieces"]
        assert fuel["staged"] == sum(fuel[k] for k in ("on_field", "in_flight", "held", "scored", "off_field"))
    else:
        assert "points" in out and "interrupted after" in out
    assert (here / "out" / "depot.html").is_file()


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGKILL on Windows")
def test_a_killed_run_leaves_a_log_that_the_replay_reads(here):
    run = subprocess.Popen(command("--seconds", "1600", "--json"), cwd=here, env=environment())
    log = here / "out" / "depot.wpilog"
    deadline = time.monotonic() + 30.0
    while time.monotonic() < deadline and not (log.exists() and log.stat().st_size > 300_000):
        time.sleep(0.02)
    run.kill()
    run.wait(30)
    read = read_log(log)
    assert read.span[1] > 0.5
    last = read.snapshot_at(float(read.column("Sim/GamePieces/Fuel").times[-1]))
    assert last.doubles["Sim/Match/Time"] == pytest.approx(last.time, abs=1e-6)
    rows = last.pose_arrays["Sim/GamePieces/Fuel"]
    assert len(rows) + last.integers["Sim/Intake/HeldCount"] + last.integers["Sim/Score/BlueHub"] == 448 + 8


# --- watching -----------------------------------------------------------------------------------------------------


@pytest.mark.realtime
def test_a_live_run_runs_at_wall_clock_speed_and_obeys_a_dashboard(here, capsys):
    """A client that only subscribes sees the match time advance; its button resets the field."""
    from dashboard import free_port, start_client

    ntcore = season.ntcore
    port = free_port()
    client = ntcore.NetworkTableInstance.create()
    options = season.pub_sub_options(send_all=True, periodic=0.02)
    times = client.get_double_topic("/Sim/Match/Time").subscribe(-1.0, options)
    status = client.get_string_topic("/Sim/Control/Status").subscribe("")
    button = client.get_boolean_topic("/Sim/Control/ResetField").publish()
    seen_status = []

    def press(event):
        if event.data.value.value() == "0 ready":
            button.set(True)
        seen_status.append(event.data.value.value())

    listen = getattr(client, "addListener", None) or client.add_listener
    listen(status, ntcore.EventFlags.VALUE_ALL, press)
    start_client(client, "watcher", port)
    start = time.monotonic()
    seen: list[float] = []

    def leave() -> None:
        end = time.monotonic() + 30.0
        while not (here / "out" / "depot.html").exists() and time.monotonic() < end:
            time.sleep(0.05)
        time.sleep(1.0)
        seen.extend(value.value for value in times.read_queue())
        os.kill(os.getpid(), signal.SIGINT)

    leaving = threading.Thread(target=leave)
    leaving.start()
    assert main(["--live", "--nt-port", str(port), "--seconds", "3", "--json"]) == 0
    leaving.join()
    assert time.monotonic() - start > 3.4
    ntcore.NetworkTableInstance.destroy(client)
    assert len(seen) > 10 and seen == sorted(seen) and 2.0 < seen[-1] <= 3.0
    assert seen_status[-1] == "1 done: the field is reset: 504 pieces staged, no points"
    said = capsys.readouterr()
    assert json.loads(said.out)["ticks"] == 150
    assert f"live on NetworkTables 4, 127.0.0.1:{port}" in said.err
    assert "the run is over; its last values stay on NetworkTables. Press Ctrl-C to leave" in said.err


@pytest.mark.parametrize("option", ["--live --nt-port", "--view --no-browser --port"])
def test_a_port_in_use_is_reported_once_and_no_file_is_overwritten(here, capsys, option):
    if "--view" in option:
        pytest.importorskip("websockets", reason="the extra 'view' is not installed")
    log = Path("before.wpilog")
    log.write_bytes(b"of the run before")
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        assert main([*option.split(), str(other.getsockname()[1]), "--seconds", "0.2", "--log", str(log)]) == 1
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert ": cannot serve" in line and log.read_bytes() == b"of the run before"


def test_a_view_without_the_extra_prints_a_single_error(here, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "websockets.asyncio.server", None)
    assert main(["--view", "--seconds", "0.1", "--json"]) == 1
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert install_command("view") in line


def test_missing_models_are_reported_in_one_message(here, capsys):
    assert main(["--view", "--models", "nowhere", "--seconds", "0.1", "--json"]) == 1
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert ": no folder 'nowhere'" in line
