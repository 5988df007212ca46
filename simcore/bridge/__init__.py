"""The bridge: robot programs in Java, C++ or Python in a process of their own, stepped over a socket.

The program runs with an extension of WPILib's simulated HAL (`extension.c`). What it has opened on ports stands here as
well (`mirrored_ports`), in the HAL of this process, so that everything that knows the ports of a Python program knows
those of any other.
"""
