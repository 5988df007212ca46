"""Random public calls with typical mistakes: each must raise a simcore error or do no harm.

`python tests/games/random_calls.py FIRST COUNT` plays COUNT seeds from FIRST on and prints violations.
"""

from __future__ import annotations

import inspect
import logging
import math
import re
import sys
from collections import Counter

import numpy as np

from games.rebuilt import REBUILT
from games.reefscape import REEFSCAPE
from simcore.errors import SimcoreError, UnknownNameError
from simcore.match.game import RobotEntry
from simcore.match.match import Match
from simcore.robot.dc_motor import motor
from simcore.robot.fixed_wheel_config import MecanumConfig, TankConfig
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import PistonConfig, ServoConfig
from simcore.robot.robot_config import RobotConfig

MISTAKES = (
    None, True, False, "x", "", "blue", "1.0", b"1", 0, -1, 3, 10**400, -(10**400), 1e300, -1e300, math.nan, math.inf,
    -math.inf, 3.7, 1j, object(), [], (), {}, set(), {1.0, 2.0}, [1.0], [math.nan] * 4, [1.0] * 3, [1.0] * 4,
    ["a"] * 4, [None] * 3, [[1.0, 2.0]], [1e300] * 4, [10**400] * 4, [True] * 4, (1.0, 2.0, 0.0), (1e300, 1.0, 1.0),
    np.nan, np.array(1.0), np.zeros(0), np.zeros((2, 3)), np.full((1, 3), np.nan), np.full((1, 3), 1e308),
    np.array([0]), np.array([0, 0]), np.array([-1]), np.array([10**6]), np.array(["a"]), np.array([None]),
    np.array([1.5]), np.array([True]), range(3), len, int, iter([1.0]), "Fuel", "Coral", "robot",
)  # fmt: skip
_BOX = GearboxConfig(motor=motor("Kraken X60"), gearing=10.0)
_OTHERS = {
    "piston": PistonConfig(stroke=0.2, stroke_time=0.4),
    "servo": ServoConfig(min_angle=0.0, max_angle=1.0, speed=3.0),
}
_COMMANDS = re.compile(
    "(set_(?!mass|requests)|reset|coast|stage|spawn|release|hold|launch|score$|set_aside|push|spare|put_down|place_|start_"
    "|human_action|take_over|carry_to|apply_forces|refuse)"
)
"""Commands for users; the other methods are queries, or the loop calls them with computed values."""


def a_match(seed: int) -> Match:
    game = (REBUILT, REEFSCAPE)[seed % 2]
    drivetrain = (TankConfig(), MecanumConfig())[seed // 2 % 2]
    other = RobotConfig(drivetrain=drivetrain, mechanisms=_OTHERS)
    return Match(game, robots=[RobotEntry(), RobotEntry(alliance="red", preload=0, config=other)], seed=seed)


def targets(match: Match) -> list:
    """Return the objects and method names to call; collected again for each call, as a reset makes new objects."""
    owners = [match, match.control, match.pieces, *match.robots]
    for robot in match.robots:
        owners += [robot.drive, robot.odometry, robot.gyro, robot.chassis, *robot.mechanisms.values()]
    found = []
    for owner in owners:
        for name, method in inspect.getmembers(type(owner), callable):
            if _COMMANDS.match(name) and inspect.isfunction(method):
                found.append((owner, name))
    return found


def arguments(rng, function) -> tuple[list, dict]:
    """Draw mistakes for all required arguments and some optional arguments."""
    given, named = [], {}
    for parameter in inspect.signature(function).parameters.values():
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            continue
        if parameter.default is not parameter.empty and rng.random() < 0.6:
            continue
        value = MISTAKES[rng.integers(len(MISTAKES))]
        if parameter.kind is parameter.KEYWORD_ONLY or parameter.default is not parameter.empty:
            named[parameter.name] = value
        else:
            given.append(value)
    return given, named


def play(seed: int, calls: int = 150) -> Counter:
    """Play random calls with ticks in between; return violations and their counts."""
    rng, wrong = np.random.default_rng(seed), Counter()
    with a_match(seed) as match:
        last = ""
        for _ in range(calls):
            choices = targets(match)
            owner, name = choices[rng.integers(len(choices))]
            given, named = arguments(rng, getattr(owner, name))
            text = f"{type(owner).__name__}.{name}"
            try:
                getattr(owner, name)(*given, **named)
                last = f"{text}({', '.join(map(repr, given))}, {named})"[:150]
            except SimcoreError as error:
                if not re.search(r"\d|got|among|; ", str(error)) and not isinstance(error, UnknownNameError):
                    wrong[f"{text} does not say what it got: {error}"] += 1
            except Exception as error:
                shown = f"{text}({', '.join(map(repr, given))}, {named})"[:150]
                wrong[f"{shown}: {type(error).__name__} {error}"[:300]] += 1
            if rng.random() < 0.5:
                try:
                    match.tick()
                except Exception as error:
                    wrong[f"a tick after {last}: {type(error).__name__} {error}"[:300]] += 1
                    return wrong
                if not match.count.is_conserved or not np.isfinite(match.pieces.state.pos).all():
                    wrong[f"pieces are lost or nowhere after {last}"] += 1
                    return wrong
        for result in match.control.results:
            if re.match(r"\w+Error: ", result.text):
                wrong[f"{result.command}: {result.text}"[:200]] += 1
    return wrong


if __name__ == "__main__":
    logging.disable(50)
    total: Counter = Counter()
    for seed in range(int(sys.argv[1]), int(sys.argv[1]) + int(sys.argv[2])):
        total += play(seed)
    for text, count in sorted(total.items()):
        print(count, text)
    print(sum(total.values()), "in all")
