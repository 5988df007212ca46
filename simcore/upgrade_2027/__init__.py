"""Makes the copy of a robot project of 2026 that runs on the libraries of 2027."""
