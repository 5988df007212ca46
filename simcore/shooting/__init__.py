"""Shooter tables: speed and elevation by distance, by simulated flights, with what they are worth."""
