"""The robot: chassis, drivetrain, battery, gyro and mechanisms."""
