"""Write the address of the repository that is released into what its package says of itself, before it is built.

A package index shows README.md alone, where links to files of the repository lead nowhere.

    python scripts/name_repository.py https://host/owner/simcore v1.0.0
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

PLACEHOLDER = "https://ADDRESS"
"""In pyproject.toml, and nowhere else."""
_LINK = re.compile(r"(!?)\[([^]]*)\]\((?!https?:|#)([^)\s]+)\)")


def name_repository(folder: Path, address: str, tag: str) -> None:
    """Rewrite `pyproject.toml` and `README.md` of a checkout.

    Args:
        folder: Of the checkout.
        address: Of the repository, as a browser opens it.
        tag: Of the release, whose files the links mean.
    """
    project, readme = folder / "pyproject.toml", folder / "README.md"
    text = project.read_text(encoding="utf-8")
    if text.count(PLACEHOLDER) != 1 or not re.fullmatch(r"https://[^/\s]+/\S*[^/\s]", address):
        raise SystemExit(f"want {PLACEHOLDER} once in pyproject.toml, and an address like https://..., got {address!r}")
    project.write_text(text.replace(PLACEHOLDER, address), encoding="utf-8")

    def whole(link: re.Match[str]) -> str:
        is_picture, text, file = link.groups()
        return f"{is_picture}[{text}]({address}/{'raw' if is_picture else 'blob'}/{tag}/{file})"

    readme.write_text(_LINK.sub(whole, readme.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else None)
    parser.add_argument("address", help="of the repository, as a browser opens it")
    parser.add_argument("tag", help="of the release")
    told = parser.parse_args()
    name_repository(Path(__file__).resolve().parents[1], told.address, told.tag)
