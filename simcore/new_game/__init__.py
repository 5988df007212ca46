"""Command `simcore new-game` and the template of a package for a new game."""
