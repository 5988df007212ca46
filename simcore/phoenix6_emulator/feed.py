"""The enable feed of device objects: a WPILib Notifier, made with the first device and kept for the whole process."""

from __future__ import annotations

from phoenix6.wpiutils import auto_feed_enable

__all__ = ["stop_feed"]

_INSTANCE = "_AutoFeedEnable__instance"
_NOTIFIER = "_AutoFeedEnable__enable_notifier"


def stop_feed() -> None:
    """End the Notifier that feeds `feed_enable`; the next device makes a new one.

    Devices that robot code left open would otherwise feed the enable signal of the next test, and a Notifier that is
    alive when Python ends aborts the process.
    """
    cls = getattr(auto_feed_enable, "AutoFeedEnable", None)
    feed = getattr(cls, _INSTANCE, None)
    if cls is None or feed is None:
        return
    getattr(feed, _NOTIFIER).stop()
    setattr(cls, _INSTANCE, None)
