"""Simulation of Limelight and PhotonVision cameras: images at the robot's true pose, and the published results."""
