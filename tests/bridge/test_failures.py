"""Each failure of a robot program raises an error of one sentence; no run hangs and no process is left."""

from __future__ import annotations

import os
import socket
import struct
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path

import pytest

from simcore.bridge.built_extension import extension_path
from simcore.bridge.packets import OUTPUTS, VERSION, VersionError
from simcore.bridge.robot_process import ProgramError, RobotProcess

PROGRAMS = Path(__file__).parent / "programs"
pytestmark = [
    pytest.mark.skipif(find_spec("wpilib") is None, reason="needs wpilib: pip install .[robotpy]"),
    pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc for what is left"),
]


def _left(mark: str) -> list[str]:
    """Return the ids of processes that have a word among their arguments."""
    found = []
    for folder in Path("/proc").iterdir():
        if folder.name.isdigit() and int(folder.name) != os.getpid():
            try:
                words = (folder / "cmdline").read_bytes().split(b"\0")
            except OSError:
                continue
            found += [folder.name] if mark.encode() in words else []
    return found


def _start(process: RobotProcess) -> None:
    """Connect to the program and wait until it has started."""
    found = process.connect()
    while not any(r.kind == [*OUTPUTS].index("GetProgramStarted") and r.value for r in found):
        time.sleep(0.005)
        found = process.exchange(0, [])


def _serve_for(server: socket.socket) -> dict[str, str]:
    """Return environment variables that make a program connect to the server."""
    port = str(server.getsockname()[1])
    return {**os.environ, "HALSIM_EXTENSIONS": str(extension_path()), "SIMCORE_PORT": port}


def _play(command: list[str], **limits: float) -> None:
    """Start a program and step it through 5 s of its clock."""
    with RobotProcess(command, **{"patience": 30.0, "hang": 30.0, **limits}) as process:
        _start(process)
        for _ in range(250):
            process.exchange(20_000, [])


MISHAPS = {
    "divides by zero": r"ended at [23]\.\d\d s of its clock \(exit status 1\)(.|\n)*ZeroDivisionError",
    "divides by zero in C++": r"ended at [23]\.\d\d s of its clock \(signal SIGFPE, as by a division by zero\)",
    "leaves": r"ended at [23]\.\d\d s of its clock \(exit status 0\)",
    "ends at once": r"has ended (at 0|before).*exit status 1\)(.|\n)*no such team",
}


@pytest.mark.parametrize("what", MISHAPS)
def test_a_program_that_exits_is_reported_in_one_sentence(what, tmp_path):
    mark = f"--mark={tmp_path}"
    with pytest.raises(ProgramError, match=MISHAPS[what]):
        _play([sys.executable, str(PROGRAMS / "mishaps.py"), what, mark])
    assert _left(mark) == []


def test_a_program_whose_loop_blocks_is_terminated(tmp_path):
    mark = f"--mark={tmp_path}"
    with pytest.raises(ProgramError, match=r"not finished its loop within 1 s .* at [23]\.\d\d s of its clock"):
        _play([sys.executable, str(PROGRAMS / "mishaps.py"), "waits", mark], hang=1.0)
    assert _left(mark) == []


def test_a_program_that_never_connects_is_terminated_with_its_children(tmp_path):
    """The command starts another process, as gradlew does."""
    mark = f"--mark={tmp_path}"
    script = (
        "import subprocess, sys; subprocess.run([sys.executable, '-c', 'import time; time.sleep(99)', sys.argv[1]])"
    )
    with pytest.raises(ProgramError, match=r"no robot program has connected within 1 s: .*--wait gives it longer"):
        _play([sys.executable, "-c", script, mark], patience=1.0)
    assert _left(mark) == []


def test_the_error_names_an_unknown_command():
    with pytest.raises(ProgramError, match="there is no command 'gradelw'"):
        RobotProcess(["gradelw"], patience=1.0, hang=1.0)


def test_output_is_cut_after_2000_shown_lines_and_10_megabytes_in_the_file(tmp_path, capsys):
    """The program prints 1 MB in each loop."""
    file = tmp_path / "printed.txt"
    said: list[str] = []
    command = [sys.executable, str(PROGRAMS / "mishaps.py"), "prints a gigabyte"]
    with RobotProcess(command, patience=30.0, hang=30.0, output=file, say=said.append) as process:
        _start(process)
        for _ in range(60):
            process.exchange(20_000, [])
    assert 10_000_000 <= file.stat().st_size < 10_010_000
    assert len(capsys.readouterr().err.splitlines()) == 2000
    assert said == ["the program prints a lot: no output is shown after 2000 lines"]


def test_simcore_refuses_an_extension_of_another_version(tmp_path):
    script = (
        "import os, socket, struct; s = socket.create_connection(('127.0.0.1', int(os.environ['SIMCORE_PORT'])));"
        "s.sendall(struct.pack('<4sIQ', b'SCB9', 0, 0)); print(s.recv(1000))"
    )
    with pytest.raises(VersionError, match="extension is version 9, but this simcore needs version 1"):
        _play([sys.executable, "-c", script])


def test_the_extension_refuses_a_simcore_of_another_version():
    with socket.create_server(("127.0.0.1", 0)) as server:
        program = subprocess.Popen(
            [sys.executable, str(PROGRAMS / "tank.py")], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            env=_serve_for(server),
        )  # fmt: skip
        connection, _ = server.accept()
        with connection:
            connection.sendall(struct.pack("<4sIQ", b"SCB%d" % (VERSION + 1), 0, 0))
            printed, _ = program.communicate(timeout=30.0)
    assert program.returncode == 1
    assert "simcore: this extension is of another version than `simcore serve`" in printed


def test_the_program_exits_when_simcore_exits():
    with socket.create_server(("127.0.0.1", 0)) as server:
        program = subprocess.Popen(
            [sys.executable, str(PROGRAMS / "tank.py")], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            env=_serve_for(server),
        )  # fmt: skip
        server.accept()[0].close()
        printed, _ = program.communicate(timeout=30.0)
    assert "simcore: the connection is lost, the program ends" in printed


def test_only_this_computer_can_connect():
    with RobotProcess([sys.executable, "-c", "import time; time.sleep(9)"], patience=1.0, hang=1.0) as process:
        assert process.address[0] == "127.0.0.1"


def test_many_starts_leave_no_process_running(compiled, tmp_path):
    """Half of the programs are abandoned during their start."""
    program, mark = str(compiled("tank")), f"--mark={tmp_path}"
    begin = time.monotonic()
    for number in range(40):
        with RobotProcess([program, mark], patience=30.0, hang=30.0) as process:
            if number % 2:
                process.connect()
                process.exchange(20_000, [])
    assert _left(mark) == []
    assert time.monotonic() - begin < 60.0
