"""Write the tables of docs/telemetry.md, all telemetry keys, from the channels that match and games declare.

python scripts/write_telemetry_keys.py
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from pathlib import Path

from games.rebuilt import REBUILT
from games.reefscape import REEFSCAPE
from simcore.channel import Channel
from simcore.match.channels import MATCH, MECHANISM, PART, PIECES, ROBOT
from simcore.match.match import Match

PAGE = Path(__file__).resolve().parents[1] / "docs" / "telemetry.md"
_HEAD = "| key | type | meaning |\n|---|---|---|\n"


def _table(channels: Iterable[Channel], before: str = "") -> str:
    return _HEAD + "".join(
        f"| `{before}{channel.key}` | {channel.kind} | {channel.meaning}{_unit(channel)} |\n" for channel in channels
    )


def _unit(channel: Channel) -> str:
    return f" [{channel.unit}]" if channel.unit and not channel.kind.startswith("Pose3d") else ""  # poses: always m


def tables() -> dict[str, str]:
    """Return each table by its name on the page."""
    found = {
        "match": _table(MATCH),
        "pieces": _table(PIECES),
        "robot": _table(ROBOT, "Sim/"),
        "mechanism": _table(MECHANISM, "Sim/Debug/<Mechanism>"),
        "part": _table(PART, "Sim/Debug/"),
    }
    for game in (REBUILT, REEFSCAPE):
        with Match(game) as match:
            found[game.name] = _table(match.rules.channels)
    return found


def text() -> str:
    """Return the page with new tables."""
    page = PAGE.read_text(encoding="utf-8")
    for name, table in tables().items():
        begin, end = f"<!-- {name}: made by scripts/write_telemetry_keys.py -->\n\n", "\n<!-- end -->"
        head, _, rest = page.partition(begin)
        page = head + begin + table + rest[rest.index(end) :]
    return page


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    PAGE.write_text(text(), encoding="utf-8")
