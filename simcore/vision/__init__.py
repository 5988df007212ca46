"""Cameras: pictures of Limelight and PhotonVision cameras at the robot's true pose, and published results."""
