"""Write the table of makers in docs/which_robots.md; the packages of all makers must be installed."""

from __future__ import annotations

import argparse
from pathlib import Path

from simcore.robotcode.program.makers import installed_makers

PAGE = Path(__file__).resolve().parents[1] / "docs" / "which_robots.md"
_BEGIN, _END = "<!-- made by scripts/write_which_robots.py -->\n", "<!-- end -->"


def table() -> str:
    """Return the models by maker, as Markdown."""
    rows = [(m.name, m.motors, m.encoders, m.gyros) for m in installed_makers()]
    lines = ["| maker | motor controllers | encoders | gyros |", "|---|---|---|---|"]
    lines += [f"| {name} | {' | '.join(', '.join(models) or '-' for models in kinds)} |" for name, *kinds in rows]
    return "\n".join(lines) + "\n"


def text() -> str:
    """Return the page with a new table."""
    page = PAGE.read_text(encoding="utf-8")
    head, rest = page.split(_BEGIN)
    return f"{head}{_BEGIN}\n{table()}\n{_END}{rest.split(_END, 1)[1]}"


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    PAGE.write_text(text(), encoding="utf-8")
