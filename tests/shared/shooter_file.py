"""A `simcore.toml` of a shooter without a hood, which tests of check and calibrate describe."""

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
