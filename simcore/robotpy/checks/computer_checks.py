"""The computer: ports, the screen, and whether a match runs here, fast enough."""

from __future__ import annotations

import math
import socket
import statistics
import sys
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from simcore.install_text import install_command
from simcore.robotpy.checks.findings import Finding, fail, ok, warn
from simcore.units import TICK

if TYPE_CHECKING:
    from simcore.match.game import Game
    from simcore.match.match import Match

__all__ = ["PORTS", "check_games", "check_ports", "check_screen", "check_speed", "is_taken", "owner_of"]

_TICKS = 50  # one simulated second
_WARM_UP = 10  # ticks; the first ones pay for caches
_SLOW = 8.0  # [ms]; robot code, Phoenix 6 and the window want the rest of the 20

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


def check_games(find: Callable[[], Mapping[str, Game]]) -> tuple[Finding, Game | None]:
    """Whether there is a game to play, and it loads.

    Args:
        find: All installed games by name, the newest first.

    Returns:
        The finding, and the newest game; None if there is none.
    """
    try:
        games = find()
    except Exception as error:  # whatever stands in a broken installation's way is what was found
        return fail("game", f"a game does not load: {error}", "install simcore again"), None
    if not games:
        return fail("game", "no game is installed", install_command()), None
    newest, *others = (f"{game.name} ({game.year})" for game in games.values())
    also = f", the newest, is played if none is named; also installed: {', '.join(others)}" if others else ""
    return ok("game", newest + also), next(iter(games.values()))


def check_speed(build: Callable[[], Match], clock: Callable[[], float]) -> list[Finding]:
    """Play a second with the whole field and a robot that drives, and compare a tick with its 20 ms.

    Args:
        build: Makes the match.
        clock: Wall time [s].
    """
    from simcore.robot.fixed_wheel_drive import TankDrive  # where half of it is missing, other checks say so

    try:
        match = build()
    except Exception as error:
        return [fail("field", f"the match cannot be built: {error}", "install simcore again: parts of it are missing")]
    took = []
    try:
        pieces = sum(len(positions) for positions in match.piece_positions().values())
        robot = match.robots[0]
        start = robot.chassis.pose
        for number in range(_WARM_UP + _TICKS):
            before = clock()
            drive = robot.drive
            if isinstance(drive, TankDrive):
                drive.set_chassis_speeds(1.0, 0.0)
            else:
                drive.set_chassis_speeds(1.0, 0.0, 0.0)
            match.tick()
            if number >= _WARM_UP:
                took.append(1e3 * (clock() - before))
        end = robot.chassis.pose
    finally:
        match.close()
    moved = math.dist(end[:2], start[:2])
    field = ok("field", f"mesh and {pieces} pieces are there")
    if not moved > 0.5:
        where = f"a robot told to drive at 1 m/s moved {moved:.2f} m in {TICK * (_WARM_UP + _TICKS):.1f} s"
        return [field, fail("physics", where, "report this: with this output, your computer and its Python")]
    return [field, _speed(statistics.median(took), statistics.quantiles(took, n=100, method="inclusive")[-1])]


def _speed(median: float, worst: float) -> Finding:
    text = f"a tick takes {median:.1f} ms, p99 {worst:.1f} ms, of 20 ms: {1e3 * TICK / median:.0f} x real time alone"
    if median > 1e3 * TICK:
        return fail("speed", text, "too slow to drive in real time: plug in the charger, close other programs")
    if median > _SLOW or worst > 1e3 * TICK:
        return warn(
            "speed",
            text,
            "robot code needs the rest of it: plug in the charger, close other programs (see performance)",
        )
    return ok("speed", text)
