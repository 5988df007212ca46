"""Where the models of REBUILT are: for AdvantageScope's custom assets folder and for the browser view."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

__all__ = ["models_folder"]


def models_folder() -> Path:
    """The folder that comes with simcore: inside an installed package, or in the source tree."""
    packaged = Path(str(resources.files("games.rebuilt"))) / "models" / "advantagescope"
    if packaged.is_dir():
        return packaged
    return Path(__file__).resolve().parents[2] / "models" / "advantagescope"
