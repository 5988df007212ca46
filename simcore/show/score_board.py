"""The board of the page: score, clock, and what the first robot is about, as HTML."""

from __future__ import annotations

import html
from collections.abc import Mapping

from simcore.telemetry.snapshot import Snapshot

__all__ = ["clock_text", "score_html"]

_BOX = "flex:1;padding:6px 0;color:#fff;text-align:center;border-radius:6px;font-size:26px;font-weight:700"


def clock_text(seconds: float) -> str:
    """Minutes, seconds and tenths.

    >>> clock_text(83.26)
    '1:23.3'
    """
    tenths = max(0, round(10.0 * seconds))
    return f"{tenths // 600}:{tenths // 10 % 60:02d}.{tenths % 10}"


def score_html(snapshot: Snapshot, robots: Mapping[int, str]) -> str:
    """The board for a snapshot.

    Args:
        snapshot: What is known; a missing number is left out.
        robots: Number and key prefix of each robot.
    """
    score, doubles = snapshot.integers, snapshot.doubles
    boxes = "".join(
        f'<div style="{_BOX};background:{color}">{score.get(f"Sim/Score/{name}", 0)}</div>'
        for name, color in (("Blue", "#1e54b7"), ("Red", "#c42828"))
    )
    clock = clock_text(doubles.get("Sim/Match/Time", snapshot.time))
    left = doubles.get("Sim/Match/TimeLeft")
    rest = "" if left is None else f'<span style="color:#667;font-size:14px"> {clock_text(left)} left</span>'
    lines = []
    pieces = {k.removeprefix("Sim/GamePieces/"): len(v) for k, v in snapshot.pose_arrays.items() if "/GamePieces/" in k}
    lines += [f"{name.lower()} on the field <b>{count}</b>" for name, count in pieces.items()]
    if "Sim/Shots" in score:
        lines.append(f"shots <b>{score['Sim/Shots']}</b>, hits <b>{score.get('Sim/Hits', 0)}</b>")
    for number, prefix in robots.items():
        held = score.get(f"{prefix}/Intake/HeldCount")
        volts = doubles.get(f"{prefix}/Debug/BatteryVoltage")
        parts = [] if held is None else [f"holds <b>{held}</b>"]
        parts += [] if volts is None else [f"battery <b>{volts:.1f} V</b>"]
        if parts:
            name = "robot" if len(robots) == 1 else f"robot {number}"
            lines.append(f"{name}: {', '.join(parts)}")
    body = "<br>".join(line if "<" in line else html.escape(line) for line in lines)
    return (
        '<div style="padding:6px 14px 2px;font-family:system-ui,sans-serif">'
        f'<div style="display:flex;gap:6px">{boxes}</div>'
        f'<div style="font-size:24px;font-variant-numeric:tabular-nums;margin:4px 0">{clock}{rest}</div>'
        f'<div style="font-size:14px;line-height:1.5">{body}</div></div>'
    )
