"""A robot measured from its own log: readers, forward models on the compiled loop, fits with intervals."""
