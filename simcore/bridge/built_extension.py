"""The extension for this computer: a file of the package that `scripts/build_bridge.py` has built."""

from __future__ import annotations

import platform
import sys
from pathlib import Path

from simcore.errors import ConfigError

__all__ = ["BUILT", "SOURCE", "TARGETS", "extension_path"]

SOURCE = Path(__file__).with_name("extension.c")
"""Source of the built files."""
BUILT = Path(__file__).with_name("built")
"""Folder of the built files."""
TARGETS = {
    # system and processor: target of Zig, file
    ("linux", "x86_64"): ("x86_64-linux-gnu.2.17", "simcore_linux_x64.so"),
    ("linux", "aarch64"): ("aarch64-linux-gnu.2.17", "simcore_linux_arm64.so"),
    ("win32", "amd64"): ("x86_64-windows-gnu", "simcore_windows_x64.dll"),
    ("darwin", "arm64"): ("aarch64-macos.11.0", "simcore_macos_arm64.dylib"),
    ("darwin", "x86_64"): ("x86_64-macos.11.0", "simcore_macos_x64.dylib"),
}
"""Target of Zig and file, by system and processor."""


def extension_path() -> Path:
    """Return the file for this computer.

    Raises:
        ConfigError: The extension is not built for this computer.
    """
    key = sys.platform, platform.machine().lower()
    if key not in TARGETS:
        known = ", ".join(f"{system} {machine}" for system, machine in TARGETS)
        raise ConfigError(f"the bridge is built for {known}, and this computer is {key[0]} {key[1]}: {SOURCE} compiles")
    return BUILT / TARGETS[key][1]
