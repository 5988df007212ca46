"""Game pieces: what they are, where they live, how they fly, are taken in and shot."""
