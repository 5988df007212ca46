"""Who may look: the view answers requests that name its own address, and only so many viewers at once.

A website in the same browser can send requests to a server on this computer. The browser says which site asks in
`Origin`, and which name it took the address for in `Host`; under DNS rebinding that is the site's own name. So the view
refuses whoever comes with another host or origin than its own, before anything else is looked at.
"""

from __future__ import annotations

import asyncio
import contextlib
import http.client
import ipaddress
import logging
import socket
import threading
from collections.abc import Callable, Iterator, Sequence
from http import HTTPStatus
from importlib.resources import files
from typing import Any, Protocol

from simcore.show.view_driving import LONGEST, SUBPROTOCOL, ViewDriving

__all__ = ["MOST_VIEWERS", "ViewGuard"]

MOST_VIEWERS = 16
"""Open pages at once; each costs the run some time."""
_LOOPBACK = frozenset({"127.0.0.1", "localhost", "[::1]"})
_LIBRARY = "viser-v"  # what a page of viser names as its websocket protocol
_SCRIPTS = ("match_sounds.js", "view_sounds.js")
"""Of every page, beside viser's own."""
_HEADERS = {
    "Content-Security-Policy": "frame-ancestors 'none'",  # no other site shows the buttons inside of its own page
    "X-Frame-Options": "DENY",
    "Cross-Origin-Resource-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
}
_patching = threading.Lock()


class Headers(Protocol):
    """Of a request."""

    def get_all(self, key: str) -> Sequence[str]:
        """All values of a header, of any case."""
        ...


