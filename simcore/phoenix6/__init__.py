"""Adapters to CTRE's Phoenix 6 devices: physics writes their simulated state and reads their volts, nothing else."""
