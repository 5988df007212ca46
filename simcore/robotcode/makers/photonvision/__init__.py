"""Adapter to PhotonVision: robot code reads simcore's cameras through photonlibpy's `PhotonCamera`."""
