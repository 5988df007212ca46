"""Game pieces: their kinds, where they are, what moves them, and what takes them in or lets them go."""
