"""Contrasts of the colors in all drawings, computed from the palette itself."""

import itertools

import numpy as np
import pytest

from simcore.show.palette import COLORS, css_variables, rgb

Color = np.ndarray[tuple[int], np.dtype[np.float64]]

SEEN_BY_PROTANS = np.array(
    [(0.152286, 1.052583, -0.204868), (0.114503, 0.786281, 0.099216), (-0.003882, -0.048116, 1.051998)]
)
SEEN_BY_DEUTANS = np.array(
    [(0.367322, 0.860646, -0.227968), (0.280085, 0.672501, 0.047413), (-0.011820, 0.042940, 0.968881)]
)
"""Linear RGB as readers without red or green cones see it; Machado, Oliveira and Fernandes 2009, severity 1."""
TEXTS = [("ink", "paper"), ("ink", "soft"), ("muted", "paper"), ("muted", "soft"), ("hit", "paper"), ("miss", "paper"),
         ("path", "paper")]  # fmt: skip
GRAPHICS = [
    *((name, ground) for name in ("hit", "miss", "path", "ghost", "ink") for ground in ("carpet", "soft", "paper")),
    *((name, ground) for name in ("blue", "red", "neutral") for ground in ("carpet", "paper")),
    ("control", "paper"), ("blue", "soft"), ("red", "soft"),
]  # fmt: skip
PAIRS = [("hit", "miss"), ("blue", "red"), ("path", "ghost"), ("hit", "path"), ("miss", "path")]


def linear(color: str) -> Color:
    values = np.array(rgb(color)) / 255.0
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def contrast(one: str, other: str) -> float:
    """Return the contrast of WCAG 2.2: the ratio of relative luminances, each with 0.05 of stray light."""
    light, dark = sorted(
        (float(linear(color) @ (0.2126, 0.7152, 0.0722)) + 0.05 for color in (one, other)), reverse=True
    )
    return light / dark


def lab(color: Color) -> Color:
    """Return CIE L*a*b* of linear RGB for daylight D65."""
    xyz = (
        np.array(
            [(0.4124564, 0.3575761, 0.1804375), (0.2126729, 0.7151522, 0.0721750), (0.0193339, 0.1191920, 0.9503041)]
        )
        @ color
    )
    t = xyz / (0.95047, 1.0, 1.08883)
    f = np.where(t > 216 / 24389, np.cbrt(np.maximum(t, 0.0)), (24389 / 27 * t + 16) / 116)
    return np.array((116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])))


def test_the_color_formulas_give_published_values() -> None:
    assert contrast("#ffffff", "#000000") == pytest.approx(21.0)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.005), "the gray that fails by a hair"
    assert lab(linear("#ff0000")) == pytest.approx((53.24, 80.09, 67.20), abs=0.05)


@pytest.mark.parametrize("theme", [0, 1], ids=["light", "dark"])
def test_texts_and_graphics_have_enough_contrast_with_their_background(theme: int) -> None:
    for pairs, least in ((TEXTS, 4.5), (GRAPHICS, 3.0)):
        found = {pair: contrast(*(COLORS[name][theme] for name in pair)) for pair in pairs}
        assert {pair: round(value, 2) for pair, value in found.items() if value < least} == {}


@pytest.mark.parametrize("theme", [0, 1], ids=["light", "dark"])
def test_pairs_of_colors_differ_for_readers_who_see_no_red_or_no_green(theme: int) -> None:
    """A difference of 20 in L*a*b* is obvious; shapes and dashes differ as well."""
    for seen, (one, other) in itertools.product((np.eye(3), SEEN_BY_PROTANS, SEEN_BY_DEUTANS), PAIRS):
        a, b = (lab(np.clip(seen @ linear(COLORS[name][theme]), 0.0, 1.0)) for name in (one, other))
        assert np.linalg.norm(a - b) > 20.0, (one, other, seen[0].tolist())


def test_both_themes_are_in_the_style_sheet() -> None:
    text = css_variables()
    assert "prefers-color-scheme:dark" in text
    assert all(f"--{name}:{color};" in text for name, pair in COLORS.items() for color in pair)
