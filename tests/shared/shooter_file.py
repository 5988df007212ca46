"""`simcore.toml` of a shooter without a hood, for tests of check and calibrate."""

SHOOTING = """
game = "rebuilt"
[[mechanism]]
name = "wheels"
kind = "flywheel"
leader = 20
gearing = 1.0
inertia = 0.004

[[shooter]]
wheels = "wheels"
height = 0.5
elevation_deg = 65
"""
