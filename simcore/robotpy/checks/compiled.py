"""Whether simcore's hot modules run as native code."""

from __future__ import annotations

from simcore.robotpy.checks.finding import Finding, ok, warn

__all__ = ["check_compiled"]

_AGAIN = "`python -m simcore compile`"


def check_compiled(*, is_off: bool, folder: str | None, trouble: str, old: int) -> Finding:
    """What `simcore compile` made, and whether it is in use.

    Args:
        is_off: The environment asks for plain Python.
        folder: Of the build in use, or None.
        trouble: Why a build that fits is not in use; empty if there is none.
        old: Builds of this Python from other sources.
    """
    if is_off:
        return ok("compiled", "plain Python: SIMCORE_COMPILED=0 switches compiled parts off")
    if folder is not None:
        return ok("compiled", f"in use: {folder}")
    if trouble:
        return warn(
            "compiled",
            f"plain Python: the compiled parts do not load: {trouble}",
            "`python -m simcore compile --remove`, then `python -m simcore compile`",
        )
    if old:
        return warn("compiled", "plain Python: the compiled parts are of another version of simcore", f"{_AGAIN} again")
    return ok("compiled", f"plain Python; {_AGAIN} makes robot tests a quarter faster")
