"""A button of the page that saves the last ten seconds as a GIF, which phones and chats open."""

from __future__ import annotations

import tempfile
import threading
from collections import deque
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from simcore.errors import SimcoreError
from simcore.show.animation import FRAME_PERIOD, animate
from simcore.show.log_page import scene_of_log
from simcore.telemetry.recording import Recording
from simcore.telemetry.sinks import Cadence
from simcore.telemetry.snapshot import Snapshot

if TYPE_CHECKING:
    import viser

__all__ = ["CLIP_SECONDS", "ClipButton", "RecentSnapshots", "clip"]

CLIP_SECONDS = 10.0
"""Simulated time that a clip shows, and in which it plays [s]."""
_WIDTH = 720  # [px]
_LABEL = f"clip of the last {CLIP_SECONDS:g} s"


def clip(snapshots: Iterable[Snapshot], title: str = "") -> bytes:
    """A moving picture of the field from above, as the bytes of a GIF.

    Args:
        snapshots: What happened, in order of time; what comes before a jump back in time is left out.
        title: In the upper left corner.

    Raises:
        OutputError: There are no snapshots, or a library is missing.
    """
    recording = Recording(period=FRAME_PERIOD, bulk_period=FRAME_PERIOD)
    for snapshot in snapshots:
        recording.write(snapshot)
    with tempfile.TemporaryDirectory(prefix="simcore_clip_") as folder:
        path = Path(folder) / "clip.gif"
        animate(path, recording, scene_of_log(recording), title=title, width=_WIDTH)
        return path.read_bytes()


class RecentSnapshots:
    """The snapshots of a run's last ten seconds. Threads may read while one writes."""

    def __init__(self) -> None:
        self._kept: deque[Snapshot] = deque()
        self._cadence = Cadence(FRAME_PERIOD)

    def due(self, time: float) -> bool:
        """Whether a snapshot of a simulated time [s] is wanted."""
        return self._cadence.due(time)

    def note(self, snapshot: Snapshot) -> None:
        """Keep one, and forget what is too old or of another run."""
        if self._kept and snapshot.time < self._kept[-1].time:
            self._kept.clear()
        self._cadence.take(snapshot.time)
        self._kept.append(snapshot)
        while self._kept[0].time < snapshot.time - CLIP_SECONDS - 1e-9:
            self._kept.popleft()

    def __call__(self) -> list[Snapshot]:
        """Those that are kept, the oldest first."""
        return list(self._kept.copy())  # a copy is made in one piece, which iterating is not


class ClipButton:
    """Draws a clip and hands it to the browser that asked.

    Args:
        server: Whose page.
        snapshots: Of the seconds up to what is shown now.
        title: Of the picture, and name of the file.
        order: Where on the page.
    """

    def __init__(
        self, server: viser.ViserServer, snapshots: Callable[[], Iterable[Snapshot]], title: str, *, order: float
    ) -> None:
        self._snapshots, self._title = snapshots, title
        self._drawing = threading.Lock()
        self._button = server.gui.add_button(_LABEL, color="gray", order=order)
        self._button.on_click(lambda event: self._save(event.client))

    def _save(self, client: Any) -> None:
        if not self._drawing.acquire(blocking=False):
            client.add_notification("one clip at a time", "another one is being drawn", auto_close_seconds=4.0)
            return
        try:
            self._button.label = "drawing the clip ..."
            content = clip(self._snapshots(), self._title)
            client.send_file_download(f"{self._title}.gif", content, save_immediately=True)
        except SimcoreError as error:
            client.add_notification("no clip", str(error))
        finally:
            self._button.label = _LABEL
            self._drawing.release()
