"""`simcore compile`: makes simulations faster with a C compiler; the results stay the same to the last bit."""

from __future__ import annotations

import argparse
import os
import time

from simcore.compiled import build, store
from simcore.compiled.modules import MODULES

__all__ = ["add_arguments", "run"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("--remove", action="store_true", help="delete all compiled parts and go back to plain Python")


def run(args: argparse.Namespace) -> int:
    """Compile or remove, and say what came of it."""
    if args.remove:
        gone = build.remove(os.environ)
        print("\n".join(f"removed {path}" for path in gone) if gone else "nothing compiled was there")
        return 0
    have = store.find(store.places(os.environ), store.tag())
    if have is not None:
        print(f"compiled already, and up to date: {have}")
        return 0
    build.check_tools()
    print(f"compiling {len(MODULES)} modules of simcore with mypyc and your C compiler; a minute or two...", flush=True)
    start = time.perf_counter()
    folder = build.build(os.environ)
    print(f"done in {time.perf_counter() - start:.0f} s: {folder}")
    off = f" ({store.VARIABLE}=0 is set: not here)" if store.is_off(os.environ) else ""
    print(f"Every program that imports simcore uses them from now on{off}; `simcore compile --remove` undoes it.")
    return 0
