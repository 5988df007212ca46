"""Adapters between RobotPy programs and simcore: physics hooks, device connections, driver controls and robot tests."""
