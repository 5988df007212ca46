"""What a robot program has built, of any maker, and what of it is a drivetrain.

- `makers` is the table of makers: how their motor controllers, encoders and gyros are found and reached.
- `recorder` notes what a program builds of WPILib's kinematics, odometry and drive classes.
- `object_graph` finds devices among the attributes of the robot object.
"""
