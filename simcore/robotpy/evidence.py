"""What a failed robot test leaves behind: the log of the run, and a picture."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from simcore.telemetry.recording import Recording
from simcore.telemetry.summary import draw_summary
from simcore.telemetry.wpilog import WpilogSink

if TYPE_CHECKING:
    from simcore.robotpy.robot_test import RobotTest

__all__ = ["Evidence"]


class Evidence:
    """Logs a run to a temporary folder, and moves it to its place if the test fails.

    Args:
        folder: Where it goes; what an earlier run left there is removed.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        _remove(folder)
        self._work = Path(tempfile.mkdtemp(prefix="simcore-run-"))
        self._log = WpilogSink(self._work / "run.wpilog")
        self._recording = Recording()
        self.sinks = (self._log, self._recording)
        """For the game."""

    def keep(self, test: RobotTest | None, title: str) -> str:
        """Write everything; returns what to tell."""
        self._log.close()
        self.folder.mkdir(parents=True, exist_ok=True)
        log = Path(shutil.move(self._work / "run.wpilog", self.folder / "run.wpilog"))
        told = [f"log (AdvantageScope): {log}"]
        picture = self.folder / "run.png"
        try:
            if test is not None and test.has_run and hasattr(test.game, "scene"):
                draw_summary(picture, self._recording, test.game.scene(), title=title, subtitle=test.summary())
                told.append(f"picture:              {picture}")
        except Exception as error:  # the test's own failure matters more
            told.append(f"no picture: {type(error).__name__}: {error}")
        if test is not None and test.has_run:
            told.append(f"at its end: {test.summary()}")
        shutil.rmtree(self._work, ignore_errors=True)
        return "\n".join(told)

    def drop(self) -> None:
        """Leave nothing."""
        self._log.close()
        shutil.rmtree(self._work, ignore_errors=True)


def _remove(folder: Path) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    try:
        folder.parent.rmdir()
    except OSError:
        pass  # not there, or somebody else's output is in it
