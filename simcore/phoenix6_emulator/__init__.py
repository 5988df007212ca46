"""Phoenix 6 in simulated time: emulates CTRE's native libraries behind the unchanged Python API.

Swerve is written from measurements of Phoenix 6 26.3.0 (`tests/adapters/swerve_reference.json`) and from WPILib's
published algorithms; plain floats throughout, because it runs 250 times a simulated second.
"""

from simcore.phoenix6_emulator.device_clock import EnableDelays
from simcore.phoenix6_emulator.emulator import Emulator
from simcore.phoenix6_emulator.installation import SeamError, install, installed, uninstall

__all__ = ["Emulator", "EnableDelays", "SeamError", "install", "installed", "uninstall"]
