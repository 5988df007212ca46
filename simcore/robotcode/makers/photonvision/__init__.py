"""Adapter to PhotonVision: what simcore's cameras see, as photonlibpy's `PhotonCamera` in robot code reads it."""
