"""Sounds of a match in a real browser: none until somebody asks for them, then one at each turn of the clock."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("viser", reason="the extra 'view' is not installed")

from simcore.show.view_page import ViewPage

from simcore import Match
from simcore.match.clock import MatchClock, Phase
from simcore.match.game import Game
from simcore.show.page import write_page
from simcore.show.scene import scene_of
from simcore.show.view_models import ViewModels
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot

pytestmark = pytest.mark.slow

STUB = """(() => { window.heard = []; window.contexts = 0;
  window.AudioContext = class {
    constructor() { window.contexts += 1; this.currentTime = 0; this.destination = {}; }
    createOscillator() { const tone = { frequency: {}, connect: (to) => to, stop() {},
      start() { window.heard.push(tone.frequency.value); } }; return tone; }
    createGain() { return { gain: { setValueAtTime() {}, linearRampToValueAtTime() {} }, connect: (to) => to }; }
  }; })()"""
START, STOP, CHANGE, LAST, END = [523, 659, 784], [330], [880, 880], [988, 988, 988], [294, 220]


def hear(page, notes: list[int], seconds: float = 15.0) -> None:
    """Until just these notes were played since the last time."""
    end = time.monotonic() + seconds
    while (heard := page.evaluate("heard")) != notes:
        assert time.monotonic() < end and len(heard) < len(notes) + 1, heard
        time.sleep(0.02)
    page.evaluate("heard.length = 0")


def shown(page: ViewPage, now: float, left: float, period: str, enabled: bool = True) -> None:
    page.show(
        Snapshot(
            time=now,
            tick=round(50 * now),
            doubles={"Sim/Match/Time": now, "Sim/Match/TimeLeft": left},
            strings={"Sim/Match/Period": period},
            booleans={"Sim/Match/Enabled": enabled},
        )
    )


def test_a_live_page_is_silent_until_its_button_is_pressed_and_again_after_it(browser) -> None:
    with ViewPage(ViewModels()) as page:
        visitor = browser(page.url)
        visitor.wait_for_text("sound: off")
        visitor.evaluate(STUB)
        shown(page, 0.02, 100.0, "auto")
        visitor.wait_for_text("period: auto")
        shown(page, 1.0, 99.0, "pause", False)
        visitor.wait_for_text("period: pause")
        time.sleep(0.3)
        assert visitor.evaluate("[heard.length, contexts]") == [0, 0], "off, and no audio is even opened"
        visitor.click("sound: off")
        visitor.wait_for_text("sound: on")
        for now, left, period, enabled, notes in (
            (1.5, 98.5, "teleop", True, START),
            (2.5, 97.5, "shift", True, CHANGE),
            (3.0, 30.0, "end game", True, LAST),
            (4.0, 0.0, "end game", False, END),
            (0.02, 100.0, "auto", True, START),  # the next run
            (1.0, 99.0, "pause", False, STOP),
        ):
            shown(page, now, left, period, enabled)
            hear(visitor, notes)
        shown(page, 60.0, 40.0, "shift", True)  # somebody has moved the slider of a replay
        visitor.wait_for_text("period: shift")
        time.sleep(0.3)
        visitor.click("sound: on")
        shown(page, 61.0, 0.0, "shift", False)
        visitor.wait_for_text("disabled")
        time.sleep(0.3)
        assert visitor.evaluate("[heard.length, contexts]") == [0, 1]


def test_the_page_of_a_run_sounds_as_it_plays_and_not_as_its_slider_moves(browser, tmp_path: Path) -> None:
    phases = [Phase("auto", 0.6, "auto"), Phase("pause", 0.4, "disabled"), Phase("teleop", 31.0), Phase("last", 0.6)]
    recording = Recording()
    with Match(replace(Game.bare(), clock=MatchClock(phases)), sinks=[recording]) as match:
        match.play(1.4)
        match.timer._start = 30.0  # it goes on 30 s later, close to its last part
        match.play(1.4)
        write_page(tmp_path / "run.html", recording, scene_of(match))
    visitor = browser((tmp_path / "run.html").as_uri())
    visitor.wait_for_text("sound: off")
    visitor.evaluate(STUB)
    visitor.click("sound: off")
    visitor.evaluate("document.querySelector('.bar input').value = 1.2")
    visitor.evaluate("document.querySelector('.bar input').dispatchEvent(new Event('input'))")
    time.sleep(0.3)
    assert visitor.evaluate("heard") == []
    visitor.evaluate("document.querySelector('.bar input').value = 0")
    visitor.evaluate("document.querySelector('.bar input').dispatchEvent(new Event('input'))")
    visitor.click("Play")
    hear(visitor, [*START, *STOP, *START, *LAST, *END])
