"""Adapter to PhotonVision: what simcore's cameras see, as photonlibpy's `PhotonCamera` in robot code reads it.

`PhotonCameraPort` and `pipeline_result` need photonlibpy; they are loaded when they are asked for.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from simcore.photonvision.photon_port import PhotonCameraPort, pipeline_result

__all__ = ["PhotonCameraPort", "pipeline_result"]

_HOMES = {"PhotonCameraPort": "photon_port", "pipeline_result": "photon_port"}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
