"""Bridge to robot programs in Java, C++ or Python: simcore steps a program in another process over a socket.

The program loads an extension of WPILib's simulated HAL (`extension.c`). The module `mirrored_ports` opens the ports of
the program also in the HAL of simcore's process. simcore therefore handles the ports of the program like the ports of a
Python program in simcore's process.
"""
