"""Robots: chassis, drivetrain, battery, gyro and mechanisms."""
