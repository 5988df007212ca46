"""Mechanisms driven by DC motors: flywheels, rollers, arms, elevators, racks."""
