"""Public test doubles, test benches and assertions."""
