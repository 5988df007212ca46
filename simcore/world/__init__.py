"""Physics world: rotations, shapes, zones, field geometry and symmetry, bodies, and physics engines."""
