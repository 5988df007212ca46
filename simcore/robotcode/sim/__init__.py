"""Adapters to RobotPy: pyfrc's physics hook, the driver station, the Field2d."""
