"""REBUILT, the 2026 game: field, fuel, hubs, a robot and its autos."""
