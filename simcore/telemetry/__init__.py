"""Telemetry: snapshots of the simulation, and storage of snapshots in memory and in logs."""
