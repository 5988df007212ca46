"""Lines of late signals become one sentence; whatever else is printed reaches the screen, to the last byte."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from simcore.robotpy.console_noise import StaleSignals

ROOT = Path(__file__).resolve().parents[3]
CHECK = "Check the CAN bus wiring, CAN bus utilization, and power to the device.\n"
STALE = f'CAN message is stale, data is valid but old. {CHECK}\ttalon fx 4 ("rio") Status Signal Position\n'
OF_ALL = f"CAN frame not received/too-stale. {CHECK}\tctre::phoenix6::BaseStatusSignal::WaitForAll\n"
OF_ONE = f'CAN frame not received/too-stale. {CHECK}\ttalon fx 31 ("rio") Config Apply\n'


def shown(lines: StaleSignals, text: str, *, now: float, step: int) -> str:
    data = text.encode()
    parts = [part for k in range(0, len(data), step) for part in lines.pass_on(data[k : k + step], now)]
    return b"".join(parts).decode()


def test_late_signals_are_said_once_however_the_stream_is_cut():
    said = set()
    for step in (1, 7, 64, 10_000):
        lines = StaleSignals()
        said.add(shown(lines, STALE + "mine\n" + 8 * STALE + OF_ALL + OF_ONE + "CAN message\n", now=1.0, step=step))
        assert lines.end() == b""
        assert "calls 10 CAN signal(s) stale" in shown(lines, STALE, now=40.0, step=step)
    (text,) = said
    first, *others = text.splitlines(keepends=True)
    assert "calls 1 CAN signal(s) stale. No wire is at fault" in first and "too busy" in first
    assert "".join(others) == "mine\n" + OF_ONE + "CAN message\n", "a device that does not answer is an error"


def test_a_process_loses_nothing_of_its_standard_error():
    """Not a line without an end, not what it prints at its very end, not the dump of a crash."""
    program = f"""
import os, sys
from simcore.robotpy.console_noise import filter_stderr, restore_stderr
filter_stderr()
os.write(2, {(STALE + "native").encode()!r})
print(" and Python", file=sys.stderr)
if len(sys.argv) > 1:
    os.abort()
print("before", file=sys.stderr, flush=True)
restore_stderr()
print("after", file=sys.stderr, flush=True)
os._exit(3)
"""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    run, crash = (
        subprocess.run(
            [sys.executable, "-c", program, *more], env=environment, capture_output=True, text=True, timeout=60
        )
        for more in ((), ("crash",))
    )
    assert run.returncode == 3 and "simcore: Phoenix 6 calls 1 CAN signal(s) stale" in run.stderr
    assert run.stderr.endswith("native and Python\nbefore\nafter\n") and "CAN message" not in run.stderr
    assert crash.returncode != 0 and "Fatal Python error: Aborted" in crash.stderr
