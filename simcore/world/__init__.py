"""Frames, quaternions, zones and the symmetry of the field: mathematics on arrays, nothing else."""
