"""Devices and drivetrain of a robot program, from any maker.

- `makers` lists the makers and connects their motor controllers, encoders and gyros.
- `recorder` records the WPILib kinematics, odometry and drive objects that a program builds.
- `object_graph` finds devices among the attributes of the robot object.
"""
