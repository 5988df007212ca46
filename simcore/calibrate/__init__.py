"""Calibration of a robot model from logs: log readers, simulation models, and fits with confidence intervals."""
