"""Web server of the live view, with one page and one WebSocket, which only the page of this server may use.

Any website in the same browser can send requests to a server on this computer. The browser names the requesting site in
`Origin` and the requested host in `Host`. Under DNS rebinding, the requested host is the name of the site. The server
therefore first refuses every request with a host or an origin other than the server's own.
"""

from __future__ import annotations

import asyncio
import contextlib
import ipaddress
import itertools
import json
import logging
import os
import socket
import sys
import threading
import webbrowser
from collections.abc import Callable, Iterable, Sequence
from html import escape
from http import HTTPStatus
from typing import Any, Protocol

from simcore.errors import ConfigError, OutputError
from simcore.install_text import install_command

__all__ = ["LONGEST", "MOST_VIEWERS", "Guard", "ViewServer", "open_browser"]

MOST_VIEWERS = 16
"""Largest number of connected pages, because each page slows the run down a little."""
LONGEST = 1000
"""Largest number of characters in a page's message."""
_BACKLOG = 200_000  # [bytes]; a slow page with more unsent data gets no further frames
_LOOPBACK = frozenset({"127.0.0.1", "localhost", "[::1]"})
_SOCKET = "/live"
_HEADERS = {
    "Content-Type": "text/html; charset=utf-8",
    "Cache-Control": "no-store",
    "X-Frame-Options": "DENY",  # no other site can embed the page with its buttons
    "Cross-Origin-Resource-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
}


class Headers(Protocol):
    """Headers of an HTTP request."""

    def get_all(self, key: str) -> Sequence[str]:
        """Return all values of the header `key`; the name of a header is case-insensitive."""
        ...


class Guard:
    """Filter that refuses the requests of other sites.

    Args:
        host: Address of the view. With a loopback address, the guard accepts only loopback addresses as `Host`. With
            another address, the guard also accepts the names of this computer and all numeric addresses, because the
            name of another site is neither.
    """

    def __init__(self, host: str) -> None:
        self._names = set(_LOOPBACK)
        self._any_address = host.lower() not in _LOOPBACK | {"::1"}
        if self._any_address:
            own = socket.gethostname().lower()
            self._names |= {host.lower(), own, f"{own}.local"}

    def refusal(self, headers: Headers, port: int) -> str:
        """Return the reason for refusing a request; empty if the request is allowed.

        Args:
            headers: Headers of the request.
            port: Port on which the request arrived.
        """
        hosts = headers.get_all("Host")
        if len(hosts) != 1 or not self._is_own(hosts[0].lower(), port):
            return f"this is not the address of the view: Host {', '.join(hosts) or 'missing'}"
        origins = headers.get_all("Origin")
        if any(origin.lower() != f"http://{hosts[0].lower()}" for origin in origins):
            return f"the view does not answer other sites: Origin {', '.join(origins)}"
        # requests without Origin may be images, scripts or frames of another site; only following a link is allowed
        site, mode, target = (", ".join(headers.get_all(f"Sec-Fetch-{name}")) for name in ("Site", "Mode", "Dest"))
        if site in ("cross-site", "same-site") and (mode, target) != ("navigate", "document"):
            return f"the view does not answer other sites: Sec-Fetch-Site {site}"
        return ""

    def _is_own(self, host: str, port: int) -> bool:
        name, colon, number = host.rpartition(":")
        if not colon or number.endswith("]"):
            name, number = host, "80"
        if number != str(port):
            return False
        if name in self._names:
            return True
        if self._any_address:
            with contextlib.suppress(ValueError):
                ipaddress.ip_address(name.strip("[]"))
                return True
        return False


