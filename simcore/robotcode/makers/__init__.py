"""Adapters to vendor libraries: Phoenix 6, REVLib, navX, PhotonVision."""
