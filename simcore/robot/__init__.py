"""Robots: chassis, drivetrains, batteries, gyros, mechanisms, and the parts that handle game pieces."""
