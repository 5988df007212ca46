"""CTRE's native swerve drivetrain in simulated time: what stands behind `phoenix6.swerve.SwerveDrivetrain`.

Written from measurements of Phoenix 6 26.3.0 (`tests/adapters/swerve_reference.json`) and from WPILib's published
algorithms; plain floats throughout, because it runs 250 times a simulated second.
"""
