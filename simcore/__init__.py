"""simcore: physics for FIRST Robotics Competition robots written in Python.

Importing this package loads neither the physics engine nor wpilib.
"""

from __future__ import annotations

from simcore.errors import SimcoreError

__all__ = ["SimcoreError", "__version__"]
__version__ = "0.1.0"
