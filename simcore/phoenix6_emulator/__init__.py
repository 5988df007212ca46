"""Phoenix 6 in simulated time: a stand-in for CTRE's native libraries, behind the unchanged Python API."""

from simcore.phoenix6_emulator.enable import EnableDelays
from simcore.phoenix6_emulator.install import SeamError, install, installed, uninstall
from simcore.phoenix6_emulator.world import StandIn

__all__ = ["EnableDelays", "SeamError", "StandIn", "install", "installed", "uninstall"]
