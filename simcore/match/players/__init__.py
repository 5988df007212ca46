"""Scripted players: robots that play a whole match with others, each in a role and at a level of skill."""
