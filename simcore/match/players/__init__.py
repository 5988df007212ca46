"""Players of whole matches: scripted robots, each with a role and a skill level, and robots driven by a person."""
