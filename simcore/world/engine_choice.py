"""Which physics engine a world gets: by name, by the environment, or the one that is installed."""

from __future__ import annotations

import argparse
import os
from importlib.util import find_spec

from simcore.errors import EngineError, UnknownNameError
from simcore.units import GRAVITY
from simcore.world.engine import Engine

__all__ = ["ENGINES", "VARIABLE", "add_engine_option", "choose_engine", "engine_label", "make_engine", "require_known"]

ENGINES = {"bullet": "pybullet", "mujoco": "mujoco"}
"""Name of each engine, and the package that it needs. PyBullet comes first: it is the default where it is installed."""
VARIABLE = "SIMCORE_ENGINE"
"""Environment variable that names the default."""


def choose_engine(name: str | None = None) -> str:
    """Name of the engine to use.

    Args:
        name: As asked for; None: what the environment variable says, else the first of `ENGINES` that is installed.

    Raises:
        UnknownNameError: There is no such engine.
        EngineError: None is named, and none is installed.
    """
    wanted = name or os.environ.get(VARIABLE) or None
    if wanted is not None:
        return require_known(wanted)
    for known, package in ENGINES.items():
        if find_spec(package) is not None:
            return known
    raise EngineError(
        "no physics engine is installed: `python -m pip install pybullet-arm64` (it imports as 'pybullet'; wheels for "
        "Python 3.10-3.13) or `python -m pip install mujoco` (Python 3.10 and newer)"
    )


def engine_label(name: str | None = None) -> str:
    """Return the engine that a world would get, for a record of a run; "none" where none is installed."""
    try:
        return choose_engine(name)
    except EngineError:
        return "none"


def make_engine(name: str | None = None, *, gravity: float = GRAVITY) -> Engine:
    """An empty world of an engine; arguments and errors as `choose_engine`.

    Raises:
        EngineError: The engine is not installed.
    """
    if choose_engine(name) == "mujoco":  # imported only here, so that importing simcore loads no engine
        from simcore.world.mujoco_engine import MuJoCoEngine

        return MuJoCoEngine(gravity=gravity)
    from simcore.world.bullet import BulletEngine

    return BulletEngine(gravity=gravity)


def add_engine_option(parser: argparse.ArgumentParser) -> None:
    """Add `--engine NAME`."""
    parser.add_argument(
        "--engine", choices=tuple(ENGINES), help="physics engine (default: bullet where it is installed)"
    )


def require_known(name: str) -> str:
    """The name itself.

    Raises:
        UnknownNameError: There is no engine of this name.
    """
    if name not in ENGINES:
        raise UnknownNameError("physics engine", name, ENGINES)
    return name
