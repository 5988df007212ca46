"""Telemetry: snapshots of the simulation, and their storage in memory and in logs."""
