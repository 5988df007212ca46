"""`simcore new-game`: a package for a new year's game that plays at once."""
