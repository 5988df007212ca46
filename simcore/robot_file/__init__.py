"""Reader, checks and template of `simcore.toml`, which describes a team's robot."""
