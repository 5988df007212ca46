"""The web server of the view: viser, started where it was asked for, guarded and silent."""

from __future__ import annotations

import os
import socket
import sys
import threading
import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import rich

from simcore.errors import ConfigError, OutputError
from simcore.install_text import install_command
from simcore.show.view_driving import ViewDriving
from simcore.show.view_guard import ViewGuard

if TYPE_CHECKING:
    import viser

__all__ = ["address", "open_browser", "start_server", "stop_server"]

_quiet_lock = threading.Lock()
_quiet_count = 0


def start_server(host: str, port: int, title: str, driving: ViewDriving | None = None) -> viser.ViserServer:
    """Start to serve an empty page.

    Args:
        host: Where to listen.
        port: 0 takes a free one.
        title: Of the page.
        driving: The person at the page; None: nobody can drive.

    Raises:
        OutputError: The extra `view` is not installed, the port is taken, or this viser cannot be guarded.
        ConfigError: No such port.
    """
    if not 0 <= port <= 65535:
        raise ConfigError(f"a port is 1 to 65535, or 0 for a free one, got {port}")
    try:
        import viser
    except ImportError as error:
        raise OutputError(f"the browser view needs the extra 'view': {install_command('view')} ({error})") from error
    with socket.socket() as probe:
        if sys.platform != "win32":
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as error:
            raise OutputError(
                f"cannot serve the view on {host or 'any address'}:{port}: {error.strerror or error}. "
                "Another view may be running: end it, or leave the port out for a free one"
            ) from error
        free: Any = probe.getsockname()[1]
    with _quiet(), ViewGuard(host, driving).guarding():
        server = viser.ViserServer(host=host, port=int(free), label=title, verbose=False)
    if not ViewGuard.is_asked(address(host), server.get_port()):
        stop_server(server)
        raise OutputError(
            f"viser {viser.__version__} cannot be kept from answering websites, so the view is not served: "
            "python -m pip install 'viser==1.1.1'"
        )
    return server


def stop_server(server: viser.ViserServer) -> None:
    """Stop serving. The port is free at once; a browser's spare connection is not waited for."""
    stopping = threading.Thread(target=_stop, args=(server,), daemon=True)
    stopping.start()
    stopping.join(0.3)


def address(host: str) -> str:
    """Under which this computer reaches a server that listens there."""
    return "127.0.0.1" if host in ("", "0.0.0.0") else host


def open_browser(url: str) -> str:
    """Try to open a page; returns one sentence about what the user sees or has to do."""
    headless = sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    if headless:
        return f"no display here: open {url} in a browser on this computer"
    try:
        opened = webbrowser.open(url)
    except (webbrowser.Error, OSError):
        opened = False
    return f"the view is at {url}" if opened else f"no browser found: open {url} yourself"


def _stop(server: viser.ViserServer) -> None:
    with _quiet():
        server.stop()  # viser waits up to ten seconds for the spare connection that a browser keeps
        loop = getattr(getattr(server, "_websock_server", None), "_server_thread", None)
        if loop is not None:
            loop.join(15.0)  # its last word shall be unheard too


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep viser's messages off stdout, which is for the report: it prints them through rich's console."""
    global _quiet_count
    console = rich.get_console()
    with _quiet_lock:
        _quiet_count += 1
        console.quiet = True
    try:
        yield
    finally:
        with _quiet_lock:
            _quiet_count -= 1
            console.quiet = _quiet_count > 0
