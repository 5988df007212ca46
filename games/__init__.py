"""One small package a year: the field, the pieces and the rules of a game."""
