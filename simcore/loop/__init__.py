"""What moves thousands of times a second: plain loops over arrays, compiled by Numba."""
