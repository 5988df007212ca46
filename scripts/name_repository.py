"""Write the repository's address into the package's metadata and README before a release is built.

A package index shows only README.md, where links to files of the repository would not work.

    python scripts/name_repository.py https://host/owner/simcore v1.0.0
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

PLACEHOLDER = "https://ADDRESS"
"""Address in pyproject.toml, and nowhere else, that is replaced."""
_LINK = re.compile(r"(!?)\[([^]]*)\]\((?!https?:|#)([^)\s]+)\)")


def name_repository(folder: Path, address: str, tag: str) -> None:
    """Rewrite `pyproject.toml` and `README.md` of a checkout.

    Args:
        folder: Folder of the checkout.
        address: Address of the repository in a browser.
        tag: Tag of the release to which the links refer.
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
    parser.add_argument("address", help="address of the repository in a browser")
    parser.add_argument("tag", help="tag of the release")
    arguments = parser.parse_args()
    name_repository(Path(__file__).resolve().parents[1], arguments.address, arguments.tag)
