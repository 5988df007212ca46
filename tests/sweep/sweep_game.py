"""A small game for sweeps: a carpet, a robot, and autos that drive, fail, hang or kill their process."""

import os
import signal
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

from simcore.match.game import Auto, Game, Role
from simcore.match.match import Match

MARK = "SWEEP_GAME_MARK"
"""Environment variable with the path of a file that exists once a run has died."""
SPOILED = 2
"""Seed with which an auto does what its name says."""


def controller(deed, match, alliance):
    volts = match.rules_rng.uniform(4.0, 8.0)

    def control(robot, now):
        robot.drive.set_volts([volts] * 4, [0.0] * 4)
        if match.seed == SPOILED and now > 0.03:
            deed()

    return control


def drive():
    pass


def fail():
    raise ZeroDivisionError("in a team's own code")


def hang():
    while True:
        pass


def leave():
    sys.exit(3)


def die():
    print("so much for that", flush=True)
    os.kill(os.getpid(), signal.SIGKILL)


def die_once():
    mark = Path(os.environ[MARK])
    if not mark.exists():
        mark.touch()
        die()


def ticks(match):
    """Count the ticks, as a metric of a team."""
    return match.ticks


def process(match):
    """Return the id of the process that plays the run."""
    return os.getpid()


def rush(match, alliance, level):
    """Return a controller for a player whose speed follows its level."""
    return lambda robot, now: robot.drive.set_volts([2.0 * level] * 4, [0.0] * 4)


with Match.bare() as match:
    SMALL: Game = replace(
        match.game,
        name="small",
        starts=((2, 2, 0), (2, 4, 0)),
        roles={"rusher": Role(name="rusher", summary="", controller=rush)},
        autos={
            deed.__name__: Auto(name=deed.__name__, summary="", controller=partial(controller, deed), start=(4, 4, 0))
            for deed in (drive, fail, hang, leave, die, die_once)
        },
    )
