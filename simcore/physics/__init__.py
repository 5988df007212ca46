"""The rigid-body world: bodies, statics, surfaces, steps. One module here imports the engine."""
