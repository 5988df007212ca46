"""Cameras: the view of a Limelight or PhotonVision camera from the robot's true pose, and its published results."""
