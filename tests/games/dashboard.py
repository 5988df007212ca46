"""Dashboard for tests: a NetworkTables client that uses only topics, and its server."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable

import pytest

from simcore import season
from simcore.match.match import Match


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def start_client(client, name: str, port: int) -> None:
    """Start a client for a server on this computer, with the names of either season."""
    of_2026 = hasattr(client, "startClient4")
    (client.startClient4 if of_2026 else client.start_client)(name)
    (client.setServer if of_2026 else client.set_server)("127.0.0.1", port)


class Dashboard:
    """Dashboard as a context manager; values published before `connect` count as left by an earlier simulation."""

    def __init__(self) -> None:
        pytest.importorskip("ntcore")
        from simcore.robotcode.networktables.networktables_sink import start_local_server

        self.server, self.client = (season.ntcore.NetworkTableInstance.create() for _ in range(2))
        self.port = free_port()
        start_local_server(self.server, port=self.port)

    def __enter__(self) -> Dashboard:
        return self

    def __exit__(self, *_: object) -> None:
        self.everything.close()
        for instance in (self.client, self.server):
            season.ntcore.NetworkTableInstance.destroy(instance)

    def connect(self, folder: str) -> None:
        self.everything = season.ntcore.MultiSubscriber(self.client, [folder])
        start_client(self.client, "dashboard", self.port)
        is_connected = getattr(self.client, "isConnected", None) or self.client.is_connected
        deadline = time.monotonic() + 10.0
        while not is_connected() and time.monotonic() < deadline:
            time.sleep(0.01)
        time.sleep(0.2)

    def until(self, match: Match, condition: Callable[[], bool]) -> None:
        """Play until a condition holds."""
        deadline = time.monotonic() + 10.0
        while not condition():
            assert time.monotonic() < deadline, [str(result) for result in match.control.results]
            match.tick()
            self.client.flush()
            self.server.flush()
            time.sleep(0.005)
