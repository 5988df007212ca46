"""`simcore new-game`: template of a package for a new year's game."""
