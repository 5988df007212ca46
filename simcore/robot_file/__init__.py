"""Reader, checks and template of `simcore.toml`, the file that describes a team's robot."""
