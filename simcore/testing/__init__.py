"""Doubles and assertions for tests, public."""
