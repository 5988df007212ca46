"""Inner loop of the simulation, 1000 steps a second and more: plain loops over arrays, compiled by Numba."""
