"""The computer: ports and the screen."""

from __future__ import annotations

import socket
import sys
from collections.abc import Callable, Collection, Mapping
from pathlib import Path

from simcore.robotpy.checks.finding import Finding, ok, warn

__all__ = ["PORTS", "check_ports", "check_screen", "is_taken", "owner_of"]

PORTS = {
    5810: "NetworkTables 4: dashboards, AdvantageScope",
    1735: "NetworkTables 3: old dashboards",
    1250: "Phoenix diagnostics: Tuner X",
    3300: "WebSocket of `robotpy sim --ws-server`",
}
"""Of a robot program, and what goes missing when another program has them."""


def check_ports(taken: Callable[[int], bool], owner: Callable[[int], str]) -> Finding:
    """Whether another program has a port of ours.

    Args:
        taken: Whether a port is.
        owner: Who has it, empty if that cannot be told.
    """
    found = [(port, owner(port)) for port in PORTS if taken(port)]
    if not found:
        return ok("ports", f"{', '.join(map(str, PORTS))} are free")
    shown = "; ".join(f"{port} ({PORTS[port]}) taken{f' by {who}' if who else ''}" for port, who in found)
    port = found[0][0]
    look = f"`netstat -ano | findstr :{port}`" if sys.platform == "win32" else f"`lsof -i :{port}`"
    advice = "end the other robot program or simulation; the second one runs on without what it cannot serve"
    return warn("ports", shown, advice if all(who for _, who in found) else f"{advice}. Who it is: {look}")


def is_taken(port: int) -> bool:
    """Whether a program listens on a TCP port of this computer."""
    with socket.socket() as probe:
        if sys.platform == "win32":
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_EXCLUSIVEADDRUSE, 1)
        else:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)  # the rest of a closed one does not count
        try:
            probe.bind(("", port))
        except OSError:
            return True
    return False


def owner_of(port: int, proc: Path = Path("/proc")) -> str:
    """Name and number of the program that listens on a TCP port; Linux only, empty elsewhere and for other users'."""
    sockets = set()
    for table in ("tcp", "tcp6"):
        try:
            lines = (proc / "net" / table).read_text().splitlines()[1:]
        except OSError:
            continue
        for line in lines:
            fields = line.split()
            if int(fields[1].rpartition(":")[2], 16) == port and fields[3] == "0A":  # listening
                sockets.add(f"socket:[{fields[9]}]")
    if not sockets:
        return ""
    for process in proc.glob("[0-9]*"):
        try:
            if any(str(handle.readlink()) in sockets for handle in (process / "fd").iterdir()):
                words = (process / "cmdline").read_bytes().decode(errors="replace").split("\0")
                command = " ".join(word for word in words if word)
                return f"process {process.name}: {command[:60]}"
        except OSError:  # it ended meanwhile, or is another user's
            continue
    return ""


def check_screen(system: str, environment: Mapping[str, str], installed: Collection[str]) -> Finding:
    """Whether the simulator's window can open.

    Args:
        system: As `platform.system()` says.
        environment: Of this process.
        installed: Names of everything installed.
    """
    if "robotpy-halsim-gui" not in installed:
        return warn(
            "screen",
            "the simulator's window is not installed",
            "`python -m pip install robotpy-halsim-gui` for a window; `robotpy sim --nogui` runs without",
        )
    has_screen = system != "Linux" or environment.get("DISPLAY") or environment.get("WAYLAND_DISPLAY")
    if not has_screen:
        return warn(
            "screen", "no screen (neither DISPLAY nor WAYLAND_DISPLAY)", "`robotpy sim --nogui`; pictures and logs work"
        )
    return ok("screen", "the simulator's window can open")
