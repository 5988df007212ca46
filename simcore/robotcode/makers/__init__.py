"""Devices by maker: Phoenix 6, REV, navX, PhotonVision."""
