"""Inner loop of the simulation, at least 1000 steps per simulated second: plain loops that Numba compiles."""
