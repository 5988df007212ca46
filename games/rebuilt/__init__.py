"""FRC 2026 REBUILT: fuel, hubs, bumps, trenches and towers."""
