"""Snapshots of the simulation and where they go: logs, memory, NetworkTables, pages."""
