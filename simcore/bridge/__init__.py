"""Bridge to robot programs in Java, C++ or Python that run in their own process and are stepped over a socket.

The program runs with an extension of WPILib's simulated HAL (`extension.c`). The ports that the program opens are
mirrored in the HAL of simcore's process (`mirrored_ports`), so simcore handles them like the ports of a Python program
in its own process.
"""
