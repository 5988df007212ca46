"""Calibration of a robot model: readers of logs, simulation models, and fits to logs with confidence intervals."""
