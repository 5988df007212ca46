"""Phoenix 6 in simulated time: an emulation of CTRE's native libraries behind the unchanged Python API.

The modules, from the outermost to the innermost:

- `installation` replaces the libraries with the functions in `emulated_native`.
- `emulator` creates all devices and advances simulated time.
- `emulated_talon` and `emulated_peripherals` implement the devices. `emulated_device` contains the devices' base class.
- `control_laws` and `output_stage` compute the output of a motor controller.
- `emulated_drivetrain` implements the swerve drivetrain with WPILib's published algorithms. The implementation is
  fitted to measurements of Phoenix 6 26.3.0 (`tests/adapters/swerve_reference.json`). The module uses plain floats,
  because the emulator updates the drivetrain 250 times per simulated second.
"""

from simcore.robotcode.emulator.emulated_device import EnableDelays
from simcore.robotcode.emulator.emulator import Emulator
from simcore.robotcode.emulator.installation import SeamError, install, installed, uninstall

__all__ = ["Emulator", "EnableDelays", "SeamError", "install", "installed", "uninstall"]
