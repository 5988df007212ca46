"""Robot code in simulation: what a program builds, its devices by maker, and how it runs."""
