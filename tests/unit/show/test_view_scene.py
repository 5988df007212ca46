"""Light of the view: shadows for browsers that draw fast, and for no others."""

from __future__ import annotations

import time
from types import SimpleNamespace

import pytest
from simcore.show.view_scene import add_sun


class Browser:
    """A viser client that takes so long to draw each of its pictures [s]; None: it has left."""

    client_id = 7

    def __init__(self, *seconds: float | None) -> None:
        self.seconds = list(seconds)
        self.asked = 0
        self.sun: SimpleNamespace | None = None
        self.scene = SimpleNamespace(add_light_directional=self._add)

    def _add(self, name: str, **light: object) -> SimpleNamespace:
        assert name == "/light/sun"
        self.sun = SimpleNamespace(**light)
        return self.sun

    def get_render(self, **_: object) -> None:
        seconds = self.seconds[self.asked]
        self.asked += 1
        if seconds is None:
            raise RuntimeError("the client disconnected")
        time.sleep(seconds)


@pytest.mark.parametrize(
    ("seconds", "asked", "has_shadows"),
    [
        ((0.0,), 1, True),
        ((0.15, 0.15, 0.0), 3, True),  # the first ones compile and load
        ((0.15, 0.15, 0.15), 3, False),
        ((0.15, None), 2, False),
        ((), 0, False),  # it has left before
    ],
)
def test_a_browser_that_draws_fast_gets_shadows(seconds, asked, has_shadows) -> None:
    browser = Browser(*seconds)
    add_sun(browser, lambda: {7: browser} if seconds else {}, settle=0.0)
    assert browser.sun is not None and browser.sun.intensity > 0.0, "light is there at once"
    end = time.monotonic() + 0.8
    while time.monotonic() < end and not (browser.asked == asked and browser.sun.cast_shadow == has_shadows):
        time.sleep(0.02)
    time.sleep(0.2)
    assert browser.asked == asked and browser.sun.cast_shadow is has_shadows
