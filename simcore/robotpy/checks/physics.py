"""Whether the simulated game runs here, and fast enough."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from simcore.robotpy.checks.finding import Finding, fail, ok, warn

__all__ = ["check_game", "check_speed"]

TICK = 0.02  # [s]
_TICKS = 50  # one simulated second
_WARM_UP = 10  # ticks; the first ones pay for caches
_SLOW = 8.0  # [ms]; robot code, Phoenix 6 and the window want the rest of the 20


def check_game(games: Iterable[Any]) -> tuple[Finding, Callable[..., Any] | None]:
    """Whether there is a game to play, and it loads.

    Args:
        games: Entry points of group `simcore.sims`: classes that make a whole match of nothing.

    Returns:
        The finding, and what builds the game; None if there is none.
    """
    found = list(games)
    if not found:
        return (
            fail(
                "game",
                "no game is installed",
                "in the folder of simcore: `python -m pip install -e .`, or install again",
            ),
            None,
        )
    names = ", ".join(sorted(entry.name for entry in found))
    try:
        return ok("game", names), found[0].load()
    except Exception as error:
        return fail("game", f"{found[0].name} does not load: {error}", "install simcore again"), None


def check_speed(build: Callable[..., Any], clock: Callable[[], float]) -> list[Finding]:
    """Play a second with the whole field and a robot that drives, and compare a tick with its 20 ms.

    Args:
        build: Makes the game; it has `robots`, `tick`, `piece_places` and `close`, as `RebuiltSim`.
        clock: Wall time [s].
    """
    try:
        game = build()
    except Exception as error:
        return [fail("field", f"the game cannot be built: {error}", "install simcore again: parts of it are missing")]
    took = []
    try:
        pieces = sum(len(places) for places in game.piece_places().values())
        robot = game.robots[0]
        start = robot.chassis.pose
        for number in range(_WARM_UP + _TICKS):
            before = clock()
            robot.drive.set_chassis_speeds(1.0, 0.0, 0.0)
            game.tick()
            if number >= _WARM_UP:
                took.append(1e3 * (clock() - before))
        end = robot.chassis.pose
    finally:
        game.close()
    moved = float(np.hypot(end[0] - start[0], end[1] - start[1]))
    field = ok("field", f"mesh and {pieces} pieces are there")
    if not moved > 0.5:
        where = f"a robot told to drive at 1 m/s moved {moved:.2f} m in {TICK * (_WARM_UP + _TICKS):.1f} s"
        return [field, fail("physics", where, "report this: with this output, your computer and its Python")]
    return [field, _speed(float(np.median(took)), float(np.percentile(took, 99)))]


def _speed(median: float, worst: float) -> Finding:
    text = f"a tick takes {median:.1f} ms, p99 {worst:.1f} ms, of 20 ms: {1e3 * TICK / median:.0f} x real time alone"
    if median > 1e3 * TICK:
        return fail(
            "speed", text, "too slow to drive in real time: plug in the charger, close other programs, less fuel"
        )
    if median > _SLOW or worst > 1e3 * TICK:
        return warn(
            "speed",
            text,
            "robot code needs the rest of it: plug in the charger, close other programs (see performance)",
        )
    return ok("speed", text)
