"""Control of a robot program in another process: start the program, step the program's clock, and end the program."""

from __future__ import annotations

import contextlib
import os
import select
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from pathlib import Path
from types import TracebackType
from typing import IO

from simcore.bridge import packets
from simcore.bridge.built_extension import extension_path
from simcore.bridge.packets import HEADER_SIZE, Record, frame, frame_size, records
from simcore.errors import SimcoreError

__all__ = ["PORT", "ProgramError", "RobotProcess"]

PORT = 9810
"""TCP port on which simcore listens for a program that another process starts."""
_STEP = 0.05  # [s], wall time between checks that the program is running
_ENDS = 2.0  # [s], wall time that a program gets to end by itself
_MOST_PRINTED = 2000  # lines of output passed on to stderr
_MOST_KEPT = 10_000_000  # [bytes], largest size of the output file
_LAST = 6  # lines of output quoted in an error


class ProgramError(SimcoreError, RuntimeError):
    """Error for a robot program that cannot be started, does not connect, hangs or has ended."""


class RobotProcess:
    """Process of a robot program, and the socket to the extension in the program.

    Args:
        command: Command that starts the program; empty if another process starts the program.
        patience: Limit of the wall time until the program connects and reaches the first loop [s].
        hang: Limit of the wall time of one step [s].
        output: File for the console output of the program; None for no file.
        shows: Number of lines of console output to copy to stderr.
        say: Function that receives each status message for the user.

    Raises:
        ProgramError: If the command cannot be started, or the port is in use.
    """

    def __init__(
        self,
        command: Sequence[str],
        *,
        patience: float,
        hang: float,
        output: Path | None = None,
        shows: int = _MOST_PRINTED,
        say: Callable[[str], None] = lambda sentence: None,
    ) -> None:
        self.patience, self._hang = patience, hang
        self._say, self._shows = say, shows
        self._connection: socket.socket | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._pid = 0
        """Process ID of the program, possibly a child of the Gradle daemon; 0 before the program connects."""
        self._last: deque[str] = deque(maxlen=_LAST)
        self._reader: threading.Thread | None = None
        self.time = 0.0
        """Time of the program's clock after the last exchange [s]."""
        self._listener = socket.socket()
        if os.name != "nt":
            self._listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            self._listener.bind(("127.0.0.1", 0 if command else PORT))
        except OSError as error:
            self._listener.close()
            raise ProgramError(
                f"port {PORT} of this computer is taken ({error.strerror}): end the other `simcore serve`, or give the "
                "program's command behind --"
            ) from error
        self._listener.listen(1)
        self.address: tuple[str, int] = self._listener.getsockname()
        """Host and port on which simcore listens."""
        try:
            if command:
                self._start(command, output)
        except BaseException:
            self._listener.close()
            raise

    def __enter__(self) -> RobotProcess:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    # --- starting ---------------------------------------------------------------------------------------------------

    def _start(self, command: Sequence[str], output: Path | None) -> None:
        environment = {**os.environ, "SIMCORE_PORT": str(self.address[1])}
        others = environment.get("HALSIM_EXTENSIONS", "")
        mine = str(extension_path())
        environment["HALSIM_EXTENSIONS"] = os.pathsep.join(filter(None, [others, mine]))
        found = shutil.which(command[0])
        if found is None:
            raise ProgramError(f"the robot program cannot be started: there is no command {command[0]!r}")
        try:
            self._process = subprocess.Popen(
                [found, *command[1:]],
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                start_new_session=True,  # creates a process group, to end it as a whole; Windows ends a process tree
            )
        except OSError as error:
            raise ProgramError(f"the robot program cannot be started: {error}") from error
        file = None if output is None else output.open("wb")
        assert self._process.stdout is not None
        self._reader = threading.Thread(
            target=self._read_output, args=(self._process.stdout, file), name="output", daemon=True
        )
        self._reader.start()

    def connect(self) -> list[Record]:
        """Wait for the program's extension to connect, send the definitions of the ports, and return received records.

        Raises:
            ProgramError: If the program does not connect within `patience`, or has ended.
            VersionError: If the version of the extension differs from the version that simcore needs.
        """
        end = time.monotonic() + self.patience
        if self._process is None:
            self._say(f"waiting for a robot program at 127.0.0.1:{PORT}, with HALSIM_EXTENSIONS={extension_path()}")
        while not select.select([self._listener], [], [], _STEP)[0]:
            self._require_alive("before it connected: does it start WPILib's HAL in simulation?")
            if time.monotonic() > end:
                raise ProgramError(
                    f"no robot program has connected within {self.patience:g} s: it must run in simulation with "
                    f"HALSIM_EXTENSIONS={extension_path()}; --wait gives it longer"
                )
        self._connection, _ = self._listener.accept()
        self._listener.close()
        self._connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        found = self._receive(_patient(end))
        self._pid = next((int(r.value) for r in found if r.kind == packets.PROCESS), 0)
        return found + self.exchange(0, packets.definitions())

    # --- running ----------------------------------------------------------------------------------------------------

    def exchange(self, time_us: int, values: list[Record]) -> list[Record]:
        """Send records to the program, step the program's clock by `time_us` [us], and return the program's records.

        Raises:
            ProgramError: If the program has ended, or does not finish the step within `hang` seconds of wall time.
        """
        assert self._connection is not None
        try:
            self._connection.sendall(frame(time_us, values))
        except OSError:
            self._raise_lost()
        return self._receive(time.monotonic() + self._hang)

    def _receive(self, end: float) -> list[Record]:
        size, time_us = frame_size(self._read(HEADER_SIZE, end))
        self.time = 1e-6 * time_us
        return list(records(self._read(size, end)))

    def _read(self, size: int, end: float) -> bytes:
        connection, found = self._connection, b""
        assert connection is not None
        while len(found) < size:
            connection.settimeout(max(0.001, end - time.monotonic()))
            try:
                part = connection.recv(size - len(found))
            except TimeoutError:
                raise ProgramError(
                    f"the robot program has not finished its loop within {self._hang:g} s of wall time, at "
                    f"{self.time:.2f} s of its clock: does a loop wait, or never end?{self._tail()}"
                ) from None
            except OSError:
                part = b""
            if not part:
                self._raise_lost()
            found += part
        return found

    # --- ending -----------------------------------------------------------------------------------------------------

    def _raise_lost(self) -> None:
        if self._process is not None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(_ENDS)
        self._require_alive(f"at {self.time:.2f} s of its clock")
        raise ProgramError(
            f"the connection to the robot program was lost at {self.time:.2f} s of its clock{self._tail()}"
        )

    def _require_alive(self, when: str) -> None:
        status = None if self._process is None else self._process.poll()
        if status is None:
            return
        if self._reader is not None:
            self._reader.join(_ENDS)
        raise ProgramError(f"the robot program has ended {when} ({_status_text(status)}){self._tail()}")

    def _tail(self) -> str:
        return (
            "".join(f"\n    {line}" for line in ["; its last output:", *self._last][:: 1 if self._last else 2])
            if (self._last)
            else ""
        )

    def close(self) -> None:
        """End the program and all child processes of the program, by force if necessary."""
        self._listener.close()
        if self._connection is not None:
            with contextlib.suppress(OSError):
                self._connection.sendall(frame(0, [Record(packets.END, 0, 0, 0.0)]))
            self._connection.close()
            self._connection = None
        if self._process is not None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(_ENDS if self._pid else 0.01)
            self._end_group()
            self._process.wait()
            if self._pid not in (0, self._process.pid) and sys.platform != "win32":
                with contextlib.suppress(ProcessLookupError, PermissionError):
                    os.kill(self._pid, signal.SIGKILL)
            if self._reader is not None:
                self._reader.join(_ENDS)
            self._process = None

    def _end_group(self) -> None:
        """End all processes that the command has started, such as a robot program under gradlew."""
        assert self._process is not None
        if os.name == "nt":
            if self._process.poll() is None:
                subprocess.run(
                    ["taskkill", "/T", "/F", "/PID", str(self._process.pid)], capture_output=True, check=False
                )
            return
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self._process.pid, signal.SIGKILL)

    # --- what it prints -----------------------------------------------------------------------------------------------

    def _read_output(self, pipe: IO[bytes], file: IO[bytes] | None) -> None:
        """Read the console output of the program until the output ends.

        Copy the first lines to stderr, write up to 10 MB to the file, and keep the last lines for errors.
        """
        lines = kept = 0
        with contextlib.ExitStack() as stack:
            stack.enter_context(pipe)
            if file is not None:
                stack.enter_context(file)
            for line in iter(lambda: pipe.readline(10_000), b""):
                lines += 1
                text = line.decode("utf-8", "replace").rstrip()
                self._last.append(text[:300])
                if lines <= self._shows:
                    sys.stderr.write(f"{text}\n")
                elif lines == _MOST_PRINTED + 1 and self._shows:
                    self._say(f"the program prints a lot: no output is shown after {_MOST_PRINTED} lines")
                if file is not None and kept < _MOST_KEPT:
                    kept += file.write(line)
                    file.flush()


def _patient(end: float) -> float:
    return max(end, time.monotonic() + _ENDS)


def _status_text(status: int) -> str:
    """Return a description of the return code of a process: the exit status, or the signal that ended the process.

    >>> _status_text(3)
    'exit status 3'
    """
    if status < 0:
        name = signal.Signals(-status).name
        why = {"SIGFPE": ", as by a division by zero", "SIGSEGV": ", as by a null pointer"}.get(name, "")
        return f"signal {name}{why}"
    return f"exit status {status}"
