"""What `simcore.toml` says of a robot, read and checked; knows no vendor."""
