"""Matches: clock, scoring, reports and digests."""
