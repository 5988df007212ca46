"""Robot code in simulation: recording of a program's devices, adapters for each maker, and the run loop."""
