"""Writes docs/real_robots.md and its figure: every comparison of simcore with a real robot, error by error.

python scripts/write_real_robots.py

The measured numbers are those of the tests that hold simcore to them.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path += [str(ROOT / "tests" / part) for part in ("shared", "games", "laws", "calibrate")]

from test_camera_noise import MEASURED, stand  # noqa: E402
from test_drive_fit import KIT, TEAM_114, real_runs, swerve  # noqa: E402
from test_measured_robots import ROBOTS, lateness  # noqa: E402

from games.rebuilt.fuel import FUEL  # noqa: E402
from simcore.calibrate.drive_fit import Prediction, fit_drive  # noqa: E402
from simcore.calibrate.drive_model import drive  # noqa: E402
from simcore.loop.contact import foam_force  # noqa: E402
from simcore.robot.fixed_wheel_config import TankConfig  # noqa: E402
from simcore.units import inches  # noqa: E402
from simcore.vision.camera import CameraBias  # noqa: E402

PAGE, FIGURE = ROOT / "docs" / "real_robots.md", ROOT / "docs" / "images" / "real_robots.svg"
_BEGIN, _END = "<!-- made by scripts/write_real_robots.py -->\n", "<!-- end -->"
_POUND_FORCE = 4.4482  # [N]
_PLATES = ((1.0, 20.6), (1.5, 42.0), (2.0, 77.0))
"""Between plates [in], and force [lbf]: AndyMark's report on the scoring element, as cited by rebuilt-sim-2026."""


class Row(NamedTuple):
    """One comparison."""

    group: str
    what: str
    real: str
    errors: tuple[float, ...]
    """Of simcore, in parts of the real value."""
    text: str
    """The errors in words."""


def rows() -> list[Row]:
    """All comparisons."""
    return [*_drivetrains(), *_shots(), *_limelight(), *_foam()]


def _drivetrains() -> list[Row]:
    found = []
    for name, path, config in (
        ("swerve of team 114, 2022", TEAM_114, swerve()), ("kit chassis, 4 NEO", KIT, TankConfig())
    ):  # fmt: skip
        runs = real_runs(path, config)
        plain = [Prediction(run, drive(config, run).way.mean(axis=1)) for run in runs]
        way = f"{min(r.span for r in runs):.1f} to {max(r.span for r in runs):.1f} m by its log"
        for what, done in (("way by defaults", plain), ("way of a run held out", fit_drive(config, runs).predictions)):
            errors = tuple(one.error for one in done)
            text = f"{_percents(errors)}; {max(1e3 * one.rms for one in done):.0f} mm rms at most"
            found.append(Row(name, what, way, errors, text))
    return found


def _shots() -> list[Row]:
    found = []
    for name, robot in ROBOTS.items():
        late = lateness(robot)
        times = np.array([time for _, time in robot.flights])
        errors = tuple((late / times).tolist())
        text = f"{_percents(errors)}; {1e3 * math.sqrt(float(np.mean(late**2))):.0f} ms rms"
        real = f"{times.min():.2f} to {times.max():.2f} s, {len(times)} distances"
        found.append(Row(f"shot table {name}, 2026", "time of flight", real, errors, text))
    return found


def _limelight() -> list[Row]:
    found = []
    for distance, angle, height, ids, _, measured in MEASURED:
        frames = stand(distance, angle, height, ids, frames=300, bias=CameraBias.none())
        places = np.array([frame.megatag1.position for frame in frames])
        ours = (*(1e3 * places.std(axis=0)[:2]), float(np.std([frame.megatag1.yaw_deg for frame in frames])))
        errors = tuple(mine / real - 1.0 for mine, real in zip(ours, measured[2:], strict=True))
        real = f"{measured[2]:g} and {measured[3]:g} mm, {measured[4]:g} deg"
        what = f"noise of MegaTag 1 at {distance:g} m, {len(ids)} tag{'s' * (len(ids) > 1)}: x, y, yaw"
        found.append(Row("a Limelight, 2024", what, real, errors, _percents(errors)))
    return found


def _foam() -> list[Row]:
    foam, errors = FUEL.foam, []
    for between, pounds in _PLATES:
        force = float(foam_force(0.5 * inches(between), foam[0], foam[1], foam[2], foam[3]))
        errors.append(force / (pounds * _POUND_FORCE) - 1.0)
    real = ", ".join(f"{pounds:g}" for _, pounds in _PLATES) + " lbf at 1, 1.5, 2 in"
    return [Row("fuel between plates", "force", real, tuple(errors), _percents(errors))]


def _percents(errors: tuple[float, ...] | list[float]) -> str:
    return (
        ", ".join(f"{100.0 * error:+.0f}" if abs(error) >= 0.1 else f"{100.0 * error:+.1f}" for error in errors) + " %"
    )


def table(found: list[Row]) -> str:
    """Return the comparisons as a Markdown table."""
    lines = ["| what is real | quantity | measured | simcore's error |", "|---|---|---|---|"]
    lines += [f"| {row.group} | {row.what} | {row.real} | {row.text} |" for row in found]
    return "\n".join(lines) + "\n"


def figure(found: list[Row]) -> str:
    """Return an SVG figure of the errors: a line of dots for each quantity."""
    line, left, width, most = 26, 380, 420, 0.5
    height = line * len(found) + 46
    at = lambda error: left + width * (0.5 + 0.5 * max(-1.0, min(1.0, error / most)))  # noqa: E731
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {left + width + 30} {height}" font-family="sans-serif" '
        'font-size="13" role="img" aria-label="Errors of simcore against real robots">',
        f'<rect width="100%" height="{height}" fill="#ffffff"/>',
    ]
    for tick in (-0.5, -0.25, -0.1, 0.0, 0.1, 0.25, 0.5):
        x = at(tick)
        color = "#333333" if tick == 0.0 else "#dddddd"
        parts.append(f'<line x1="{x:.0f}" y1="10" x2="{x:.0f}" y2="{height - 30}" stroke="{color}"/>')
        parts.append(
            f'<text x="{x:.0f}" y="{height - 12}" text-anchor="middle" fill="#333333">{100 * tick:+.0f} %</text>'
        )
    for number, row in enumerate(found):
        y = 24 + line * number
        parts.append(
            f'<text x="{left - 12}" y="{y + 4}" text-anchor="end" fill="#111111">{row.group}: {row.what}</text>'
        )
        parts += [f'<circle cx="{at(e):.1f}" cy="{y}" r="4.5" fill="#1f6fb2" fill-opacity="0.65"/>' for e in row.errors]
    return "\n".join([*parts, "</svg>"]) + "\n"


def text(found: list[Row]) -> str:
    """Return the page with an up-to-date table."""
    head, rest = PAGE.read_text(encoding="utf-8").split(_BEGIN)
    return f"{head}{_BEGIN}\n{table(found)}\n{_END}{rest.split(_END, 1)[1]}"


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    compared = rows()
    PAGE.write_text(text(compared), encoding="utf-8")
    FIGURE.write_text(figure(compared), encoding="utf-8")
