"""Swerve and tank drivetrains: motors, gears, tires, steering, encoders and gyro."""
