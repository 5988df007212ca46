"""Hot modules as native code: an opt-in, from the same sources, with the same results to the last bit."""
