"""The match clock."""

from __future__ import annotations

import math

import pytest

from simcore.errors import ConfigError
from simcore.match.clock import MatchClock, Phase

CLOCK = MatchClock([Phase("auto", 20.0), Phase("pause", 3.0), Phase("teleop", 140.0)])


@pytest.mark.parametrize(
    ("time", "name"),
    [(0.0, "auto"), (19.98, "auto"), (20.0, "pause"), (23.0, "teleop"), (162.99, "teleop"), (500.0, "teleop")],
)
def test_a_phase_begins_at_its_first_instant(time, name):
    assert CLOCK.phase(time).name == name


def test_summed_ticks_change_the_phase_at_the_right_tick():
    """1000 x 0.02 added up is 20.00000000000014, and 1149 ticks 22.98: neither rounding moves a border."""
    time, names = 0.0, []
    for _ in range(1200):
        names.append(CLOCK.phase(time).name)
        time += 0.02
    assert names.index("pause") == 1000
    assert names.index("teleop") == 1150


def test_starts_and_what_remains():
    assert [CLOCK.start(p.name) for p in CLOCK.phases] == [0.0, 20.0, 23.0]
    assert CLOCK.duration == 163.0
    assert (CLOCK.remaining(100.0), CLOCK.remaining(200.0)) == (63.0, 0.0)


def test_what_cannot_be_is_refused():
    with pytest.raises(ConfigError, match=r"no phase 'endgame'; there are \['auto', 'pause', 'teleop'\]"):
        CLOCK.start("endgame")
    with pytest.raises(ConfigError, match="at least one phase"):
        MatchClock([])
    for duration in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(ConfigError, match="Phase 'auto': duration"):
            Phase("auto", duration)
