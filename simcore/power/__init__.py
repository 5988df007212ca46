"""The battery and what it feeds."""
