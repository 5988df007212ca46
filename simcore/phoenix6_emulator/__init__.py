"""Phoenix 6 in simulated time: emulates CTRE's native libraries behind the unchanged Python API.

From the outside to the inside:

- `installation` replaces the libraries by `emulated_native` (devices, signals, configurations) and `swerve_native`.
- `emulator` holds all devices and steps them.
- `emulated_talon`, `emulated_encoders` and `emulated_peripherals` are the devices, `emulated_device` is
  what they share.
- A motor controller is a control loop (`emulated_talon`) on configuration and requests (`talon_requests`), with its
  `talon_feedback`, `talon_follower`, `talon_frame` and `talon_limits`, on the plain `talon_state`.
- `control_plan`, `control_laws`, `motion_profile`, `output_stage` and `motor_constants` compute the output.
- `emulated_drivetrain`, `drivetrain_requests`, `emulated_module`, `pose_estimator` and `swerve_kinematics` are the
  swerve drivetrain, with motors and gyro by `drivetrain_devices`: measured on Phoenix 6 26.3.0
  (`tests/adapters/swerve_reference.json`), with WPILib's published algorithms; plain floats throughout, because it runs
  250 times a simulated second.
"""

from simcore.phoenix6_emulator.device_clock import EnableDelays
from simcore.phoenix6_emulator.emulator import Emulator
from simcore.phoenix6_emulator.installation import SeamError, install, installed, uninstall

__all__ = ["Emulator", "EnableDelays", "SeamError", "install", "installed", "uninstall"]
