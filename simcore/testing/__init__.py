"""Public doubles and assertions for tests."""
