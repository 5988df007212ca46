"""Pace of a run, measured with a fake clock."""

import pytest

from simcore.show.pacing import FrameRate, Pacer


class Wall:
    """Clock that advances only by sleep and work."""

    def __init__(self) -> None:
        self.now = 100.0
        self.naps = 0

    def clock(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        assert seconds > 0.0
        self.now += seconds
        self.naps += 1


@pytest.fixture
def wall() -> Wall:
    return Wall()


@pytest.mark.parametrize("speed", [0.1, 1.0, 5.0])
def test_a_simulated_second_takes_one_second_over_the_speed(wall: Wall, speed: float) -> None:
    pacer = Pacer(speed, clock=wall.clock, sleep=wall.sleep)
    for tick in range(51):
        pacer.wait(0.02 * tick)
        wall.now += 0.001
    assert wall.now - 100.0 == pytest.approx(1.0 / speed, abs=0.003)


def test_a_long_stall_is_not_made_up_for(wall: Wall) -> None:
    pacer = Pacer(clock=wall.clock, sleep=wall.sleep)
    pacer.wait(0.0)
    wall.now += 10.0
    pacer.wait(0.02)
    before = wall.now
    pacer.wait(0.04)
    assert wall.now - before == pytest.approx(0.02)


def test_the_pacer_reports_the_reached_speed(wall: Wall) -> None:
    """With 50 ms of work in each tick the speed is 0.4 of real time for any requested speed; no time is spare."""
    pacer = Pacer(1.0, clock=wall.clock, sleep=wall.sleep)
    assert pacer.reached is None
    for tick in range(200):
        pacer.wait(0.02 * tick)
        wall.now += 0.05
    assert pacer.reached == pytest.approx(0.4, rel=0.01) and pacer.spare(4.0) == 0.0
    pacer.speed = 0.1
    for tick in range(200, 230):
        pacer.wait(0.02 * tick)
    assert pacer.reached == pytest.approx(0.1, rel=0.02) and pacer.spare(0.02 * 230) == pytest.approx(0.2, rel=0.01)
    pacer.wait(0.0)  # another run
    assert pacer.reached is None


def test_a_small_delay_is_made_up_for(wall: Wall) -> None:
    pacer = Pacer(clock=wall.clock, sleep=wall.sleep)
    pacer.wait(0.0)
    wall.now += 0.1
    for tick in range(1, 11):
        pacer.wait(0.02 * tick)
    assert wall.now == pytest.approx(100.2)


def test_a_paused_run_waits_until_the_run_is_resumed_or_ended(wall: Wall) -> None:
    pacer = Pacer(clock=wall.clock, sleep=wall.sleep)
    pacer.wait(0.0)
    pacer.paused = True
    pacer.wait(0.02, should_stop=lambda: wall.naps >= 50)
    assert wall.naps == 50

    def sleep(seconds: float) -> None:
        wall.sleep(seconds)
        pacer.paused = wall.naps < 60

    pacer._sleep = sleep
    pacer.wait(0.02)
    assert wall.naps == 60
    before = wall.now
    pacer.wait(0.04)
    assert wall.now - before == pytest.approx(0.02), "the pause is not made up for"


def test_the_pacer_restarts_when_a_new_run_begins(wall: Wall) -> None:
    pacer = Pacer(clock=wall.clock, sleep=wall.sleep)
    pacer.wait(0.0)
    pacer.wait(10.0)
    before = wall.now
    pacer.wait(0.0)
    pacer.wait(0.02)
    assert wall.now - before == pytest.approx(0.02)


def test_a_frame_rate_of_30_takes_three_of_five_ticks_on_average(wall: Wall) -> None:
    rate, frames = FrameRate(30.0, clock=wall.clock), 0
    for _ in range(500):
        if rate.due():
            rate.take()
            frames += 1
        wall.now += 0.02
    assert frames == pytest.approx(300, abs=2), "sometimes one tick apart, sometimes two"
    slow = FrameRate(30.0, clock=wall.clock)
    taken = 0
    for _ in range(10_000):
        if slow.due():
            slow.take()
            taken += 1
        wall.now += 0.001
    assert taken == pytest.approx(300, abs=12)
