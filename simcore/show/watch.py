"""Live outputs of a run in real time: the live view in a browser, and NetworkTables.

If a port is in use or an optional dependency is missing, the command ends before the run.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from simcore.match.game import Game
from simcore.match.match import Match
from simcore.quantities import PORT, number_flag
from simcore.show.live_view import LiveView
from simcore.show.pacing import Pacer
from simcore.show.view_driving import ViewDriving
from simcore.show.view_models import load_models
from simcore.show.view_server import open_browser
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import TelemetrySink

__all__ = ["Watch", "add_options"]

_FIELD = "SmartDashboard/Field"
"""Topic of the `Field2d`, as in `robotpy sim`."""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options for watching a run in real time, for `simcore play` and `simcore serve`."""
    group = parser.add_argument_group("watching, in real time")
    group.add_argument("--view", action="store_true", help="show the run in a browser, once it is open (extra: view)")
    group.add_argument("--live", action="store_true", help="publish over NetworkTables, e.g. for AdvantageScope")
    group.add_argument(
        "--host", default="127.0.0.1", help="address on which the view listens (default: this computer only)"
    )
    group.add_argument("--port", type=number_flag(PORT), default=0, help="port of the view (default: a free one)")
    group.add_argument(
        "--nt-port",
        type=number_flag(replace(PORT, least=1)),
        default=5810,
        help="NetworkTables port of --live (default: 5810, as AdvantageScope expects)",
    )
    group.add_argument("--no-browser", action="store_true", help="do not open a browser")
    group.add_argument(
        "--models", type=Path, metavar="FOLDER", help="your own Robot_... and Field3d_... folders for --view"
    )


class Watch:
    """Live outputs of a run that the options select: the browser view and NetworkTables.

    Args:
        options: Parsed command-line options, with `seed` and the options of `add_options`.
        game: Game of the run.
        driving: Input of the drivers at the pages; None if no robot can be driven.

    Raises:
        SimcoreError: If an output cannot be started.
    """

    def __init__(self, options: argparse.Namespace, game: Game, driving: ViewDriving | None = None) -> None:
        self._view: LiveView | None = None
        self._tables: Any = None
        self._control: Any = None
        self._controlled: Match | None = None
        self._pacer = Pacer() if options.view or options.live else None
        self._sink: Any = None
        if options.live:
            self._tables = _serve(options.nt_port)
        if options.view:
            self._view = _open(options, game, driving)
            _say(f"the view is at {self._view.url}" if options.no_browser else open_browser(self._view.url))

    @property
    def wants_restart(self) -> bool:
        """Whether a page has requested a new run."""
        return self._view is not None and self._view.wants_restart

    def sinks(self) -> list[TelemetrySink]:
        """Return new telemetry sinks for one run: of the live view and of NetworkTables, if selected."""
        sinks: list[TelemetrySink] = []
        if self._view is not None:
            sinks.append(self._view.sink())
        if self._tables is not None:
            from simcore.robotcode.networktables.networktables_sink import NetworkTablesSink

            if self._sink is not None:  # from the previous run
                self._sink.withdraw()
            self._sink = NetworkTablesSink(self._tables, stays=True, field=_FIELD)
            sinks.append(self._sink)
        return sinks

    def after_tick(self, match: Match, should_stop: Callable[[], bool]) -> None:
        """Execute commands of pages and dashboards, and wait until the next tick is due by the wall clock."""
        if self._tables is not None and self._controlled is not match:
            self._listen(match)
        if self._view is not None:
            self._view.after_tick(match, should_stop=should_stop)
        elif self._pacer is not None:
            self._pacer.wait(match.time, should_stop=should_stop)

    def wait(self, should_stop: Callable[[], bool]) -> None:
        """Wait before the first run until a page of the view is open or `should_stop` returns True."""
        if self._view is not None and not self._view.has_viewers:
            _say("the run begins when the page is open; Ctrl-C leaves")
            self._view.wait_for_viewer(should_stop=should_stop)

    def next_seed(self, played: Recording, should_stop: Callable[[], bool]) -> int | None:
        """Wait after a run until a page requests a restart or `should_stop` returns True.

        Returns:
            Seed of the next run; None after a stop, or at once without live outputs.
        """
        if self._view is None and self._tables is None:
            return None
        if not self.wants_restart:
            stays = "the page stays" if self._view is not None else "its last values stay on NetworkTables"
            _say(f"the run is over; {stays}. Press Ctrl-C to leave")
        if self._view is not None:
            return self._view.next_seed(played, should_stop=should_stop)
        while not should_stop():
            time.sleep(0.05)
        return None

    def close(self) -> None:
        """Stop all live outputs; a second call has no effect."""
        if self._view is not None:
            self._view.close()
        if self._control is not None:
            self._control.close()
        if self._tables is not None:
            self._tables.stop_server()

    def _listen(self, match: Match) -> None:
        """Connect the control topics for dashboards on NetworkTables to a match, and disconnect the last match."""
        from simcore.robotcode.networktables.control_topics import ControlTopics

        if self._control is not None:
            self._control.close()
        self._controlled, self._control = match, ControlTopics(match, self._tables)


def _open(options: argparse.Namespace, game: Game, driving: ViewDriving | None) -> LiveView:
    if options.models is not None:
        load_models(options.models)  # raises an error for an invalid model before the run
    return LiveView(
        host=options.host, port=options.port, title=game.heading, seed=options.seed, driving=driving,
        models=options.models,
    )  # fmt: skip


def _serve(port: int) -> Any:
    from simcore import season
    from simcore.robotcode.networktables.networktables_sink import start_local_server

    instance = season.ntcore.NetworkTableInstance.create()
    start_local_server(instance, port=port)
    _say(f"live on NetworkTables 4, 127.0.0.1:{port}")
    return instance


def _say(text: str) -> None:
    """Print a line to stderr, because stdout contains only the report."""
    print(text, file=sys.stderr, flush=True)
