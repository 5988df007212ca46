"""The robot as a rigid body in the world, and how a drivetrain moves it."""
