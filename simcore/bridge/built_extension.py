"""Path of the HAL extension for this computer; the script `scripts/build_bridge.py` builds the extensions."""

from __future__ import annotations

import platform
import sys
from pathlib import Path

from simcore.errors import ConfigError

__all__ = ["BUILT", "SOURCE", "TARGETS", "extension_path"]

SOURCE = Path(__file__).with_name("extension.c")
"""C source file of the extension."""
BUILT = Path(__file__).with_name("built")
"""Folder of the built extensions."""
TARGETS = {
    # system and processor: Zig target, file name
    ("linux", "x86_64"): ("x86_64-linux-gnu.2.17", "simcore_linux_x64.so"),
    ("linux", "aarch64"): ("aarch64-linux-gnu.2.17", "simcore_linux_arm64.so"),
    ("win32", "amd64"): ("x86_64-windows-gnu", "simcore_windows_x64.dll"),
    ("darwin", "arm64"): ("aarch64-macos.11.0", "simcore_macos_arm64.dylib"),
    ("darwin", "x86_64"): ("x86_64-macos.11.0", "simcore_macos_x64.dylib"),
}
"""Zig target and file name of the extension, by system and processor."""


def extension_path() -> Path:
    """Return the path of the extension for this computer.

    Raises:
        ConfigError: If simcore has no extension for this operating system and processor.
    """
    key = sys.platform, platform.machine().lower()
    if key not in TARGETS:
        known = ", ".join(f"{system} {machine}" for system, machine in TARGETS)
        raise ConfigError(f"the bridge is built for {known}, but this computer is {key[0]} {key[1]}: compile {SOURCE}")
    return BUILT / TARGETS[key][1]
