"""Adapter to PhotonVision: simcore's cameras as photonlib's `PhotonCamera` reads them."""
