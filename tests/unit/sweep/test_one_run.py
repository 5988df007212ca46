"""A limit on wall time ends what takes too long, and leaves nothing behind."""

from __future__ import annotations

import subprocess
import sys
import textwrap
import time

import pytest

from simcore.sweep.one_run import TimeLimitError, time_limit


def test_what_takes_too_long_is_ended():
    start = time.perf_counter()
    with pytest.raises(TimeLimitError, match=r"longer than 0\.05 s"), time_limit(0.05):
        while time.perf_counter() < start + 20.0:
            pass
    assert time.perf_counter() < start + 10.0


def test_what_is_in_time_is_let_alone():
    with time_limit(0.05):
        done = 1
    time.sleep(0.2)
    assert done == 1


def test_an_error_of_the_run_passes_through():
    with pytest.raises(ZeroDivisionError), time_limit(20.0):
        raise ZeroDivisionError


def test_a_profiler_works_after_it():
    """CPython 3.11 hangs in profiled code once an exception for a thread was taken back, so in a process of its own."""
    code = """
        import cProfile
        from simcore.sweep.one_run import time_limit
        with time_limit(60.0):
            pass
        profile = cProfile.Profile()
        profile.enable()
        total = sorted(abs(x) for x in range(-1000, 1000))
        profile.disable()
        print(len(total))
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, timeout=60.0, check=False
    )
    assert done.stdout == "2000\n", done.stderr
