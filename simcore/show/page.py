"""Page of a run: a single HTML file that replays the run in two and three dimensions in any browser.

The page loads nothing from the network; the content security policy of the page forbids network access. The source of
the page's script is in `simcore/show/player/`.
"""

from __future__ import annotations

import base64
import functools
import gzip
import json
import re
from collections.abc import Mapping
from html import escape
from pathlib import Path
from string import Template
from typing import Any

from simcore.show.palette import css_variables
from simcore.show.run_data import run_data
from simcore.show.scene import Scene
from simcore.telemetry.recording import Recording
from simcore.telemetry.sinks import write_text

__all__ = ["packed", "page_frame", "page_html", "page_style", "write_page"]

_PLAYER = Path(__file__).with_name("player")
_MODULES = (
    "dom", "charts", "data", "key", "top", "solid", "timeline", "picture", "panels",
    "sound", "player", "live", "robot_model", "report", "main",
)  # fmt: skip
"""Modules of the player's script, in an order in which each module follows the modules that it imports."""
_IMPORT = re.compile(r'^import (\{.*?\}) from "\./(\w+)\.js";$', re.MULTILINE)
_EXPORT = re.compile(r"^export ((?:async )?(?:class|const|function) (\w+))", re.MULTILINE)


def write_page(path: str | Path, recording: Recording, scene: Scene, *, title: str = "run", subtitle: str = "") -> None:
    """Write the page of a run, and create missing folders.

    Args:
        path: Path of the file, usually with the suffix `.html`.
        recording: Recording of the run.
        scene: Scene of the run.
        title: Heading, and title of the browser tab.
        subtitle: Text next to the heading; line breaks are kept.

    Raises:
        OutputError: If the file cannot be written.
    """
    meta, data = run_data(recording, scene, title=title, subtitle=subtitle)
    write_text("page", Path(path), page_html(title, meta, data))


def page_html(title: str, meta: dict[str, Any] | None = None, data: bytes = b"") -> str:
    """Return the HTML page of a run.

    Args:
        title: Heading, and title of the browser tab.
        meta: JSON object with the data of the run, from `run_data`; None for a page that receives a live run over a
            WebSocket.
        data: Binary block with the data of the run, from `run_data`.
    """
    blocks = {}
    if meta is not None:
        text = json.dumps(meta, separators=(",", ":"), allow_nan=False).encode()
        blocks = {"run": text, "data": data}
    return page_frame(title, _PLAYER.joinpath("player.html").read_text(encoding="utf-8"), blocks)


def page_frame(title: str, body: str, blocks: Mapping[str, bytes]) -> str:
    """Return an HTML page with a heading, a body and the player's script.

    The content security policy lets a page without blocks connect to the server that sent the page. Other pages cannot
    connect to any server.

    Args:
        title: Heading, and title of the browser tab.
        body: HTML below the heading.
        blocks: Data for the script, by element id.
    """
    data = "\n".join(
        f'<script type="text/plain" id="{name}">{packed(content)}</script>' for name, content in blocks.items()
    )
    return Template(_PLAYER.joinpath("frame.html").read_text(encoding="utf-8")).substitute(
        TITLE=escape(title), STYLE=page_style(), BODY=body, DATA=data, SCRIPT=_script(),
        CONNECT="'none'" if blocks else "'self'",
    )  # fmt: skip


def packed(content: bytes) -> str:
    """Compress bytes reproducibly with gzip, and encode the result in base64 for the player's `inflate`."""
    return base64.b64encode(gzip.compress(content, 7, mtime=0)).decode("ascii")


def page_style() -> str:
    """Return the style sheet for all pages, with light and dark colors."""
    return css_variables() + _PLAYER.joinpath("player.css").read_text(encoding="utf-8")


@functools.cache
def _script() -> str:
    """Return Three.js and the player's modules as one compressed script in a separate scope."""
    three = _PLAYER.joinpath("vendor", "three.min.js").read_text(encoding="utf-8")
    own = "".join(_bundled(name, _PLAYER.joinpath(f"{name}.js").read_text(encoding="utf-8")) for name in _MODULES)
    return packed(f"{three}\n(() => {{\n'use strict';\n{own}}})();\n".encode())


def _bundled(name: str, text: str) -> str:
    r"""Wrap a JavaScript module in a function that returns the module's exports, because a page must not import files.

    >>> print(_bundled("top", 'import { b } from "./data.js";\nexport const a = b;\n'))
    const top_ = (() => {
    const { b } = data_;
    const a = b;
    return { a };
    })();
    <BLANKLINE>
    """
    names = ", ".join(match[2] for match in _EXPORT.finditer(text))
    body = _EXPORT.sub(r"\1", _IMPORT.sub(r"const \1 = \2_;", text))
    return f"const {name}_ = (() => {{\n{body}return {{ {names} }};\n}})();\n"
