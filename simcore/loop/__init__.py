"""Inner loop of the simulation with at least 1000 steps per second: plain loops over arrays, compiled by Numba."""
