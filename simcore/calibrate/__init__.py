"""Calibration of a robot model from logs: log readers, forward models on the compiled loop, fits with intervals."""