class ViewGuard:
    """Decides about each request to a view.

    Args:
        host: Where the view listens. On another address than the loopback's, every name of this computer and every
            numeric address will do: a site's own name is neither.
        driving: Has a script in the page and a socket from it; None: nobody can drive.
    """

    def __init__(self, host: str, driving: ViewDriving | None = None) -> None:
        self._driving = driving
        scripts = [(files(__package__) / name).read_text(encoding="utf-8") for name in _SCRIPTS]
        scripts += [] if driving is None else [driving.script]
        self._scripts = "".join(f"<script>{script}</script>" for script in scripts).encode()
        self._names = set(_LOOPBACK)
        self._any_address = host.lower() not in _LOOPBACK | {"::1"}
        if self._any_address:
            own = socket.gethostname().lower()
            self._names |= {host.lower(), own, f"{own}.local"}
        self._viewers: set[Any] = set()

    def refusal(self, headers: Headers, port: int) -> tuple[HTTPStatus, str] | None:
        """Why a request is not answered, None if it is.

        Args:
            headers: Of the request.
            port: At which it came in.
        """
        hosts = headers.get_all("Host")
        if len(hosts) != 1 or not self._is_own(hosts[0].lower(), port):
            return HTTPStatus.FORBIDDEN, f"this is not the address of the view: Host {', '.join(hosts) or 'missing'}"
        origins = headers.get_all("Origin")
        if any(origin.lower() != f"http://{hosts[0].lower()}" for origin in origins):
            return HTTPStatus.FORBIDDEN, f"the view does not answer other sites: Origin {', '.join(origins)}"
        # a request without Origin: an image, a script or a frame of another site; but a link may be followed
        site, mode, target = (", ".join(headers.get_all(f"Sec-Fetch-{name}")) for name in ("Site", "Mode", "Dest"))
        if site in ("cross-site", "same-site") and (mode, target) != ("navigate", "document"):
            return HTTPStatus.FORBIDDEN, f"the view does not answer other sites: Sec-Fetch-Site {site}"
        if self._drives(headers):
            return None
        if len(self._viewers) >= MOST_VIEWERS:
            return HTTPStatus.SERVICE_UNAVAILABLE, f"{MOST_VIEWERS} pages look at this view, no more can; close one"
        if _is_websocket(headers) and not any(_LIBRARY in name for name in headers.get_all("Sec-WebSocket-Protocol")):
            return HTTPStatus.BAD_REQUEST, "this socket is for the page of the view"
        return None

    def add_scripts(self, answer: Any) -> None:
        """Put our scripts into an answer of the web server, if that is a page of HTML without compression."""
        if "html" in answer.headers.get("Content-Type", ""):
            before, tag, after = answer.body.rpartition(b"</body>")
            answer.body = before + self._scripts + tag + after if tag else answer.body + self._scripts
            del answer.headers["Content-Length"]
            answer.headers["Content-Length"] = str(len(answer.body))

    def _drives(self, headers: Headers) -> bool:
        asked = headers.get_all("Sec-WebSocket-Protocol")
        return self._driving is not None and _is_websocket(headers) and list(asked) == [SUBPROTOCOL]

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

    @contextlib.contextmanager
    def guarding(self) -> Iterator[None]:
        """Have the websocket servers that start in this context ask first, and hand sockets that drive over.

        viser passes no hook on, so the one function with which it starts its server is wrapped meanwhile. `is_asked`
        tells whether that worked.
        """
        from websockets.asyncio import server as library

        with _patching:
            real: Any = library.serve

            def serve(handler: Any, *args: Any, process_request: Any = None, **options: Any) -> Any:
                select = options.pop("select_subprotocol", None)
                return real(
                    self._handler(handler),
                    *args,
                    process_request=self._before(process_request),
                    select_subprotocol=lambda connection, names: (
                        SUBPROTOCOL if names == [SUBPROTOCOL] else select and select(connection, names)
                    ),
                    logger=_silent(),
                    **options,
                )

            library.serve = serve
            try:
                yield
            finally:
                library.serve = real

    @staticmethod
    def is_asked(host: str, port: int) -> bool:
        """Whether the server there refuses a page and a socket for a foreign host, and a socket for a foreign site."""
        own, upgrade = (
            f"{host}:{port}",
            {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13"},
        )
        upgrade |= {"Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA==", "Sec-WebSocket-Protocol": _LIBRARY}
        foreign = {"Host": f"simcore.invalid:{port}"}
        asked = (foreign, {**upgrade, **foreign}, {**upgrade, "Host": own, "Origin": "http://simcore.invalid"})
        return all(_status(host, port, headers) == HTTPStatus.FORBIDDEN for headers in asked)

    def _handler(self, inner: Callable[..., Any]) -> Callable[..., Any]:
        async def handle(connection: Any) -> None:
            if self._driving is not None and connection.subprotocol == SUBPROTOCOL:
                await self._driving.serve(connection)
            else:
                await inner(connection)

        return handle

    def _before(self, inner: Callable[..., Any] | None) -> Callable[..., Any]:
        def process_request(connection: Any, request: Any) -> Any:
            refused = self.refusal(request.headers, connection.local_address[1])
            if refused is not None:
                answer = connection.respond(refused[0], f"{refused[1]}\n")
            elif self._drives(request.headers):
                connection.protocol.max_message_size = 4 * LONGEST  # bytes; else they may be as long as viser's
                return None
            else:
                if "Accept-Encoding" in request.headers:
                    del request.headers["Accept-Encoding"]  # the scripts go into the plain page
                answer = inner(connection, request) if inner is not None else None
                if answer is not None:
                    self.add_scripts(answer)
                if answer is None and _is_websocket(request.headers):
                    self._viewers.add(connection)
                    task = asyncio.ensure_future(connection.wait_closed())
                    task.add_done_callback(lambda _: self._viewers.discard(connection))
            if answer is not None:
                answer.headers.update(_HEADERS)
            return answer

        return process_request


def _is_websocket(headers: Headers) -> bool:
    return any(value.lower() == "websocket" for value in headers.get_all("Upgrade"))


def _silent() -> logging.Logger:
    """For whoever knocks and says nothing sensible: no line of it reaches the screen."""
    logger = logging.getLogger(f"{__name__}.connections")
    logger.setLevel(logging.CRITICAL + 1)
    return logger


def _status(host: str, port: int, headers: dict[str, str]) -> int:
    connection = http.client.HTTPConnection(host, port, timeout=10.0)
    try:
        connection.putrequest("GET", "/", skip_host=True, skip_accept_encoding=True)
        for name, value in headers.items():
            connection.putheader(name, value)
        connection.endheaders()
        return connection.getresponse().status
    except (OSError, http.client.HTTPException):
        return 0
    finally:
        connection.close()
