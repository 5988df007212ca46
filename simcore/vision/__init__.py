"""Cameras: what a Limelight or PhotonVision camera sees from the robot's true pose, and what it publishes."""
