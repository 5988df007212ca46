"""Cameras: what a Limelight would see from where the robot truly is, and what it would say about it."""