class ViewServer:
    """Server for a page and the WebSocket of the page; the server runs in a separate thread.

    Args:
        host: Address to listen on; `0.0.0.0` also allows other computers to connect.
        port: TCP port; 0 for any free port.
        page: HTML of the page.
        greet: Function that returns the first messages for a newly connected page.
        take: Function that the server's thread calls with the number of a page and a JSON object for each message, or
            None when the page has disconnected.

    Raises:
        OutputError: If the extra `view` is not installed or the port is in use.
        ConfigError: If the port number is invalid.
    """

    def __init__(
        self,
        host: str,
        port: int,
        page: str,
        greet: Callable[[], Iterable[str | bytes]],
        take: Callable[[int, dict[str, Any] | None], None],
    ) -> None:
        if not 0 <= port <= 65535:
            raise ConfigError(f"a port is 1 to 65535, or 0 for a free one, got {port}")
        try:
            from websockets.asyncio.server import broadcast, serve
        except ImportError as error:
            raise OutputError(f"the live view needs the extra 'view': {install_command('view')} ({error})") from error
        self._broadcast, self._serve = broadcast, serve
        self._page, self._greet, self._take, self._guard = page.encode(), greet, take, Guard(host)
        self._clients: dict[Any, int] = {}
        self._numbers = itertools.count(1)
        self._loop = asyncio.new_event_loop()
        listening = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET)
        if sys.platform != "win32":
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listening.bind((host, port))
            listening.listen(100)  # from here on, early connections wait instead of being refused
        except OSError as error:
            listening.close()
            raise OutputError(
                f"cannot serve the view on {host or 'any address'}:{port}: {error.strerror or error}. "
                "Another view may be running: end it, or leave the port out for a free one"
            ) from error
        self._port: int = listening.getsockname()[1]
        self.url = f"http://{'127.0.0.1' if host in ('', '0.0.0.0') else host}:{self._port}"
        self._stop = asyncio.Event()
        self._thread = threading.Thread(target=self._run, args=(listening,), daemon=True)
        self._thread.start()

    @property
    def has_viewers(self) -> bool:
        """Whether any page is connected."""
        return bool(self._clients)

    def send(self, message: str | bytes, *, is_frame: bool = False) -> None:
        """Send a message to all pages without waiting.

        If `is_frame` is true, skip pages with too much unsent data.
        """
        if self._clients:
            self._loop.call_soon_threadsafe(self._send, message, is_frame)

    def close(self) -> None:
        """Stop the server; a second call has no effect."""
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._stop.set)
            self._thread.join(2.0)

    # --- in the server's thread ---------------------------------------------------------------------------------

    def _run(self, listening: socket.socket) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.run_until_complete(self._main(listening))

    async def _main(self, listening: socket.socket) -> None:
        silent = logging.getLogger(f"{__name__}.connections")  # no log lines about invalid requests
        silent.setLevel(logging.CRITICAL + 1)
        server = await self._serve(
            self._talk, sock=listening, process_request=self._answer, max_size=4 * LONGEST, compression=None,
            logger=silent, server_header=None, close_timeout=0.3,
        )  # fmt: skip
        await self._stop.wait()
        server.close()
        for connection in list(self._clients):
            connection.transport.abort()  # do not wait for a page that does not read
        await asyncio.wait([asyncio.ensure_future(server.wait_closed())], timeout=0.5)
        left = asyncio.all_tasks() - {asyncio.current_task()}
        for task in left:
            task.cancel()
        await asyncio.gather(*left, return_exceptions=True)

    def _answer(self, connection: Any, request: Any) -> Any:
        refused = self._guard.refusal(request.headers, self._port)
        status, text = HTTPStatus.FORBIDDEN, refused
        is_socket = any(value.lower() == "websocket" for value in request.headers.get_all("Upgrade"))
        if not refused and is_socket and request.path == _SOCKET:
            if len(self._clients) < MOST_VIEWERS:
                return None
            status, text = HTTPStatus.SERVICE_UNAVAILABLE, f"{MOST_VIEWERS} pages are open already; close one"
        elif not refused:
            status, text = HTTPStatus.NOT_FOUND, f"the view is at {self.url}"
            if request.path.partition("?")[0] == "/":
                status, text = HTTPStatus.OK, ""
        answer = connection.respond(status, f"{escape(text)}\n")
        headers = {**_HEADERS, "Content-Length": str(len(self._page))} if status == HTTPStatus.OK else _HEADERS
        if status == HTTPStatus.OK:
            answer.body = self._page
        for name, value in headers.items():
            if name in answer.headers:
                del answer.headers[name]
            answer.headers[name] = value
        return answer

    async def _talk(self, connection: Any) -> None:
        from websockets.exceptions import ConnectionClosed

        if len(self._clients) >= MOST_VIEWERS:  # several pages connected at the same time
            await connection.close(1013, f"{MOST_VIEWERS} pages are open already")
            return
        number = next(self._numbers)
        try:
            self._clients[connection] = number  # before greeting: a page may get a message twice, but misses none
            for message in self._greet():
                await connection.send(message)
            async for text in connection:
                try:
                    message = json.loads(text)
                    if not isinstance(message, dict):
                        raise ConfigError("a message must be an object")
                    self._take(number, message)
                except (ValueError, RecursionError) as error:  # ConfigError is a ValueError
                    await connection.close(1007, str(error).encode("ascii", "replace")[:120].decode())
        except ConnectionClosed:
            pass
        finally:
            self._clients.pop(connection, None)
            self._take(number, None)

    def _send(self, message: str | bytes, is_frame: bool) -> None:
        ready = [
            one
            for one in self._clients
            if not is_frame or one.transport is None or one.transport.get_write_buffer_size() < _BACKLOG
        ]
        self._broadcast(ready, message)


def open_browser(url: str) -> str:
    """Try to open a page in the browser, and return a sentence for the user with the address of the page."""
    headless = sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    if headless:
        return f"no display here: open {url} in a browser on this computer"
    try:
        opened = webbrowser.open(url)
    except (webbrowser.Error, OSError):
        opened = False
    return f"the view is at {url}" if opened else f"no browser found: open {url} yourself"
