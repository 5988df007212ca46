"""Choice of the physics engine: by name, by environment variable, or the one that is installed."""

from __future__ import annotations

import argparse
import os
from importlib.util import find_spec

from simcore.errors import EngineError, UnknownNameError
from simcore.units import GRAVITY
from simcore.world.engine import Engine

__all__ = ["ENGINES", "VARIABLE", "add_engine_option", "choose_engine", "engine_label", "make_engine", "require_known"]

ENGINES = {"bullet": "pybullet", "mujoco": "mujoco"}
"""Name of each engine and the package that it needs. PyBullet is first: it is the default where installed."""
VARIABLE = "SIMCORE_ENGINE"
"""Environment variable that names the default engine."""


def choose_engine(name: str | None = None) -> str:
    """Return the name of the engine to use.

    Args:
        name: Requested name; None: the environment variable's, else the first of `ENGINES` that is installed.

    Raises:
        UnknownNameError: If there is no such engine.
        EngineError: If none is named and none is installed.
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
    """Return the engine that a world would get, for a run record; "none" if none is installed."""
    try:
        return choose_engine(name)
    except EngineError:
        return "none"


def make_engine(name: str | None = None, *, gravity: float = GRAVITY) -> Engine:
    """Make an empty world of an engine; arguments and errors as for `choose_engine`.

    Raises:
        EngineError: If the engine is not installed.
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
    """Return the name if an engine has it.

    Raises:
        UnknownNameError: If there is no engine of this name.
    """
    if name not in ENGINES:
        raise UnknownNameError("physics engine", name, ENGINES)
    return name
