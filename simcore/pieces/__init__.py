"""Game pieces: kinds, states, flight, launches and resting places."""
