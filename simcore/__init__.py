"""simcore: physics for FIRST Robotics Competition robots written in Python.

Importing this package loads neither the physics engine nor wpilib.
"""

from __future__ import annotations

import os

from simcore.compiled.finder import install as _install
from simcore.errors import SimcoreError

__all__ = ["SimcoreError", "__version__"]
__version__ = "0.1.0"

_install(os.environ)  # before any module that may be compiled
