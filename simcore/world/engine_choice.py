"""Choice of the physics engine by name, by environment variable, or by installed packages."""

from __future__ import annotations

import argparse
import os
from importlib.util import find_spec

from simcore.errors import EngineError, UnknownNameError
from simcore.units import GRAVITY
from simcore.world.engine import Engine

__all__ = ["ENGINES", "VARIABLE", "add_engine_option", "choose_engine", "engine_label", "make_engine", "require_known"]

ENGINES = {"bullet": "pybullet", "mujoco": "mujoco"}
"""Required package by engine name, in order of preference: the first engine with an installed package is the
default."""
VARIABLE = "SIMCORE_ENGINE"
"""Name of the environment variable that selects the default engine."""


def choose_engine(name: str | None = None) -> str:
    """Return the name of the engine to use.

    Args:
        name: Requested name; None for the engine in the environment variable, or else the first installed engine.

    Raises:
        UnknownNameError: If no engine has this name.
        EngineError: If neither the argument nor the variable names an engine, and no engine is installed.
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
    """Return the name of the engine that `choose_engine` chooses, or "none" if no engine is installed."""
    try:
        return choose_engine(name)
    except EngineError:
        return "none"


def make_engine(name: str | None = None, *, gravity: float = GRAVITY) -> Engine:
    """Make an engine with an empty world.

    Args:
        name: Name of the engine; None for the default of `choose_engine`.
        gravity: Gravitational acceleration, downward [m/s^2].

    Raises:
        UnknownNameError: If no engine has this name.
        EngineError: If the engine is not installed.
    """
    if choose_engine(name) == "mujoco":  # engines are imported here, so that `import simcore` loads none
        from simcore.world.mujoco_engine import MuJoCoEngine

        return MuJoCoEngine(gravity=gravity)
    from simcore.world.bullet import BulletEngine

    return BulletEngine(gravity=gravity)


def add_engine_option(parser: argparse.ArgumentParser) -> None:
    """Add the option `--engine NAME` to a command-line parser."""
    parser.add_argument(
        "--engine", choices=tuple(ENGINES), help="physics engine (default: bullet where it is installed)"
    )


def require_known(name: str) -> str:
    """Check that `name` is the name of an engine, and return `name`.

    Raises:
        UnknownNameError: If no engine has this name.
    """
    if name not in ENGINES:
        raise UnknownNameError("physics engine", name, ENGINES)
    return name
