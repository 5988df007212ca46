"""Devices and drivetrain that a robot program has built, of any maker.

- `makers` is the table of makers: how to find and reach their motor controllers, encoders and gyros.
- `recorder` records the objects of WPILib's kinematics, odometry and drive classes that a program builds.
- `object_graph` finds devices among the attributes of the robot object.
"""
