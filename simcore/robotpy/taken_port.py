"""Says it when another program holds NetworkTables' port: dashboards would go on to show that one."""

from __future__ import annotations

import logging
import socket

__all__ = ["warn_of_taken_port"]

_log = logging.getLogger(__name__)

NETWORKTABLES = 5810
"""Port of the NT4 server."""


def warn_of_taken_port(port: int = NETWORKTABLES) -> bool:
    """Look before the robot program starts its own server, which would fail with one line among many.

    Args:
        port: On this machine.

    Returns:
        Whether somebody listens there.
    """
    try:
        socket.create_connection(("127.0.0.1", port), timeout=0.2).close()
    except OSError:
        return False
    _log.warning(
        "another program (a simulation that is still open?) holds port %d of NetworkTables: dashboards will show that "
        "one, not this; close it and start again",
        port,
    )
    return True
