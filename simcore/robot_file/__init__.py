"""`simcore.toml`, which describes a team's robot: read, checked, and written as a template."""
