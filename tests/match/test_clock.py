"""Match clock and timer."""

import math

import pytest
from each_case import each

from simcore.errors import ConfigError
from simcore.match.clock import MatchClock, MatchTimer, Phase

CLOCK = MatchClock([Phase("auto", 20.0, "auto"), Phase("pause", 3.0, "disabled"), Phase("teleop", 140.0)])


@each(
    ("time", "name"),
    [(0.0, "auto"), (19.98, "auto"), (20.0, "pause"), (23.0, "teleop"), (162.99, "teleop"), (500.0, "teleop")],
)
def test_a_phase_includes_its_start_time(time, name):
    assert CLOCK.phase(time).name == name


def test_summed_ticks_change_the_phase_at_the_right_tick():
    """1000 x 0.02 summed is 20.00000000000014, and 1149 ticks give 22.98: rounding moves neither border."""
    time, names = 0.0, []
    for _ in range(1200):
        names.append(CLOCK.phase(time).name)
        time += 0.02
    assert names.index("pause") == 1000
    assert names.index("teleop") == 1150


def test_the_clock_reports_phase_starts_the_duration_and_the_remaining_time():
    assert [CLOCK.start(p.name) for p in CLOCK.phases] == [0.0, 20.0, 23.0]
    assert CLOCK.duration == 163.0
    assert (CLOCK.remaining(100.0), CLOCK.remaining(200.0)) == (63.0, 0.0)


def test_invalid_clocks_are_refused():
    with pytest.raises(ConfigError, match=r"no phase 'endgame'; there are \['auto', 'pause', 'teleop'\]"):
        CLOCK.start("endgame")
    with pytest.raises(ConfigError, match="at least one phase"):
        MatchClock([])
    for duration in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(ConfigError, match="Phase 'auto': duration"):
            Phase("auto", duration)


# --- the timer ------------------------------------------------------------------------------------------------------


def after(timer: MatchTimer, ticks: int) -> MatchTimer:
    for _ in range(ticks):
        timer.advance(0.02)
    return timer


def test_the_time_of_many_ticks_is_exactly_their_number_times_their_length():
    """Summing 0.02 s for 8150 ticks would be off by some 1e-11 s."""
    timer = after(MatchTimer(CLOCK), 8150)
    assert timer.time == 8150 * 0.02 and timer.is_over and timer.remaining == 0.0


def test_robots_may_move_except_in_pauses_and_after_the_end():
    enabled = [after(MatchTimer(CLOCK), ticks).is_enabled for ticks in (0, 999, 1000, 1149, 1150, 8149, 8150)]
    assert enabled == [True, True, False, False, True, True, False]


def test_a_driver_station_starts_and_stops_the_match_time():
    timer = MatchTimer(CLOCK)
    timer.follow_driver_station()
    assert after(timer, 50).time == 0.0 and not timer.is_enabled
    timer.start("auto")
    timer.set_enabled(True)
    assert after(timer, 50).time == pytest.approx(1.0)
    timer.set_enabled(False)
    assert after(timer, 50).time == pytest.approx(1.0)
    timer.set_enabled(True)
    after(timer, 950)
    timer.set_enabled(False)
    assert after(timer, 100).time == pytest.approx(22.0), "the pause between auto and teleop goes on while disabled"
    timer.start("teleop")
    assert timer.time == 23.0 and timer.phase.name == "teleop"
    assert after(timer, 10).time == 23.0, "still disabled"
    timer.set_enabled(True)
    assert after(timer, 10).time == pytest.approx(23.2)


def test_a_mode_without_a_phase_is_refused():
    with pytest.raises(ConfigError, match="no phase of mode 'auto'"):
        MatchTimer(MatchClock([Phase("all", 10.0)])).start("auto")
    with pytest.raises(ConfigError, match="mode must be"):
        Phase("x", 1.0, "test")  # type: ignore[arg-type]
