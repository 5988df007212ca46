"""Phoenix 6 in simulated time: an emulation of CTRE's native libraries behind the unchanged Python API.

From the outside to the inside:

- `installation` replaces the libraries by the functions of `emulated_native`.
- `emulator` holds all devices and steps them.
- `emulated_talon` and `emulated_peripherals` are the devices, `emulated_device` is
  their base.
- `control_laws` and `output_stage` compute the output of a motor controller.
- `emulated_drivetrain` is the swerve drivetrain: measured on Phoenix 6 26.3.0
  (`tests/adapters/swerve_reference.json`), with WPILib's published algorithms; plain floats throughout, because it runs
  250 times a simulated second.
"""

from simcore.robotcode.emulator.emulated_device import EnableDelays
from simcore.robotcode.emulator.emulator import Emulator
from simcore.robotcode.emulator.installation import SeamError, install, installed, uninstall

__all__ = ["Emulator", "EnableDelays", "SeamError", "install", "installed", "uninstall"]
