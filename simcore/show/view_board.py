"""The score board of the page: points, period and clock, what counts now, pieces, robots and their lights."""

from __future__ import annotations

import html
import itertools
import math
import re
from collections.abc import Iterator, Mapping, Sequence

from simcore.match.runner import NOTHING, split_level
from simcore.telemetry.snapshot import Snapshot, key_in_words

__all__ = ["board_html", "clock_text", "lights_html"]

_BOX = "flex:1;padding:6px 0;color:#fff;text-align:center;border-radius:6px;font-size:26px;font-weight:700"
_MOST_SQUARES = 24  # of a strip of lights
_MATCH, _PLACED = "Sim/Match/", "Sim/Placed/"
_KNOWN = frozenset(_MATCH + name for name in ("Time", "TimeLeft", "Period", "Enabled", "Game"))
# On a phone the page's buttons are a sheet of 20 em at the bottom right: here it is as wide as the screen, and leaves
# the upper part of it to the field (`view_cameras.COVERED`).
_STYLE = """<style>@media (max-width: 36em) {
div[style*="position: fixed"][style*="bottom: 0"] { width: 100% !important; max-height: 45% !important; }
div[style="width: 20em;"] { width: 100% !important; }
.simcore-box { padding: 1px 0 !important; font-size: 18px !important; }
.simcore-clock { font-size: 18px !important; margin: 1px 0 !important; }
.simcore-line { display: inline; margin-right: 1em; } }</style>"""


def clock_text(seconds: float) -> str:
    """Minutes, seconds and tenths.

    >>> clock_text(83.26)
    '1:23.3'
    """
    tenths = max(0, round(10.0 * seconds))
    return f"{tenths // 600}:{tenths // 10 % 60:02d}.{tenths % 10}"


def board_html(snapshot: Snapshot, robots: Mapping[int, str]) -> str:
    """The board for a snapshot.

    Args:
        snapshot: What is known; a missing number is left out.
        robots: Number and key prefix of each robot.
    """
    score, doubles = snapshot.integers, snapshot.doubles
    boxes = "".join(
        f'<div class=simcore-box style="{_BOX};background:{color}">'
        f'<small style="font-size:12px">{name.upper()}</small> {score.get(f"Sim/Score/{name}", 0)}</div>'
        for name, color in (("Blue", "#1e54b7"), ("Red", "#c42828"))
    )
    time = doubles.get("Sim/Match/Time", snapshot.time)
    clock = f'<span title="time of the match">{clock_text(time)}</span>'
    left = doubles.get("Sim/Match/TimeLeft")
    rest = [] if left is None else [f"{clock_text(left)} left"]
    if period := snapshot.strings.get("Sim/Match/Period"):
        rest.append(f"period: {html.escape(period)}")
    enabled = snapshot.booleans.get("Sim/Match/Enabled", True)
    if not enabled:
        rest.append("disabled")
    facts = {"period": period, "enabled": enabled, "time": time, "left": left} if period and left is not None else {}
    data = "".join(f' data-{name}="{html.escape(str(value))}"' for name, value in facts.items())  # for sounds
    lines = [*_placed(snapshot), *_counting(snapshot)]
    pieces = {k.removeprefix("Sim/GamePieces/"): len(v) for k, v in snapshot.pose_arrays.items() if "/GamePieces/" in k}
    lines += [f"{html.escape(name.lower())} on the field <b>{count}</b>" for name, count in pieces.items()]
    if score.get("Sim/Shots"):
        lines.append(f"shots <b>{score['Sim/Shots']}</b>, hits <b>{score.get('Sim/Hits', 0)}</b>")
    for number, prefix in robots.items():
        lines += _robot(snapshot, prefix, "robot" if len(robots) == 1 else f"robot {number}")
    body = "".join(f"<div class=simcore-line>{line}</div>" for line in lines)
    return (
        f'{_STYLE}<div style="padding:6px 14px 2px;font-family:system-ui,sans-serif">'
        f'<div style="display:flex;gap:6px">{boxes}</div>'
        f'<div class=simcore-clock{data} style="font-size:24px;font-variant-numeric:tabular-nums;margin:4px 0">{clock}'
        f' <span style="color:#4a5260;font-size:14px">{", ".join(rest)}</span></div>'
        f'<div style="font-size:14px;line-height:1.5">{body}</div></div>'
    )


def _placed(snapshot: Snapshot) -> Iterator[str]:
    """Pieces by level, a line an alliance."""
    by_alliance: dict[str, list[str]] = {}
    for key, count in snapshot.integers.items():
        if key.startswith(_PLACED):
            whose, label = split_level(key.removeprefix(_PLACED))
            by_alliance.setdefault(whose, []).append(f"{html.escape(label)} <b>{count}</b>")
    for whose, counts in by_alliance.items():
        yield f"{whose} placed: {', '.join(counts)}".strip()


def _counting(snapshot: Snapshot) -> list[str]:
    """What a game says of now, as it names it: a flag has a mark, so that it is not told by color alone."""
    found = []
    for key, on in snapshot.booleans.items():
        if key.startswith(_MATCH) and key not in _KNOWN:
            mark, style = ("\u2714", "font-weight:600") if on else ("\u2718", "color:#4a5260")
            found.append(f'<span style="{style}">{mark} {_words(key)}{"" if on else ": no"}</span>')
    for values in (snapshot.integers, snapshot.doubles, snapshot.strings):
        for key, value in values.items():
            if key.startswith(_MATCH) and key not in _KNOWN and value not in NOTHING:
                text = f"{value:g}" if isinstance(value, float) else html.escape(str(value))
                found.append(f"{_words(key)} <b>{text}</b>")
    return found


def _words(key: str) -> str:
    """The last part of a key in small words: `Sim/Match/BlueGoalActive` is `blue goal active`."""
    return html.escape(key_in_words(key.rsplit("/", 1)[-1]))


def _robot(snapshot: Snapshot, prefix: str, name: str) -> Iterator[str]:
    held = snapshot.integers.get(f"{prefix}/Intake/HeldCount")
    volts = snapshot.doubles.get(f"{prefix}/Debug/BatteryVoltage")
    parts = [] if held is None else [f"holds <b>{held}</b>"]
    parts += [] if volts is None else [f"battery <b>{volts:.1f} V</b>"]
    if parts:
        yield f"{name}: {', '.join(parts)}"
    lights = re.compile(rf"^{prefix}/Lights/([^/]+)/Colors$")
    for key, colors in snapshot.integer_arrays.items():
        if match := lights.match(key):
            yield f"{html.escape(match[1])} {lights_html(colors.tolist())}"


def lights_html(colors: Sequence[int]) -> str:
    """A strip of lights as squares: one per LED, or each for several LEDs of a long strip.

    Args:
        colors: 0xRRGGBB of each LED; below zero: of changing colors.
    """
    step = max(1, math.ceil(len(colors) / _MOST_SQUARES))
    text = ""
    for color, run in itertools.groupby(colors[::step]):
        squares = "\u25a0" * len(list(run))
        text += f'<span style="color:#{color:06x}">{squares}</span>' if color >= 0 else "\u25a8" * len(squares)
    return text
