"""Scripted players: robots that play a whole match with others, each with a role and a level of skill."""
