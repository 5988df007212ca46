"""Adapters to RobotPy: physics hooks, robot tests, the driver station and the Field2d."""
