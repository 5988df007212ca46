"""Scoring zones, events and the match clock."""
