"""Space and what fills it: rotations, zones, symmetry; bodies, fields and engines. One module imports each engine."""
