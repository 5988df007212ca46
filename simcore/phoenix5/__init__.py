"""CTRE's Phoenix 5: Talon SRX, Victor SPX and Pigeon IMU, as the library shows them to robot code.

Its simulation runs in threads on the wall clock, the closed loops of a Talon SRX too, with status frames of 10 to
50 ms, whatever simulated time does. So simcore notes what robot code asks for, runs the loops on the clock of the
physics and answers what robot code reads.

- `built_talons` notes controllers and gyros that a program builds, what they are configured with and told.
- `talon_loop` is the control law of a Talon SRX and a Victor SPX.
- `talon_srx_port` is one controller as robot code sees it, `talon_srx_motor` connects it with a mechanism.
- `ctre5_maker` is the gyro, and says what of it all makes a drivetrain.

All need the extra 'phoenix5'.
"""

import phoenix5  # noqa: F401  # before the modules: whoever watches its import loads them
