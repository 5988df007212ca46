"""Physics world: rotations, zones, symmetry, shapes, bodies, fields and engines. One module imports each engine."""
