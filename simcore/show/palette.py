"""Named colors for all pages, in light and in dark mode, as CSS variables."""

from __future__ import annotations

from collections.abc import Sequence

from simcore.typing import alliance_in

__all__ = [
    "COLORS",
    "color",
    "css_variables",
    "rgb",
    "screen_color",
    "shade",
    "tint",
]

COLORS: dict[str, tuple[str, str]] = {
    "paper": ("#ffffff", "#14171c"),
    "soft": ("#f4f5f7", "#1e2229"),
    "ink": ("#20242b", "#e8eaee"),
    "muted": ("#56606b", "#a6aeb9"),
    "grid": ("#dfe2e6", "#343a44"),
    "control": ("#7f8792", "#6f7884"),
    "carpet": ("#d3d6da", "#2a2f37"),
    "seams": ("#c3c7cc", "#3a414c"),
    "hit": ("#00685a", "#35d0b4"),
    "miss": ("#b04400", "#ffa060"),
    "path": ("#6a3fb5", "#b8a1f2"),
    "ghost": ("#7a1254", "#ff9bd0"),
    "blue": ("#2f5fae", "#82abf2"),
    "blue-fill": ("#9db4dd", "#294370"),
    "red": ("#b3312b", "#f28d87"),
    "red-fill": ("#e3a9a6", "#6b2b29"),
    "neutral": ("#666e78", "#a0a7b1"),
    "neutral-fill": ("#b4b9c0", "#474e58"),
}
"""Colors `#rrggbb` in light mode and in dark mode, by name.

`tests/show/test_palette.py` checks the contrast (WCAG 2.2: text 4.5 : 1, graphics 3 : 1). The test also checks that
color-blind readers can distinguish hits from misses, and blue from red.
"""


def color(name: str) -> str:
    """Return the CSS value of a color in `COLORS`.

    >>> color("hit")
    'var(--hit)'
    """
    assert name in COLORS, name
    return f"var(--{name})"


def css_variables() -> str:
    """Return CSS that defines all colors as variables, light or dark by the system setting, and light in print."""
    light, dark = ("".join(f"--{name}:{pair[k]};" for name, pair in COLORS.items()) for k in (0, 1))
    return (
        f":root{{color-scheme:light dark;{light}}}\n"
        f"@media (prefers-color-scheme:dark){{:root{{{dark}}}}}\n"
        f"@media print{{:root{{color-scheme:light;{light}}}}}\n"
    )


def tint(name: str) -> tuple[str, str]:
    """Return the CSS fill and edge colors of the alliance at the beginning of a name, or neutral colors.

    >>> tint("blue_tower")
    ('var(--blue-fill)', 'var(--blue)')
    """
    alliance = alliance_in(name) or "neutral"
    return color(f"{alliance}-fill"), color(alliance)


def rgb(hexadecimal: str) -> tuple[int, int, int]:
    """Convert a color `#rrggbb` to red, green and blue, 0 to 255.

    >>> rgb("#0e8a43")
    (14, 138, 67)
    """
    return int(hexadecimal[1:3], 16), int(hexadecimal[3:5], 16), int(hexadecimal[5:7], 16)


def shade(hexadecimal: str, part: float) -> str:
    """Multiply the red, green and blue of a color `#rrggbb` by a factor `part`, and return the new color.

    >>> shade("#804020", 0.5)
    '#402010'
    """
    return "#" + "".join(f"{round(part * value):02x}" for value in rgb(hexadecimal))


def screen_color(linear: Sequence[float]) -> str:
    """Convert a linear-light color, 0 to 1, to a hexadecimal sRGB color. Source: IEC 61966-2-1.

    >>> screen_color((1.0, 0.21586, 0.0))
    '#ff8000'
    """
    screen = (12.92 * c if c <= 0.0031308 else 1.055 * c ** (1.0 / 2.4) - 0.055 for c in linear[:3])
    return "#" + "".join(f"{round(255.0 * c):02x}" for c in screen)
