"""Matches: the tick, clock, scoring, human players, records and reports."""
